// Stage 5: Mesh<D> -> ControlVolumes<D>: |V_i|, |A_ij|, h_ij, region by region; and the cells' shapes for output.
#pragma once

#include <vector>

#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// Computes the Voronoi control volumes of a boundary-conforming Delaunay mesh, clipped to its regions.
///
/// Areas come from the exact-sign identity l* = |n| |InSphere| / (2 |O_d| |O_e|) for the dual edge of each face, so
/// that they are accurate to 1e-12 relative however flat the slivers, and never negative (docs/theory/dual.md). On a
/// mesh that is not boundary-conforming Delaunay the areas are the signed circumcentric ones: `face_area` may then be
/// negative, which is what a check of another program's mesh needs to see.
template <int D>
ControlVolumes<D> build_control_volumes(const Mesh<D>& mesh, Observer& observer = silent_observer());

/// The cells as polyhedra (3D) or polygons (2D), in the order of ControlVolumes::cell_vertex. For output and pictures.
template <int D>
struct CellShapes {
  std::vector<Vec<D>> points;
  Csr<CellId, std::uint32_t> cell_faces;       ///< 3D: indices of faces. 2D: the corner points, counterclockwise.
  Csr<DualFaceId, std::uint32_t> face_points;  ///< 3D: the corner points of each face in order. Empty in 2D.
};

template <int D>
CellShapes<D> build_cell_shapes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes);

}  // namespace voropack
