// The meshes of Figure 3 of [Miller1996]: grids of the unit cube whose points are moved a little, which makes slivers.
#pragma once

#include <cstdint>
#include <vector>

#include "voropack/mesh.h"

namespace voropack::app {

/// The (n+1)^3 points of a grid of width h = 1/n, each moved by an independent displacement that is uniform in
/// [-eps h, eps h] per coordinate. Points of a face or edge of the cube move within it, corners do not move.
std::vector<Vec<3>> perturbed_cube_points(std::uint32_t n, double eps, std::uint64_t seed);

/// Their Delaunay triangulation. The points of a face of the cube lie exactly in its plane and no simplex is flat, so
/// that none has its four vertices in one face.
Mesh<3> delaunay_mesh(const std::vector<Vec<3>>& points);

}  // namespace voropack::app
