// Places and paths of pictures.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "base/number_text.h"
#include "voropack/vec.h"

namespace voropack::io {

/// The longer side of the picture. Coordinates get one decimal: a tenth of a unit is far below a pixel on any screen.
inline constexpr double kPictureSize = 10000;
inline constexpr double kMargin = 0.02 * kPictureSize;

/// A point of the picture.
using Place = std::array<std::int64_t, 2>;

/// Maps the domain to the picture: y upwards becomes y downwards.
class Frame {
 public:
  explicit Frame(const Box<2>& box) : box_(box) {
    const Vec<2> extent = box.empty() ? Vec<2>{1.0, 1.0} : box.hi - box.lo;
    const double longest = std::max(extent[0], extent[1]);
    scale_ = longest > 0 ? kPictureSize / longest : 1;
    width = extent[0] * scale_ + 2 * kMargin;
    height = extent[1] * scale_ + 2 * kMargin;
  }
  [[nodiscard]] Place place(const Vec<2>& p) const {
    return {std::llround((p[0] - box_.lo[0]) * scale_ + kMargin), std::llround((box_.hi[1] - p[1]) * scale_ + kMargin)};
  }
  double width = 0, height = 0;

 private:
  Box<2> box_;
  double scale_ = 1;
};

/// The data of one path element. Points are relative to the one before, which keeps the text short.
class Path {
 public:
  explicit Path(const Frame& frame) : frame_(frame) {}
  void move_to(const Vec<2>& p) { move_to(frame_.place(p)); }
  void line_to(const Vec<2>& p) { line_to(frame_.place(p)); }
  void move_to(const Place& p) { add('m', p); }
  void line_to(const Place& p) { add('l', p); }
  void close() {
    data_ += 'z';
    at_ = start_;
    command_ = 'z';
  }
  [[nodiscard]] const std::string& data() const { return data_; }

 private:
  void add(char command, const Place& next) {
    if (command != command_) data_ += command;
    append(next[0] - at_[0], command == command_);
    append(next[1] - at_[1], true);
    at_ = next;
    if (command == 'm') start_ = next;
    // After a move, further pairs are lines unless said otherwise.
    command_ = command;
  }
  void append(std::int64_t value, bool needs_space) {
    if (needs_space && value >= 0) data_ += ' ';
    append_number(data_, value);
  }
  const Frame& frame_;
  std::string data_;
  Place at_{}, start_{};
  char command_ = ' ';
};

}  // namespace voropack::io
