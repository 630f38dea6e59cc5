// How a level is connected with the next finer one: which vertices they share, and barycentric interpolation.
#pragma once

#include "voropack/coarsening.h"
#include "voropack/mesh.h"

namespace voropack {

/// Fills in `finer_vertex` and `prolongation` of a level, of which the mesh and `finest_vertex` are known. `finer` is
/// the next finer level, nullptr where that is the finest mesh itself. Vertices outside of the level's mesh are
/// interpolated from the nearest point of the simplex that is nearest.
template <int D>
void link_level(const Mesh<D>& finest, const CoarseLevel<D>* finer, CoarseLevel<D>& level);

}  // namespace voropack
