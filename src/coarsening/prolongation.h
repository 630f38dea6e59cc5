// Barycentric interpolation from a coarse mesh to the vertices of a finer one.
#pragma once

#include <vector>

#include "voropack/linear_system.h"
#include "voropack/mesh.h"

namespace voropack {

/// `coarse_of`: for each vertex of the finer mesh the coarse vertex that it is, or none. Vertices outside of the coarse
/// mesh are interpolated from the nearest point of the simplex that is nearest.
template <int D>
SparseMatrix barycentric_prolongation(const Mesh<D>& coarse, const Mesh<D>& fine,
                                      const std::vector<VertexId>& coarse_of);

}  // namespace voropack
