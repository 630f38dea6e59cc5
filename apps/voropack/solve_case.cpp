#include "solve_case.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "figure3.h"
#include "voropack/error.h"
#include "voropack/fem.h"
#include "voropack/nonlinear.h"
#include "voropack/norms.h"
#include "voropack/quality.h"
#include "voropack/transient.h"

namespace voropack::app {

namespace {

/// The solver knows no files: its errors are about the case.
template <class Work>
auto blame_case(const std::filesystem::path& file, Work&& work) {
  try {
    return work();
  } catch (const InputError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults)
      if (fault.file.empty()) fault.file = file.string();
    throw InputError(std::move(faults));
  }
}

template <int D>
VertexValues errors_at_vertices(const Setting<D>& setting, const IdVector<VertexId, double>& values, double time) {
  VertexValues errors(values.size());
  exact_solution(setting.compiled, time)(setting.mesh.points.raw(), errors.raw());
  for (const VertexId v : ids(errors)) errors[v] = values[v] - errors[v];
  return errors;
}

template <int D>
SolveErrors measure_errors(const Setting<D>& setting, const IdVector<VertexId, double>& values, double time) {
  const auto exact = exact_solution(setting.compiled, time);
  const auto gradient = exact_gradient(setting.compiled, time);
  const Mesh<D>& mesh = setting.mesh;
  const VertexValues errors = errors_at_vertices(setting, values, time);
  SolveErrors result;
  const auto& areas = setting.volumes.face_area;
  // Where areas are negative it is no norm.
  if (std::all_of(areas.begin(), areas.end(), [](double area) { return area >= 0; }))
    result.w = w_norm(setting.volumes, errors, find_hull_vertices(mesh));
  result.l2 = l2_error<D>(mesh, values, exact);
  result.max = max_norm(errors);
  if constexpr (D == 2) {
    result.h1 = h1_error<D>(mesh, values, gradient);
  } else {
    IdVector<SimplexId, std::uint8_t> is_sliver(mesh.simplex_vertices.size());
    for (const SimplexId s : ids(is_sliver)) is_sliver[s] = min_dihedral_deg(mesh, s) < kSliverDihedralDeg ? 1 : 0;
    result.n_slivers = static_cast<std::uint64_t>(std::count(is_sliver.begin(), is_sliver.end(), 1));
    // Each simplex is integrated over once: formulas take their time.
    const auto h1_where = [&](std::uint8_t sliver) {
      return h1_error<D>(mesh, values, gradient, [&](SimplexId s) { return is_sliver[s] == sliver; });
    };
    result.h1_without_slivers = h1_where(0);
    result.h1 = std::hypot(*result.h1_without_slivers, h1_where(1));
  }
  return result;
}

/// What multigrid does not precondition is left to incomplete Cholesky, or with finite elements, where slivers make it
/// break down, to the diagonal.
template <int D>
NewtonOptions solver_options(const Case& given, MultigridMaker<D>& multigrid) {
  NewtonOptions options = given.newton;
  options.linear.own_preconditioner = std::ref(multigrid);
  const bool is_diagonal =
      given.preconditioner == CasePreconditioner::kDiagonal ||
      (given.preconditioner != CasePreconditioner::kIncompleteCholesky && given.method == CaseMethod::kFiniteElements);
  options.linear.preconditioner = is_diagonal ? PreconditionerKind::kDiagonal : PreconditionerKind::kIncompleteCholesky;
  return options;
}

/// The problem at a time, with the integrals of a source that is a formula. Where it does not depend on time, it is
/// integrated once.
template <int D>
class ProblemInTime {
 public:
  explicit ProblemInTime(const Setting<D>& setting)
      : setting_(setting), source_varies_(any_formula<D>(setting.compiled.source, &CompiledFormula<D>::uses_time)) {}

  DiffusionProblem<D> operator()(double time) {
    DiffusionProblem<D> problem = make_problem(setting_.compiled, time);
    if (!setting_.shapes) return problem;
    if (!is_integrated_ || source_varies_)
      integrals_ = integrate_source(setting_.compiled, *setting_.shapes, setting_.volumes, time);
    is_integrated_ = true;
    problem.source_integrals = integrals_;
    return problem;
  }

 private:
  const Setting<D>& setting_;
  bool source_varies_;
  bool is_integrated_ = false;
  std::optional<IdVector<CellId, double>> integrals_;
};

}  // namespace

template <int D>
DiffusionProblem<D> stationary_problem(const Setting<D>& setting) {
  return ProblemInTime<D>(setting)(0);
}

