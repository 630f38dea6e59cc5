// Meshes for tests that do not want the mesher: Delaunay triangulations of given points by CGAL.
#pragma once

#include <functional>
#include <vector>

#include "voropack/mesh.h"

namespace voropack::test {

/// Fills simplex_neighbors by sorting faces, and lists as boundary every face whose two sides differ. Slow and plain.
template <int D>
void connect(Mesh<D>& mesh);

/// The Delaunay triangulation of `points` without flat simplices; `region_of` gets the mean of a simplex's corners.
template <int D>
Mesh<D> delaunay_mesh(
    const std::vector<Vec<D>>& points,
    const std::function<int(const Vec<D>&)>& region_of = [](const Vec<D>&) { return 1; });

/// The (n+1)^D points of a grid of the unit cube, each moved by at most eps/n per coordinate: points of the cube's
/// faces within them, points of the plane x = 1/2 within it if `keep_middle` (n even).
template <int D>
std::vector<Vec<D>> perturbed_grid(int n, double eps, std::uint64_t seed = 1, bool keep_middle = false);

}  // namespace voropack::test
