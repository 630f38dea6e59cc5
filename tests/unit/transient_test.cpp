// Steps in time: orders, exactness, conservation, and what is refused.
#include "voropack/transient.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

constexpr auto kSchemes = {TimeScheme::kBackwardEuler, TimeScheme::kCrankNicolson};

/// A problem that does not depend on time.
template <int D>
TransientProblem<D> steady(const DiffusionProblem<D>& problem) {
  TransientProblem<D> out;
  out.at = [problem](double) { return problem; };
  return out;
}

/// Three vertices with fixed ends: du/dt = -2 u in the middle, from 1.
TransientProblem<2> decay() {
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Dirichlet<2>{0.0}}, {2, Dirichlet<2>{0.0}}};
  TransientProblem<2> transient = steady(problem);
  transient.initial = 1.0;
  return transient;
}

double decayed(TimeScheme scheme, double step) {
  const Strip s = strip(3);
  TimeOptions options;
  options.scheme = scheme;
  options.step = step;
  return solve_transient(s.volumes, s.boundary, decay(), options).values[VertexId(1)];
}

TEST(Transient, OrderOneAndTwoInTime) {
  const double exact = std::exp(-2.0);
  for (const auto scheme : kSchemes) {
    const double ratio = (decayed(scheme, 0.02) - exact) / (decayed(scheme, 0.01) - exact);
    EXPECT_NEAR(std::log2(ratio), scheme == TimeScheme::kBackwardEuler ? 1 : 2, 0.1);
  }
}

TEST(Transient, OneStepOfBackwardEulerByHand) {
  // (u - 1) / 1 = -2 u
  EXPECT_NEAR(decayed(TimeScheme::kBackwardEuler, 1), 1.0 / 3, 1e-15);
}

TEST(Transient, CrankNicolsonByHand) {
  // Without startup: (u - 1) / 1 = -(u + 1); u = 0.
  const Strip s = strip(3);
  TimeOptions options;
  options.step = 1;
  options.n_startup = 0;
  const auto u = solve_transient(s.volumes, s.boundary, decay(), options);
  EXPECT_NEAR(u.values[VertexId(1)], 0, 1e-15);
  EXPECT_EQ(u.report.n_steps, 1U);
  EXPECT_TRUE(u.matrix.is_m_matrix);
}

TEST(Transient, StartupStepsDampRinging) {
  // Steps far beyond what the mode 1 -> 0 needs: Crank-Nicolson alone flips its sign, again and again.
  const Strip s = strip(3);
  TransientProblem<2> problem = decay();
  problem.capacity = 1e-4;
  TimeOptions options;
  options.step = 0.1;
  options.n_startup = 0;
  EXPECT_GT(std::abs(solve_transient(s.volumes, s.boundary, problem, options).values[VertexId(1)]), 0.9);
  options.n_startup = 2;
  const auto damped = solve_transient(s.volumes, s.boundary, problem, options);
  EXPECT_LT(std::abs(damped.values[VertexId(1)]), 1e-10);
  EXPECT_EQ(damped.report.n_steps, 12U);
  EXPECT_EQ(damped.report.n_factorizations, 1U);  // Two halves of backward Euler have the same matrix.
}

template <int D>
double linear(const Vec<D>& x) {
  return 2 + x[0] - 0.5 * x[1];
}

/// u = linear(x) + 3 t, with capacity and conductivity that vary by region.
template <int D>
TransientProblem<D> linear_in_time(const BoundaryAreas<D>& boundary) {
  TransientProblem<D> problem;
  problem.capacity = std::map<int, double>{{7, 2.0}, {9, 5.0}};
  problem.initial = [](const Vec<D>& x, int) { return linear(x); };
  problem.at = [boundary](double t) {
    DiffusionProblem<D> now;
    now.source = std::map<int, double>{{7, 6.0}, {9, 15.0}};
    for (const int marker : boundary.patch_marker)
      now.conditions[marker] = Dirichlet<D>{[t](const Vec<D>& x) { return linear(x) + 3 * t; }};
    return now;
  };
  return problem;
}

template <int D>
void linear_functions_are_exact() {
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.1 : 0.3));
  const auto boundary = build_boundary_areas(result.mesh);
  for (const auto scheme : kSchemes)
    for (const bool is_adaptive : {false, true}) {
      TimeOptions options;
      options.end = 0.7;
      options.step = 0.1;
      options.scheme = scheme;
      if (is_adaptive) options.tolerance = 1e-3;
      const auto u = solve_transient<D>(result.volumes, boundary, linear_in_time(boundary), options,
                                        [](const TransientStep<D>& step) { test::expect_balanced(step.balances); });
      for (const VertexId v : ids(u.values)) EXPECT_NEAR(u.values[v], linear(result.volumes.sites[v]) + 3 * 0.7, 1e-12);
    }
}
TEST(Transient, LinearFunctionsAreExactInThePlane) { linear_functions_are_exact<2>(); }
TEST(Transient, LinearFunctionsAreExactInSpace) { linear_functions_are_exact<3>(); }

