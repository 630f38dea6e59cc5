// How far two surfaces are from each other, not only at their vertices.
#pragma once

#include "voropack/mesh.h"

namespace voropack {

/// The Hausdorff distance between the boundary faces of two meshes, each of which is searched all over: at most 2 % too
/// small, or below 1 % of the diameter. Exact at vertices.
double surface_distance(const Mesh<3>& a, const Mesh<3>& b);

}  // namespace voropack
