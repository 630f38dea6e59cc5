// The stabilized bi-conjugate gradient method for systems that are not symmetric.
#pragma once

#include <vector>

#include "solve/iteration_goal.h"
#include "voropack/linear_system.h"

namespace voropack {

/// Improves the free entries of `values`, and fills the residuals and iterations of the report. An iteration has two
/// products with the matrix. Throws NumericalError solve.not_converged, solve.singular.
void bicgstab(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
              Observer& observer, std::vector<double>& values, LinearReport& report);

}  // namespace voropack
