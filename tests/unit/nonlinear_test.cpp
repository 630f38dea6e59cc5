// Newton's method on problems that are worked out by hand, and what it refuses.
#include "voropack/nonlinear.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "support/allow_threads.h"
#include "support/balance_checks.h"
#include "support/cases.h"
#include "support/faults.h"
#include "support/strip_volumes.h"

namespace voropack {
namespace {

using test::fault_of;
using test::Strip;
using test::strip;

const VertexId v1(1);
using Values = IdVector<VertexId, double>;

DiffusionProblem<2> between(double left, double right) {
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Dirichlet<2>{left}}, {2, Dirichlet<2>{right}}};
  return problem;
}

/// kappa = exp(u), whose integral is kappa itself, so that exp(u) is linear.
template <int D>
StateFunction<D> exponential() {
  const auto f = [](const Vec<D>&, int, double u) { return std::exp(u); };
  return {f, f};
}

TEST(Nonlinear, ALinearProblemTakesOneStep) {
  const Strip s = strip(5);
  DiffusionProblem<2> problem = between(1, 3);
  problem.source = 0.25;
  problem.reaction = 0.5;
  const auto linear = solve(s.volumes, s.boundary, problem);
  const auto u = solve_nonlinear(s.volumes, s.boundary, problem);
  EXPECT_EQ(u.newton.steps.size(), 1U);
  for (const VertexId v : ids(linear.values)) EXPECT_NEAR(u.state.values[v], linear.values[v], 1e-14);
  EXPECT_NEAR(u.state.fluxes[0].inflow, linear.fluxes[0].inflow, 1e-14);
  EXPECT_TRUE(u.state.matrix.is_m_matrix);
}

TEST(Nonlinear, TheHarmonicMeanConducts) {
  // kappa = 1 + u between 0, u and 1: 2 (1 + u) / (2 + u) u = 2 (1 + u) 2 / (3 + u) (1 - u).
  const Strip s = strip(3);
  DiffusionProblem<2> problem = between(0, 1);
  problem.conductivity = StateFunction<2>{[](const Vec<2>&, int, double u) { return 1 + u; }, {}};
  const auto solution = solve_nonlinear(s.volumes, s.boundary, problem);
  const double u = solution.state.values[v1];
  const double left = 2 * (1 + u) / (2 + u) * u, right = 4 * (1 + u) / (3 + u) * (1 - u);
  EXPECT_NEAR(left, right, 1e-14);
  EXPECT_NEAR(solution.state.fluxes[1].inflow, right, 1e-14);
  test::expect_balanced(solution.state.balances);
}

TEST(Nonlinear, ConvergesWithSecondOrderInSpace) {
  double before = 0;
  for (const std::size_t n : {8U, 16U, 32U, 64U}) {
    const Strip s = strip(n + 1);
    DiffusionProblem<2> problem = between(0, 2);
    problem.conductivity = exponential<2>();
    const Values u = solve_nonlinear(s.volumes, s.boundary, problem).state.values;
    double error = 0;
    for (const VertexId v : ids(u)) {
      const double x = static_cast<double>(v.value()) / static_cast<double>(n);
      error = std::max(error, std::abs(u[v] - std::log(1 + x * (std::exp(2.0) - 1))));
    }
    if (before > 0) {
      EXPECT_GT(before / error, 3.5) << n;
    }
    before = error;
  }
}

TEST(Nonlinear, ConvergesQuadratically) {
  const Strip s = strip(20);
  DiffusionProblem<2> problem = between(0, 2);
  problem.conductivity = exponential<2>();
  const NewtonReport report = solve_nonlinear(s.volumes, s.boundary, problem).newton;
  ASSERT_GE(report.steps.size(), 3U);
  EXPECT_LE(report.steps.size(), 10U);
  EXPECT_GT(report.first_residual, 1e-3);
  EXPECT_EQ(report.residual, report.steps.back().residual);
  for (std::size_t k = 1; k < report.steps.size(); ++k) {
    const double before = report.steps[k - 1].residual;
    if (before < 1e-2 && before > 1e-7) {
      EXPECT_LT(report.steps[k].residual, 20 * before * before) << k;
    }
  }
}

