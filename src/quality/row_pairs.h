// Many rows of a few numbers each, for loops over all rows.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <tuple>
#include <vector>

#include "base/lanes.h"

namespace voropack {

/// Two rows side by side, so that they take the same instructions. Keeps its memory when it is cleared.
template <std::size_t K>
class RowPairs {
 public:
  using Row = std::array<double, K>;

  void clear() { n_ = 0; }
  [[nodiscard]] std::size_t size() const { return n_; }
  [[nodiscard]] Row operator[](std::size_t row) const {
    Row values;
    for (std::size_t k = 0; k < K; ++k) values[k] = pairs_[row / Lanes::kSize][k][row % Lanes::kSize];
    return values;
  }

  void push_back(const Row& row) {
    make_room();
    std::array<Lanes, K>& pair = pairs_[n_ / Lanes::kSize];
    if (n_ % Lanes::kSize == 0)
      for (std::size_t k = 0; k < K; ++k) pair[k] = row[k];  // A last row without a partner stands in both places.
    else
      for (std::size_t k = 0; k < K; ++k) pair[k].set(1, row[k]);
    ++n_;
  }
  /// Both rows of `pair`, after an even number of rows.
  void push_back(const std::array<Lanes, K>& pair) {
    make_room();
    pairs_[n_ / Lanes::kSize] = pair;
    n_ += Lanes::kSize;
  }

  struct Place {
    double value;
    std::size_t row;
  };
  /// The largest of fn(column 0, column 1, ...) over all rows, and the first row that has it; -infinity and row 0 if
  /// none is a number.
  template <class Fn>
  [[nodiscard]] Place largest(const Fn& fn) const {
    Lanes best = -std::numeric_limits<double>::infinity(), place = 0.0, pair = 0.0;
    for (std::size_t k = 0; k < n_; k += Lanes::kSize) {
      const Lanes value = std::apply(fn, pairs_[k / Lanes::kSize]);
      const Lanes::Mask larger = value > best;
      best = select(larger, value, best);
      place = select(larger, pair, place);
      pair = pair + 1.0;
    }
    const std::array<std::size_t, 2> row = {2 * static_cast<std::size_t>(place[0]),
                                            2 * static_cast<std::size_t>(place[1]) + 1};
    const bool second = best[1] > best[0] || (best[1] == best[0] && row[1] < row[0]);
    return {best[second ? 1 : 0], row[second ? 1 : 0]};
  }

 private:
  void make_room() {
    if (pairs_.size() * Lanes::kSize <= n_) pairs_.resize(2 * pairs_.size() + 16);
  }

  std::size_t n_ = 0;
  std::vector<std::array<Lanes, K>> pairs_;
};

}  // namespace voropack
