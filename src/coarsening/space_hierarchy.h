// Coarsening beyond the boundary in space: first all surfaces, from the finest to the coarsest one, then the vertices
// inside, from the coarsest level to the finest one.
#pragma once

#include <vector>

#include "voropack/coarsening.h"

namespace voropack {

/// `coarsen_beyond_boundary` in space, for options that are right and a mesh that is Delaunay.
std::vector<SimplifiedLevel<3>> make_space_hierarchy(const Mesh<3>& mesh, const BeyondBoundaryOptions& options,
                                                     Observer& observer);

}  // namespace voropack