TEST(Nonlinear, BalancesCloseWhereEachResidualIsSmallButAllHaveOneSign) {
  for (const std::size_t n : {100U, 1000U, 10'000U}) {
    const Strip s = strip(n);
    DiffusionProblem<2> problem = between(0, 1);
    problem.source = StateFunction<2>{[](const Vec<2>&, int, double u) { return -u * u * u; }, {}};
    test::expect_balanced(solve_nonlinear(s.volumes, s.boundary, problem).state.balances);
  }
}

TEST(Nonlinear, DifferencesReplaceDerivatives) {
  const Strip s = strip(20);
  DiffusionProblem<2> problem = between(0, 2);
  StateFunction<2> kappa = exponential<2>();
  const auto cubic = [](const Vec<2>&, int, double u) { return 0.01 * (1 - u * u * u); };
  problem.conductivity = kappa;
  problem.source = StateFunction<2>{cubic, [](const Vec<2>&, int, double u) { return -0.03 * u * u; }};
  const auto given = solve_nonlinear(s.volumes, s.boundary, problem);
  kappa.derivative = {};
  problem.conductivity = kappa;
  problem.source = StateFunction<2>{cubic, {}};
  const auto found = solve_nonlinear(s.volumes, s.boundary, problem);
  EXPECT_EQ(given.newton.steps.size(), found.newton.steps.size());
  for (const VertexId v : ids(given.state.values)) EXPECT_NEAR(given.state.values[v], found.state.values[v], 1e-11);
}

TEST(Nonlinear, DampingFindsWhatFullStepsOvershoot) {
  // Newton's method for atan runs away from beyond 1.4.
  const Strip s = strip(3);
  DiffusionProblem<2> problem = between(0, 0);
  problem.source = StateFunction<2>{[](const Vec<2>&, int, double u) { return -1e4 * std::atan(u); }, {}};
  const auto u = solve_nonlinear(s.volumes, s.boundary, problem, Values(3, 10.0));
  EXPECT_NEAR(u.state.values[v1], 0, 1e-14);
  const auto& steps = u.newton.steps;
  EXPECT_TRUE(std::any_of(steps.begin(), steps.end(), [](const NewtonStep& step) { return step.damping < 1; }));
}

TEST(Nonlinear, StatesOutOfRangeAreNotTaken) {
  // kappa = u needs u > 0; a full step from 1 leads below.
  const Strip s = strip(12);
  DiffusionProblem<2> problem = between(1e-3, 1e-3);
  problem.conductivity = StateFunction<2>{[](const Vec<2>&, int, double u) { return u; }, {}};
  problem.source = -1e-9;
  const auto u = solve_nonlinear(s.volumes, s.boundary, problem, Values(12, 1.0));
  for (const double value : u.state.values) EXPECT_GT(value, 0);
  test::expect_balanced(u.state.balances);
}

TEST(Nonlinear, ASourceMayHoldTheSolution) {
  // No condition: f(u) = 0 in each cell.
  const Strip s = strip(4);
  DiffusionProblem<2> problem;
  problem.source = StateFunction<2>{[](const Vec<2>&, int, double u) { return 8 - u * u * u; }, {}};
  const auto u = solve_nonlinear(s.volumes, s.boundary, problem, Values(4, 1.0));
  for (const double value : u.state.values) EXPECT_NEAR(value, 2, 1e-12);
}

TEST(Nonlinear, SaysWhereItDidNotConverge) {
  const Strip s = strip(20);
  DiffusionProblem<2> problem = between(0, 3);
  problem.conductivity = exponential<2>();
  NewtonOptions options;
  options.max_steps = 2;
  const Fault fault = fault_of<NumericalError>([&] { solve_nonlinear(s.volumes, s.boundary, problem, {}, options); });
  EXPECT_EQ(fault.id, "solve.not_converged");
  EXPECT_EQ(fault.position.size(), 2U);
  EXPECT_NE(fault.message.find("in 2 steps"), std::string::npos) << fault.message;
}

TEST(Nonlinear, ASourceWithoutAnyZeroHasNoSolution) {
  const Strip s = strip(4);
  DiffusionProblem<2> problem;
  problem.source = StateFunction<2>{[](const Vec<2>&, int, double u) { return 1 + u * u; }, {}};
  const Fault fault =
      fault_of<NumericalError>([&] { solve_nonlinear(s.volumes, s.boundary, problem, Values(4, 1.0)); });
  EXPECT_TRUE(fault.id == "solve.not_converged" || fault.id == "solve.singular") << fault.id;
}

TEST(Nonlinear, RefusesWhatItCannotUse) {
  const Strip s = strip(3);
  const auto refused = [&](const DiffusionProblem<2>& problem, const Values& initial = {}) {
    return fault_of<InputError>([&] { solve_nonlinear(s.volumes, s.boundary, problem, initial); }).id;
  };
  DiffusionProblem<2> problem = between(0, 1);
  EXPECT_EQ(refused(problem, Values(2)), "solve.wrong_length");
  problem.mean = 1;
  EXPECT_EQ(refused(problem), "solve.nonlinear_mean");
  problem = between(0, 1);
  problem.conductivity = StateFunction<2>{[](const Vec<2>&, int, double u) { return u - 2; }, {}};
  EXPECT_EQ(refused(problem), "solve.bad_conductivity");
  EXPECT_EQ(fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); }).id, "solve.nonlinear");
  EXPECT_EQ(fault_of<InputError>([&] { assemble(s.volumes, s.boundary, problem); }).id, "solve.nonlinear");
  problem = between(0, 1);
  problem.reaction = exponential<2>();
  EXPECT_EQ(refused(problem), "solve.nonlinear");
  problem = between(0, 1);
  problem.source = exponential<2>();
  problem.source_integrals = IdVector<CellId, double>(3);
  EXPECT_EQ(refused(problem), "solve.nonlinear");
  problem = {};
  problem.conductivity = exponential<2>();
  EXPECT_EQ(refused(problem), "solve.no_condition");
}

