#include "spacing/integral.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/adaptive.h"
#include "base/random.h"

namespace voropack {

namespace {

/// Samples along each axis of a cell.
constexpr int kSamples = 3;
template <int D>
struct DensityCell {
  Box<D> box;
  double integral = 0;    // Over the part of the cell in the domain.
  double volume = 0;      // Of that part.
  double error = 0;       // Standard deviation of `integral`, roughly.
  bool is_exact = false;  // f is constant on the cell, which is in the domain as a whole or not at all.
  Vec<D> sample;          // A point of the cell that is in the domain, drawn by its density; if integral > 0.
};

template <int D>
double volume_of(const Box<D>& box) {
  double v = 1;
  for (int k = 0; k < D; ++k) v *= box.hi[k] - box.lo[k];
  return v;
}

template <int D>
int sample_count() {
  return D == 2 ? kSamples * kSamples : kSamples * kSamples * kSamples;
}

/// The i-th point of a jittered grid, a pure function of the cell.
template <int D>
Vec<D> sample_point(const Box<D>& box, int i, std::uint64_t key) {
  Vec<D> x;
  for (int k = 0, rest = i; k < D; ++k, rest /= kSamples) {
    const double t = (rest % kSamples + to_unit(hash_words(key, i, k))) / kSamples;
    x[k] = box.lo[k] + t * (box.hi[k] - box.lo[k]);
  }
  return x;
}

template <int D>
void examine(DensityCell<D>& cell, std::uint64_t key, const RegionLocator<D>& locator, const Spacing<D>& f) {
  const Vec<D> center = cell.box.center();
  const double volume = volume_of(cell.box);
  const bool is_mixed = locator.meets_any_wall(center, 0.5 * cell.box.diagonal());
  cell.is_exact = !is_mixed && !locator.in_domain(center);
  if (cell.is_exact) return;
  const std::optional<double> constant = f.constant_on(cell.box);
  cell.is_exact = !is_mixed && constant;
  if (cell.is_exact) {
    cell.volume = volume;
    cell.integral = volume / std::pow(*constant, D);
    cell.sample = center;
    return;
  }
  // Relative to the density at the center, for squares of densities may overflow.
  const double at_center = constant ? *constant : f(center), unit = volume / std::pow(at_center, D);
  const int n = sample_count<D>();
  int n_inside = 0;
  double sum = 0;
  double sum_sq = 0;
  for (int i = 0; i < n; ++i) {
    const Vec<D> x = sample_point(cell.box, i, key);
    if (is_mixed && !locator.in_domain(x)) continue;
    const double density = constant ? 1 : std::pow(at_center / f(x), D);
    ++n_inside;
    sum += density;
    sum_sq += density * density;
    if (to_unit(hash_words(key, i, D)) * sum < density) cell.sample = x;
  }
  cell.volume = volume * n_inside / n;
  cell.integral = unit * sum / n;
  // A cell that meets a wall is taken to hold something even if no sample fell into the domain.
  const double least_sq = is_mixed && n_inside == 0 ? 1.0 : 0.0;
  const double variance = std::max(sum_sq / n - (sum / n) * (sum / n), least_sq / n);
  cell.error = unit * std::sqrt(variance / n);
}

template <int D>
std::array<DensityCell<D>, 2> halves(const DensityCell<D>& cell) {
  const Box<D>& box = cell.box;
  int axis = 0;
  for (int k = 1; k < D; ++k)
    if (box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis]) axis = k;
  std::array<DensityCell<D>, 2> result;
  for (DensityCell<D>& half : result) half.box = box;
  result[0].box.hi[axis] = result[1].box.lo[axis] = box.center()[axis];
  return result;
}

/// The standard deviation of the sum by the sum.
template <int D>
double relative_error(const std::vector<DensityCell<D>>& cells) {
  double integral = 0, error_sq = 0;
  for (const DensityCell<D>& cell : cells) {
    integral += cell.integral;
    error_sq += cell.error * cell.error;
  }
  return std::sqrt(error_sq) / integral;
}

/// The cells of the sum, with the factor that scales the sampled volume to the true one.
template <int D>
struct DensityCells {
  std::vector<DensityCell<D>> cells;
  double scale = 1;
};

template <int D>
double measure_of(const Domain<D>& domain) {
  double measure = 0;
  for (const double m : domain.region_measure) measure += m;
  return measure;
}

/// One cell that stands for the whole domain.
template <int D>
DensityCells<D> single_cell(const Domain<D>& domain, double f) {
  const double measure = measure_of(domain);
  return {{{domain.box, measure / std::pow(f, D), measure, 0, true, domain.box.center()}}, 1};
}

template <int D>
DensityCells<D> cut_into_cells(const Domain<D>& domain, const RegionLocator<D>& locator, const Spacing<D>& f) {
  if (const auto constant = f.constant_on(domain.box)) return single_cell(domain, *constant);
  std::vector<DensityCell<D>> cells(1);
  cells[0].box = domain.box;
  cells = cut_adaptively(
      std::move(cells),
      [&](DensityCell<D>& cell, std::uint64_t round, std::size_t i) {
        examine(cell, hash_words(round, i), locator, f);
      },
      halves<D>, relative_error<D>);
  double volume = 0;
  for (const DensityCell<D>& cell : cells) volume += cell.volume;
  if (!(volume > 0)) return single_cell(domain, f(domain.box.center()));
  return {std::move(cells), measure_of(domain) / volume};
}

}  // namespace

template <int D>
double integrate_density(const Domain<D>& domain, const RegionLocator<D>& locator, const Spacing<D>& f) {
  const DensityCells<D> all = cut_into_cells(domain, locator, f);
  double integral = 0;
  for (const DensityCell<D>& cell : all.cells) integral += cell.integral;
  return integral * all.scale;
}

template <int D>
std::vector<IntegralSample<D>> sample_density(const Domain<D>& domain, const RegionLocator<D>& locator,
                                              const Spacing<D>& f) {
  const DensityCells<D> all = cut_into_cells(domain, locator, f);
  std::vector<IntegralSample<D>> samples;
  for (const DensityCell<D>& cell : all.cells)
    if (cell.integral > 0) samples.push_back({cell.sample, cell.integral * all.scale});
  return samples;
}

template double integrate_density<2>(const Domain<2>&, const RegionLocator<2>&, const Spacing<2>&);
template double integrate_density<3>(const Domain<3>&, const RegionLocator<3>&, const Spacing<3>&);

template std::vector<IntegralSample<2>> sample_density<2>(const Domain<2>&, const RegionLocator<2>&, const Spacing<2>&);
template std::vector<IntegralSample<3>> sample_density<3>(const Domain<3>&, const RegionLocator<3>&, const Spacing<3>&);

}  // namespace voropack
