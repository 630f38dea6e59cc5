// Laws of the control volume method on packed meshes: exact for linear functions, conservative, an M-matrix.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "base/parallel.h"
#include "support/allow_threads.h"
#include "support/balance_checks.h"
#include "support/cases.h"
#include "support/sharp_domains.h"
#include "voropack/diffusion.h"

namespace voropack {
namespace {

constexpr double kExact = 1e-12;  ///< Of linear functions, relative to their largest value.
using test::kBalance;

/// A linear function that varies in every direction.
template <int D>
struct Linear {
  Vec<D> gradient;
  Linear() {
    for (int k = 0; k < D; ++k) gradient[k] = 1.5 - k;
  }
  double operator()(const Vec<D>& x) const { return 2 + dot(gradient, x); }
};

template <int D>
std::set<int> markers_of(const BoundaryAreas<D>& boundary) {
  return {boundary.patch_marker.begin(), boundary.patch_marker.end()};
}

template <int D>
DiffusionProblem<D> dirichlet_everywhere(const BoundaryAreas<D>& boundary, BoundaryValue<D> value) {
  DiffusionProblem<D> problem;
  for (const int marker : markers_of(boundary)) problem.conditions[marker] = Dirichlet<D>{value};
  return problem;
}

template <int D>
double largest_error(const ControlVolumes<D>& volumes, const DiffusionSolution<D>& u, auto&& exact) {
  double error = 0, scale = 0;
  for (const VertexId v : ids(u.values)) {
    error = std::max(error, std::abs(u.values[v] - exact(volumes.sites[v])));
    scale = std::max(scale, std::abs(exact(volumes.sites[v])));
  }
  return error / scale;
}

template <int D>
void expect_balanced(const DiffusionSolution<D>& u) {
  test::expect_balanced(u.balances);
}

/// The outward normal of each marker of an axis-aligned box [0, hi].
template <int D>
std::map<int, Vec<D>> box_normals(const BoundaryAreas<D>& boundary, const Vec<D>& hi) {
  std::map<int, Vec<D>> normals;
  for (const int marker : markers_of(boundary))
    for (int k = 0; k < D; ++k)
      for (const double at : {0.0, hi[k]}) {
        const auto lies_there = [&](std::size_t p) {
          return boundary.patch_marker[PatchId(p)] != marker ||
                 std::abs(boundary.patch_centroid[PatchId(p)][k] - at) < 1e-12;
        };
        bool is_side = true;
        for (std::size_t p = 0; p < boundary.patch_marker.size(); ++p) is_side = is_side && lies_there(p);
        if (is_side) normals[marker][k] = at == 0 ? -1 : 1;
      }
  return normals;
}

template <int D>
void linear_functions_are_exact() {
  const Linear<D> exact;
  for (const test::Case<D>& c : test::all_cases<D>())
    for (const test::Filling& f : {test::all_fillings()[0], test::all_fillings()[1]}) {
      SCOPED_TRACE(c.name + ' ' + f.name);
      const auto result = make_mesh(c.input, test::meshing_options<D>(f, D == 2 ? 0.1 : 0.3));
      const auto boundary = build_boundary_areas(result.mesh);
      const auto u = solve(result.volumes, boundary, dirichlet_everywhere<D>(boundary, exact));
      EXPECT_LE(largest_error(result.volumes, u, exact), kExact);
      EXPECT_TRUE(u.matrix.is_m_matrix);
      expect_balanced(u);
    }
}
TEST(DiffusionProperty, LinearFunctionsAreExactInThePlane) { linear_functions_are_exact<2>(); }
TEST(DiffusionProperty, LinearFunctionsAreExactInSpace) { linear_functions_are_exact<3>(); }

/// Neumann and Robin conditions on all sides but one, from the exact solution; then Neumann conditions alone.
template <int D>
void linear_functions_are_exact_with_fluxes() {
  const Linear<D> exact;
  const double kappa = 2.5;
  for (const test::Filling& f : test::all_fillings()) {
    SCOPED_TRACE(f.name);
    const auto result = make_mesh(domains::unit_box<D>(), test::meshing_options<D>(f, D == 2 ? 0.08 : 0.25));
    const auto boundary = build_boundary_areas(result.mesh);
    const auto normals = box_normals<D>(boundary, domains::all<D>(1));
    ASSERT_EQ(normals.size(), 2U * D);
    DiffusionProblem<D> problem;
    problem.conductivity = kappa;
    for (const auto& [marker, normal] : normals) {
      const double inflow = kappa * dot(exact.gradient, normal);
      if (marker % 3 == 0)
        problem.conditions[marker] = Dirichlet<D>{exact};
      else if (marker % 3 == 1)
        problem.conditions[marker] = Neumann<D>{inflow};
      else  // kappa du/dn = alpha (outside - u) with an outside value that varies linearly.
        problem.conditions[marker] = Robin<D>{4.0, [=](const Vec<D>& x) { return exact(x) + inflow / 4.0; }};
    }
    const auto mixed = solve(result.volumes, boundary, problem);
    EXPECT_LE(largest_error(result.volumes, mixed, exact), kExact);
    expect_balanced(mixed);

    for (const auto& [marker, normal] : normals)
      problem.conditions[marker] = Neumann<D>{kappa * dot(exact.gradient, normal)};
    double mean = 0;
    for (const CellId c : ids(result.volumes.cell_vertex))
      mean += result.volumes.cell_volume[c] * exact(result.volumes.sites[result.volumes.cell_vertex[c]]);
    problem.mean = mean;
    const auto pure = solve(result.volumes, boundary, problem);
    EXPECT_LE(largest_error(result.volumes, pure, exact), kExact);
    EXPECT_LE(std::abs(pure.compensation), kExact);
    expect_balanced(pure);
    for (const MarkerFlux& flux : pure.fluxes) {
      EXPECT_NEAR(flux.area, 1, kExact);
      EXPECT_NEAR(flux.inflow, kappa * dot(exact.gradient, normals.at(flux.marker)), 10 * kExact);
    }
  }
}
TEST(DiffusionProperty, NeumannConditionsAreExactInThePlane) { linear_functions_are_exact_with_fluxes<2>(); }
TEST(DiffusionProperty, NeumannConditionsAreExactInSpace) { linear_functions_are_exact_with_fluxes<3>(); }

/// Two materials side by side in [0, 2] x [0, 1]^(D-1): u is linear in each, and its flux the same in both.
template <int D>
void two_materials_are_exact() {
  const double kappa_left = 1, kappa_right = 50;
  const auto exact = [&](const Vec<D>& x) { return x[0] <= 1 ? 3 + x[0] : 4 + (x[0] - 1) * kappa_left / kappa_right; };
  for (const test::Filling& f : test::all_fillings()) {
    SCOPED_TRACE(f.name);
    const auto result = make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(f, D == 2 ? 0.1 : 0.3));
    const auto boundary = build_boundary_areas(result.mesh);
    Vec<D> hi = domains::all<D>(1);
    hi[0] = 2;
    DiffusionProblem<D> problem;
    problem.conductivity = std::map<int, double>{{7, kappa_left}, {9, kappa_right}};
    for (const auto& [marker, normal] : box_normals<D>(boundary, hi))
      if (normal[0] != 0) problem.conditions[marker] = Dirichlet<D>{exact};
    ASSERT_EQ(problem.conditions.size(), 2U);
    const auto u = solve(result.volumes, boundary, problem);
    EXPECT_LE(largest_error(result.volumes, u, exact), kExact);
    EXPECT_TRUE(u.matrix.is_m_matrix);
    expect_balanced(u);
    ASSERT_EQ(u.balances.size(), 2U);
    EXPECT_NEAR(u.balances[0].interface_inflow, kappa_left, 10 * kExact);
    EXPECT_NEAR(u.balances[1].boundary_inflow, kappa_left, 10 * kExact);
  }
}
TEST(DiffusionProperty, TwoMaterialsAreExactInThePlane) { two_materials_are_exact<2>(); }
TEST(DiffusionProperty, TwoMaterialsAreExactInSpace) { two_materials_are_exact<3>(); }

/// With f = 0 the solution lies between the boundary values, however sharp the domain and flat its simplices.
template <int D>
void maximum_principle_holds(const test::Case<D>& c) {
  SCOPED_TRACE(c.name);
  const auto result = make_mesh(c.input, test::meshing_options<D>(test::all_fillings()[1]));
  const auto boundary = build_boundary_areas(result.mesh);
  for (const double area : boundary.patch_area) EXPECT_GE(area, 0);
  const auto bumpy = [](const Vec<D>& x) { return std::sin(40 * x[0]) * std::cos(55 * x[1]); };
  const auto u = solve(result.volumes, boundary, dirichlet_everywhere<D>(boundary, bumpy));
  EXPECT_TRUE(u.matrix.is_m_matrix) << u.matrix.n_positive_couplings << ' ' << u.matrix.n_negative_row_sums;
  double lo = 1, hi = -1;
  for (const VertexId v : boundary.patch_vertex) {
    lo = std::min(lo, bumpy(result.volumes.sites[v]));
    hi = std::max(hi, bumpy(result.volumes.sites[v]));
  }
  for (const double value : u.values) {
    EXPECT_GE(value, lo - 1e-14);
    EXPECT_LE(value, hi + 1e-14);
  }
  expect_balanced(u);
}
TEST(DiffusionProperty, TheMaximumPrincipleHoldsInThePlane) {
  maximum_principle_holds(test::sharp::sliver(1));
  maximum_principle_holds(test::sharp::fan(5, 10));
  maximum_principle_holds(test::sharp::leaning_slit(3));
}
TEST(DiffusionProperty, TheMaximumPrincipleHoldsInSpace) {
  maximum_principle_holds(test::sharp::wedge(1));
  maximum_principle_holds(test::sharp::skew_wedge(20));
  maximum_principle_holds(test::sharp::pyramid(5, 30));
}

/// Everything at once: two materials, varying coefficients, a source, a reaction, and all kinds of conditions.
template <int D>
DiffusionProblem<D> busy_problem() {
  DiffusionProblem<D> problem;
  problem.conductivity = [](const Vec<D>& x, int region) { return region == 7 ? 1 + x[1] : 20.0; };
  problem.reaction = std::map<int, double>{{7, 0.0}, {9, 0.5}};
  problem.source = [](const Vec<D>& x, int) { return 3 * std::sin(5 * x[0]); };
  problem.conditions = {{1, Dirichlet<D>{[](const Vec<D>& x) { return x[0]; }}},
                        {2, Robin<D>{0.7, 2.0}},
                        {3, Neumann<D>{[](const Vec<D>& x) { return std::cos(x[0]); }}}};
  return problem;
}

template <int D>
void everything_is_balanced() {
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.05 : 0.2));
  const auto boundary = build_boundary_areas(result.mesh);
  LinearOptions options;
  options.tolerance = 1e-4;  // Of the iteration: balances close all the same.
  for (const auto method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
    options.method = method;
    const auto u = solve(result.volumes, boundary, busy_problem<D>(), options);
    EXPECT_TRUE(u.matrix.is_m_matrix);
    expect_balanced(u);
    double through_markers = 0, through_regions = 0;
    for (const MarkerFlux& flux : u.fluxes) through_markers += flux.inflow;
    for (const RegionBalance& balance : u.balances) through_regions += balance.boundary_inflow;
    EXPECT_NEAR(through_markers, through_regions, kBalance * u.balances[0].throughput);
  }
}
TEST(DiffusionProperty, EverythingIsBalancedInThePlane) { everything_is_balanced<2>(); }
TEST(DiffusionProperty, EverythingIsBalancedInSpace) { everything_is_balanced<3>(); }

template <int D>
void threads_do_not_matter() {
  const test::AllowThreads allow(8);
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.01 : 0.1));
  const auto solve_with = [&](int n, LinearMethod method) {
    DiffusionSolution<D> u;
    run_with_threads(n, [&] {
      LinearOptions options;
      options.method = method;
      u = solve(result.volumes, build_boundary_areas(result.mesh), busy_problem<D>(), options);
    });
    return u;
  };
  for (const auto method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
    const auto one = solve_with(1, method);
    for (const int n : {2, 8}) {
      const auto many = solve_with(n, method);
      EXPECT_EQ(one.values, many.values) << n;
      EXPECT_EQ(one.fluxes[0].inflow, many.fluxes[0].inflow) << n;
      EXPECT_EQ(one.linear.residuals, many.linear.residuals) << n;
    }
  }
}
TEST(DiffusionProperty, ThreadsDoNotMatterInThePlane) { threads_do_not_matter<2>(); }
TEST(DiffusionProperty, ThreadsDoNotMatterInSpace) { threads_do_not_matter<3>(); }

}  // namespace
}  // namespace voropack