TEST(Nonlinear, RefusesBadOptions) {
  const Strip s = strip(3);
  const auto refused = [&](const NewtonOptions& options) {
    return fault_of<OptionError>([&] { solve_nonlinear(s.volumes, s.boundary, between(0, 1), {}, options); }).id;
  };
  NewtonOptions options;
  options.tolerance = 0;
  EXPECT_EQ(refused(options), "solve.bad_option");
  options = {};
  options.max_steps = 0;
  EXPECT_EQ(refused(options), "solve.bad_option");
  options = {};
  options.smallest_damping = 2;
  EXPECT_EQ(refused(options), "solve.bad_option");
}

/// Two materials, one whose conductivity depends on u, a source that does, and all kinds of conditions.
template <int D>
DiffusionProblem<D> busy_problem() {
  DiffusionProblem<D> problem;
  problem.conductivity =
      StateFunction<D>{[](const Vec<D>& x, int region, double u) { return region == 7 ? 1 + u * u : 5 + x[1]; }, {}};
  problem.source =
      StateFunction<D>{[](const Vec<D>& x, int, double u) { return 3 * std::sin(5 * x[0]) - std::sinh(u); },
                       [](const Vec<D>&, int, double u) { return -std::cosh(u); }};
  problem.reaction = std::map<int, double>{{7, 0.0}, {9, 0.5}};
  problem.conditions = {{1, Dirichlet<D>{[](const Vec<D>& x) { return x[0]; }}},
                        {2, Robin<D>{0.7, 2.0}},
                        {3, Neumann<D>{[](const Vec<D>& x) { return std::cos(x[0]); }}},
                        {4, Rate<D>{0.3}}};
  return problem;
}

template <int D>
void everything_is_balanced() {
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.05 : 0.2));
  const auto boundary = build_boundary_areas(result.mesh);
  NewtonOptions options;
  options.linear.method = LinearMethod::kDirect;
  const auto direct = solve_nonlinear(result.volumes, boundary, busy_problem<D>(), {}, options);
  EXPECT_EQ(direct.state.linear.method, "direct");
  for (const auto kind : {PreconditionerKind::kDiagonal, PreconditionerKind::kIncompleteCholesky}) {
    options.linear.method = LinearMethod::kConjugateGradients;
    options.linear.preconditioner = kind;
    const auto iterated = solve_nonlinear(result.volumes, boundary, busy_problem<D>(), {}, options);
    EXPECT_EQ(iterated.state.linear.method, "BiCGSTAB");
    for (const VertexId v : ids(direct.state.values))
      EXPECT_NEAR(iterated.state.values[v], direct.state.values[v], 1e-10);
    test::expect_balanced(iterated.state.balances);
    if (kind == PreconditionerKind::kIncompleteCholesky) {
      EXPECT_EQ(iterated.state.linear.preconditioner, "incomplete LU");
    }
  }
  test::expect_balanced(direct.state.balances);
  EXPECT_TRUE(direct.state.matrix.is_m_matrix);
  for (const MarkerFlux& flux : direct.state.fluxes)
    if (flux.marker == 4) {
      EXPECT_NEAR(flux.inflow, 0.3, 1e-14);
    }
}
TEST(Nonlinear, EverythingIsBalancedInThePlane) { everything_is_balanced<2>(); }
TEST(Nonlinear, EverythingIsBalancedInSpace) { everything_is_balanced<3>(); }

TEST(Nonlinear, ThreadsDoNotMatter) {
  const test::AllowThreads allow(8);
  const auto result =
      make_mesh(domains::two_material_box<2>(), test::meshing_options<2>(test::all_fillings()[1], 0.008));
  ASSERT_GT(result.mesh.points.size(), 20'000U);  // More than one block of the factorization.
  const auto boundary = build_boundary_areas(result.mesh);
  const auto solve_with = [&](int n) {
    NonlinearSolution<2> u;
    NewtonOptions options;
    options.tolerance = 1e-6;
    options.linear.method = LinearMethod::kConjugateGradients;
    options.linear.tolerance = 1e-3;
    run_with_threads(n, [&] { u = solve_nonlinear(result.volumes, boundary, busy_problem<2>(), {}, options); });
    return u;
  };
  const auto one = solve_with(1), many = solve_with(8);
  EXPECT_EQ(one.state.values, many.state.values);
  EXPECT_EQ(one.newton.residual, many.newton.residual);
}

}  // namespace
}  // namespace voropack
