// Norms and errors on functions whose norms are known.
#include "voropack/norms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/delaunay_mesh.h"
#include "support/grid_mesh.h"
#include "voropack/dual.h"
#include "voropack/quality.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

template <int D>
VertexValues values_of(const Mesh<D>& mesh, const auto& function) {
  VertexValues values;
  for (const Vec<D>& x : mesh.points) values.push_back(function(x));
  return values;
}

TEST(Norms, HullVerticesAreThoseOnTheCube) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(5, 0.1));
  const VertexFlags hull = find_hull_vertices(mesh);
  for (const VertexId v : ids(mesh.points)) {
    bool on_cube = false;
    for (const double x : mesh.points[v].coord) on_cube |= x == 0 || x == 1;
    EXPECT_EQ(hull[v] != 0, on_cube);
  }
}

TEST(Norms, InterfacesAreNotHull) {
  const Mesh<2> mesh = delaunay_mesh<2>(perturbed_grid<2>(4, 0.1, 1, true), [](const Vec<2>& x) { return x[0] < 0.5; });
  std::size_t n_hull = 0;
  for (const std::uint8_t flag : find_hull_vertices(mesh)) n_hull += flag;
  EXPECT_EQ(n_hull, 16U);
}

TEST(Norms, WOfACoordinateIsTheVolume) {
  // By the closure of the cells, the sum of A h n_z^2 is the area of the face z = 1, if no edge is left out.
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(5, 0.2));
  const ControlVolumes<3> volumes = build_control_volumes(mesh);
  const VertexValues linear = values_of(mesh, [](const Vec<3>& x) { return 1 - 3 * x[2]; });
  EXPECT_NEAR(w_norm(volumes, linear, VertexFlags(mesh.points.size(), 0)), 3, 1e-12);
  // The reference's convention: edges within the boundary do not count.
  const double w = w_norm(volumes, linear, find_hull_vertices(mesh));
  EXPECT_LT(w, 3);
  EXPECT_GT(w, 2);
}

TEST(Norms, WProductIsBilinear) {
  const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(6, 0.2));
  const ControlVolumes<2> volumes = build_control_volumes(mesh);
  const VertexFlags none(mesh.points.size(), 0);
  const EdgeValues a = difference_quotients(volumes, values_of(mesh, [](const Vec<2>& x) { return x[0]; }));
  const EdgeValues b = difference_quotients(volumes, values_of(mesh, [](const Vec<2>& x) { return x[1]; }));
  EXPECT_NEAR(w_product(volumes, a, b, none), 0, 1e-14);  // As the gradients of x and y.
  EXPECT_NEAR(w_product(volumes, a, a, none), 1, 1e-13);
}

TEST(Norms, L2OfAPolynomial) {
  // u_h = 0: the norm of x y over the unit square is 1/3.
  const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(3, 0.2));
  EXPECT_NEAR(l2_error<2>(mesh, VertexValues(mesh.points.size(), 0.0), [](const Vec<2>& x) { return x[0] * x[1]; }),
              1.0 / 3, 1e-14);
}

TEST(Norms, H1OfAPolynomial) {
  // grad of x y z: the integral of y^2 z^2 + x^2 z^2 + x^2 y^2 over the unit cube is 1/3.
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(3, 1e-6));
  const std::function<Vec<3>(const Vec<3>&)> gradient = [](const Vec<3>& x) {
    return Vec<3>(x[1] * x[2], x[0] * x[2], x[0] * x[1]);
  };
  const VertexValues zero(mesh.points.size(), 0.0);
  EXPECT_NEAR(h1_error(mesh, zero, gradient), std::sqrt(1.0 / 3), 1e-13);
  EXPECT_EQ((h1_error<3>(mesh, zero, gradient, [](SimplexId) { return false; })), 0);
}

TEST(Norms, ErrorsOfALinearFunctionVanish) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(4, 0.1));
  const std::function<double(const Vec<3>&)> exact = [](const Vec<3>& x) { return 4 + x[0] - 3 * x[2]; };
  const VertexValues values = values_of(mesh, exact);
  EXPECT_NEAR(l2_error(mesh, values, exact), 0, 1e-14);
  EXPECT_NEAR((h1_error<3>(mesh, values, [](const Vec<3>&) { return Vec<3>(1, 0, -3); })), 0, 1e-12);
  EXPECT_EQ(max_norm(vertex_errors(mesh.points, values, exact)), 0);
}

TEST(Norms, MaximumDoesNotHideNaN) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(max_norm(VertexValues(std::vector<double>{1, -3, 2})), 3);
  EXPECT_TRUE(std::isnan(max_norm(VertexValues(std::vector<double>{1, nan, 2}))));
}

