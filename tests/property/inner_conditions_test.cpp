// Conditions on what lies inside the domain: walls, wires, wells.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "support/balance_checks.h"
#include "support/cases.h"
#include "support/faults.h"
#include "voropack/diffusion.h"
#include "voropack/fem.h"

namespace voropack {
namespace {

constexpr double kExact = 1e-12;
constexpr int kInner = 77;

/// A mesh of a domain and its boundary with the polytopes of marker kInner.
template <int D>
struct Inner {
  MeshingResult<D> result;
  BoundaryAreas<D> boundary;

  Inner(const DomainInput<D>& input, double size)
      : result(make_mesh(input, test::meshing_options<D>(test::all_fillings()[1], size))),
        boundary(build_boundary_areas(result.mesh, {kInner})) {}

  [[nodiscard]] std::set<int> hull_markers() const {
    std::set<int> markers(boundary.patch_marker.begin(), boundary.patch_marker.end());
    markers.erase(kInner);
    return markers;
  }
  [[nodiscard]] DiffusionProblem<D> fixed_on_hull(BoundaryValue<D> value) const {
    DiffusionProblem<D> problem;
    for (const int marker : hull_markers()) problem.conditions[marker] = Dirichlet<D>{value};
    return problem;
  }
};

template <int D>
MarkerFlux flux_of(const DiffusionSolution<D>& u, int marker) {
  for (const MarkerFlux& flux : u.fluxes)
    if (flux.marker == marker) return flux;
  ADD_FAILURE() << "no flux of marker " << marker;
  return {};
}

template <int D>
DomainInput<D> box_with_wall() {
  DomainInput<D> input = domains::box_with_internal_wall<D>();
  if constexpr (D == 2)
    input.segments.back().marker = kInner;
  else
    input.facets.back().marker = kInner;
  return input;
}

DomainInput<3> box_with_wire() {
  DomainInput<3> input = domains::unit_cube();
  const auto a = domains::add_point<3>(input, {0.5, 0.5, 0});
  const auto b = domains::add_point<3>(input, {0.5, 0.5, 1});
  domains::add_segment(input, a, b, kInner);
  return input;
}

template <int D>
DomainInput<D> box_with_point() {
  DomainInput<D> input = domains::box_with_isolated_point<D>();
  input.point_markers.resize(input.points.size());
  input.point_markers.back() = kInner;
  return input;
}

template <int D>
double inner_area(const Inner<D>& inner) {
  double sum = 0;
  for (const PatchId p : ids(inner.boundary.patch_marker))
    if (inner.boundary.patch_marker[p] == kInner) sum += inner.boundary.patch_area[p];
  return sum;
}

TEST(InnerConditions, AreasAreThoseOfWallsLengthsOfWiresAndNumbersOfPoints) {
  EXPECT_NEAR(inner_area(Inner<2>(box_with_wall<2>(), 0.1)), 0.4, kExact);
  EXPECT_NEAR(inner_area(Inner<3>(box_with_wall<3>(), 0.2)), 0.16, kExact);
  EXPECT_NEAR(inner_area(Inner<3>(box_with_wire(), 0.2)), 1, kExact);
  EXPECT_EQ(inner_area(Inner<2>(box_with_point<2>(), 0.1)), 1);
  EXPECT_EQ(inner_area(Inner<3>(box_with_point<3>(), 0.3)), 1);
}

TEST(InnerConditions, HullFacesComeFirst) {
  const Inner<2> inner(box_with_wall<2>(), 0.1);
  // Markers of the hull and those that nothing has change nothing.
  EXPECT_EQ(build_boundary_areas(inner.result.mesh, {*inner.hull_markers().begin(), 12345}),
            build_boundary_areas(inner.result.mesh));
}

template <int D>
void a_wall_with_exact_values_changes_nothing() {
  const Inner<D> inner(box_with_wall<D>(), D == 2 ? 0.08 : 0.25);
  const auto exact = [](const Vec<D>& x) { return 2 + x[0] - 0.5 * x[1]; };
  DiffusionProblem<D> problem = inner.fixed_on_hull(exact);
  problem.conditions[kInner] = Dirichlet<D>{exact};
  const auto u = solve(inner.result.volumes, inner.boundary, problem);
  for (const VertexId v : ids(u.values)) EXPECT_NEAR(u.values[v], exact(inner.result.volumes.sites[v]), kExact);
  EXPECT_NEAR(flux_of(u, kInner).inflow, 0, kExact);
  test::expect_balanced(u.balances);
}
TEST(InnerConditions, AWallWithExactValuesChangesNothingInThePlane) { a_wall_with_exact_values_changes_nothing<2>(); }
TEST(InnerConditions, AWallWithExactValuesChangesNothingInSpace) { a_wall_with_exact_values_changes_nothing<3>(); }

/// [0, 2] x [0, 1]^(D-1) with fixed ends: what enters at the interface between the two materials splits.
template <int D>
void an_interface_feeds_both_sides() {
  const DomainInput<D> input = domains::two_material_box<D>();
  const auto result = make_mesh(input, test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.1 : 0.3));
  std::set<int> interface;  // Its marker is that of the faces at x = 1 that are not on the hull.
  for (const BoundaryId b : ids(result.mesh.boundary_vertices)) {
    bool is_there = true;
    for (const VertexId v : result.mesh.boundary_vertices[b]) is_there = is_there && result.mesh.points[v][0] == 1;
    if (is_there) interface.insert(result.mesh.boundary_marker[b]);
  }
  ASSERT_EQ(interface.size(), 1U);
  const auto boundary = build_boundary_areas(result.mesh, interface);
  std::set<int> ends;
  for (const PatchId p : ids(boundary.patch_marker))
    if (const double x = boundary.patch_centroid[p][0]; x == 0 || x == 2) ends.insert(boundary.patch_marker[p]);
  ASSERT_EQ(ends.size(), 2U);
  DiffusionProblem<D> problem;
  problem.conductivity = std::map<int, double>{{7, 1.0}, {9, 50.0}};
  for (const int end : ends) problem.conditions[end] = Dirichlet<D>{0.0};
  const auto expect_split = [&](const BoundaryCondition<D>& condition, double value) {
    problem.conditions[*interface.begin()] = condition;
    const auto u = solve(result.volumes, boundary, problem);
    for (const VertexId v : ids(u.values))
      EXPECT_NEAR(u.values[v], value * (1 - std::abs(result.volumes.sites[v][0] - 1)), kExact);
    EXPECT_NEAR(flux_of(u, *interface.begin()).inflow, 51 * value, 51 * kExact);
    EXPECT_NEAR(flux_of(u, *interface.begin()).area, 1, kExact);
    test::expect_balanced(u.balances);
    return u;
  };
  const auto fixed = expect_split(Dirichlet<D>{3.0}, 3);
  EXPECT_NEAR(fixed.balances[0].boundary_inflow, 0, 10 * kExact);  // Each region is fed on its own side.
  EXPECT_NEAR(fixed.balances[0].interface_inflow, 0, 10 * kExact);
  expect_split(Neumann<D>{102.0}, 2);
  expect_split(Rate<D>{51.0}, 1);
  expect_split(Robin<D>{51.0, 8.0}, 4);
}
TEST(InnerConditions, AnInterfaceFeedsBothSidesInThePlane) { an_interface_feeds_both_sides<2>(); }
TEST(InnerConditions, AnInterfaceFeedsBothSidesInSpace) { an_interface_feeds_both_sides<3>(); }

/// -rate / (2 pi) log(distance from the axis through the middle), the field of a well.
template <int D>
auto well(double rate) {
  return [=](const Vec<D>& x) { return -rate / (2 * std::numbers::pi) * std::log(std::hypot(x[0] - 0.5, x[1] - 0.5)); };
}

/// The largest error at vertices that are not close to the well, of a solution between 0 and 0.4.
template <int D>
double error_away_from_well(const Inner<D>& inner, const IdVector<VertexId, double>& values) {
  double error = 0;
  for (const VertexId v : ids(values)) {
    const Vec<D>& x = inner.result.volumes.sites[v];
    if (std::hypot(x[0] - 0.5, x[1] - 0.5) > 0.15) error = std::max(error, std::abs(values[v] - well<D>(1)(x)));
  }
  return error;
}

TEST(InnerConditions, APointIsAWellInThePlane) {
  double before = 0;
  for (const double size : {0.04, 0.02}) {
    const Inner<2> inner(box_with_point<2>(), size);
    DiffusionProblem<2> problem = inner.fixed_on_hull(well<2>(1));
    problem.conditions[kInner] = Rate<2>{1.0};
    const auto u = solve(inner.result.volumes, inner.boundary, problem);
    EXPECT_NEAR(flux_of(u, kInner).inflow, 1, kExact);
    double through_hull = 0;
    for (const int marker : inner.hull_markers()) through_hull += flux_of(u, marker).inflow;
    EXPECT_NEAR(through_hull, -1, kExact);
    test::expect_balanced(u.balances);
    const double error = error_away_from_well(inner, u.values);
    EXPECT_LT(error, 0.1 * size);
    if (before > 0) {
      EXPECT_LT(error, 0.6 * before);
    }
    before = error;
    // The other way round: the level that the rate leads to needs the rate.
    for (const PatchId p : ids(inner.boundary.patch_marker)) {
      if (inner.boundary.patch_marker[p] != kInner) continue;
      problem.conditions[kInner] = Dirichlet<2>{u.values[inner.boundary.patch_vertex[p]]};
      const auto held = solve(inner.result.volumes, inner.boundary, problem);
      EXPECT_NEAR(flux_of(held, kInner).inflow, 1, 10 * kExact);
    }
  }
}

TEST(InnerConditions, ASegmentIsAWellInSpace) {
  const Inner<3> inner(box_with_wire(), 0.08);
  const auto exact = well<3>(1);
  DiffusionProblem<3> problem;
  for (const PatchId p : ids(inner.boundary.patch_marker)) {
    const Vec<3>& x = inner.boundary.patch_centroid[p];
    if (inner.boundary.patch_marker[p] != kInner && x[2] > 1e-9 && x[2] < 1 - 1e-9)
      problem.conditions[inner.boundary.patch_marker[p]] = Dirichlet<3>{exact};
  }
  ASSERT_EQ(problem.conditions.size(), 4U);
  problem.conditions[kInner] = Rate<3>{1.0};
  const auto u = solve(inner.result.volumes, inner.boundary, problem);
  EXPECT_NEAR(flux_of(u, kInner).inflow, 1, kExact);
  EXPECT_NEAR(flux_of(u, kInner).area, 1, kExact);
  test::expect_balanced(u.balances);
  EXPECT_LT(error_away_from_well(inner, u.values), 0.01);
}

TEST(InnerConditions, FiniteElementsAgreeInThePlane) {
  for (const auto& input : {box_with_wall<2>(), box_with_point<2>()}) {
    const Inner<2> inner(input, 0.1);
    DiffusionProblem<2> problem = inner.fixed_on_hull([](const Vec<2>& x) { return x[0]; });
    for (const BoundaryCondition<2>& condition :
         {BoundaryCondition<2>(Dirichlet<2>{2.0}), BoundaryCondition<2>(Neumann<2>{3.0}),
          BoundaryCondition<2>(Robin<2>{2.0, 5.0}), BoundaryCondition<2>(Rate<2>{3.0})}) {
      problem.conditions[kInner] = condition;
      const auto cvm = solve(inner.result.volumes, inner.boundary, problem);
      const auto fem = solve_fem(inner.result.mesh, problem);
      for (const VertexId v : ids(cvm.values)) EXPECT_NEAR(cvm.values[v], fem.values[v], 1e-10);
    }
  }
}

TEST(InnerConditions, WithoutPatchesTheMarkerIsUnknown) {
  const Inner<2> inner(box_with_point<2>(), 0.2);
  DiffusionProblem<2> problem = inner.fixed_on_hull(0.0);
  problem.conditions[kInner] = Rate<2>{1.0};
  const auto hull = build_boundary_areas(inner.result.mesh);
  EXPECT_EQ(test::fault_of<InputError>([&] { solve(inner.result.volumes, hull, problem); }).id, "solve.unknown_marker");
}

}  // namespace
}  // namespace voropack
