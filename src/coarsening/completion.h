// Completes a packed level at circumcenters, as algorithm PACKING does, as far as the finest mesh has vertices there.
#pragma once

#include "coarsening/fine_mesh.h"
#include "coarsening/level_packer.h"

namespace voropack {

/// Triangulates the level. Where a circumcenter leaves room for another sphere, or a simplex that no sharp feature
/// explains has R / l > 2.5, the nearest vertex of the finest mesh joins, and f shrinks at it and its neighbors to what
/// fits; until there is no such simplex left that a vertex can help. Radii are b-Lipschitz in the end.
///
/// Returns where f would have to be smaller: the balls of those simplices that are left. Empty if the level is
/// Voronoi-maximal.
template <int D>
std::vector<SpacingCap<D>> complete_level(const FineMesh<D>& fine, double lipschitz, PackedLevel<D>& level,
                                          const Observer& observer);

}  // namespace voropack
