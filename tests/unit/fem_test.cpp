// The laws of P1 finite elements, and where they agree with control volumes.
#include "voropack/fem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/parallel.h"
#include "support/allow_threads.h"
#include "support/balance_checks.h"
#include "support/cases.h"
#include "support/delaunay_mesh.h"
#include "voropack/dual.h"
#include "voropack/error.h"
#include "voropack/norms.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

/// Calls visit(row, column, value) for each entry.
void for_each_entry(const SparseMatrix& matrix, const auto& visit) {
  for (std::uint32_t row = 0; row < matrix.size(); ++row)
    for (std::uint64_t e = matrix.offsets[row]; e < matrix.offsets[row + 1]; ++e)
      visit(row, matrix.columns[e], matrix.values[e]);
}

/// The largest entry of a matrix minus that of the control volumes, the sum over regions of |A_ij| / h_ij.
template <int D>
double largest_difference(const SparseMatrix& fem, const ControlVolumes<D>& volumes) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> difference;
  for_each_entry(fem, [&](std::uint32_t i, std::uint32_t j, double value) { difference[{i, j}] += value; });
  for (const DualFaceId f : ids(volumes.face_area)) {
    const std::uint32_t i = volumes.face_vertices[f][0].value(), j = volumes.face_vertices[f][1].value();
    const double coupling = volumes.face_area[f] / volumes.face_edge_length[f];
    difference[{i, j}] += coupling;
    difference[{j, i}] += coupling;
    difference[{i, i}] -= coupling;
    difference[{j, j}] -= coupling;
  }
  double largest = 0;
  for (const auto& [place, value] : difference) largest = std::max(largest, std::abs(value));
  return largest;
}

int halves2(const Vec<2>& x) { return x[0] < 0.5 ? 1 : 2; }
int halves3(const Vec<3>& x) { return x[0] < 0.5 ? 1 : 2; }

TEST(Fem, MatrixIsThatOfControlVolumesInThePlane) {  // MacNeal 1953.
  for (const double eps : {0.0, 1e-10, 0.01, 0.3}) {
    const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(12, eps));
    EXPECT_LT(largest_difference(stiffness_matrix<2>(mesh), build_control_volumes(mesh)), 1e-13) << eps;
  }
  const Mesh<2> two = delaunay_mesh<2>(perturbed_grid<2>(12, 0.1, 1, true), halves2);
  EXPECT_LT(largest_difference(stiffness_matrix<2>(two), build_control_volumes(two)), 1e-13);
}

TEST(Fem, MatrixIsNotThatOfControlVolumesInSpace) {
  // The difference grows without bound as slivers become flat; the couplings stay near h.
  double last = 0.1;
  for (const double eps : {1e-2, 1e-4, 1e-6}) {
    const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(4, eps));
    const double difference = largest_difference(stiffness_matrix<3>(mesh), build_control_volumes(mesh));
    EXPECT_GT(difference, 10 * last) << eps;
    last = difference;
  }
}

