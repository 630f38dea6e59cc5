// f without caps: everything that is built once for a domain and its wishes.
#pragma once

#include <limits>

#include "spacing/polytope_set.h"
#include "spacing/region_locator.h"
#include "spacing/size_atoms.h"
#include "voropack/domain.h"

namespace voropack {

/// The family of functions whose minimum is f: disjoint pairs of polytopes, size atoms and one constant. Its search
/// works at every point of space; SpacingTree makes it fast inside the domain's box.
template <int D>
struct SpacingSources {
  SpacingSources(const Domain<D>& domain, PairWeights pair_weights, double slope)
      : polytopes(domain), locator(domain, polytopes), sizes(polytopes, locator, slope), weights(pair_weights) {}
  SpacingSources(const SpacingSources&) = delete;
  SpacingSources& operator=(const SpacingSources&) = delete;

  PolytopeSet<D> polytopes;
  RegionLocator<D> locator;
  SizeAtoms<D> sizes;
  PairWeights weights;
  double constant = std::numeric_limits<double>::infinity();

  /// min(bound, f(x)), by search.
  [[nodiscard]] double search(const Vec<D>& x, double bound) const {
    bound = sizes.minimum(x, std::min(bound, constant));
    return polytopes.smallest_pair_value(x, weights, bound);
  }
};

}  // namespace voropack
