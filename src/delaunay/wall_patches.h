// The boundary of a mesh as flat patches, and the faces of another triangulation of the same vertices that tile them.
//
// Where corners of coplanar faces are cocircular, as on every structured grid, one diagonal is as good as the other:
// not the faces of a wall are its own but the polygon that they cover.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "delaunay/face_table.h"
#include "voropack/mesh.h"

namespace voropack {

/// Boundary faces with the same marker and the same regions on their sides, coplanar up to kOnTolerance, joined at
/// edges where no third face is and that are no part of a segment. In the plane one edge: its ends leave no choice.
template <int D>
struct WallPatch {
  std::vector<std::array<VertexId, D>> faces;  ///< Turning the same way; the first is the largest.
  /// In front, where a point that follows a face's vertices makes a positive simplex, and behind. Nothing where no
  /// simplex is; in front is one if any is anywhere.
  std::array<std::optional<int>, 2> region;
  int marker = 0;
};

/// `faces`: of `mesh`. Every boundary face is in one patch.
template <int D>
std::vector<WallPatch<D>> find_wall_patches(const Mesh<D>& mesh, const FaceTable<D>& faces);

/// For each patch the faces of `mesh` that tile it, turning as it does; nothing where none do. `mesh` has the patches'
/// vertices and neighbors, its regions are not looked at. Where simplices in the plane of the patch leave more than one
/// tiling, since its vertices are coplanar only up to rounding, it is that in front of them.
template <int D>
std::vector<std::vector<std::array<VertexId, D>>> tile_patches(const Mesh<D>& mesh,
                                                               const std::vector<WallPatch<D>>& patches);

}  // namespace voropack
