// Min, mean, 99th percentile, max and a histogram of many values, the same for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voropack/quality.h"

namespace voropack {

/// The spread of `values`, which are reordered. All zero if there are none. Bins: `n_bins` equal ones of [lo, hi].
QualityReport::Spread measure_spread(std::vector<double>& values, double lo, double hi, std::size_t n_bins);

/// Counts angles of [0, pi] without calling an arc function for each.
///
/// An angle is given as (x, y) with y >= 0, any positive multiple of its cosine and sine. It is counted in a fine bin
/// of the pseudo-angle y / (|x| + y), which grows with the angle. The extremes are exact; mean and percentile, made
/// from the bins, are off by less than 0.01 degrees.
class AngleTally {
 public:
  AngleTally() : bins_(kFineBins, 0) {}

  void add(double x, double y) {
    const double ratio = y / ((x < 0 ? -x : x) + y);
    const double pseudo = x < 0 ? 2 - ratio : ratio;
    if (!(pseudo >= 0)) return;  // No direction at all: a triangle with two equal corners.
    // Near 0 and near pi the ratio itself keeps the digits.
    if (pseudo < least_) least_ = pseudo;
    if (pseudo > greatest_) greatest_ = pseudo;
    const auto bin = static_cast<std::size_t>(pseudo * (0.5 * kFineBins));
    ++bins_[bin < kFineBins ? bin : kFineBins - 1];
  }

  void merge(const AngleTally& other);
  [[nodiscard]] QualityReport::Spread spread_deg() const;

 private:
  static constexpr std::size_t kFineBins = 1U << 14U;

  std::vector<std::uint64_t> bins_;
  double least_ = 2, greatest_ = 0;
};

}  // namespace voropack