template <int D>
void expect_mean_fluxes_of_a_linear_function(const Mesh<D>& mesh) {
  const ControlVolumes<D> volumes = build_control_volumes(mesh);
  Vec<D> slope;
  for (int k = 0; k < D; ++k) slope[k] = 1 + k;
  const EdgeValues fluxes = mean_fluxes<D>(mesh, volumes, [&](const Vec<D>&) { return slope; });
  const EdgeValues quotients =
      difference_quotients(volumes, values_of(mesh, [&](const Vec<D>& x) { return dot(slope, x); }));
  for (const DualFaceId f : ids(fluxes))
    EXPECT_NEAR(volumes.face_area[f] * fluxes[f], volumes.face_area[f] * quotients[f], 1e-14);
}

TEST(Norms, MeanFluxesOfALinearFunctionAreItsDifferenceQuotients) {
  expect_mean_fluxes_of_a_linear_function(delaunay_mesh(perturbed_grid<2>(6, 0.3)));
  expect_mean_fluxes_of_a_linear_function(
      delaunay_mesh<2>(perturbed_grid<2>(6, 0.1, 1, true), [](const Vec<2>& x) { return x[0] < 0.5 ? 4 : 2; }));
  for (const double eps : {0.0, 1e-4, 0.2})
    expect_mean_fluxes_of_a_linear_function(delaunay_mesh(perturbed_grid<3>(5, eps)));
}

TEST(Norms, MeanFluxesOfAHarmonicFunctionBalanceInEachCellInside) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(8, 0.1));
  const ControlVolumes<3> volumes = build_control_volumes(mesh);
  const EdgeValues fluxes =
      mean_fluxes<3>(mesh, volumes, [](const Vec<3>& x) { return Vec<3>(2 * x[0] + x[1], x[0], -2 * x[2]); });
  VertexValues sum(mesh.points.size(), 0.0);
  for (const DualFaceId f : ids(fluxes)) {
    sum[volumes.face_vertices[f][0]] += volumes.face_area[f] * fluxes[f];
    sum[volumes.face_vertices[f][1]] -= volumes.face_area[f] * fluxes[f];
  }
  const VertexFlags hull = find_hull_vertices(mesh);
  for (const VertexId v : ids(sum)) {
    if (hull[v] == 0) {
      EXPECT_NEAR(sum[v], 0, 1e-15);
    }
  }
}

TEST(ShapeRatios, OfARegularSimplexAndOfASliver) {
  const auto one = [](std::vector<Vec<3>> points) {
    Mesh<3> mesh;
    mesh.points = IdVector<VertexId, Vec<3>>(std::move(points));
    mesh.simplex_vertices.push_back(
        {VertexId(std::size_t{0}), VertexId(std::size_t{1}), VertexId(std::size_t{2}), VertexId(std::size_t{3})});
    return max_shape_ratios(mesh);
  };
  const ShapeRatios regular = one({{1.0, 1.0, 1.0}, {-1.0, 1.0, -1.0}, {1.0, -1.0, -1.0}, {-1.0, -1.0, 1.0}});
  EXPECT_NEAR(regular.radius_ratio, 3, 1e-14);
  EXPECT_NEAR(regular.radius_edge, std::sqrt(3.0 / 8), 1e-15);
  // A square whose corners leave their plane by +-z: R tends to 1, the inradius to z.
  const ShapeRatios sliver = one({{1.0, 0.0, 1e-9}, {0.0, 1.0, -1e-9}, {0.0, -1.0, -1e-9}, {-1.0, 0.0, 1e-9}});
  EXPECT_NEAR(sliver.radius_ratio, 1e9, 1e-3);
  EXPECT_NEAR(sliver.radius_edge, std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(std::isinf(one({{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, -1.0, 0.0}, {-1.0, 0.0, 0.0}}).radius_ratio));
}

TEST(MinDihedral, OfAnythingFromRegularToAlmostFlat) {
  Mesh<3> mesh;
  mesh.simplex_vertices.push_back(
      {VertexId(std::size_t{0}), VertexId(std::size_t{1}), VertexId(std::size_t{2}), VertexId(std::size_t{3})});
  const auto angle = [&](std::vector<Vec<3>> points) {
    mesh.points = IdVector<VertexId, Vec<3>>(std::move(points));
    return min_dihedral_deg(mesh, SimplexId(std::size_t{0}));
  };
  EXPECT_NEAR(angle({{1.0, 1.0, 1.0}, {-1.0, 1.0, -1.0}, {1.0, -1.0, -1.0}, {-1.0, -1.0, 1.0}}),
              std::acos(1.0 / 3) * 180 / 3.14159265358979323846, 1e-12);
  // The corner of a box, z high: the triangle that cuts it off meets the base at atan(z sqrt 2).
  for (const double z : {1.0, 1e-3, 1e-9}) {
    const double expected = std::atan(z * std::sqrt(2.0)) * 180 / 3.14159265358979323846;
    EXPECT_NEAR(angle({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, z}}), expected, 1e-13 * expected);
  }
}

}  // namespace
}  // namespace voropack