template <int D>
void expect_symmetric_with_zero_sums(const Mesh<D>& mesh) {
  const SparseMatrix matrix = stiffness_matrix<D>(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> entries;
  std::vector<double> sum(matrix.size()), magnitude(matrix.size());
  for_each_entry(matrix, [&](std::uint32_t i, std::uint32_t j, double value) {
    EXPECT_TRUE((entries.emplace(std::pair(i, j), value).second)) << "an entry occurs twice";
    sum[i] += value;
    magnitude[i] += std::abs(value);
  });
  for (std::size_t i = 0; i < sum.size(); ++i) EXPECT_NEAR(sum[i], 0, 1e-14 * magnitude[i]);
  for (const auto& [place, value] : entries) EXPECT_EQ(value, (entries.at({place.second, place.first})));
}

TEST(Fem, StiffnessIsSymmetricToTheBitWithZeroSums) {
  expect_symmetric_with_zero_sums(delaunay_mesh(perturbed_grid<2>(9, 0.3)));
  expect_symmetric_with_zero_sums(delaunay_mesh(perturbed_grid<3>(5, 1e-3)));
}

double total(const SparseMatrix& matrix) {
  double sum = 0;
  for (const double value : matrix.values) sum += value;
  return sum;
}

TEST(Fem, MassSumsToTheIntegralOfTheReaction) {
  EXPECT_NEAR(total(mass_matrix<2>(delaunay_mesh(perturbed_grid<2>(9, 0.3)))), 1, 1e-13);
  const RegionFunction<3> cubic = [](const Vec<3>& x, int) { return x[0] * x[0] * x[1]; };
  EXPECT_NEAR(total(mass_matrix<3>(delaunay_mesh(perturbed_grid<3>(5, 0.01)), cubic)), 1.0 / 6, 1e-13);
}

template <int D>
void expect_load_is_mass_times_linear(const Mesh<D>& mesh) {
  const RegionFunction<D> f = [](const Vec<D>& x, int) { return 2 + 3 * x[0] - x[D - 1]; };
  IdVector<VertexId, double> values;
  for (const Vec<D>& x : mesh.points) values.push_back(f(x, 1));
  std::vector<double> expected(values.size());
  multiply(mass_matrix<D>(mesh), values.raw(), expected);
  for (const Coefficient<D>& source : {Coefficient<D>(f), Coefficient<D>(values)}) {
    const auto load = load_vector<D>(mesh, source);
    for (const VertexId v : ids(load)) EXPECT_NEAR(load[v], expected[v.value()], 1e-16);
  }
}

TEST(Fem, LoadOfALinearSourceIsMassTimesItsValues) {
  expect_load_is_mass_times_linear(delaunay_mesh(perturbed_grid<2>(9, 0.3)));
  expect_load_is_mass_times_linear(delaunay_mesh(perturbed_grid<3>(5, 0.1)));
}

TEST(Fem, LoadSumsToTheIntegralOfTheSource) {
  const auto load =
      load_vector<3>(delaunay_mesh(perturbed_grid<3>(3, 0.1)),
                     RegionFunction<3>([](const Vec<3>& x, int) { return x[0] * x[0] * x[1] * x[2] * x[2]; }));
  double sum = 0;
  for (const double x : load) sum += x;
  EXPECT_NEAR(sum, 1.0 / 18, 1e-14);
}

template <int D>
using Function = std::function<double(const Vec<D>&)>;

/// u = exact on the whole hull.
template <int D>
DiffusionProblem<D> dirichlet_problem(const Function<D>& exact) {
  DiffusionProblem<D> problem;
  problem.conditions[0] = Dirichlet<D>{exact};
  return problem;
}

template <int D>
double worst_error(const Mesh<D>& mesh, const DiffusionProblem<D>& problem, const Function<D>& exact) {
  return max_norm(vertex_errors<D>(mesh.points, solve_fem(mesh, problem).values, exact));
}

TEST(Fem, ReproducesLinearFunctions) {
  const Function<2> plane = [](const Vec<2>& x) { return 1 + 2 * x[0] - 3 * x[1]; };
  EXPECT_LT(worst_error(delaunay_mesh(perturbed_grid<2>(16, 0.3)), dirichlet_problem(plane), plane), 1e-12);
  const Function<3> space = [](const Vec<3>& x) { return 1 + 2 * x[0] - 3 * x[1] + x[2]; };
  for (const double eps : {0.0, 1e-4, 0.3})
    EXPECT_LT(worst_error(delaunay_mesh(perturbed_grid<3>(6, eps)), dirichlet_problem(space), space), 1e-11) << eps;
}

TEST(Fem, IterationReachesTheDirectSolutionOnSlivers) {
  const Function<3> exact = [](const Vec<3>& x) { return std::exp(x[0]) * std::cos(x[1]); };
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(10, 1e-4));
  LinearOptions options = fem_linear_options();
  options.method = LinearMethod::kConjugateGradients;
  const auto iterated = solve_fem(mesh, dirichlet_problem(exact), options);
  const auto direct = solve_fem(mesh, dirichlet_problem(exact));
  EXPECT_EQ(direct.linear.method, "direct");
  EXPECT_EQ(iterated.linear.preconditioner, "diagonal");
  for (const VertexId v : ids(mesh.points)) EXPECT_NEAR(iterated.values[v], direct.values[v], 1e-9);
}

