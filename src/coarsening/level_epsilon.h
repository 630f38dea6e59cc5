// How far a level is from a maximal packing.
#pragma once

#include "voropack/mesh.h"

namespace voropack {

/// The least E with R (1 - b) <= (2 + E (1 + b)) f at every circumcenter, where f is as large as its slope allows; 0 if
/// the packing is Voronoi-maximal, more where a sphere fits or R / l is beyond what such packings keep.
template <int D>
double measured_epsilon(const Mesh<D>& mesh);

}  // namespace voropack
