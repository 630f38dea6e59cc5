#include "quality/spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 1U << 16U;

std::size_t bin_of(const Histogram& histogram, double value) {
  const double width = (histogram.hi - histogram.lo) / static_cast<double>(histogram.bins.size());
  const double bin = width > 0 ? std::floor((value - histogram.lo) / width) : 0;
  return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(histogram.bins.size() - 1)));
}

/// In degrees, of a pseudo-angle of [0, 2].
double angle_deg(double pseudo) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return pseudo <= 1 ? std::atan2(pseudo, 1 - pseudo) * kDegrees : 180 - std::atan2(2 - pseudo, pseudo - 1) * kDegrees;
}

}  // namespace

QualityReport::Spread measure_spread(std::vector<double>& values, double lo, double hi, std::size_t n_bins) {
  QualityReport::Spread spread;
  spread.histogram = {lo, hi, std::vector<std::uint64_t>(n_bins, 0)};
  if (values.empty()) return spread;
  struct Partial {
    double min, max, sum;
    std::vector<std::uint64_t> bins;
  };
  const Partial nothing{values[0], values[0], 0, std::vector<std::uint64_t>(n_bins, 0)};
  const Partial all = parallel_reduce_ordered(
      values.size(), kBlock, nothing,
      [&](std::size_t begin, std::size_t end) {
        Partial part = nothing;
        for (std::size_t k = begin; k != end; ++k) {
          part.min = std::min(part.min, values[k]);
          part.max = std::max(part.max, values[k]);
          part.sum += values[k];
          ++part.bins[bin_of(spread.histogram, values[k])];
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
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  spread.p99 = *place;
  return spread;
}

void AngleTally::merge(const AngleTally& other) {
  for (std::size_t k = 0; k < kFineBins; ++k) bins_[k] += other.bins_[k];
  least_ = std::min(least_, other.least_);
  greatest_ = std::max(greatest_, other.greatest_);
}

QualityReport::Spread AngleTally::spread_deg() const {
  QualityReport::Spread spread;
  spread.histogram = {0, 180, std::vector<std::uint64_t>(36, 0)};
  std::uint64_t n = 0;
  for (const std::uint64_t count : bins_) n += count;
  if (n == 0) return spread;
  spread.min = angle_deg(least_);
  spread.max = angle_deg(greatest_);
  double sum = 0;
  std::uint64_t below = 0;
  bool found = false;
  for (std::size_t k = 0; k < kFineBins; ++k) {
    const double middle = angle_deg((static_cast<double>(k) + 0.5) * (2.0 / kFineBins));
    const double angle = std::clamp(middle, spread.min, spread.max);
    sum += angle * static_cast<double>(bins_[k]);
    spread.histogram.bins[bin_of(spread.histogram, middle)] += bins_[k];
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
