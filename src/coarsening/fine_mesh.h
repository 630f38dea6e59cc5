// What every level of a hierarchy needs to know of the finest mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "coarsening/vertex_groups.h"
#include "mesh/edge_graph.h"
#include "packing/incidence.h"
#include "voropack/coarsening.h"
#include "voropack/mesh_domain.h"

namespace voropack {

template <int D>
struct FineMesh {
  /// `is_outside` marks vertices that no level on this domain may have; empty if there are none. Those of no simplex
  /// are added.
  FineMesh(const Mesh<D>& mesh, MeshDomain<D> place, const CoarseningOptions& options,
           std::vector<std::uint8_t> is_outside = {});

  const Mesh<D>& mesh;
  MeshDomain<D> place;
  Incidence<D> incidence;  ///< Of the domain.
  EdgeGraph edges;
  IdVector<VertexId, double> initial;     ///< f_0.
  IdVector<VertexId, double> floor;       ///< Half the distance to the nearest neighbor: with it all vertices fit.
  std::vector<VertexId> point_vertices;   ///< By PointId.
  Csr<FacetId, VertexId> facet_vertices;  ///< 3D: inside each facet, in the order in which they are tried.
  std::vector<std::uint8_t> is_outside;
  std::vector<std::uint32_t> curve;             ///< All vertices, along a Hilbert curve.
  std::vector<VertexId> interior;               ///< In no polytope below D, in the order in which they are tried.
  VertexGroups<D> groups;                       ///< The same ones along the curve.
  std::vector<std::uint32_t> number_in_groups;  ///< By place in `interior`: the number among groups.vertices.

  [[nodiscard]] bool is_interior(VertexId v) const {
    return place.carrier[v].dimension == D && (is_outside.empty() || is_outside[v.value()] == 0);
  }

 private:
  void sort_vertices(const CoarseningOptions& options);
  void group_interior();
};

}  // namespace voropack
