#include "solve/linear_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "base/iteration_limits.h"
#include "solve/bicgstab.h"
#include "solve/conjugate_gradients.h"
#include "solve/incomplete_lu.h"
#include "solve/preconditioners.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

void check_options(const LinearOptions& options) {
  check_iteration_limits("solve.bad_option", "the linear solver", options.tolerance, options.max_iterations,
                         "iterations");
}

std::shared_ptr<const Preconditioner> make_preconditioner(const LinearSystem& system, const LinearOptions& options) {
  if (options.own_preconditioner)
    if (auto own = options.own_preconditioner(system)) return own;
  if (options.preconditioner == PreconditionerKind::kDiagonal) return std::make_shared<DiagonalPreconditioner>(system);
  if (!system.is_symmetric) return std::make_shared<IncompleteLu>(system);
  return std::make_shared<IncompleteCholesky>(system);
}

/// The norm of the residual of the solution 0.
double load_norm(const LinearSystem& system) {
  std::vector<double> residual(system.matrix.size());
  free_residual(system, system.fixed_value.raw(), residual);
  return norm(residual);
}

void check_overflow(double norm_of_residual) {
  if (!std::isfinite(norm_of_residual))
    throw NumericalError(Fault{.id = "solve.overflow",
                               .message = "the linear system has numbers beyond the range of double precision",
                               .fix = "choose units in which conductivities, sources and values are nearer to 1"});
}

}  // namespace

LinearSolver::LinearSolver(const LinearSystem& system, const LinearOptions& options)
    : options_(options),
      n_unknowns_(static_cast<std::uint64_t>(std::count(system.is_fixed.begin(), system.is_fixed.end(), 0))) {
  check_options(options);
  const bool is_direct = options.method == LinearMethod::kDirect ||
                         (options.method == LinearMethod::kAutomatic && n_unknowns_ <= options.max_direct);
  if (is_direct)
    direct_.emplace(system);
  else
    preconditioner_ = make_preconditioner(system, options);
}

LinearSolution LinearSolver::solve(const LinearSystem& system, Observer& observer,
                                   const IdVector<VertexId, double>* guess) const {
  LinearSolution solution{.values = system.fixed_value, .report = {}};
  LinearReport& report = solution.report;
  report.n_unknowns = n_unknowns_;
  report.n_entries = system.matrix.values.size();
  report.method = direct_ ? "direct" : system.is_symmetric ? "conjugate gradients" : "BiCGSTAB";
  if (preconditioner_) report.preconditioner = preconditioner_->name();
  const double unit = load_norm(system);
  report.residuals = {unit > 0 ? 1.0 : 0.0};
  check_overflow(unit);
  if (unit == 0) return solution;
  std::vector<double>& values = solution.values.raw();
  if (direct_) {
    direct_->solve(system, unit, values, report);
    check_overflow(report.residual);
    return solution;
  }
  if (guess != nullptr)
    for (const VertexId v : ids(*guess))
      if (system.is_fixed[v] == 0) solution.values[v] = (*guess)[v];
  const auto iterate = system.is_symmetric ? conjugate_gradients : bicgstab;
  iterate(system, *preconditioner_, {options_.tolerance, unit, options_.max_iterations}, observer, values, report);
  check_overflow(report.residual);
  return solution;
}

LinearSolution solve_linear_system(const LinearSystem& system, const LinearOptions& options, Observer& observer) {
  observer.begin_stage("solve");
  return LinearSolver(system, options).solve(system, observer);
}

}  // namespace voropack