TEST(Fem, ReproducesPiecewiseLinearFunctionsOfTwoMaterials) {
  // kappa du/dx = 3 on both sides of x = 1/2.
  const Function<3> exact = [](const Vec<3>& x) { return (x[0] < 0.5 ? 3 : 0.1) * (x[0] - 0.5); };
  DiffusionProblem<3> problem = dirichlet_problem(exact);
  problem.conductivity = std::map<int, double>{{1, 1.0}, {2, 30.0}};
  const Mesh<3> mesh = delaunay_mesh<3>(perturbed_grid<3>(6, 0.05, 2, true), halves3);
  EXPECT_LT(worst_error(mesh, problem, exact), 1e-12);
}

/// Marker 1 where x = 0, 2 where x = 1, else 3.
Mesh<3> mesh_with_markers() {
  Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(5, 0.1));
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    const auto all_at = [&](double at) {
      const auto& face = mesh.boundary_vertices[b];
      return std::all_of(face.begin(), face.end(), [&](VertexId v) { return mesh.points[v][0] == at; });
    };
    mesh.boundary_marker[b] = all_at(0) ? 1 : all_at(1) ? 2 : 3;
  }
  return mesh;
}

TEST(Fem, ReproducesALinearFunctionWithEveryKindOfCondition) {
  // kappa du/dx = 6 enters at x = 1 and leaves at x = 0.
  const Function<3> exact = [](const Vec<3>& x) { return 1 + 3 * x[0]; };
  const Mesh<3> mesh = mesh_with_markers();
  DiffusionProblem<3> problem;
  problem.conductivity = 2.0;
  problem.conditions[1] = Dirichlet<3>{exact};
  problem.conditions[2] = Neumann<3>{6.0};
  EXPECT_LT(worst_error(mesh, problem, exact), 1e-12);
  problem.conditions[1] = Robin<3>{4.0, -0.5};  // kappa du/dn = -6 = 4 (-0.5 - 1).
  EXPECT_LT(worst_error(mesh, problem, exact), 1e-12);
}

TEST(Fem, ReactionBalancesTheSource) {
  // -laplace u + sigma u = sigma u for a linear u.
  const Function<2> exact = [](const Vec<2>& x) { return 1 + 3 * x[0] - x[1]; };
  DiffusionProblem<2> problem = dirichlet_problem(exact);
  problem.reaction = 5.0;
  problem.source = RegionFunction<2>([&](const Vec<2>& x, int) { return 5 * exact(x); });
  EXPECT_LT(worst_error(delaunay_mesh(perturbed_grid<2>(9, 0.2)), problem, exact), 1e-12);
}

TEST(Fem, ConvergesWithSecondOrderOnGoodMeshes) {
  constexpr double kPi = 3.14159265358979323846;
  const Function<2> exact = [](const Vec<2>& x) { return std::sin(kPi * x[0]) * std::sin(kPi * x[1]); };
  DiffusionProblem<2> problem = dirichlet_problem(exact);
  problem.source = RegionFunction<2>([&](const Vec<2>& x, int) { return 2 * kPi * kPi * exact(x); });
  const auto error = [&](int n) {
    const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(n, 0.2));
    return l2_error(mesh, solve_fem(mesh, problem).values, exact);
  };
  const double order = std::log2(error(16) / error(32));
  EXPECT_GT(order, 1.9);
  EXPECT_LT(order, 2.1);
}

TEST(Fem, MatricesDoNotDependOnThreads) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(14, 0.01));
  const RegionFunction<3> source = [](const Vec<3>& x, int) { return std::exp(x[0]); };
  SparseMatrix one, many;
  IdVector<VertexId, double> load_one, load_many;
  run_with_threads(1, [&] {
    one = stiffness_matrix<3>(mesh);
    load_one = load_vector<3>(mesh, source);
  });
  const test::AllowThreads threads(8);
  run_with_threads(8, [&] {
    many = stiffness_matrix<3>(mesh);
    load_many = load_vector<3>(mesh, source);
  });
  EXPECT_EQ(one, many);
  EXPECT_EQ(load_one, load_many);
}

template <class Call>
void expect_fault(const std::string& id, const Call& call) {
  try {
    call();
    FAIL() << "accepted, but should be " << id;
  } catch (const InputError& error) {
    EXPECT_EQ(error.id(), id);
    EXPECT_FALSE(error.faults().front().fix.empty());
  }
}

