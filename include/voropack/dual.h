// Stage 5: Mesh<D> -> ControlVolumes<D>: |V_i|, |A_ij|, h_ij, region by region; and the cells' shapes for output.
#pragma once

#include <vector>

#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// Computes the Voronoi control volumes of a boundary-conforming Delaunay mesh, clipped to its regions.
///
/// Areas come from the exact-sign identity l* = |n| |InSphere| / (2 |O_d| |O_e|) for the dual edge of each face, so
/// that they are accurate to 1e-12 h^(D-1) however flat the slivers, and never negative (docs/theory/dual.md). On a
/// mesh that is not boundary-conforming Delaunay the areas are the signed circumcentric ones: `face_area` may then be
/// negative, which is what a check of another program's mesh needs to see.
///
/// An internal facet with the same region on both sides does not divide cells or dual faces.
///
/// Cost: O(n); at peak about 80 bytes per simplex of a Mesh<3> besides the mesh, the result included.
/// Throws: InputError mesh.degenerate_simplex  if a simplex is flat or negatively oriented.
///         LimitError dual.too_many_faces      if the dual faces exceed 32-bit ids.
///         Cancelled                           if the observer asks to stop.
template <int D>
ControlVolumes<D> build_control_volumes(const Mesh<D>& mesh, Observer& observer = silent_observer());

/// The cells as polyhedra (3D) or polygons (2D), in the order of ControlVolumes::cell_vertex. For output and pictures.
///
/// 3D: a face between two cells is stored once and listed by both, also across an interface. Its corners are
/// counterclockwise seen from outside of the first cell that lists it (the one with the lower id); the second cell sees
/// them clockwise, so a writer that wants outward faces reverses a face the second time. Where a region meets an edge
/// in several wedges, the dual face is several polygons. A cell's part of the boundary is a kite (site, edge midpoint,
/// circumcenter of the boundary triangle, edge midpoint) for each boundary triangle at its site. Every polyhedron is
/// closed: faces share point numbers, points that coincide exactly are one, and faces without area are left out.
///
/// 2D: the polygon of a vertex that the region meets in several wedges passes through the site once per wedge.
template <int D>
struct CellShapes {
  std::vector<Vec<D>> points;                  ///< Each used by some cell.
  Csr<CellId, std::uint32_t> cell_faces;       ///< 3D: indices of faces. 2D: the corner points, counterclockwise.
  Csr<DualFaceId, std::uint32_t> face_points;  ///< 3D: the corner points of each face in order. Empty in 2D. Not
                                               ///< numbered as ControlVolumes::face_area.
};

/// Throws LimitError dual.too_many_points if the corner points exceed 32-bit numbers.
template <int D>
CellShapes<D> build_cell_shapes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes);

}  // namespace voropack
