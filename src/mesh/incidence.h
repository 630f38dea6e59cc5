// From "which vertices has simplex s" to "which simplices has vertex v".
#pragma once

#include <array>
#include <cstddef>

#include "voropack/index.h"

namespace voropack {

/// Row v lists, in ascending order, the rows of `tuples` that contain v. O(n), sequential: a counting sort.
template <class V, class S, std::size_t N>
Csr<V, S> invert_incidence(const IdVector<S, std::array<V, N>>& tuples, std::size_t n_values) {
  Csr<V, S> rows;
  // offsets[v + 2] counts row v, so that offsets[v + 1] is where row v grows while it is filled.
  rows.offsets.assign(n_values + 2, 0);
  for (const std::array<V, N>& tuple : tuples)
    for (const V v : tuple) ++rows.offsets[v.value() + std::size_t{2}];
  for (std::size_t v = 2; v < rows.offsets.size(); ++v) rows.offsets[v] += rows.offsets[v - 1];
  rows.values.resize(tuples.size() * N);
  for (const S s : ids(tuples))
    for (const V v : tuples[s]) rows.values[rows.offsets[v.value() + std::size_t{1}]++] = s;
  rows.offsets.pop_back();
  return rows;
}

}  // namespace voropack