TEST(Transient, BackwardEulerKeepsTheMaximumPrinciple) {
  const auto result = make_mesh(domains::unit_box<2>(), test::meshing_options<2>(test::all_fillings()[1], 0.05));
  const auto boundary = build_boundary_areas(result.mesh);
  TransientProblem<2> problem = steady(DiffusionProblem<2>{});
  problem.initial = [](const Vec<2>& x, int) { return x[0] < 0.5 ? 0.0 : 1.0; };
  for (const double step : {1e-4, 1e-2, 1.0}) {
    TimeOptions options;
    options.end = 5 * step;
    options.step = step;
    options.scheme = TimeScheme::kBackwardEuler;
    solve_transient<2>(result.volumes, boundary, problem, options, [](const TransientStep<2>& at) {
      for (const double u : at.values) {
        EXPECT_GE(u, -1e-14);
        EXPECT_LE(u, 1 + 1e-14);
      }
    });
  }
}

template <int D>
double content(const ControlVolumes<D>& volumes, const IdVector<VertexId, double>& values) {
  double sum = 0;
  for (const CellId c : ids(volumes.cell_vertex)) sum += volumes.cell_volume[c] * values[volumes.cell_vertex[c]];
  return sum;
}

TEST(Transient, AClosedDomainKeepsItsContent) {
  const auto result = make_mesh(domains::unit_box<3>(), test::meshing_options<3>(test::all_fillings()[1], 0.2));
  const auto boundary = build_boundary_areas(result.mesh);
  TransientProblem<3> problem = steady(DiffusionProblem<3>{});
  IdVector<VertexId, double> initial;
  for (const Vec<3>& x : result.volumes.sites) initial.push_back(std::exp(x[0]));
  problem.initial = initial;
  for (const auto scheme : kSchemes) {
    TimeOptions options;
    options.end = 0.1;
    options.scheme = scheme;
    options.newton.linear.method = LinearMethod::kConjugateGradients;
    options.newton.linear.tolerance = 1e-6;  // Closed all the same.
    const auto u = solve_transient(result.volumes, boundary, problem, options);
    const double before = content(result.volumes, initial), after = content(result.volumes, u.values);
    EXPECT_NEAR(after, before, 1e-12 * before);
    EXPECT_GT(*std::min_element(u.values.begin(), u.values.end()), 1.1);  // Something has happened.
  }
}

/// Two materials, all kinds of conditions that change with time; if asked for, a conductivity that depends on u.
template <int D>
TransientProblem<D> busy_problem(bool is_nonlinear) {
  TransientProblem<D> problem;
  problem.capacity = std::map<int, double>{{7, 2.0}, {9, 5.0}};
  problem.at = [=](double t) {
    DiffusionProblem<D> now;
    now.conductivity = [](const Vec<D>& x, int region) { return region == 7 ? 1 + x[1] : 20.0; };
    if (is_nonlinear) now.conductivity = StateFunction<D>{[](const Vec<D>&, int, double u) { return 1 + u * u; }, {}};
    now.reaction = std::map<int, double>{{7, 0.0}, {9, 0.5}};
    now.source = [t](const Vec<D>& x, int) { return 3 * std::sin(5 * x[0] + 20 * t); };
    now.conditions = {{1, Dirichlet<D>{[t](const Vec<D>& x) { return x[0] + t; }}},
                      {2, Robin<D>{0.7, 2.0 + t}},
                      {3, Neumann<D>{[t](const Vec<D>& x) { return std::cos(x[0] + 10 * t); }}}};
    return now;
  };
  return problem;
}

template <int D>
void everything_is_balanced() {
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.08 : 0.3));
  const auto boundary = build_boundary_areas(result.mesh);
  for (const auto scheme : kSchemes)
    for (const bool is_nonlinear : {false, true}) {
      TimeOptions options;
      options.end = 0.2;
      options.step = 0.02;
      options.scheme = scheme;
      const TransientProblem<D> problem = busy_problem<D>(is_nonlinear);
      double time = 0, stored = 0, before = 0;
      const auto u = solve_transient<D>(result.volumes, boundary, problem, options, [&](const TransientStep<D>& step) {
        if (step.length == 0) return;
        test::expect_balanced(step.balances);
        EXPECT_NEAR(step.time, time + step.length, 1e-14);
        EXPECT_EQ(step.newton.empty(), !is_nonlinear);
        time = step.time;
        for (const RegionBalance& b : step.balances) stored += step.length * b.stored;
      });
      EXPECT_EQ(time, options.end);
      // What is stored in all steps is what there is more at the end than at the beginning.
      double after = 0;
      for (const CellId c : ids(result.volumes.cell_vertex)) {
        const VertexId v = result.volumes.cell_vertex[c];
        const double weight = result.volumes.cell_volume[c] * (result.volumes.cell_region[c] == 7 ? 2 : 5);
        after += weight * u.values[v];
        for (std::size_t p = 0; p < boundary.patch_vertex.size(); ++p)
          if (boundary.patch_vertex[PatchId(p)] == v && boundary.patch_marker[PatchId(p)] == 1) {
            before += weight * result.volumes.sites[v][0];
            break;
          }
      }
      EXPECT_NEAR(stored, after - before, 1e-11);
    }
}
TEST(Transient, EveryStepIsBalancedInThePlane) { everything_is_balanced<2>(); }
TEST(Transient, EveryStepIsBalancedInSpace) { everything_is_balanced<3>(); }

