// What flows through markers and between regions: conservation, added up.
#pragma once

#include <vector>

#include "solve/coefficients.h"
#include "voropack/diffusion.h"

namespace voropack {

/// What cells gain and lose per time: at one time, or on average over a step.
struct Flows {
  IdVector<CellId, double> source;
  IdVector<CellId, double> absorbed;
  IdVector<CellId, double> stored;
  /// What each cell still needs to be in balance once neighbors in its region, source, absorption, storage and given
  /// inflow are added up. Inside a region it is a residual, on an interface what comes from the other regions, and at a
  /// fixed vertex also what comes through the boundary.
  IdVector<CellId, double> deficit;
  IdVector<PatchId, double> inflow;  ///< Given by conditions; 0 at fixed patches.
};

template <int D>
Flows flows_at(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
               const IdVector<VertexId, double>& values);

/// flows = share * flows + (1 - share) * other
void blend_flows(Flows& flows, const Flows& other, double share);

/// Sets what is stored, which is 0 before.
void add_storage(Flows& flows, const IdVector<CellId, double>& stored);

struct FlowSums {
  std::vector<MarkerFlux> fluxes;
  std::vector<RegionBalance> balances;
};

/// Sums by marker and region. `terms` says which patches are fixed.
template <int D>
FlowSums add_up_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                      const Flows& flows);

}  // namespace voropack
