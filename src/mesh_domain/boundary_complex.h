// The boundary of a mesh as corners, straight chains of edges and flat patches of faces.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "mesh_domain/boundary_zone.h"
#include "voropack/mesh.h"

namespace voropack {

/// A straight row of vertices between two corners: a segment of the domain.
struct BoundaryChain {
  std::vector<VertexId> vertices;  ///< Both ends included.
  std::optional<int> marker;       ///< Nothing where the mesh does not say.
};

/// 3D: coplanar boundary faces between feature edges: a facet of the domain.
struct BoundaryPatch {
  std::vector<std::array<VertexId, 3>> faces;                ///< Turning the same way.
  std::vector<std::array<VertexId, 2>> outline;              ///< Directed edges with the patch to their left.
  std::vector<std::array<VertexId, 2>> inner_feature_edges;  ///< Feature edges with the patch on both sides.
  Vec<3> normal;                                             ///< Of the largest face.
  int marker = 0;
};

template <int D>
struct BoundaryComplex {
  std::vector<VertexId> corners;
  std::vector<BoundaryChain> chains;
  std::vector<BoundaryPatch> patches;  ///< Empty in 2D.
};

/// `tolerance`: what is this near to a line or plane lies on it. Length.
template <int D>
BoundaryComplex<D> find_boundary_complex(const Mesh<D>& mesh, const BoundaryZone<D>& zone, double tolerance);

}  // namespace voropack
