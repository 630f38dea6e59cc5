// The cells of vertices: the one in a region, and the volume of all.
#pragma once

#include <cstddef>
#include <vector>

#include "voropack/mesh.h"

namespace voropack {

/// From a vertex and a region to the cell that they have in common. Needs cells that are sorted by vertex, with at
/// least one for every vertex. The volumes have to stay where they are.
class CellIndex {
 public:
  template <int D>
  explicit CellIndex(const ControlVolumes<D>& volumes)
      : first_(volumes.sites.size() + 1), region_(&volumes.cell_region) {
    first_.back() = CellId(volumes.cell_vertex.size());
    for (std::size_t c = volumes.cell_vertex.size(); c-- > 0;)
      first_[volumes.cell_vertex[CellId(c)].value()] = CellId(c);
  }

  /// The cell, which has to be there.
  [[nodiscard]] CellId operator()(VertexId v, int region) const {
    CellId c = first_[v.value()];
    while ((*region_)[c] != region) ++c;
    return c;
  }

  /// Whether it is there; v has to be a vertex.
  [[nodiscard]] bool contains(VertexId v, int region) const {
    for (CellId c = first_[v.value()]; c != first_[v.value() + std::size_t{1}]; ++c)
      if ((*region_)[c] == region) return true;
    return false;
  }

 private:
  std::vector<CellId> first_;  ///< [n_vertices + 1]
  const IdVector<CellId, int>* region_;
};

/// [n_vertices] the volume of the cells of each vertex in all regions.
template <int D>
IdVector<VertexId, double> vertex_volumes(const ControlVolumes<D>& volumes) {
  IdVector<VertexId, double> sum(volumes.sites.size(), 0.0);
  for (const CellId c : ids(volumes.cell_vertex)) sum[volumes.cell_vertex[c]] += volumes.cell_volume[c];
  return sum;
}

}  // namespace voropack
