#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "solve/conjugate_gradients.h"
#include "solve/direct_solver.h"
#include "solve/preconditioners.h"
#include "voropack/linear_system.h"

namespace voropack {

namespace {

void check_options(const LinearOptions& options) {
  const auto fail = [](std::string message, std::string fix) {
    throw OptionError(Fault{.id = "solve.bad_option", .message = std::move(message), .fix = std::move(fix)});
  };
  if (!(options.tolerance > 0 && options.tolerance < 1))
    fail(fmt::format("the tolerance of the linear solver is {}", options.tolerance), "choose it between 0 and 1");
  if (options.max_iterations < 1)
    fail(fmt::format("the linear solver may make {} iterations", options.max_iterations), "allow at least 1");
}

std::shared_ptr<const Preconditioner> make_preconditioner(const LinearSystem& system, const LinearOptions& options) {
  if (options.own_preconditioner) return options.own_preconditioner;
  if (options.preconditioner == PreconditionerKind::kDiagonal) return std::make_shared<DiagonalPreconditioner>(system);
  return std::make_shared<IncompleteCholesky>(system);
}

}  // namespace

LinearSolution solve_linear_system(const LinearSystem& system, const LinearOptions& options, Observer& observer) {
  check_options(options);
  observer.begin_stage("solve");
  LinearSolution solution;
  LinearReport& report = solution.report;
  report.n_unknowns = static_cast<std::uint64_t>(std::count(system.is_fixed.begin(), system.is_fixed.end(), 0));
  report.n_entries = system.matrix.values.size();
  std::vector<double> values = system.fixed_value.raw();
  const bool is_direct = options.method == LinearMethod::kDirect ||
                         (options.method == LinearMethod::kAutomatic && report.n_unknowns <= options.max_direct);
  if (is_direct) {
    report.method = "direct";
    solve_directly(system, values, report);
  } else {
    const auto preconditioner = make_preconditioner(system, options);
    report.method = "conjugate gradients";
    report.preconditioner = preconditioner->name();
    conjugate_gradients(system, *preconditioner, options.tolerance, options.max_iterations, observer, values, report);
  }
  solution.values = IdVector<VertexId, double>(std::move(values));
  return solution;
}

}  // namespace voropack
