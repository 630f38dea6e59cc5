// The boundary in control volumes, by hand.
#include "voropack/boundary_areas.h"

#include <gtest/gtest.h>

#include "support/small_meshes.h"

namespace voropack {
namespace {

TEST(BoundaryAreas, HalvesOfEdgesInThePlane) {
  // The unit square: markers 1 to 4 around it from the bottom, an interface with marker 7, region 2 on the right.
  const BoundaryAreas<2> areas = build_boundary_areas(test::square_mesh());
  ASSERT_EQ(areas.patch_vertex.size(), 8U);
  for (const double area : areas.patch_area) EXPECT_EQ(area, 0.5);
  EXPECT_EQ(areas.patch_vertex.raw()[0], VertexId(0));
  EXPECT_EQ(areas.patch_marker.raw()[0], 1);
  EXPECT_EQ(areas.patch_centroid.raw()[0], (Vec<2>{0.25, 0.0}));
  EXPECT_EQ(areas.patch_marker.raw()[1], 4);
  EXPECT_EQ(areas.patch_vertex.raw()[3], VertexId(1));
  EXPECT_EQ(areas.patch_marker.raw()[3], 2);
  EXPECT_EQ(areas.patch_region.raw()[3], 2);
  EXPECT_EQ(areas.patch_centroid.raw()[3], (Vec<2>{1.0, 0.25}));
}

TEST(BoundaryAreas, KitesInSpace) {
  // Corner tetrahedron: three right triangles of area 1/2, in which the right angle's kite is a square of 1/4, and an
  // equilateral one of area sqrt(3)/2.
  Mesh<3> mesh;
  mesh.points = IdVector<VertexId, Vec<3>>(std::vector<Vec<3>>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  mesh.simplex_vertices.push_back({VertexId(0), VertexId(1), VertexId(2), VertexId(3)});
  mesh.simplex_region.push_back(5);
  build_neighbors(mesh);
  mesh.boundary_vertices.push_back({VertexId(3), VertexId(1), VertexId(2)});  // Markers of the others are unknown: 0.
  mesh.boundary_marker.push_back(8);
  const BoundaryAreas<3> areas = build_boundary_areas(mesh);
  ASSERT_EQ(areas.patch_vertex.size(), 7U);
  EXPECT_NEAR(areas.patch_area.raw()[0], 3 * 0.25, 1e-15);
  EXPECT_LT(distance(areas.patch_centroid.raw()[0], {1.0 / 6, 1.0 / 6, 1.0 / 6}), 1e-15);
  for (std::size_t k = 1; k < 7; k += 2) {
    EXPECT_EQ(areas.patch_marker.raw()[k], 0);
    EXPECT_NEAR(areas.patch_area.raw()[k], 2 * 0.125, 1e-15);
    EXPECT_EQ(areas.patch_marker.raw()[k + 1], 8);
    EXPECT_NEAR(areas.patch_area.raw()[k + 1], std::sqrt(3.0) / 6, 1e-15);
    EXPECT_EQ(areas.patch_region.raw()[k], 5);
  }
}

}  // namespace
}  // namespace voropack
