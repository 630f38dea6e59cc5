// Preconditioned conjugate gradients on the free vertices of a system.
#pragma once

#include <vector>

#include "voropack/linear_system.h"
#include "voropack/observer.h"

namespace voropack {

/// Improves `values`, which has the fixed values in place, until the residual is at most the tolerance relative to the
/// first one, or rounding stops it. Appends to report.residuals. Throws NumericalError solve.not_converged,
/// solve.singular.
void conjugate_gradients(const LinearSystem& system, const Preconditioner& preconditioner, double tolerance,
                         int max_iterations, Observer& observer, std::vector<double>& values, LinearReport& report);

}  // namespace voropack
