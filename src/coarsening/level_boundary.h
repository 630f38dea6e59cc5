// A level with a boundary of the user's own: where the vertices of the finest mesh are in it, and how far it is from
// theirs.
#pragma once

#include <vector>

#include "voropack/coarsening.h"
#include "voropack/mesh_domain.h"

namespace voropack {

template <int D>
struct PlacedMesh {
  MeshDomain<D> place;                   ///< Vertices outside have the carrier of inner ones.
  std::vector<std::uint8_t> is_outside;  ///< [n_vertices] 1 for vertices in no region.
};

/// Finds the carrier of each vertex of `mesh` in the boundary of a level. Coordinates may differ by kOnTolerance; the
/// domain gets those of the vertices. O(n log n).
/// Throws: InputError coarsen.level_boundary  where a point of the domain is no vertex.
template <int D>
PlacedMesh<D> place_in_boundary(const Mesh<D>& mesh, const LevelBoundary<D>& boundary);

/// The largest distance of a boundary vertex of one mesh from the boundary of the other.
template <int D>
double boundary_distance(const Mesh<D>& a, const Mesh<D>& b);

}  // namespace voropack
