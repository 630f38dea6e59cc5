// Inserts vertices with several threads, without locks and with the same simplices, in the same slots, for any number
// of threads.
//
// Space is cut into parts, and every vertex belongs to one. A part owns the simplices whose finite corners all belong
// to it; a simplex with corners in several parts has no owner. For each part one inserter at a time works through the
// vertices of the part, in the order of the sequential insertion. It changes only simplices that its part owns: where
// a cavity needs another one, or the walk to it leads across another one, the vertex is postponed. There are several
// such phases with different cuts, and each vertex is tried in the phase whose cuts are farthest from it. Postponed
// vertices are tried again in the next phase; the few that are left at the end wait for the sequential insertion.
//
// Why inserters do not meet. Let p be a part.
//  1. What an insertion makes belongs to p: the finite corners of a new simplex are the new vertex, which is in p, and
//     corners of a simplex that p owned.
//  2. A neighbor of a simplex of p belongs to p or to nobody, for the two share a finite corner (K >= 2).
//  3. A simplex without owner stays as it is during a phase, except for its entries of neighbors that have an owner,
//     each of which only this owner writes, and nobody reads.
// An inserter reads the corners of simplices of p and of their neighbors, which by 2 and 3 nobody else writes. It reads
// entries of neighbors of simplices of p, which only p writes, by 2. To test an infinite simplex without owner it also
// reads which simplex is beyond the finite face, and its corners; that one has no owner either, having all its finite
// corners, so neither entry nor corners change. Only simplices of p are marked as visited. Free slots are shared out
// before. `vertex_slot` is written for vertices of p only: a simplex that is destroyed has no other corner, but for the
// infinite vertex, whose entry each inserter keeps for itself.
//
// So what the inserter of p does depends on the simplices of p, its vertices and its free slots, and not on when the
// other inserters do their work. The parts depend on the points alone.
#pragma once

#include <cstdint>
#include <vector>

#include "geom/simplex_arrays.h"
#include "geom/vertex_inserter.h"

namespace voropack {

/// A triangulation of n_points points spread evenly has about so many simplices: 6.77 tetrahedra for each, or 2
/// triangles in the plane.
template <int K>
constexpr std::size_t expected_simplices(std::size_t n_points) {
  return K == 2 ? 2 * n_points : 69 * n_points / 10;
}

/// Inserting fewer vertices at a time in parallel is not worth while: too many have to be postponed.
template <int K>
inline constexpr std::size_t kLeastParallelRound = K == 2 ? 10'000 : 40'000;

/// Inserts vertices, given by their numbers in ascending order, into a triangulation that has about 1/8 as many at
/// least, spread like them. Returns those left over, in ascending order. `insertion` is the state of the sequential
/// insertion.
template <int K>
std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<K>& arrays, InsertionState<K>& insertion,
                                              const std::vector<std::uint32_t>& vertices);

/// A slot near the vertex from which it can be located, or kEmpty: that of one of the numbers before it.
template <int K, class Admits>
std::uint32_t slot_nearby(const SimplexArrays<K>& arrays, std::uint32_t vertex, Admits&& admits) {
  constexpr std::uint32_t kReach = 64;
  const std::uint32_t last = vertex > kReach ? vertex - kReach : 1;
  for (std::uint32_t v = vertex - 1; v >= last; --v)
    if (admits(v) && arrays.vertex_slot[v] != SimplexArrays<K>::kEmpty) return arrays.vertex_slot[v];
  return SimplexArrays<K>::kEmpty;
}

}  // namespace voropack
