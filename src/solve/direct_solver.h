// Sparse direct solution on the free vertices of a system.
#pragma once

#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// Replaces the free entries of `values`, which has the fixed values in place and 0 elsewhere. Sets report.residual.
/// Throws NumericalError solve.singular.
void solve_directly(const LinearSystem& system, std::vector<double>& values, LinearReport& report);

}  // namespace voropack
