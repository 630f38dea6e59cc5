// Closes the balances that an iteration leaves open.
#pragma once

#include <cstdint>
#include <vector>

#include "voropack/linear_system.h"
#include "voropack/mesh.h"

namespace voropack {

/// The vertices of each region, and those on interfaces.
struct RegionGroups {
  IdVector<VertexId, std::uint32_t> of;  ///< [n_vertices]
  std::uint32_t n = 0;
};
template <int D>
RegionGroups region_groups(const ControlVolumes<D>& volumes);

/// Adds a constant to the free values of each group, so that the residuals of each group add up to 0.
///
/// The constants solve the Galerkin system Z^T A Z c = Z^T r, where the columns of Z are the groups, so that the error
/// does not grow in the energy norm. They are of the size of the residual.
void close_balances(const LinearSystem& system, const RegionGroups& groups, LinearSolution& solution);

}  // namespace voropack
