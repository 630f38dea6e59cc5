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

/// The Delaunay triangulation of the vertices of `mesh`, with its regions and markers: for meshes with flat simplices,
/// which are left out of `mesh` (read_mesh), or that are not Delaunay. Vertices keep their numbers and data; those that
/// no simplex uses stay unused.
///
/// A simplex gets the region of the old one that lies on the same side of a common face, or of its neighbor inside the
/// same region; what gets none is outside. Faces and segments with a marker, and the volume of each region, have to be
/// there again: such as in a mesh that was boundary-conforming Delaunay before it was rounded.
/// Throws: InputError mesh.boundary_lost     if they are not; names a face or region.
///         InputError delaunay.duplicate_points
template <int D>
Mesh<D> retriangulate(const Mesh<D>& mesh, Observer& observer = silent_observer());

}  // namespace voropack
