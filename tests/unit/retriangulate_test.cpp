// Meshes that are triangulated anew keep their regions, markers and volumes, or are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "support/cases.h"
#include "support/delaunay_mesh.h"
#include "support/faults.h"
#include "support/grid_mesh.h"
#include "voropack/certificate.h"
#include "voropack/delaunay.h"

namespace voropack {
namespace {

template <int D>
std::multiset<std::pair<std::array<VertexId, D>, int>> marked_faces(const Mesh<D>& mesh) {
  std::multiset<std::pair<std::array<VertexId, D>, int>> faces;
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    auto face = mesh.boundary_vertices[b];
    std::sort(face.begin(), face.end());
    faces.insert({face, mesh.boundary_marker[b]});
  }
  return faces;
}

template <int D>
std::map<int, double> volumes_by_region(const Mesh<D>& mesh) {
  std::map<int, double> volume;
  const auto cells = build_control_volumes(mesh);
  for (const CellId c : ids(cells.cell_volume)) volume[cells.cell_region[c]] += cells.cell_volume[c];
  return volume;
}

template <int D>
void a_conforming_mesh_comes_out_as_it_was() {
  for (const test::Case<D>& c : test::all_cases<D>()) {
    SCOPED_TRACE(c.name);
    const Mesh<D> mesh = make_mesh(c.input, test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.2 : 0.5)).mesh;
    const Mesh<D> again = retriangulate(mesh);
    EXPECT_EQ(find_mesh_fault(again), "");
    EXPECT_EQ(again.points, mesh.points);
    EXPECT_EQ(again.segment_edges, mesh.segment_edges);
    EXPECT_EQ(again.vertex_marker, mesh.vertex_marker);
    EXPECT_EQ(marked_faces(again), marked_faces(mesh));
    for (const auto& [region, volume] : volumes_by_region(mesh))
      EXPECT_NEAR(volumes_by_region(again)[region], volume, 1e-12);
  }
}
TEST(Retriangulate, AConformingMeshComesOutAsItWasInThePlane) { a_conforming_mesh_comes_out_as_it_was<2>(); }
TEST(Retriangulate, AConformingMeshComesOutAsItWasInSpace) { a_conforming_mesh_comes_out_as_it_was<3>(); }

double area_of(const Mesh<3>& mesh, const std::array<VertexId, 3>& face) {
  const Vec<3>& a = mesh.points[face[0]];
  return norm(cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a)) / 2;
}

std::map<int, double> areas_by_marker(const Mesh<3>& mesh) {
  std::map<int, double> area;
  for (const BoundaryId b : ids(mesh.boundary_vertices))
    area[mesh.boundary_marker[b]] += area_of(mesh, mesh.boundary_vertices[b]);
  return area;
}

/// Those of `names` that the mesh fails.
std::set<std::string> failed_checks(const Mesh<3>& mesh, const std::set<std::string>& names) {
  std::set<std::string> failed;
  for (const Certificate::Check& check : certify(mesh, build_control_volumes(mesh)).checks)
    if (names.contains(check.name) && !check.ok) failed.insert(check.name);
  return failed;
}

/// A structured mesh of two regions, with other diagonals in its faces than ties give.
Mesh<3> structured_cube() {
  Mesh<3> mesh = test::grid_mesh<3>(6);
  for (Vec<3>& x : mesh.points) x[0] = 1 - x[0];
  for (auto& corners : mesh.simplex_vertices) std::swap(corners[0], corners[1]);
  mesh.vertex_carrier_dimension.clear();  // Not those of its boundary.
  mesh.vertex_spacing.clear();
  build_neighbors(mesh);
  return mesh;
}

TEST(Retriangulate, TakesAnyDiagonalOfCocircularFaces) {
  const Mesh<3> mesh = structured_cube(), again = retriangulate(mesh);
  EXPECT_NE(marked_faces(again), marked_faces(mesh)) << "a case without other diagonals shows nothing";
  EXPECT_EQ(find_mesh_fault(again), "");
  EXPECT_EQ(again.boundary_vertices.size(), mesh.boundary_vertices.size());
  for (const auto& [marker, area] : areas_by_marker(mesh)) EXPECT_NEAR(areas_by_marker(again)[marker], area, 1e-12);
  for (const auto& [region, volume] : volumes_by_region(mesh))
    EXPECT_NEAR(volumes_by_region(again)[region], volume, 1e-12);
  const std::set<std::string> wanted = {"delaunay", "protecting_balls", "voronoi_containment", "volume_sum", "closure"};
  EXPECT_EQ(failed_checks(again, wanted), std::set<std::string>());
}

