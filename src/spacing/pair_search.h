// Nearest-first search for the disjoint pair of polytopes that matters at a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "spacing/pair_table.h"
#include "spacing/polytope_set.h"

namespace voropack {

struct PairSearch {
  double value;
  std::size_t n_met;  ///< Polytopes looked at: what the search cost.
};

/// The least of `bound` and the pairs' contributions at x. With a table, only its pairs are considered. Stops when it
/// has looked at `max_met` polytopes and some of them gave less than `bound`; then the value is an upper bound.
template <int D>
PairSearch search_pairs(const PolytopeSet<D>& polytopes, const PairTable<D>* table, PairWeights weights,
                        const Vec<D>& x, double bound, std::size_t max_met);

struct PairAt {
  double value;  ///< What the pair contributes at x.
  double gap;    ///< Its distance. Length.
  std::uint32_t p, q;
};

/// All pairs that contribute less than `limit` at x, among the `max_met` nearest polytopes. In no particular order.
template <int D>
std::vector<PairAt> pairs_below(const PolytopeSet<D>& polytopes, const PairTable<D>* table, PairWeights weights,
                                const Vec<D>& x, double limit, std::size_t max_met);

}  // namespace voropack