TEST(Fem, RefusesWhatItCannotUse) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(2, 0.1));
  Mesh<3> inverted = mesh;
  std::swap(inverted.simplex_vertices[SimplexId(5)][0], inverted.simplex_vertices[SimplexId(5)][1]);
  expect_fault("mesh.degenerate_simplex", [&] { stiffness_matrix<3>(inverted); });
  expect_fault("solve.bad_conductivity", [&] { stiffness_matrix<3>(mesh, 0.0); });
  expect_fault("solve.unknown_region", [&] { stiffness_matrix<3>(mesh, std::map<int, double>{{7, 1.0}}); });
  expect_fault("solve.wrong_length", [&] { load_vector<3>(mesh, IdVector<VertexId, double>(3)); });
  DiffusionProblem<3> problem;
  problem.conditions[12] = Dirichlet<3>{};
  expect_fault("solve.unknown_marker", [&] { assemble_fem(mesh, problem); });
}

TEST(Fem, RefusesWhatBelongsToControlVolumes) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_grid<3>(2, 0.1));
  DiffusionProblem<3> problem;
  problem.conditions[0] = Dirichlet<3>{};
  problem.source_integrals = IdVector<CellId, double>(mesh.points.size());
  expect_fault("solve.cell_integrals", [&] { solve_fem(mesh, problem); });
  problem.source_integrals.reset();
  problem.source = StateFunction<3>{[](const Vec<3>&, int, double u) { return -u; }, {}};
  expect_fault("solve.nonlinear", [&] { solve_fem(mesh, problem); });
  problem.source = 0.0;
  problem.mean = 1;
  expect_fault("solve.mean_not_free", [&] { solve_fem(mesh, problem); });
  problem.conditions.clear();
  problem.mean.reset();
  expect_fault("solve.no_condition", [&] { solve_fem(mesh, problem); });
  problem.mean = 1;
  problem.source = 1.0;
  expect_fault("solve.incompatible", [&] { solve_fem(mesh, problem); });
}

TEST(Fem, PureNeumannTakesTheMean) {
  // -laplace u = pi^2 cos(pi x): u = 3 + cos(pi x), nothing enters anywhere.
  constexpr double kPi = 3.14159265358979323846;
  const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(24, 0.1));
  DiffusionProblem<2> problem;
  problem.source = RegionFunction<2>([](const Vec<2>& x, int) { return kPi * kPi * std::cos(kPi * x[0]); });
  problem.mean = 3;
  const auto values = solve_fem(mesh, problem).values;
  const auto volume = load_vector<2>(mesh, 1.0);
  double mean = 0, total = 0, error = 0;
  for (const VertexId v : ids(values)) {
    mean += volume[v] * values[v];
    total += volume[v];
    error = std::max(error, std::abs(values[v] - 3 - std::cos(kPi * mesh.points[v][0])));
  }
  EXPECT_NEAR(mean / total, 3, 1e-12);
  EXPECT_LT(error, 0.01);
}

/// In 2D the matrices agree, and so does everything that flows.
TEST(Fem, FlowsAreThoseOfControlVolumesInThePlane) {
  const auto result = make_mesh(domains::two_material_box<2>(), test::meshing_options<2>(test::all_fillings()[1], 0.2));
  DiffusionProblem<2> problem;
  problem.conductivity = std::map<int, double>{{7, 2.0}, {9, 0.5}};
  const auto boundary = build_boundary_areas(result.mesh);
  for (const int marker : boundary.patch_marker)
    problem.conditions[marker] = Dirichlet<2>{[](const Vec<2>& x) { return x[0] * x[0] - x[1]; }};
  const auto fem = solve_fem(result.mesh, problem);
  const auto cvm = solve(result.volumes, boundary, problem);
  ASSERT_EQ(fem.fluxes.size(), cvm.fluxes.size());
  for (std::size_t k = 0; k < cvm.fluxes.size(); ++k) {
    EXPECT_EQ(fem.fluxes[k].marker, cvm.fluxes[k].marker);
    EXPECT_NEAR(fem.fluxes[k].area, cvm.fluxes[k].area, 1e-13);
    EXPECT_NEAR(fem.fluxes[k].inflow, cvm.fluxes[k].inflow, 1e-11);
  }
  ASSERT_EQ(fem.balances.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(fem.balances[k].volume, cvm.balances[k].volume, 1e-13);
    EXPECT_NEAR(fem.balances[k].interface_inflow, cvm.balances[k].interface_inflow, 1e-11);
  }
  test::expect_balanced(fem.balances);
}