TEST(Retriangulate, KeepsFacesThatAreCoplanarUpToRounding) {
  // Turned, no face of the cube is exactly flat, and no two of its circles through four points are the same.
  Mesh<3> mesh = structured_cube();
  for (Vec<3>& x : mesh.points) {
    x = {0.8 * x[0] - 0.6 * x[1], 0.6 * x[0] + 0.8 * x[1], x[2]};
    x = {x[0], 0.28 * x[1] - 0.96 * x[2], 0.96 * x[1] + 0.28 * x[2]};
  }
  const Mesh<3> again = retriangulate(mesh);
  EXPECT_EQ(find_mesh_fault(again), "");
  EXPECT_EQ(again.boundary_vertices.size(), mesh.boundary_vertices.size());
  for (const auto& [marker, area] : areas_by_marker(mesh)) EXPECT_NEAR(areas_by_marker(again)[marker], area, 1e-12);
  for (const auto& [region, volume] : volumes_by_region(mesh))
    EXPECT_NEAR(volumes_by_region(again)[region], volume, 1e-12);
  EXPECT_EQ(failed_checks(again, {"delaunay"}), std::set<std::string>());
}

TEST(Retriangulate, RefusesFacesThatNoOthersTile) {
  // Two vertices so near to the interface, on its two sides, that the edge between them crosses it.
  Mesh<3> mesh = structured_cube();
  for (Vec<3>& x : mesh.points)
    if (std::abs(x[0] - 0.5) < 0.2 && x[0] != 0.5 && x[1] == 0.5 && x[2] == 0.5)
      x = {x[0] < 0.5 ? 0.48 : 0.52, 0.55, 0.58};
  EXPECT_EQ(test::fault_of<InputError>([&] { retriangulate(mesh); }).id, "mesh.boundary_lost");
}

/// The two triangles of the unit square along its diagonal from (0, 0), which moved corners make the wrong one.
Mesh<2> wrong_diagonal(int left_region, int diagonal_marker) {
  Mesh<2> mesh;
  mesh.points = IdVector<VertexId, Vec<2>>(std::vector<Vec<2>>{{-1, -1}, {1, 0}, {1.5, 1.5}, {0, 1}});
  const std::array<VertexId, 4> v = {VertexId(0), VertexId(1), VertexId(2), VertexId(3)};
  mesh.simplex_vertices.push_back({v[0], v[1], v[2]});
  mesh.simplex_vertices.push_back({v[0], v[2], v[3]});
  mesh.simplex_region.push_back(1);
  mesh.simplex_region.push_back(left_region);
  build_neighbors(mesh);
  for (std::size_t i = 0; i < 4; ++i) {
    mesh.boundary_vertices.push_back({v[i], v[(i + 1) % 4]});
    mesh.boundary_marker.push_back(static_cast<int>(i) + 1);
  }
  mesh.boundary_vertices.push_back({v[0], v[2]});
  mesh.boundary_marker.push_back(diagonal_marker);
  return mesh;
}

TEST(Retriangulate, FlipsWhatIsNotDelaunay) {
  const Mesh<2> mesh = retriangulate(wrong_diagonal(1, 0));
  EXPECT_EQ(mesh.simplex_vertices.size(), 2U);
  for (const auto& corners : mesh.simplex_vertices) {
    EXPECT_NE(std::find(corners.begin(), corners.end(), VertexId(1)), corners.end());
    EXPECT_NE(std::find(corners.begin(), corners.end(), VertexId(3)), corners.end());
  }
  EXPECT_EQ(mesh.boundary_vertices.size(), 4U);
  EXPECT_EQ(find_mesh_fault(mesh), "");
}

TEST(Retriangulate, RefusesLostBoundaries) {
  const auto refused = [](const Mesh<2>& mesh) { return test::fault_of<InputError>([&] { retriangulate(mesh); }).id; };
  EXPECT_EQ(refused(wrong_diagonal(1, 7)), "mesh.boundary_lost");  // A wall with a marker.
  EXPECT_EQ(refused(wrong_diagonal(2, 0)), "mesh.boundary_lost");  // An interface without.
}

TEST(Retriangulate, NoticesVolumeThatWasNotThere) {
  // A simplex that is missing inside is filled, as the gap of a flat one is; but this one has volume.
  const Mesh<3> mesh = test::delaunay_mesh(test::perturbed_grid<3>(4, 0.05));
  const auto whole = mesh.simplex_vertices.size();
  Mesh<3> gap = mesh;
  gap.simplex_vertices.raw().erase(gap.simplex_vertices.raw().begin() + 100);
  gap.simplex_region.raw().pop_back();
  build_neighbors(gap);
  EXPECT_EQ(test::fault_of<InputError>([&] { retriangulate(gap); }).id, "mesh.boundary_lost");
  EXPECT_EQ(retriangulate(mesh).simplex_vertices.size(), whole);
}

}  // namespace
}  // namespace voropack
