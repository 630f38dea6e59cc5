// Small meshes with every kind of data, for tests of what reads, writes or checks meshes.
#pragma once

#include "voropack/mesh.h"

namespace voropack::test {

/// The unit square cut by both diagonals; the right-hand triangle is region 2, the others region 1. All data present.
inline Mesh<2> square_mesh() {
  const auto v = [](std::size_t i) { return VertexId(i); };
  Mesh<2> mesh;
  mesh.points = IdVector<VertexId, Vec<2>>(
      std::vector<Vec<2>>{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {1.0 / 3, 0.1 + 0.2}});
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, 3>>(std::vector<std::array<VertexId, 3>>{
      {v(0), v(1), v(4)}, {v(1), v(2), v(4)}, {v(2), v(3), v(4)}, {v(3), v(0), v(4)}});
  mesh.simplex_region = IdVector<SimplexId, int>(std::vector<int>{1, 2, 1, 1});
  mesh.boundary_vertices = IdVector<BoundaryId, std::array<VertexId, 2>>(std::vector<std::array<VertexId, 2>>{
      {v(0), v(1)}, {v(1), v(2)}, {v(2), v(3)}, {v(3), v(0)}, {v(1), v(4)}, {v(2), v(4)}});
  mesh.boundary_marker = IdVector<BoundaryId, int>(std::vector<int>{1, 2, 3, 4, 7, 7});
  mesh.vertex_spacing = IdVector<VertexId, double>(std::vector<double>{0.1, 0.2, 0.3, 1e-17 / 3, 2.0 / 3});
  mesh.vertex_marker = IdVector<VertexId, int>(std::vector<int>{1, 1, 2, 3, 0});
  mesh.vertex_carrier_dimension = IdVector<VertexId, std::uint8_t>(std::vector<std::uint8_t>{0, 0, 0, 0, 2});
  build_neighbors(mesh);
  return mesh;
}

/// Two tetrahedra on a common face, in the regions 5 and -3. All data present.
inline Mesh<3> two_tetrahedra() {
  const auto v = [](std::size_t i) { return VertexId(i); };
  Mesh<3> mesh;
  mesh.points = IdVector<VertexId, Vec<3>>(
      std::vector<Vec<3>>{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 0.1}, {0.3, 0.3, -1e10 / 3}});
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, 4>>(
      std::vector<std::array<VertexId, 4>>{{v(0), v(1), v(2), v(3)}, {v(1), v(0), v(2), v(4)}});
  mesh.simplex_region = IdVector<SimplexId, int>(std::vector<int>{5, -3});
  mesh.boundary_vertices =
      IdVector<BoundaryId, std::array<VertexId, 3>>(std::vector<std::array<VertexId, 3>>{{v(0), v(1), v(3)},
                                                                                         {v(3), v(2), v(1)},
                                                                                         {v(0), v(2), v(3)},
                                                                                         {v(0), v(1), v(4)},
                                                                                         {v(1), v(2), v(4)},
                                                                                         {v(0), v(2), v(4)},
                                                                                         {v(0), v(2), v(1)}});
  mesh.boundary_marker = IdVector<BoundaryId, int>(std::vector<int>{1, 2, 3, 4, 5, 6, -7});
  mesh.segment_edges =
      IdVector<EdgeId, std::array<VertexId, 2>>(std::vector<std::array<VertexId, 2>>{{v(0), v(1)}, {v(4), v(2)}});
  mesh.segment_edge_marker = IdVector<EdgeId, int>(std::vector<int>{11, 12});
  mesh.vertex_spacing = IdVector<VertexId, double>(std::vector<double>{0.1, 0.2, 0.3, 0.4, 5e-324});
  mesh.vertex_marker = IdVector<VertexId, int>(std::vector<int>{9, 0, 0, 0, -2147483647});
  mesh.vertex_carrier_dimension = IdVector<VertexId, std::uint8_t>(std::vector<std::uint8_t>{0, 1, 2, 3, 0});
  build_neighbors(mesh);
  return mesh;
}

}  // namespace voropack::test