namespace {

template <int D>
void add_flows(DiffusionSolution<D>& solution, SolveFigures& figures) {
  figures.fluxes = std::move(solution.fluxes);
  figures.balances = std::move(solution.balances);
  figures.matrix = solution.matrix;
  figures.linear = std::move(solution.linear);
  figures.compensation = solution.compensation;
}

template <int D>
IdVector<VertexId, double> solve_stationary(const Setting<D>& setting, const NewtonOptions& options,
                                            SolveFigures& figures, Observer& observer) {
  DiffusionSolution<D> solution;
  if (setting.given.method == CaseMethod::kFiniteElements) {
    solution = solve_fem(setting.mesh, make_problem(setting.compiled, 0), options.linear, observer);
  } else {
    observer.begin_stage("assemble");
    const DiffusionProblem<D> problem = stationary_problem(setting);
    if (setting.compiled.is_nonlinear) {
      IdVector<VertexId, double> initial;
      if (setting.given.newton_initial) initial = vertex_values(setting.compiled.newton_initial, setting.mesh);
      NonlinearSolution<D> nonlinear =
          solve_nonlinear(setting.volumes, setting.boundary, problem, initial, options, observer);
      solution = std::move(nonlinear.state);
      figures.newton = std::move(nonlinear.newton);
    } else {
      solution = solve(setting.volumes, setting.boundary, problem, options.linear, observer);
    }
  }
  add_flows(solution, figures);
  return std::move(solution.values);
}

template <int D>
SolutionArrays<D> to_arrays(const Setting<D>& setting, IdVector<VertexId, double> values, double time) {
  SolutionArrays<D> arrays;
  if (setting.compiled.exact) arrays.error = errors_at_vertices(setting, values, time);
  arrays.u = std::move(values);
  return arrays;
}

/// Which states are written before the last: the initial one, and the first to reach each multiple of the interval.
class Schedule {
 public:
  Schedule(const TimeOptions& options, std::optional<double> every)
      : begin_(options.begin), end_(options.end), every_(every) {}

  bool is_due(double time) {
    if (time <= begin_) return true;
    if (!every_ || time >= end_) return false;
    constexpr double kRounding = 1e-9;  // Of an interval: times are sums of steps.
    if (time < begin_ + *every_ * (static_cast<double>(next_) - kRounding)) return false;
    next_ = static_cast<std::uint64_t>((time - begin_) / *every_ + kRounding) + 1;
    return true;
  }

 private:
  double begin_, end_;
  std::optional<double> every_;
  std::uint64_t next_ = 1;
};

template <int D>
IdVector<VertexId, double> solve_in_time(const Setting<D>& setting, const NewtonOptions& solvers,
                                         const StateCallback<D>& on_state, SolveFigures& figures, Observer& observer) {
  const CaseTime& time = *setting.given.time;
  ProblemInTime<D> problem_at(setting);
  TransientProblem<D> problem;
  problem.at = [&](double t) { return problem_at(t); };
  problem.capacity = to_coefficient<D>(setting.compiled.capacity, 0);
  problem.initial = to_coefficient<D>(setting.compiled.initial, 0);
  TimeOptions options = time.options;
  options.newton = solvers;
  figures.time.emplace();
  Schedule schedule(options, setting.given.outputs.every);
  const auto on_step = [&](const TransientStep<D>& step) {
    if (on_state && schedule.is_due(step.time)) on_state(step.time, to_arrays(setting, step.values, step.time));
    if (step.length == 0) return;  // The initial state.
    const auto [least, largest] = std::minmax_element(step.values.begin(), step.values.end());
    figures.time->rows.push_back({.time = step.time,
                                  .length = step.length,
                                  .least = *least,
                                  .largest = *largest,
                                  .fluxes = step.fluxes,
                                  .balances = step.balances,
                                  .linear_iterations = step.linear_iterations,
                                  .newton_steps = step.newton.size()});
  };
  TransientSolution<D> solution =
      solve_transient<D>(setting.volumes, setting.boundary, problem, options, on_step, observer);
  figures.time->report = solution.report;
  figures.fluxes = figures.time->rows.back().fluxes;
  figures.balances = figures.time->rows.back().balances;
  figures.matrix = solution.matrix;
  figures.linear = std::move(solution.linear);
  return std::move(solution.values);
}

}  // namespace

template <int D>
void prepare(Setting<D>& setting, Observer& observer) {
  setting.boundary = bind_case(setting.given, setting.mesh, setting.compiled, observer);
  const bool integrates = setting.given.method == CaseMethod::kControlVolumes &&
                          any_formula<D>(setting.compiled.source, &CompiledFormula<D>::is_formula);
  setting.shapes.reset();
  if (setting.writes_cells || integrates) setting.shapes = build_cell_shapes(setting.mesh, setting.volumes);
}

template <int D>
Solved<D> solve_case(const Setting<D>& setting, const StateCallback<D>& on_state, Observer& observer) {
  Solved<D> result;
  SolveFigures& figures = result.figures;
  figures.method = setting.given.method;
  const double end = setting.given.time ? setting.given.time->options.end : 0;
  MultigridMaker<D> multigrid = blame_case(
      setting.given.file, [&] { return MultigridMaker<D>(setting.mesh, setting.domain, setting.given, observer); });
  const NewtonOptions options = solver_options(setting.given, multigrid);
  IdVector<VertexId, double> values = blame_case(setting.given.file, [&] {
    return setting.given.time ? solve_in_time(setting, options, on_state, figures, observer)
                              : solve_stationary(setting, options, figures, observer);
  });
  figures.multigrid = multigrid.figures();
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  figures.least = *least;
  figures.largest = *largest;
  if (setting.compiled.exact) {
    observer.begin_stage("norms");
    figures.errors = measure_errors(setting, values, end);
  }
  result.arrays = to_arrays(setting, std::move(values), end);
  return result;
}

template DiffusionProblem<2> stationary_problem(const Setting<2>&);
template DiffusionProblem<3> stationary_problem(const Setting<3>&);
template void prepare(Setting<2>&, Observer&);
template void prepare(Setting<3>&, Observer&);
template Solved<2> solve_case(const Setting<2>&, const StateCallback<2>&, Observer&);
template Solved<3> solve_case(const Setting<3>&, const StateCallback<3>&, Observer&);

}  // namespace voropack::app
