// A diffusion problem as numbers on cells and patches: everything that assembly and balances need, checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "voropack/diffusion.h"

namespace voropack {

/// Finds the cell of a vertex in a region.
class CellIndex {
 public:
  template <int D>
  explicit CellIndex(const ControlVolumes<D>& volumes) : first_(volumes.sites.size()), region_(&volumes.cell_region) {
    for (std::size_t c = volumes.cell_vertex.size(); c-- > 0;) first_[volumes.cell_vertex[CellId(c)]] = CellId(c);
  }
  /// The cell has to be there.
  [[nodiscard]] CellId operator()(VertexId v, int region) const {
    CellId c = first_[v];
    while ((*region_)[c] != region) ++c;
    return c;
  }

 private:
  IdVector<VertexId, CellId> first_;
  const IdVector<CellId, int>* region_;
};

/// What a condition makes of a patch: fixed at `value`, or an inflow of `inflow` - `transfer` u.
struct PatchTerm {
  bool is_fixed = false;
  double value = 0;
  double inflow = 0;
  double transfer = 0;
};

struct CellTerms {
  CellIndex index;
  IdVector<CellId, double> conductivity;  ///< [n_cells] kappa at the site.
  IdVector<CellId, double> absorption;    ///< [n_cells] sigma |V_i|
  IdVector<CellId, double> source;        ///< [n_cells] integral of f.
  IdVector<PatchId, PatchTerm> patches;   ///< [n_patches]

  /// The coupling of a dual face: kappa |A| / h, with the harmonic mean of kappa at its ends.
  template <int D>
  [[nodiscard]] double coupling(const ControlVolumes<D>& volumes, DualFaceId f) const {
    const auto [i, j] = volumes.face_vertices[f];
    const int region = volumes.face_region[f];
    const double a = conductivity[index(i, region)], b = conductivity[index(j, region)];
    const double mean = a == b ? a : 2 / (1 / a + 1 / b);
    return mean * (volumes.face_area[f] / volumes.face_edge_length[f]);
  }
};

/// Checks volumes, areas and problem, and evaluates the problem. Throws as `assemble`.
template <int D>
CellTerms evaluate(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                   const DiffusionProblem<D>& problem);

}  // namespace voropack