TEST(Transient, AdaptiveStepsAgreeWithFixedOnes) {
  const Strip s = strip(9);
  const auto problem = [](double t) {
    DiffusionProblem<2> now;
    now.conditions = {{1, Dirichlet<2>{std::sin(3 * t)}}, {2, Neumann<2>{1.0}}};
    return now;
  };
  TransientProblem<2> transient;
  transient.at = problem;
  for (const auto scheme : kSchemes) {
    TimeOptions options;
    options.scheme = scheme;
    options.step = 1e-4;
    const auto fixed = solve_transient(s.volumes, s.boundary, transient, options);
    options.step = 0.5;  // Too long for the tolerance.
    options.tolerance = scheme == TimeScheme::kBackwardEuler ? 1e-5 : 1e-6;
    const auto adaptive = solve_transient(s.volumes, s.boundary, transient, options);
    EXPECT_GT(adaptive.report.n_rejected, 0U);
    EXPECT_LT(adaptive.report.n_steps, fixed.report.n_steps / 5);
    EXPECT_GT(adaptive.report.longest_step, 1.5 * adaptive.report.shortest_step);
    for (const VertexId v : ids(fixed.values)) EXPECT_NEAR(adaptive.values[v], fixed.values[v], 2e-3);
    EXPECT_LT(adaptive.report.n_factorizations, adaptive.report.n_steps / 2);
  }
}

TEST(Transient, ASmallerToleranceIsMoreAccurate) {
  const Strip s = strip(3);
  double before = 1;
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
    TimeOptions options;
    options.tolerance = tolerance;
    options.step = 0.1;
    const auto u = solve_transient(s.volumes, s.boundary, decay(), options);
    const double error = std::abs(u.values[VertexId(1)] - std::exp(-2.0));
    EXPECT_LT(error, 20 * tolerance);
    EXPECT_LT(error, before);
    before = error;
  }
}

TEST(Transient, ConditionsMayBeginToHold) {
  // The left end is free until time 1/2, and fixed at 5 then. Crank-Nicolson begins anew.
  const Strip s = strip(3);
  TransientProblem<2> problem;
  problem.at = [](double t) {
    DiffusionProblem<2> now;
    if (t > 0.5) now.conditions[1] = Dirichlet<2>{5.0};
    return now;
  };
  problem.initial = 1.0;
  for (const auto scheme : kSchemes) {
    TimeOptions options;
    options.scheme = scheme;
    options.step = 0.1;
    double last = 0, entered = 0;
    solve_transient<2>(s.volumes, s.boundary, problem, options, [&](const TransientStep<2>& step) {
      if (step.length == 0) return;
      test::expect_balanced(step.balances);
      entered += step.length * step.fluxes[0].inflow;
      if (step.time < 0.51) {
        EXPECT_NEAR(step.values[VertexId(1)], 1, 1e-14);
      }
      if (step.time > 0.51) {
        EXPECT_EQ(step.values[VertexId(0)], 5);
      }
      last = content(s.volumes, step.values);
    });
    EXPECT_NEAR(entered, last - 2, 1e-13);
    EXPECT_GT(last, 4);
  }
}

TEST(Transient, TheInitialStateComesFirst) {
  const Strip s = strip(3, 1);
  TransientProblem<2> problem = steady(DiffusionProblem<2>{});
  problem.at = [](double) {
    DiffusionProblem<2> at;
    at.conditions[1] = Dirichlet<2>{7.0};
    return at;
  };
  problem.initial = [](const Vec<2>& x, int) { return x[0]; };
  TimeOptions options;
  options.begin = 2;
  options.end = 3;
  options.step = 0.5;
  options.n_startup = 0;
  std::vector<TransientStep<2>> steps;
  const auto u = solve_transient<2>(s.volumes, s.boundary, problem, options,
                                    [&](const TransientStep<2>& step) { steps.push_back(step); });
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(u.report.n_steps, 2U);
  EXPECT_EQ(steps[0].time, 2);
  EXPECT_EQ(steps[0].length, 0);
  EXPECT_TRUE(steps[0].balances.empty());
  for (const VertexId v : ids(s.volumes.sites)) {
    const double value = steps[0].values[v];
    EXPECT_TRUE(value == 7 || value == s.volumes.sites[v][0]);
  }
  EXPECT_EQ(std::count(steps[0].values.begin(), steps[0].values.end(), 7.0),
            std::count(u.values.begin(), u.values.end(), 7.0));
}

