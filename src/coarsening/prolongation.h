// How a level is connected with the next finer one: which vertices they share, and barycentric interpolation.
#pragma once

#include <vector>

#include "voropack/coarsening.h"
#include "voropack/mesh.h"

namespace voropack {

/// Fills in `finer_vertex` and `prolongation` of a level, of which the mesh and `finest_vertex` are known. `finer` is
/// the next finer level, nullptr where that is the finest mesh itself. Vertices outside of the level's mesh are
/// interpolated from the nearest point of the simplex that is nearest.
template <int D>
void link_level(const Mesh<D>& finest, const CoarseLevel<D>* finer, CoarseLevel<D>& level);

/// Rows of barycentric coordinates in `coarse` for the vertices of `fine`. `coarse_of`: for each of these the coarse
/// vertex that it is, or none.
template <int D>
SparseMatrix barycentric_prolongation(const Mesh<D>& coarse, const Mesh<D>& fine,
                                      const std::vector<VertexId>& coarse_of);

}  // namespace voropack
