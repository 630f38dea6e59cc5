// Closes the balances that an iteration leaves open.
#pragma once

#include <cstdint>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// Adds a constant to the free values of each group, so that the residuals of each group add up to 0. `group` gives
/// the group of each vertex.
///
/// The constants solve the Galerkin system Z^T A Z c = Z^T r, where the columns of Z are the groups, so that the error
/// does not grow in the energy norm. They are of the size of the residual.
void close_balances(const LinearSystem& system, const IdVector<VertexId, std::uint32_t>& group, std::uint32_t n_groups,
                    LinearSolution& solution);

}  // namespace voropack
