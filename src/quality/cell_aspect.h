// R/r of Theorem 2.4 for every cell.
#pragma once

#include <vector>

#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// [n_cells] R/r of each cell, in the order of ControlVolumes::cell_vertex. R is the radius of the smallest ball around
/// the cell, r that of the largest ball in it (docs/theory/quality.md); a cell whose boundary is not convex at its
/// site gets a ball in a convex part of it, so that its R/r is an upper bound. Infinite for a cell without interior.
///
/// `circumcenters` are those of the mesh's simplices.
template <int D>
std::vector<double> cell_aspects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                                 const IdVector<SimplexId, Vec<D>>& circumcenters, Observer& observer);

}  // namespace voropack
