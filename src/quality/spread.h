// Min, mean, 99th percentile, max and a histogram of many values, the same for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voropack/quality.h"

namespace voropack {

/// The spread of `values`. All zero if there are none. Bins: `n_bins` equal ones of [lo, hi].
QualityReport::Spread measure_spread(std::span<const double> values, double lo, double hi, std::size_t n_bins);

/// Counts angles of [0, pi] without calling an arc function for each.
///
/// An angle is given as (x, y) with y >= 0, any positive multiple of its cosine and sine. It is counted in a fine bin
/// of the pseudo-angle y / (|x| + y), which grows with the angle. The extremes are exact; mean and percentile, made
/// from the bins, are off by less than 0.01 degrees.
class AngleTally {
 public:
  AngleTally() : bins_(kFineBins, 0) {}

  void add(double x, double y) { add_if(true, x, y); }
  /// Without a branch, as the callers' conditions cannot be predicted.
  void add_if(bool counts, double x, double y) {
    x_[n_waiting_] = x;
    y_[n_waiting_] = y;
    n_waiting_ += counts ? 1U : 0U;
    if (n_waiting_ == kBatch) count_waiting();
  }

  /// Adds what `other` counted, angles that wait in it included.
  void merge(AngleTally& other);
  [[nodiscard]] QualityReport::Spread spread_deg();

 private:
  static constexpr std::size_t kFineBins = 1U << 14U;
  static constexpr std::size_t kBatch = 256;

  /// Divides many at once: divisions of a batch overlap, and two share an instruction.
  void count_waiting();

  std::array<double, kBatch> x_, y_;  ///< [n_waiting_] angles that are not counted yet.
  std::size_t n_waiting_ = 0;
  std::vector<std::uint64_t> bins_;
  double least_ = 2, greatest_ = 0;
};

}  // namespace voropack
