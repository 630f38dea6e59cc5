#include "perturbed_cube.h"

#include <random>

#include "voropack/delaunay.h"

namespace voropack::app {

namespace {

/// Uniform in [-1, 1) with 53 bits: the standard's distributions differ between libraries, its generators do not.
double draw(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1.0p-52 - 1; }

}  // namespace

std::vector<Vec<3>> perturbed_cube_points(std::uint32_t n, double eps, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Vec<3>> points;
  points.reserve(std::size_t{n + 1} * (n + 1) * (n + 1));
  const auto place = [&](std::uint32_t step) {
    const double move = step == 0 || step == n ? 0.0 : eps * draw(random);
    return (step + move) / n;
  };
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j)
      for (std::uint32_t k = 0; k <= n; ++k) {
        const double x = place(i), y = place(j), z = place(k);
        points.push_back({x, y, z});
      }
  return points;
}

Mesh<3> delaunay_mesh(const std::vector<Vec<3>>& points) {
  const Triangulation<3> triangulation = delaunay_triangulation(points);
  Mesh<3> mesh;
  mesh.points = IdVector<VertexId, Vec<3>>(points);
  for (const auto& simplex : triangulation.simplices) {
    std::array<VertexId, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = VertexId(simplex[i]);
    mesh.simplex_vertices.push_back(corners);
  }
  mesh.simplex_region = IdVector<SimplexId, int>(mesh.simplex_vertices.size(), 1);
  build_neighbors(mesh);
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    // Counterclockwise seen from outside.
    const std::array<std::array<VertexId, 3>, 4> faces = {
        {{c[1], c[2], c[3]}, {c[0], c[3], c[2]}, {c[0], c[1], c[3]}, {c[0], c[2], c[1]}}};
    for (std::size_t i = 0; i < 4; ++i) {
      if (!mesh.simplex_neighbors[s][i].is_none()) continue;
      mesh.boundary_vertices.push_back(faces[i]);
      mesh.boundary_marker.push_back(0);
    }
  }
  return mesh;
}

}  // namespace voropack::app
