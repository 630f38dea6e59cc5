// Filled contours of a function on a 2D mesh, and the scale of their colours.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "io/svg_path.h"
#include "voropack/mesh.h"

namespace voropack::io {

/// Room for the colour bar, to the right of the frame.
inline constexpr double kColorBarWidth = 0.17 * kPictureSize;

/// Bands of values between round numbers, each with a colour.
class ColorScale {
 public:
  explicit ColorScale(std::span<const double> values);
  [[nodiscard]] std::size_t size() const { return n_bands_; }
  /// Where band i begins; size() is the end of the last.
  [[nodiscard]] double edge(std::size_t i) const { return step_ * (first_ + static_cast<double>(i)); }
  /// The band that holds a value; a value on an edge is in the upper one.
  [[nodiscard]] std::size_t band_of(double value) const;
  /// Such as "#31688e".
  [[nodiscard]] std::string color(std::size_t band) const;
  /// The label of an edge, or nothing: every fourth has one.
  [[nodiscard]] std::string label(std::size_t i) const;

 private:
  double step_ = 1, first_ = 0;  ///< Edges are whole multiples of the step, from `first_` on.
  std::size_t n_bands_ = 1;
};

/// One path per band: the outline of where the P1 function of `values` is in it.
std::string contour_bands(const Mesh<2>& mesh, std::span<const double> values, const ColorScale& scale,
                          const Frame& frame);

/// The scale as a bar beside the picture, with its name and labels.
std::string color_bar(const std::string& name, const ColorScale& scale, const Frame& frame);

/// Text for XML.
std::string escaped(const std::string& text);

}  // namespace voropack::io
