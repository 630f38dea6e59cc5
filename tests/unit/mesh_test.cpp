#include "voropack/mesh.h"

#include <gtest/gtest.h>

#include "support/small_meshes.h"
#include "voropack/error.h"

namespace voropack {
namespace {

using test::square_mesh;
using test::two_tetrahedra;

VertexId v(std::size_t i) { return VertexId(i); }

template <class Fn>
std::string error_id(Fn&& fn) {
  try {
    fn();
  } catch (const Error& error) {
    EXPECT_FALSE(error.faults().front().fix.empty());
    return error.id();
  }
  return "no error";
}

TEST(BuildNeighbors, FindsTheFaceOppositeToEachCorner) {
  const Mesh<2> mesh = square_mesh();
  // Triangle 0 is (0, 1, 4): opposite to 0 lies triangle 1, opposite to 1 triangle 3, opposite to 4 the hull.
  EXPECT_EQ(mesh.simplex_neighbors[SimplexId(std::size_t{0})],
            (std::array{SimplexId(std::size_t{1}), SimplexId(std::size_t{3}), SimplexId::none()}));
  const Mesh<3> pair = two_tetrahedra();
  EXPECT_EQ(pair.simplex_neighbors[SimplexId(std::size_t{0})],
            (std::array{SimplexId::none(), SimplexId::none(), SimplexId::none(), SimplexId(std::size_t{1})}));
}

TEST(BuildNeighbors, RejectsThreeSimplicesOnOneFace) {
  Mesh<2> mesh = square_mesh();
  mesh.points.push_back({0.9, 0.9});
  mesh.simplex_vertices.push_back({v(1), v(5), v(4)});
  EXPECT_EQ(error_id([&] { build_neighbors(mesh); }), "mesh.nonmanifold");
}

TEST(BuildNeighbors, RejectsTwoSimplicesOnTheSameSideOfAFace) {
  Mesh<3> mesh = two_tetrahedra();
  mesh.simplex_vertices[SimplexId(std::size_t{1})] = {v(0), v(1), v(2), v(4)};
  EXPECT_EQ(error_id([&] { build_neighbors(mesh); }), "mesh.overlapping_simplices");
}

TEST(FindMeshFault, AcceptsSoundMeshes) {
  EXPECT_EQ(find_mesh_fault(square_mesh()), "");
  EXPECT_EQ(find_mesh_fault(two_tetrahedra()), "");
  EXPECT_EQ(find_mesh_fault(Mesh<2>{}), "");
}

TEST(FindMeshFault, NoticesEachBrokenInvariant) {
  const auto fault_after = [](auto&& change) {
    Mesh<3> mesh = two_tetrahedra();
    change(mesh);
    return find_mesh_fault(mesh);
  };
  const SimplexId first(std::size_t{0});
  EXPECT_NE(fault_after([&](auto& m) { std::swap(m.simplex_vertices[first][0], m.simplex_vertices[first][1]); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.simplex_vertices[first][0] = v(1); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.simplex_vertices[first][0] = v(99); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.simplex_neighbors[first][3] = SimplexId::none(); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.simplex_region.clear(); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.vertex_spacing.resize(3); }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.vertex_carrier_dimension[v(0)] = 4; }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.points[v(0)][0] = std::nan(""); }), "");
  // The interface is the last face.
  EXPECT_NE(fault_after([&](auto& m) {
              m.boundary_vertices.resize(6);
              m.boundary_marker.resize(6);
            }),
            "");
  EXPECT_NE(fault_after([&](auto& m) { m.boundary_vertices.back() = m.boundary_vertices[BoundaryId(std::size_t{0})]; }),
            "");
  EXPECT_NE(fault_after([&](auto& m) {
              m.boundary_vertices.push_back({v(0), v(3), v(4)});
              m.boundary_marker.push_back(1);
            }),
            "");
  EXPECT_NE(fault_after([&](auto& m) { m.segment_edges.back() = {v(3), v(4)}; }), "");
  EXPECT_NE(fault_after([&](auto& m) { m.segment_edges.back() = {v(1), v(0)}; }), "");
}

TEST(FindMeshFault, NoticesDuplicateSimplices) {
  Mesh<2> mesh = square_mesh();
  mesh.simplex_vertices.push_back({v(4), v(0), v(1)});
  mesh.simplex_neighbors.push_back({});
  mesh.simplex_region.push_back(1);
  EXPECT_NE(find_mesh_fault(mesh), "");
}

}  // namespace
}  // namespace voropack
