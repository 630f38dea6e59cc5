// What flows through markers and between regions: conservation, added up.
#pragma once

#include "solve/coefficients.h"
#include "voropack/diffusion.h"

namespace voropack {

/// Fills `fluxes` and `balances` from `values`.
template <int D>
void add_up_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                  DiffusionSolution<D>& solution);

}  // namespace voropack
