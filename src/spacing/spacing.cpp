#include "voropack/spacing.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "spacing/cap_tree.h"
#include "spacing/integral.h"
#include "spacing/spacing_sources.h"
#include "spacing/spacing_tree.h"
#include "spacing/value_memory.h"
#include "spacing/wishes.h"

namespace voropack {

template <int D>
struct Spacing<D>::Impl {
  SpacingOptions options;
  std::shared_ptr<const SpacingSources<D>> sources;
  std::shared_ptr<const SpacingTree<D>> tree;
  std::vector<SpacingCap<D>> caps;
  BoxTree<D> cap_boxes;                        // Over the caps' balls.
  std::shared_ptr<const CapTree<D>> cap_tree;  // Where the tree is.
  std::shared_ptr<ValueMemory<D>> memory;      // Of f without caps: caps follow caps, and most places stay the same.

  /// f without caps.
  [[nodiscard]] double base_at(const Vec<D>& x) const {
    return tree->box().contains(x) ? (*tree)(x) : sources->search(x, std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] double cap_at(std::uint32_t i, const Vec<D>& x) const {
    return caps[i].value + options.gradation * std::max(0.0, distance(x, caps[i].center) - caps[i].radius);
  }
};

template <int D>
double Spacing<D>::operator()(const Vec<D>& x) const {
  const Impl& f = *impl_;
  if (f.caps.empty()) return f.base_at(x);
  const double base = f.memory->get(x, [&] { return f.base_at(x); });
  if (!f.cap_tree->box().contains(x))
    return f.cap_boxes.minimize(x, f.options.gradation, base, [&](std::uint32_t i) { return f.cap_at(i, x); });
  return f.cap_tree->minimum(x, base, [&](const Vec<D>& y) { return f.memory->get(y, [&] { return f.base_at(y); }); });
}

template <int D>
double Spacing<D>::lipschitz() const {
  return impl_->options.gradation;
}

template <int D>
double Spacing<D>::feature_factor() const {
  return impl_->options.feature_factor;
}

template <int D>
std::optional<double> Spacing<D>::constant_on(const Box<D>& box) const {
  const Impl& f = *impl_;
  const std::optional<double> base = f.tree->constant_on(box);
  if (!base) return std::nullopt;
  // A cap can be less than the base somewhere in the box only if it is less than `bound` at the center.
  const double b = f.options.gradation;
  const double bound = *base + b * 0.5 * box.diagonal();
  const double caps =
      f.cap_boxes.minimize(box.center(), b, bound, [&](std::uint32_t i) { return f.cap_at(i, box.center()); });
  return caps < bound ? std::nullopt : base;
}

template <int D>
Spacing<D> Spacing<D>::with_caps(const std::vector<SpacingCap<D>>& caps) const {
  auto impl = std::make_shared<Impl>(*impl_);
  impl->caps.insert(impl->caps.end(), caps.begin(), caps.end());
  std::vector<Box<D>> boxes;
  std::vector<double> values;
  for (const SpacingCap<D>& cap : impl->caps) {
    Box<D> box(cap.center, cap.center);
    box.inflate(cap.radius);
    boxes.push_back(box);
    values.push_back(cap.value);
  }
  impl->cap_boxes = BoxTree<D>(boxes, values);
  impl->cap_tree = std::make_shared<CapTree<D>>(impl->tree->box(), impl->caps, impl->options.gradation);
  return Spacing(std::move(impl));
}

template <int D>
double Spacing<D>::integral(const Domain<D>& domain) const {
  return integrate_density(domain, impl_->sources->locator, *this);
}

template <int D>
std::vector<IntegralSample<D>> Spacing<D>::integral_samples(const Domain<D>& domain) const {
  return sample_density(domain, impl_->sources->locator, *this);
}

template <int D>
double Spacing<D>::wished(const Vec<D>& x) const {
  return impl_->sources->sizes.minimum(x, impl_->sources->constant);
}

template <int D>
std::vector<SpacingCause> Spacing<D>::causes(const Vec<D>& x, double reach) const {
  // The pair that decides has to be found wherever it is; of those that come next, the nearest are enough.
  constexpr std::size_t kMaxMet = 64, kAll = std::numeric_limits<std::size_t>::max();
  constexpr double kRounding = 1 + 1e-9;  // The tree and the search round distances differently.
  const SpacingSources<D>& sources = *impl_->sources;
  const double value = (*this)(x), wish = wished(x);
  std::vector<SpacingCause> result;
  if (!(value * kRounding < wish)) return result;
  const double limit = std::min(wish, reach * value);
  const PairTable<D>* const table = sources.table.is_built() ? &sources.table : nullptr;
  const auto find_pairs = [&](double below, std::size_t max_met) {
    return pairs_below(sources.polytopes, table, sources.weights, x, below, max_met);
  };
  std::vector<PairAt> pairs = find_pairs(limit, kMaxMet);
  const auto decides = [&](const PairAt& pair) { return pair.value <= value * kRounding; };
  if (std::none_of(pairs.begin(), pairs.end(), decides))
    for (const PairAt& pair : find_pairs(value * kRounding, kAll)) pairs.push_back(pair);
  for (const PairAt& pair : pairs)
    result.push_back(
        {pair.value,
         {sources.polytopes.id_of(std::min(pair.p, pair.q)), sources.polytopes.id_of(std::max(pair.p, pair.q))},
         pair.gap,
         false});
  const Impl& f = *impl_;
  f.cap_boxes.minimize(x, f.options.gradation, limit, [&](std::uint32_t i) {
    const SpacingCap<D>& cap = f.caps[i];
    const double at = f.cap_at(i, x);
    if (cap.between && at < limit) result.push_back({at, *cap.between, cap.radius, true});
    return limit;  // All of them are wanted.
  });
  std::sort(result.begin(), result.end(), [](const SpacingCause& a, const SpacingCause& b) {
    return std::tuple(a.value, a.polytopes, a.is_cap) < std::tuple(b.value, b.polytopes, b.is_cap);
  });
  return result;
}

template <int D>
Spacing<D> build_spacing(const Domain<D>& domain, const SizeWishes<D>& wishes, const SpacingOptions& options,
                         Observer& observer) {
  check_spacing_options(options);
  const double diameter = domain.diameter();
  if (!(std::isfinite(diameter) && diameter > 0))
    throw OptionError(Fault{.id = "spacing.unbounded",
                            .message = "nothing bounds the spacing, because the domain has no extent",
                            .fix = "give a domain with at least one region"});
  const double a = options.feature_factor;
  const double b = options.gradation;
  auto sources =
      std::make_shared<SpacingSources<D>>(domain, PairWeights{std::min(a, b), std::max(0.0, 0.5 * (a - b))}, b);
  const double everywhere =
      add_wishes(domain, wishes, options, sources->polytopes, sources->locator, sources->sizes, observer);
  sources->sizes.finish();
  // a * lfs never exceeds a * diameter inside the box, so this binds only where there is no disjoint pair.
  sources->constant = std::min(everywhere, a * diameter);
  auto impl = std::make_shared<typename Spacing<D>::Impl>();
  impl->options = options;
  impl->tree = std::make_shared<SpacingTree<D>>(domain, *sources, observer);
  impl->memory = std::make_shared<ValueMemory<D>>();
  impl->sources = std::move(sources);
  return Spacing<D>(std::move(impl));
}

#define VOROPACK_INSTANTIATE(D) \
  template class Spacing<D>;    \
  template Spacing<D> build_spacing<D>(const Domain<D>&, const SizeWishes<D>&, const SpacingOptions&, Observer&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
