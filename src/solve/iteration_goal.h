// When an iteration ends: what conjugate gradients and BiCGSTAB have in common.
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "voropack/error.h"
#include "voropack/linear_system.h"

namespace voropack {

struct IterationGoal {
  double tolerance = 0;  ///< Relative to `unit`.
  double unit = 0;       ///< The residual norm of the solution 0, > 0.
  int max_iterations = 0;
};

/// Runs an iteration until the residual is small enough. The residual of its recurrence drifts away from the true one
/// by rounding. Where that matters, the iteration begins anew from the true one, as long as this gains something.
///
/// `start(values)` sets the residual to that of `values` and returns its norm; `run(values)` iterates from there until
/// the residual of the recurrence is small enough, and adds to the residuals of the report.
template <class Iteration>
void iterate_to(const IterationGoal& goal, Iteration& iteration, std::vector<double>& values, LinearReport& report) {
  double reached = iteration.start(values);
  report.residuals = {reached / goal.unit};
  report.residual = reached / goal.unit;
  for (double before = 2 * reached; reached > goal.tolerance * goal.unit && reached <= 0.5 * before;) {
    iteration.run(values);
    before = reached;
    reached = iteration.start(values);
    report.residual = reached / goal.unit;
  }
}

/// Throws NumericalError solve.not_converged. `residual` is relative.
[[noreturn]] inline void throw_not_converged(std::string_view method, const Preconditioner& preconditioner,
                                             double residual, int n_iterations) {
  throw NumericalError(
      Fault{.id = "solve.not_converged",
            .message = fmt::format("{} with {} preconditioner reached a relative residual of {:.3g} in {} iterations",
                                   method, preconditioner.name(), residual, n_iterations),
            .fix = "raise the number of iterations or the tolerance, or use the direct solver"});
}

}  // namespace voropack
