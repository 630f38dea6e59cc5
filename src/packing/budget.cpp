#include "packing/budget.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "packing/foresight.h"

namespace voropack {

namespace {

/// Peak memory of the whole pipeline per vertex in bytes, measured (docs/theory/packing.md).
template <int D>
constexpr double kBytesPerVertex = D == 3 ? 1200 : 500;
/// One round of repairs shrinks f to no less than 0.3 of itself, so that the number grows by no more than 0.3^-3.
constexpr double kMostGrowth = 40;
/// A limit that is recommended leaves room for the error of the estimate.
constexpr double kRoom = 1.3;

double memory_bytes() {
  const double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return bytes > 0 ? bytes : std::numeric_limits<double>::infinity();
}

/// Rounded up to two digits: 1400 for 1312.
double rounded_up(double x) {
  const double unit = std::pow(10, std::max(0.0, std::floor(std::log10(x)) - 1));
  return std::ceil(x / unit) * unit;
}

/// The features by which an estimate comes about, one on each line.
template <int D>
std::string listed(const std::vector<CostlyFeature<D>>& features, const Domain<D>& domain) {
  if (features.empty()) return {};
  std::string text = ". What geometry asks for most of them:";
  for (const CostlyFeature<D>& feature : features) text += "\n    " + describe(feature, domain);
  return text;
}

template <int D>
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
void Budget<D>::check(const Spacing<D>& f) {
  const Spacing<D> foreseen = with_foreseen_caps(domain_, f);
  estimate_ = estimate_sphere_count(domain_, foreseen, options_);
  if (estimate_ <= affordable()) return;
  const double in_memory = memory_bytes() / kBytesPerVertex<D>;
  std::vector<CostlyFeature<D>> features;
  if (std::isfinite(estimate_)) features = estimate_costliest_features(domain_, foreseen, options_);
  std::string fix = "ask for larger sizes";
  if (!features.empty()) fix += ", or mend the places listed: join, part or remove what comes near there";
  if (estimate_ > static_cast<double>(options_.max_vertices)) {
    if (kRoom * estimate_ <= in_memory)
      fix += fmt::format(", or raise --max-vertices to {:.0f}", rounded_up(kRoom * estimate_));
    else
      fix += fmt::format("; with the memory of this machine --max-vertices can be {:.0f}", rounded_up(in_memory));
    throw LimitError(Fault{.id = "packing.too_many_vertices",
                           .message = fmt::format("the mesh would have {}; the limit is {}{}", many<D>(estimate_),
                                                  options_.max_vertices, listed(features, domain_)),
                           .fix = std::move(fix)});
  }
  throw LimitError(
      Fault{.id = "packing.too_little_memory",
            .message = fmt::format("the mesh would have {} and need {:.3g} GB of memory; the machine has {:.3g} GB{}",
                                   many<D>(estimate_), estimate_ * kBytesPerVertex<D> / 1e9, memory_bytes() / 1e9,
                                   listed(features, domain_)),
            .fix = fix + ", or use a machine with more memory"});
}

template <int D>
void Budget<D>::check_again(const Spacing<D>& f, std::size_t n_boundary) {
  estimate_ = std::max(estimate_, static_cast<double>(n_boundary));
  if (kMostGrowth * estimate_ > affordable()) check(f);
}

template class Budget<2>;
template class Budget<3>;

}  // namespace voropack
