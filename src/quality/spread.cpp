#include "quality/spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 1U << 16U;

/// Finds bins; the width is not divided out again for each value.
class BinFinder {
 public:
  BinFinder(double lo, double hi, std::size_t n_bins)
      : lo_(lo), width_((hi - lo) / static_cast<double>(n_bins)), last_(static_cast<double>(n_bins - 1)) {}

  [[nodiscard]] std::size_t operator()(double value) const {
    const double bin = width_ > 0 ? (value - lo_) / width_ : 0;
    return static_cast<std::size_t>(static_cast<int>(std::clamp(bin, 0.0, last_)));
  }

 private:
  double lo_, width_, last_;
};

/// The value of the given rank, which lies in `bin`, where the ranks start with `first_rank`.
double value_of_rank(std::span<const double> values, const BinFinder& bin_of, std::size_t bin, std::size_t rank,
                     std::size_t first_rank) {
  std::vector<std::vector<double>> found((values.size() + kBlock - 1) / kBlock);
  parallel_for(
      found.size(),
      [&](std::size_t block) {
        for (const double value : values.subspan(block * kBlock, std::min(kBlock, values.size() - block * kBlock)))
          if (bin_of(value) == bin) found[block].push_back(value);
      },
      1);
  std::vector<double> candidates;
  for (const std::vector<double>& block : found) candidates.insert(candidates.end(), block.begin(), block.end());
  const auto place = candidates.begin() + static_cast<std::ptrdiff_t>(rank - first_rank);
  std::nth_element(candidates.begin(), place, candidates.end());
  return *place;
}

/// In degrees, of a pseudo-angle of [0, 2].
double angle_deg(double pseudo) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return pseudo <= 1 ? std::atan2(pseudo, 1 - pseudo) * kDegrees : 180 - std::atan2(2 - pseudo, pseudo - 1) * kDegrees;
}

}  // namespace

QualityReport::Spread measure_spread(std::span<const double> values, double lo, double hi, std::size_t n_bins) {
  QualityReport::Spread spread;
  spread.histogram = {lo, hi, std::vector<std::uint64_t>(n_bins, 0)};
  if (values.empty()) return spread;
  struct Partial {
    double min, max, sum;
    std::vector<std::uint64_t> bins;
  };
  const BinFinder bin_of(lo, hi, n_bins);
  const Partial nothing{values[0], values[0], 0, std::vector<std::uint64_t>(n_bins, 0)};
  const Partial all = parallel_reduce_ordered(
      values.size(), kBlock, nothing,
      [&](std::size_t begin, std::size_t end) {
        Partial part = nothing;
        for (std::size_t k = begin; k != end; ++k) {
          part.min = std::min(part.min, values[k]);
          part.max = std::max(part.max, values[k]);
          part.sum += values[k];
          ++part.bins[bin_of(values[k])];
        }
        return part;
      },
      [](Partial a, const Partial& b) {
        a.min = std::min(a.min, b.min);
        a.max = std::max(a.max, b.max);
        a.sum += b.sum;
        for (std::size_t k = 0; k < a.bins.size(); ++k) a.bins[k] += b.bins[k];
        return a;
      });
  spread.min = all.min;
  spread.max = all.max;
  spread.mean = all.sum / static_cast<double>(values.size());
  spread.histogram.bins = all.bins;
  const std::size_t rank = (values.size() * 99 - 1) / 100;  // The nearest-rank definition.
  std::size_t bin = 0, first_rank = 0;
  while (first_rank + all.bins[bin] <= rank) first_rank += all.bins[bin++];
  spread.p99 = value_of_rank(values, bin_of, bin, rank, first_rank);
  return spread;
}

void AngleTally::count_waiting() {
  std::array<double, kBatch> pseudo;
  for (std::size_t k = 0; k < n_waiting_; ++k) {
    const double x = x_[k], ratio = y_[k] / (std::abs(x) + y_[k]);
    // ratio, or 2 - ratio if x < 0: which one cannot be predicted, so there is no branch.
    pseudo[k] = (1 - std::copysign(1.0, x)) + std::copysign(ratio, x);
  }
  double least = least_, greatest = greatest_;
  for (std::size_t k = 0; k < n_waiting_; ++k) {
    if (!(pseudo[k] >= 0)) continue;  // No direction at all: a triangle with two equal corners.
    // Near 0 and near pi the ratio itself keeps the digits.
    least = std::min(least, pseudo[k]);
    greatest = std::max(greatest, pseudo[k]);
    const auto bin = static_cast<std::size_t>(static_cast<int>(pseudo[k] * (0.5 * kFineBins)));
    ++bins_[std::min(bin, kFineBins - 1)];
  }
  least_ = least;
  greatest_ = greatest;
  n_waiting_ = 0;
}

void AngleTally::merge(AngleTally& other) {
  other.count_waiting();
  for (std::size_t k = 0; k < kFineBins; ++k) bins_[k] += other.bins_[k];
  least_ = std::min(least_, other.least_);
  greatest_ = std::max(greatest_, other.greatest_);
}

QualityReport::Spread AngleTally::spread_deg() {
  count_waiting();
  QualityReport::Spread spread;
  spread.histogram = {0, 180, std::vector<std::uint64_t>(36, 0)};
  std::uint64_t n = 0;
  for (const std::uint64_t count : bins_) n += count;
  if (n == 0) return spread;
  spread.min = angle_deg(least_);
  spread.max = angle_deg(greatest_);
  const BinFinder bin_of(0, 180, spread.histogram.bins.size());
  double sum = 0;
  std::uint64_t below = 0;
  bool found = false;
  for (std::size_t k = 0; k < kFineBins; ++k) {
    const double middle = angle_deg((static_cast<double>(k) + 0.5) * (2.0 / kFineBins));
    const double angle = std::clamp(middle, spread.min, spread.max);
    sum += angle * static_cast<double>(bins_[k]);
    spread.histogram.bins[bin_of(middle)] += bins_[k];
    below += bins_[k];
    if (!found && below * 100 >= n * 99) {
      spread.p99 = angle;
      found = true;
    }
  }
  spread.mean = sum / static_cast<double>(n);
  return spread;
}

}  // namespace voropack
