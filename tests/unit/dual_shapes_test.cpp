// The cells' polyhedra and polygons: closed, and of the volumes that the areas say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "support/delaunay_mesh.h"
#include "voropack/dual.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

double polygon_area(const CellShapes<2>& shapes, CellId c) {
  double twice = 0;
  const auto corners = shapes.cell_faces[c];
  for (std::size_t k = 0; k < corners.size(); ++k)
    twice += cross(shapes.points[corners[k]], shapes.points[corners[(k + 1) % corners.size()]]);
  return 0.5 * twice;
}

/// The faces of a cell, oriented outward: a face is stored outward of the first cell that lists it.
std::vector<std::vector<std::uint32_t>> outward_faces(const CellShapes<3>& shapes, CellId c,
                                                      std::vector<char>& listed) {
  std::vector<std::vector<std::uint32_t>> faces;
  for (const std::uint32_t f : shapes.cell_faces[c]) {
    const auto row = shapes.face_points[DualFaceId(f)];
    faces.emplace_back(row.begin(), row.end());
    if (listed[f] != 0) std::reverse(faces.back().begin(), faces.back().end());
    listed[f] = 1;
  }
  return faces;
}

double polyhedron_volume(const CellShapes<3>& shapes, const std::vector<std::vector<std::uint32_t>>& faces) {
  double six = 0;
  const Vec<3> origin = shapes.points[faces[0][0]];
  for (const auto& f : faces)
    for (std::size_t k = 1; k + 1 < f.size(); ++k)
      six += dot(shapes.points[f[0]] - origin, cross(shapes.points[f[k]] - origin, shapes.points[f[k + 1]] - origin));
  return six / 6;
}

/// Each edge is used as often in one direction as in the other.
bool is_closed(const std::vector<std::vector<std::uint32_t>>& faces) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (const auto& f : faces) {
    for (std::size_t k = 0; k < f.size(); ++k) {
      const auto a = f[k], b = f[(k + 1) % f.size()];
      if (a == b) return false;
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  return std::all_of(balance.begin(), balance.end(), [](const auto& entry) { return entry.second == 0; });
}

void expect_polyhedra(const Mesh<3>& mesh) {
  const auto volumes = build_control_volumes(mesh);
  const auto shapes = build_cell_shapes(mesh, volumes);
  ASSERT_EQ(shapes.cell_faces.size(), volumes.cell_vertex.size());
  std::vector<char> listed(shapes.face_points.size(), 0);
  std::vector<int> uses(shapes.face_points.size(), 0);
  for (const CellId c : ids(volumes.cell_vertex)) {
    const auto faces = outward_faces(shapes, c, listed);
    for (const auto& f : faces) EXPECT_GE(f.size(), 3U);
    EXPECT_TRUE(is_closed(faces)) << "cell " << c.value();
    EXPECT_NEAR(polyhedron_volume(shapes, faces), volumes.cell_volume[c], 1e-10 * volumes.cell_volume[c]);
    for (const std::uint32_t f : shapes.cell_faces[c]) ++uses[f];
  }
  std::set<std::uint32_t> used(shapes.face_points.values.begin(), shapes.face_points.values.end());
  EXPECT_EQ(used.size(), shapes.points.size());
  for (const int n : uses) EXPECT_TRUE(n == 1 || n == 2);
}

TEST(CellShapes, PolyhedraAreClosedAndHaveTheCellsVolumes) {
  for (const double eps : {1e-2, 1e-6, 1e-10, 1e-14, 0.0}) {
    SCOPED_TRACE(eps);
    expect_polyhedra(delaunay_mesh(perturbed_grid<3>(4, eps)));
  }
}

TEST(CellShapes, PolyhedraOfTwoRegionsShareTheInterface) {
  for (const double eps : {1e-2, 1e-12, 0.0})
    expect_polyhedra(
        delaunay_mesh<3>(perturbed_grid<3>(4, eps, 1, true), [](const Vec<3>& x) { return x[0] < 0.5 ? 7 : 3; }));
}

TEST(CellShapes, ARegionThatTouchesAnEdgeTwiceHasTwoFansThere) {
  // A chessboard of 2 x 2 columns: each region meets the middle edges in two wedges.
  expect_polyhedra(delaunay_mesh<3>(perturbed_grid<3>(2, 0.0),
                                    [](const Vec<3>& x) { return (x[0] < 0.5) == (x[1] < 0.5) ? 1 : 2; }));
}

TEST(CellShapes, CellsOfTheExactGridAreBoxes) {
  const auto mesh = delaunay_mesh(perturbed_grid<3>(4, 0));
  const auto volumes = build_control_volumes(mesh);
  const auto shapes = build_cell_shapes(mesh, volumes);
  for (const CellId c : ids(volumes.cell_vertex)) {
    const Vec<3>& p = mesh.points[volumes.cell_vertex[c]];
    if (p[0] > 0 && p[0] < 1 && p[1] > 0 && p[1] < 1 && p[2] > 0 && p[2] < 1) {
      EXPECT_EQ(shapes.cell_faces[c].size(), 6U);
      for (const auto f : shapes.cell_faces[c]) EXPECT_EQ(shapes.face_points[DualFaceId(f)].size(), 4U);
    }
  }
}

TEST(CellShapes, PolygonsAreCounterclockwiseAndHaveTheCellsAreas) {
  for (const double eps : {0.1, 1e-6, 1e-14, 0.0}) {
    const auto mesh =
        delaunay_mesh<2>(perturbed_grid<2>(6, eps, 3, true), [](const Vec<2>& x) { return x[0] < 0.5 ? 2 : 1; });
    const auto volumes = build_control_volumes(mesh);
    const auto shapes = build_cell_shapes(mesh, volumes);
    for (const CellId c : ids(volumes.cell_vertex)) {
      EXPECT_GE(shapes.cell_faces[c].size(), 3U);
      EXPECT_NEAR(polygon_area(shapes, c), volumes.cell_volume[c], 1e-10 * volumes.cell_volume[c]);
    }
  }
}

TEST(CellShapes, ARegionThatTouchesAVertexTwiceKeepsItsArea) {
  const auto mesh =
      delaunay_mesh<2>(perturbed_grid<2>(2, 0.0), [](const Vec<2>& x) { return (x[0] < 0.5) == (x[1] < 0.5) ? 1 : 2; });
  const auto volumes = build_control_volumes(mesh);
  const auto shapes = build_cell_shapes(mesh, volumes);
  for (const CellId c : ids(volumes.cell_vertex)) EXPECT_DOUBLE_EQ(polygon_area(shapes, c), volumes.cell_volume[c]);
}

}  // namespace
}  // namespace voropack
