// The areas against exact rational circumcenters, from fat simplices to slivers as flat as doubles can be.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "support/delaunay_mesh.h"
#include "support/rational.h"
#include "voropack/dual.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

/// Every area equals the exact one to 1e-12 h^(D-1), has its sign, and an area that is not listed is below that.
template <int D>
void expect_areas_exact(const Mesh<D>& mesh) {
  const auto volumes = build_control_volumes(mesh);
  auto exact = test::exact_areas(mesh);
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const auto place = exact.find({i, j, volumes.face_region[f]});
    ASSERT_NE(place, exact.end());
    const double h = distance(mesh.points[i], mesh.points[j]);
    EXPECT_DOUBLE_EQ(volumes.face_edge_length[f], h);
    const double expected = place->second.get_d() / (D == 3 ? 2 * h : h);
    EXPECT_NEAR(volumes.face_area[f], expected, 1e-12 * std::pow(h, D - 1));
    exact.erase(place);
  }
  EXPECT_EQ(exact.size(), volumes.n_zero_areas);
  for (const auto& [key, value] : exact) {
    const double h = distance(mesh.points[std::get<0>(key)], mesh.points[std::get<1>(key)]);
    EXPECT_LT(std::abs(value.get_d()) / h, 1e-12 * std::pow(h, D - 1));
  }
}

TEST(DualReference, AreasOfPerturbedCubesAreExact) {
  for (const double eps : {1e-1, 1e-2, 1e-6, 1e-10, 1e-14, 0.0}) {
    SCOPED_TRACE(eps);
    expect_areas_exact(delaunay_mesh(perturbed_grid<3>(2, eps, 5)));
  }
}

TEST(DualReference, AreasOfPerturbedSquaresAreExact) {
  for (const double eps : {1e-1, 1e-2, 1e-4, 1e-8, 1e-14, 0.0}) {
    SCOPED_TRACE(eps);
    expect_areas_exact(delaunay_mesh(perturbed_grid<2>(6, eps, 5)));
  }
}

TEST(DualReference, AreasAreExactRegionByRegion) {
  const auto region = [](const Vec<3>& x) { return x[0] < 0.5 ? 7 : 3; };
  for (const double eps : {1e-2, 1e-14})
    expect_areas_exact(delaunay_mesh<3>(perturbed_grid<3>(2, eps, 2, true), region));
}

TEST(DualReference, SignsAreExactWhenNoAreaIsLarge) {
  // Grid coordinates that are not dyadic: every dual edge inside a cube is rounding noise with a definite sign.
  auto points = perturbed_grid<3>(2, 0);
  for (auto& p : points) p = Vec<3>{0.1, 0.7, -0.3} + 0.1 * p;
  const auto mesh = delaunay_mesh(points);
  const auto volumes = build_control_volumes(mesh);
  auto exact = test::exact_areas(mesh);
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const double h = volumes.face_edge_length[f];
    EXPECT_NEAR(volumes.face_area[f], exact[std::make_tuple(i, j, 1)].get_d() / (2 * h), 1e-12 * h * h);
  }
}

TEST(DualReference, NegativeAreasOfAMeshThatIsNotDelaunayAreReported) {
  // The wrong diagonal of a kite.
  Mesh<2> mesh;
  for (const Vec<2>& p : {Vec<2>{0, 0}, Vec<2>{1, -0.2}, Vec<2>{2, 0}, Vec<2>{1, 0.2}}) mesh.points.push_back(p);
  mesh.simplex_vertices.push_back({VertexId(0), VertexId(1), VertexId(2)});
  mesh.simplex_vertices.push_back({VertexId(0), VertexId(2), VertexId(3)});
  mesh.simplex_region.resize(2, 1);
  test::connect(mesh);
  const auto volumes = build_control_volumes(mesh);
  double least = 0, sum = 0;
  for (const double a : volumes.face_area) least = std::min(least, a);
  for (const double v : volumes.cell_volume) sum += v;
  EXPECT_LT(least, -1);
  EXPECT_NEAR(sum, 0.4, 1e-14);
  expect_areas_exact(mesh);
}

TEST(DualReference, RandomPointsWhoseHullIsNotConformingGetSignedAreas) {
  std::vector<Vec<3>> points;
  Random random(3);
  for (int k = 0; k < 25; ++k) points.push_back({random.unit(), random.unit(), random.unit()});
  const auto mesh = delaunay_mesh(points);
  const auto volumes = build_control_volumes(mesh);
  auto exact = test::exact_areas(mesh);
  std::size_t n_negative = 0;
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const double h = volumes.face_edge_length[f];
    const double expected = exact[std::make_tuple(i, j, 1)].get_d() / (2 * h);
    EXPECT_NEAR(volumes.face_area[f], expected, 1e-12 * std::abs(expected) + 1e-11 * h);
    n_negative += volumes.face_area[f] < 0 ? 1U : 0U;
    EXPECT_EQ(volumes.face_area[f] < 0, expected < 0);
  }
  EXPECT_GT(n_negative, 0U);
}

}  // namespace
}  // namespace voropack
