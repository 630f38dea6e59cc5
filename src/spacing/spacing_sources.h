// f without caps: everything that is built once for a domain and its wishes.
#pragma once

#include <limits>

#include "spacing/pair_search.h"
#include "spacing/pair_table.h"
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
      : polytopes(domain), locator(domain, polytopes), sizes(polytopes, locator, slope), weights(pair_weights) {
    // Otherwise the table would be long, for want of cutoffs.
    constexpr double kLargestRatio = 4;
    if (weights.slope <= kLargestRatio * weights.gap) table = PairTable<D>(polytopes, weights);
  }
  SpacingSources(const SpacingSources&) = delete;
  SpacingSources& operator=(const SpacingSources&) = delete;

  PolytopeSet<D> polytopes;
  RegionLocator<D> locator;
  SizeAtoms<D> sizes;
  PairWeights weights;
  PairTable<D> table;  // Not built if the pairs' offsets are small: then they are found when needed.
  double constant = std::numeric_limits<double>::infinity();

  /// See search_pairs.
  [[nodiscard]] PairSearch pairs(const Vec<D>& x, double bound,
                                 std::size_t max_met = std::numeric_limits<std::size_t>::max()) const {
    return search_pairs(polytopes, table.is_built() ? &table : nullptr, weights, x, bound, max_met);
  }

  /// min(bound, f(x)), by search.
  [[nodiscard]] double search(const Vec<D>& x, double bound) const {
    bound = sizes.minimum(x, std::min(bound, constant));
    return pairs(x, bound).value;
  }
};

}  // namespace voropack
