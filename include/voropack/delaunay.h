// Stage 4: Packing<D> -> Mesh<D>: the boundary-conforming Delaunay mesh with regions assigned.
#pragma once

#include "voropack/domain.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"
#include "voropack/packing.h"

namespace voropack {

/// Triangulates the sphere centers, assigns regions by flood fill across subfacets, and drops what lies outside.
///
/// Vertices and simplices are ordered along a Hilbert curve. Flat simplices between points of one facet never reach the
/// result. Throws: InternalError delaunay.not_conforming if a protected simplex is not in the triangulation.
template <int D>
Mesh<D> triangulate(const Domain<D>& domain, Packing<D> packing, Observer& observer = silent_observer());

/// A mesh whose vertices are the centers of spheres.
template <int D>
struct PackingMesh {
  Mesh<D> mesh;
  IdVector<SphereId, VertexId> vertex_of_sphere;  ///< [n_spheres]
};

/// The same, and which sphere became which vertex.
template <int D>
PackingMesh<D> triangulate_packing(const Domain<D>& domain, Packing<D> packing, Observer& observer = silent_observer());

/// The Delaunay triangulation of `points` alone, such as for tests and other programs' point sets.
/// Identical points are an InputError delaunay.duplicate_points.
template <int D>
Triangulation<D> delaunay_triangulation(const std::vector<Vec<D>>& points);

/// The Delaunay triangulation of the vertices of `mesh`, with its regions and markers: for meshes with flat, duplicate
/// or overlapping simplices (read_mesh accepts them on request), or that are not Delaunay. Vertices keep their numbers
/// and data; those that no simplex uses stay unused. Nothing but vertices, boundary and regions counts, the neighbors
/// do not.
///
/// Coplanar boundary faces with one marker and the same regions on their sides are one wall, which other faces may
/// tile: where corners are cocircular, any diagonal will do. A simplex beside a wall gets the region that was there,
/// others that of their neighbors on the same side; what gets none is outside. Walls and segments with a marker, and
/// the volume that the boundary of each region encloses, have to be there again.
/// Throws: InputError mesh.boundary_lost if they are not; names a face or region.
///         InputError mesh.empty, mesh.too_large, mesh.too_small, delaunay.duplicate_points
template <int D>
Mesh<D> retriangulate(const Mesh<D>& mesh, Observer& observer = silent_observer());

}  // namespace voropack
