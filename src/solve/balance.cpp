#include "solve/balance.h"

#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace voropack {

namespace {

/// What each cell still needs to be in balance once neighbors in its region, source, absorption and given inflow are
/// added up. Inside a region it is a residual, on an interface what comes from the other regions, and at a fixed vertex
/// also what comes through the boundary.
template <int D>
IdVector<CellId, double> cell_deficits(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                       const CellTerms& terms, const IdVector<VertexId, double>& values) {
  IdVector<CellId, double> deficit(volumes.cell_vertex.size());
  for (const DualFaceId f : ids(volumes.face_vertices)) {
    const auto [i, j] = volumes.face_vertices[f];
    const double flow = terms.coupling[f] * (values[i] - values[j]);
    deficit[terms.index(i, volumes.face_region[f])] += flow;
    deficit[terms.index(j, volumes.face_region[f])] -= flow;
  }
  for (const CellId c : ids(volumes.cell_vertex))
    deficit[c] += terms.absorption[c] * values[volumes.cell_vertex[c]] - terms.source[c];
  for (const PatchId p : ids(terms.patches)) {
    const VertexId v = boundary.patch_vertex[p];
    const PatchTerm& term = terms.patches[p];
    deficit[terms.index(v, boundary.patch_region[p])] += term.transfer * values[v] - term.inflow;
  }
  return deficit;
}

/// What enters through fixed patches and what cells receive from other regions.
struct Flows {
  IdVector<PatchId, double> through;  ///< 0 at patches that are not fixed.
  IdVector<CellId, double> exchange;
};

/// The patches of one vertex that are fixed, in one region or in all.
class FixedPatches {
 public:
  template <int D>
  FixedPatches(const BoundaryAreas<D>& boundary, const CellTerms& terms, std::span<const PatchId> patches,
               std::optional<int> region) {
    for (const PatchId p : patches) {
      if (!terms.patches[p].is_fixed || (region && boundary.patch_region[p] != *region)) continue;
      patches_.push_back(p);
      areas_.push_back(boundary.patch_area[p]);
      sum_ += boundary.patch_area[p];
    }
  }
  [[nodiscard]] bool empty() const { return patches_.empty(); }

  /// fn(patch, share) with shares in proportion to areas, which add up to 1.
  template <class Fn>
  void for_each_share(Fn&& fn) const {
    for (std::size_t k = 0; k < patches_.size(); ++k)
      fn(patches_[k], sum_ > 0 ? areas_[k] / sum_ : 1 / static_cast<double>(patches_.size()));
  }

 private:
  std::vector<PatchId> patches_;
  std::vector<double> areas_;
  double sum_ = 0;
};

/// Says where the deficits of the cells of one vertex come from. A region with fixed patches draws what it lacks
/// through these; a region without draws it from the regions that have some; and where nothing is fixed, all regions
/// exchange what they lack and have.
template <int D>
void trace_deficits(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                    std::span<const CellId> cells, std::span<const PatchId> patches,
                    const IdVector<CellId, double>& deficit, Flows& flows) {
  const FixedPatches all(boundary, terms, patches, {});
  for (const CellId c : cells) {
    if (all.empty()) {
      if (cells.size() > 1) flows.exchange[c] = deficit[c];
      continue;
    }
    const FixedPatches own(boundary, terms, patches, volumes.cell_region[c]);
    (own.empty() ? all : own).for_each_share([&](PatchId p, double share) {
      const double flow = share * deficit[c];
      flows.through[p] += flow;
      if (!own.empty()) return;
      flows.exchange[c] += flow;
      flows.exchange[terms.index(boundary.patch_vertex[p], boundary.patch_region[p])] -= flow;
    });
  }
}

template <int D>
Flows trace_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                  const IdVector<VertexId, double>& values) {
  const IdVector<CellId, double> deficit = cell_deficits(volumes, boundary, terms, values);
  Flows flows{IdVector<PatchId, double>(terms.patches.size()), IdVector<CellId, double>(deficit.size())};
  std::vector<CellId> cells;
  std::vector<PatchId> patches;
  CellId c(0);
  PatchId p(0);
  for (const VertexId v : ids(values)) {
    for (cells.clear(); c.value() < deficit.size() && volumes.cell_vertex[c] == v; ++c) cells.push_back(c);
    for (patches.clear(); p.value() < terms.patches.size() && boundary.patch_vertex[p] == v; ++p) patches.push_back(p);
    if (cells.size() > 1 || !patches.empty())
      trace_deficits<D>(volumes, boundary, terms, cells, patches, deficit, flows);
  }
  return flows;
}

}  // namespace

template <int D>
void add_up_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                  DiffusionSolution<D>& solution) {
  const IdVector<VertexId, double>& values = solution.values;
  const Flows flows = trace_flows(volumes, boundary, terms, values);
  std::map<int, RegionBalance> balances;
  for (const CellId c : ids(volumes.cell_vertex)) {
    RegionBalance& balance = balances[volumes.cell_region[c]];
    const double absorbed = terms.absorption[c] * values[volumes.cell_vertex[c]];
    balance.volume += volumes.cell_volume[c];
    balance.source += terms.source[c];
    balance.absorbed += absorbed;
    balance.interface_inflow += flows.exchange[c];
    balance.throughput += std::abs(terms.source[c]) + std::abs(absorbed) + std::abs(flows.exchange[c]);
  }
  std::map<int, MarkerFlux> fluxes;
  for (const PatchId p : ids(terms.patches)) {
    const PatchTerm& term = terms.patches[p];
    const double inflow = term.inflow - term.transfer * values[boundary.patch_vertex[p]] + flows.through[p];
    MarkerFlux& flux = fluxes[boundary.patch_marker[p]];
    flux.area += boundary.patch_area[p];
    flux.inflow += inflow;
    RegionBalance& balance = balances[boundary.patch_region[p]];
    balance.boundary_inflow += inflow;
    balance.throughput += std::abs(inflow);
  }
  for (auto& [region, balance] : balances) {
    balance.region = region;
    balance.imbalance = balance.source - balance.absorbed + balance.boundary_inflow + balance.interface_inflow;
    solution.balances.push_back(balance);
  }
  for (auto& [marker, flux] : fluxes) {
    flux.marker = marker;
    solution.fluxes.push_back(flux);
  }
}

template void add_up_flows(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellTerms&, DiffusionSolution<2>&);
template void add_up_flows(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellTerms&, DiffusionSolution<3>&);

}  // namespace voropack
