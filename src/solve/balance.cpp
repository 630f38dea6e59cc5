#include "solve/balance.h"

#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace voropack {

namespace {

/// What enters through fixed patches and what cells receive from other regions.
struct Traces {
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
                    const IdVector<CellId, double>& deficit, Traces& flows) {
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
Traces trace_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                   const IdVector<CellId, double>& deficit) {
  Traces flows{IdVector<PatchId, double>(terms.patches.size()), IdVector<CellId, double>(deficit.size())};
  std::vector<CellId> cells;
  std::vector<PatchId> patches;
  CellId c(0);
  PatchId p(0);
  for (const VertexId v : ids(volumes.sites)) {
    for (cells.clear(); c.value() < deficit.size() && volumes.cell_vertex[c] == v; ++c) cells.push_back(c);
    for (patches.clear(); p.value() < terms.patches.size() && boundary.patch_vertex[p] == v; ++p) patches.push_back(p);
    if (cells.size() > 1 || !patches.empty())
      trace_deficits<D>(volumes, boundary, terms, cells, patches, deficit, flows);
  }
  return flows;
}

/// into = share * into + (1 - share) * other
template <class I>
void blend(IdVector<I, double>& into, const IdVector<I, double>& other, double share) {
  for (const I i : ids(into)) into[i] = share * into[i] + (1 - share) * other[i];
}

}  // namespace

template <int D>
Flows flows_at(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
               const IdVector<VertexId, double>& values) {
  const std::size_t n = volumes.cell_vertex.size();
  Flows flows{.source = terms.source,
              .absorbed = IdVector<CellId, double>(n),
              .stored = IdVector<CellId, double>(n),
              .deficit = IdVector<CellId, double>(n),
              .inflow = IdVector<PatchId, double>(terms.patches.size())};
  for (const DualFaceId f : ids(volumes.face_vertices)) {
    const auto [i, j] = volumes.face_vertices[f];
    const double flow = terms.coupling[f] * (values[i] - values[j]);
    flows.deficit[terms.index(i, volumes.face_region[f])] += flow;
    flows.deficit[terms.index(j, volumes.face_region[f])] -= flow;
  }
  for (const CellId c : ids(volumes.cell_vertex)) {
    flows.absorbed[c] = terms.absorption[c] * values[volumes.cell_vertex[c]];
    flows.deficit[c] += flows.absorbed[c] - flows.source[c];
  }
  for (const PatchId p : ids(terms.patches)) {
    const VertexId v = boundary.patch_vertex[p];
    flows.inflow[p] = terms.patches[p].inflow - terms.patches[p].transfer * values[v];
    flows.deficit[terms.index(v, boundary.patch_region[p])] -= flows.inflow[p];
  }
  return flows;
}

void blend_flows(Flows& flows, const Flows& other, double share) {
  blend(flows.source, other.source, share);
  blend(flows.absorbed, other.absorbed, share);
  blend(flows.deficit, other.deficit, share);
  blend(flows.inflow, other.inflow, share);
}

void add_storage(Flows& flows, const IdVector<CellId, double>& stored) {
  flows.stored = stored;
  for (const CellId c : ids(stored)) flows.deficit[c] += stored[c];
}

template <int D>
FlowSums add_up_flows(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                      const Flows& flows) {
  const Traces traces = trace_flows(volumes, boundary, terms, flows.deficit);
  std::map<int, RegionBalance> balances;
  for (const CellId c : ids(volumes.cell_vertex)) {
    RegionBalance& balance = balances[volumes.cell_region[c]];
    balance.volume += volumes.cell_volume[c];
    balance.source += flows.source[c];
    balance.absorbed += flows.absorbed[c];
    balance.stored += flows.stored[c];
    balance.interface_inflow += traces.exchange[c];
    balance.throughput += std::abs(flows.source[c]) + std::abs(flows.absorbed[c]) + std::abs(flows.stored[c]) +
                          std::abs(traces.exchange[c]);
  }
  std::map<int, MarkerFlux> fluxes;
  for (const PatchId p : ids(terms.patches)) {
    const double inflow = flows.inflow[p] + traces.through[p];
    MarkerFlux& flux = fluxes[boundary.patch_marker[p]];
    flux.area += boundary.patch_area[p];
    flux.inflow += inflow;
    RegionBalance& balance = balances[boundary.patch_region[p]];
    balance.boundary_inflow += inflow;
    balance.throughput += std::abs(inflow);
  }
  FlowSums sums;
  for (auto& [region, balance] : balances) {
    balance.region = region;
    balance.imbalance =
        balance.source - balance.absorbed - balance.stored + balance.boundary_inflow + balance.interface_inflow;
    sums.balances.push_back(balance);
  }
  for (auto& [marker, flux] : fluxes) {
    flux.marker = marker;
    sums.fluxes.push_back(flux);
  }
  return sums;
}

template Flows flows_at(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellTerms&,
                        const IdVector<VertexId, double>&);
template FlowSums add_up_flows(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellTerms&, const Flows&);
template Flows flows_at(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellTerms&,
                        const IdVector<VertexId, double>&);
template FlowSums add_up_flows(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellTerms&, const Flows&);

}  // namespace voropack