TEST(Transient, AtAnInterfaceInitialValuesAreWeightedByCapacity) {
  const Strip s = strip(3, 1);
  TransientProblem<2> problem = steady(DiffusionProblem<2>{});
  problem.capacity = std::map<int, double>{{1, 1.0}, {2, 3.0}};
  problem.initial = std::map<int, double>{{1, 4.0}, {2, 8.0}};
  TimeOptions options;
  options.end = 1e4;
  options.step = 1e3;
  options.scheme = TimeScheme::kBackwardEuler;
  const auto u = solve_transient(s.volumes, s.boundary, problem, options);
  for (const double value : u.values) EXPECT_NEAR(value, 7, 1e-10);  // (4 * 1 + 8 * 3) / 4
}

TEST(Transient, ThreadsDoNotMatter) {
  const test::AllowThreads allow(8);
  const auto result =
      make_mesh(domains::two_material_box<2>(), test::meshing_options<2>(test::all_fillings()[1], 0.04));
  const auto boundary = build_boundary_areas(result.mesh);
  for (const bool is_nonlinear : {false, true}) {
    const auto solve_with = [&](int n) {
      TransientSolution<2> u;
      TimeOptions options;
      options.end = 0.05;
      options.tolerance = 0.03;
      options.newton.linear.method = LinearMethod::kConjugateGradients;
      run_with_threads(n,
                       [&] { u = solve_transient(result.volumes, boundary, busy_problem<2>(is_nonlinear), options); });
      return u;
    };
    const auto one = solve_with(1), many = solve_with(8);
    EXPECT_EQ(one.values, many.values);
    EXPECT_EQ(one.report.n_steps, many.report.n_steps);
    EXPECT_EQ(one.report.linear_iterations, many.report.linear_iterations);
    EXPECT_GT(one.report.linear_iterations, 0U);
  }
}

TEST(Transient, RefusesWhatItCannotUse) {
  const Strip s = strip(3);
  const auto refused = [&](const TransientProblem<2>& problem) {
    return fault_of<InputError>([&] { solve_transient(s.volumes, s.boundary, problem); }).id;
  };
  TransientProblem<2> problem = decay();
  problem.capacity = 0.0;
  EXPECT_EQ(refused(problem), "solve.bad_capacity");
  problem = decay();
  problem.initial = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refused(problem), "solve.bad_initial");
  problem = decay();
  problem.at = [](double) {
    DiffusionProblem<2> now;
    now.mean = 1;
    return now;
  };
  EXPECT_EQ(refused(problem), "solve.mean_not_free");
  problem.at = {};
  EXPECT_EQ(fault_of<OptionError>([&] { solve_transient(s.volumes, s.boundary, problem); }).id, "solve.bad_option");
}

TEST(Transient, RefusesBadOptions) {
  const Strip s = strip(3);
  const auto refused = [&](auto&& change) {
    TimeOptions options;
    change(options);
    return fault_of<OptionError>([&] { solve_transient(s.volumes, s.boundary, decay(), options); }).id;
  };
  EXPECT_EQ(refused([](TimeOptions& o) { o.end = o.begin; }), "solve.bad_option");
  EXPECT_EQ(refused([](TimeOptions& o) { o.step = 0; }), "solve.bad_option");
  EXPECT_EQ(refused([](TimeOptions& o) { o.n_startup = -1; }), "solve.bad_option");
  EXPECT_EQ(refused([](TimeOptions& o) { o.tolerance = 0; }), "solve.bad_option");
  EXPECT_EQ(refused([](TimeOptions& o) { o.smallest_step = -1; }), "solve.bad_option");
}

TEST(Transient, SaysWhenItCannotGoOn) {
  const Strip s = strip(3);
  TimeOptions options;
  options.max_steps = 10;
  EXPECT_EQ(fault_of<LimitError>([&] { solve_transient(s.volumes, s.boundary, decay(), options); }).id,
            "solve.too_many_steps");
  options = {};
  options.tolerance = 1e-9;
  options.smallest_step = 0.005;
  EXPECT_EQ(fault_of<NumericalError>([&] { solve_transient(s.volumes, s.boundary, decay(), options); }).id,
            "solve.step_too_small");
}

}  // namespace
}  // namespace voropack
