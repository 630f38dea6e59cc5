// Nearest-first search for the disjoint pair of polytopes that matters at a point.
#pragma once

#include <cstddef>

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

}  // namespace voropack
