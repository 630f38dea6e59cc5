// A diffusion problem as numbers on cells and patches: everything that assembly and balances need, checked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
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
  // Derivatives by the solution; empty where nothing depends on it.
  IdVector<DualFaceId, std::array<double, 2>> coupling_slope;  ///< [n_faces] of the coupling by u at the face's ends.
  IdVector<CellId, double> source_slope;                       ///< [n_cells] of the source by u at the site.
};

/// The range that the values of a coefficient have to lie in.
enum class Range : std::uint8_t { kFinite, kNotNegative, kPositive };

/// A coefficient as faults speak of it.
struct Quantity {
  std::string_view name;
  std::string_view fault;  ///< Id of the fault of values out of range.
  Range range;
};

/// The value at the site of each cell. Throws as `assemble`.
template <int D>
IdVector<CellId, double> evaluate_at_sites(const ControlVolumes<D>& volumes, const Coefficient<D>& coefficient,
                                           const Quantity& quantity);

/// The terms of the conditions. Throws as `assemble`.
template <int D>
IdVector<PatchId, PatchTerm> evaluate_patches(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                              const std::map<int, BoundaryCondition<D>>& conditions);

/// Evaluates the problem for a solution; without one, nothing may depend on it. The volumes have to be checked.
/// Throws as `assemble`.
template <int D>
CellTerms evaluate(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellIndex& index,
                   const DiffusionProblem<D>& problem, const IdVector<VertexId, double>* solution = nullptr);

/// The conductivity or the source depends on the solution.
template <int D>
bool depends_on_solution(const DiffusionProblem<D>& problem) {
  return std::holds_alternative<StateFunction<D>>(problem.conductivity) ||
         std::holds_alternative<StateFunction<D>>(problem.source);
}

}  // namespace voropack
