// Coarsening rests on the finest mesh being Delaunay: nearest vertices share edges, and holes in it are no larger than
// its circumballs.
#pragma once

#include "voropack/mesh.h"

namespace voropack {

/// Throws InputError coarsen.not_delaunay where the vertex beyond a face lies inside of a simplex's circumball, or on
/// the simplex's own side of the face. O(n), in parallel.
template <int D>
void require_delaunay(const Mesh<D>& mesh);

}  // namespace voropack
