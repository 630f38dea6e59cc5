// The boundary of a mesh as its control volumes see it: |V_i n dOmega| by marker and region.
#pragma once

#include <set>

#include "voropack/index.h"
#include "voropack/mesh.h"
#include "voropack/vec.h"

namespace voropack {

using PatchId = Id<struct PatchTag>;  ///< The part of the boundary that one vertex, marker and region have in common.

/// The part of the domain's boundary in each control volume. A solver needs it for conditions on the boundary.
///
/// A *patch* is the part of one vertex's Voronoi cell on the boundary faces of one marker beside one region. Every
/// vertex of a boundary face has a patch.
template <int D>
struct BoundaryAreas {
  IdVector<PatchId, VertexId> patch_vertex;  ///< [n_patches] sorted by vertex, then marker, then region.
  IdVector<PatchId, int> patch_marker;       ///< [n_patches]
  IdVector<PatchId, int> patch_region;       ///< [n_patches] the region's id as users see it.
  IdVector<PatchId, double> patch_area;      ///< [n_patches] length^(D-1).
  IdVector<PatchId, Vec<D>> patch_centroid;  ///< [n_patches] where an inflow that is given as a function is evaluated.

  friend bool operator==(const BoundaryAreas&, const BoundaryAreas&) = default;
};

/// The patches of a mesh's hull: the circumcentric dual of its boundary faces, which on a boundary-conforming Delaunay
/// mesh is the Voronoi diagram of each facet, so that no area is negative. On other meshes areas are signed.
///
/// What lies inside the domain has no patches unless its marker is in `inner_markers`: conditions on a contact, a wire
/// or a well. A marker stands for the hull faces that have it; where there are none, for the faces inside; then, in 3D,
/// for the segments; then for the points, at which the domain's own carry their markers. If nothing has it, it gets no
/// patch. The area is then that of a facet (length in 2D), the length of segments, or 1 for a point; regions that meet
/// there share it equally.
///
/// Cost: O(n) for n simplices, and a sort of the boundary faces. The same result for any number of threads.
template <int D>
BoundaryAreas<D> build_boundary_areas(const Mesh<D>& mesh, const std::set<int>& inner_markers = {});

}  // namespace voropack