/// -2 laplace u = 0 with u = 1 + 3 x: 6 enters at x = 1, whatever condition says so.
TEST(Fem, FluxesOfALinearFunctionAreExact) {
  const Mesh<3> mesh = mesh_with_markers();
  const Function<3> exact = [](const Vec<3>& x) { return 1 + 3 * x[0]; };
  DiffusionProblem<3> problem;
  problem.conductivity = 2.0;
  for (const BoundaryCondition<3>& right :
       {BoundaryCondition<3>(Dirichlet<3>{exact}), BoundaryCondition<3>(Neumann<3>{6.0}),
        BoundaryCondition<3>(Robin<3>{2.0, 7.0}), BoundaryCondition<3>(Rate<3>{6.0})}) {
    problem.conditions[1] = Dirichlet<3>{exact};
    problem.conditions[2] = right;
    const auto u = solve_fem(mesh, problem);
    ASSERT_EQ(u.fluxes.size(), 3U);
    EXPECT_NEAR(u.fluxes[0].inflow, -6, 1e-11);
    EXPECT_NEAR(u.fluxes[1].inflow, 6, 1e-11);
    EXPECT_NEAR(u.fluxes[2].inflow, 0, 1e-11);
    EXPECT_NEAR(u.fluxes[1].area, 1, 1e-13);
    test::expect_balanced(u.balances);
  }
}

/// Source, reaction and every condition at once.
TEST(Fem, WhatGoesInComesOut) {
  const Mesh<3> mesh = mesh_with_markers();
  DiffusionProblem<3> problem;
  problem.conductivity = RegionFunction<3>([](const Vec<3>& x, int) { return 1 + x[0] * x[1]; });
  problem.reaction = 3.0;
  problem.source = RegionFunction<3>([](const Vec<3>& x, int) { return std::exp(x[2]); });
  problem.conditions[1] = Dirichlet<3>{[](const Vec<3>& x) { return x[1]; }};
  problem.conditions[2] = Robin<3>{[](const Vec<3>& x) { return 1 + x[1]; }, 2.0};
  problem.conditions[3] = Neumann<3>{[](const Vec<3>& x) { return x[0] - x[2]; }};
  const auto u = solve_fem(mesh, problem);
  ASSERT_EQ(u.balances.size(), 1U);
  EXPECT_GT(u.balances[0].absorbed, 0.1);
  EXPECT_NEAR(u.balances[0].source, std::exp(1.0) - 1, 1e-6);
  test::expect_balanced(u.balances);
  problem = {};
  problem.conditions[1] = Rate<3>{1.0};
  problem.conditions[2] = Rate<3>{-1.0};
  problem.mean = 4;
  test::expect_balanced(solve_fem(mesh, problem).balances);
}

TEST(Fem, ARateIsATotalInflow) {
  const Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(6, 0.1));
  DiffusionProblem<2> problem;
  problem.conditions[0] = Rate<2>{2.5};
  const LinearSystem system = assemble_fem(mesh, problem);
  double sum = 0;
  for (const double load : system.load) sum += load;
  EXPECT_NEAR(sum, 2.5, 1e-13);
}

TEST(Fem, FixesAVertexWithoutSimplices) {
  const Function<2> exact = [](const Vec<2>& x) { return x[0] + x[1]; };
  Mesh<2> mesh = delaunay_mesh(perturbed_grid<2>(4, 0.1));
  mesh.points.push_back({3.0, 7.0});
  const auto values = solve_fem(mesh, dirichlet_problem(exact)).values;
  EXPECT_EQ(values[VertexId(mesh.points.size() - 1)], 0.0);
  EXPECT_NEAR(values[VertexId(std::size_t{12})], exact(mesh.points[VertexId(std::size_t{12})]), 1e-14);
}

}  // namespace
}  // namespace voropack
