// Preconditioned conjugate gradients on the free vertices of a system.
#pragma once

#include <vector>

#include "solve/iteration_goal.h"
#include "voropack/linear_system.h"
#include "voropack/observer.h"

namespace voropack {

/// Improves `values`, which has the fixed values in place, until the residual is at most the tolerance relative to the
/// first one, or rounding stops it. Appends to report.residuals. Throws NumericalError solve.not_converged,
/// solve.singular.
void conjugate_gradients(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
                         Observer& observer, std::vector<double>& values, LinearReport& report);

}  // namespace voropack
