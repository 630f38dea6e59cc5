#include "packing/budget.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "packing/attribution.h"

namespace voropack {

namespace {

/// Peak memory of the whole pipeline per vertex in bytes, measured (docs/theory/packing.md).
template <int D>
constexpr double kBytesPerVertex = D == 3 ? 1200 : 500;
/// One round of repairs shrinks f to no less than 0.3 of itself, so that the number grows by no more than 0.3^-3.
constexpr double kMostGrowth = 40;
/// Where features make up less than the first part of the vertices, to mend them is not recommended; where they make up
/// more than the second one, sizes are of no use.
constexpr double kSome = 0.2, kMost = 0.8;
/// A limit that is recommended leaves room for the error of the estimate.
constexpr double kRoom = 1.3;

double memory_bytes() {
  const double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return bytes > 0 ? bytes : std::numeric_limits<double>::infinity();
}

/// To two digits: 1312 becomes 1400 by kUp, 1300 by kDown.
template <class Round>
std::string two_digits(double x, Round&& round) {
  const double unit = std::pow(10, std::max(0.0, std::floor(std::log10(x)) - 1));
  return fmt::format("{:.0f}", round(x / unit) * unit);
}
constexpr auto kUp = [](double x) { return std::ceil(x); };
constexpr auto kDown = [](double x) { return std::floor(x); };

/// The features by which an estimate comes about, one on each line.
template <int D>
std::string listed(const std::vector<CostlyFeature<D>>& features, const Domain<D>& domain) {
  if (features.empty()) return {};
  std::string text = ". Costliest features:";
  for (const CostlyFeature<D>& feature : features) text += "\n    " + describe(feature, domain);
  return text;
}

std::string many(double estimate) {
  if (!std::isfinite(estimate)) return "more vertices than can be counted";
  return fmt::format("about {:.3g} vertices", estimate);
}

}  // namespace

template <int D>
double Budget<D>::affordable() const {
  return std::min(static_cast<double>(options_.max_vertices), memory_bytes() / kBytesPerVertex<D>);
}

template <int D>
void Budget<D>::refuse(const Spacing<D>& f, double estimate) const {
  const double in_memory = memory_bytes() / kBytesPerVertex<D>;
  std::vector<CostlyFeature<D>> features;
  if (std::isfinite(estimate)) features = estimate_costliest_features(domain_, f, options_);
  const std::string count = many(estimate);
  double by_features = 0;
  for (const CostlyFeature<D>& feature : features) by_features += feature.vertices;
  std::string fix;
  if (by_features < kMost * estimate) fix = "ask for larger sizes";
  if (by_features > kSome * estimate)
    fix +=
        std::string(fix.empty() ? "" : ", or ") + "mend the places listed: join, part or remove what comes near there";
  if (estimate <= static_cast<double>(options_.max_vertices))
    throw LimitError(
        Fault{.id = "packing.too_little_memory",
              .message =
                  fmt::format("the mesh would have {} and need {:.3g} GB of memory; the machine has {:.3g} GB{}", count,
                              estimate * kBytesPerVertex<D> / 1e9, memory_bytes() / 1e9, listed(features, domain_)),
              .fix = fix + ", or use a machine with more memory"});
  if (kRoom * estimate <= in_memory)
    fix += ", or raise --max-vertices to " + two_digits(kRoom * estimate, kUp);
  else
    fix += "; with the memory of this machine --max-vertices can be " + two_digits(in_memory, kDown);
  throw LimitError(Fault{.id = "packing.too_many_vertices",
                         .message = fmt::format("the mesh would have {}; the limit is {}{}", count,
                                                options_.max_vertices, listed(features, domain_)),
                         .fix = std::move(fix)});
}

template <int D>
void Budget<D>::check_ahead(const Spacing<D>& f) {
  const CountEstimate<D> ahead = estimate_count(domain_, f, options_);
  estimate_ = std::max(static_cast<double>(domain_.points.size()), ahead.count());
  plateau_ = ahead.plateau;
  if (!(estimate_ <= affordable())) refuse(f, estimate_);
}

template <int D>
void Budget<D>::check_again(const Spacing<D>& f, std::size_t n_boundary) {
  estimate_ = std::max(estimate_, static_cast<double>(n_boundary));
  if (kMostGrowth * estimate_ <= affordable()) return;
  estimate_ = std::max(estimate_sphere_count(domain_, f, options_), static_cast<double>(n_boundary));
  if (!(estimate_ <= affordable())) refuse(f, estimate_);
}

template class Budget<2>;
template class Budget<3>;

}  // namespace voropack
