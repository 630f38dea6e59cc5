// A diffusion problem as numbers on cells and patches: everything that assembly and balances need, checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "solve/cell_index.h"
#include "voropack/diffusion.h"

namespace voropack {

/// What a condition makes of a patch: fixed at `value`, or an inflow of `inflow` - `transfer` u.
struct PatchTerm {
  bool is_fixed = false;
  double value = 0;
  double inflow = 0;
  double transfer = 0;
};

struct CellTerms {
  CellIndex index;
  IdVector<DualFaceId, double> coupling;  ///< [n_faces] kappa |A| / h, with the harmonic mean of kappa at the two ends.
  IdVector<CellId, double> absorption;    ///< [n_cells] sigma |V_i|
  IdVector<CellId, double> source;        ///< [n_cells] integral of f.
  IdVector<PatchId, PatchTerm> patches;   ///< [n_patches]
};

/// Checks volumes, areas and problem, and evaluates the problem. Throws as `assemble`.
template <int D>
CellTerms evaluate(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                   const DiffusionProblem<D>& problem);

}  // namespace voropack
