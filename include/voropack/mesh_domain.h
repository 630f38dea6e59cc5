// The way back: from a mesh of any origin to the domain that its boundary describes.
#pragma once

#include "voropack/domain.h"
#include "voropack/index.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// A domain, and where the vertices of a mesh are in it.
template <int D>
struct MeshDomain {
  Domain<D> domain;
  IdVector<VertexId, PolytopeId> carrier;   ///< [n_vertices] the polytope of lowest dimension that holds the vertex.
  Csr<SegmentId, VertexId> segment_chains;  ///< The vertices along each segment, both ends included.
};

/// Joins the boundary simplices of a mesh to the polytopes that they subdivide, so that a subdivided box has six
/// facets again.
///
/// Facets are boundary faces with the same marker and the same regions on their sides, coplanar up to kOnTolerance,
/// that meet at edges with no third face which the mesh does not list as a part of a segment. Segments are straight
/// chains of edges where facets end, or of listed edges, with one marker. Points are where segments end, and vertices
/// that the mesh says are points. A curved surface stays as it is: every vertex is a point.
/// Cost: O(n log n) for n boundary faces, O(n) for n simplices.
/// Throws: InputError mesh.empty, mesh.too_large, mesh.too_small; as `build_domain`, if the boundary is no piecewise
///         linear system.
template <int D>
MeshDomain<D> domain_of(const Mesh<D>& mesh, Observer& observer = silent_observer());

/// The same for a domain that is known, such as the one that the mesh was made of: nothing is left to guess. Boundary
/// vertices may be off their polytopes by `tolerance`, a length, and rounding; the points of the domain get the
/// coordinates of their vertices.
/// Cost: O(n log n) for n boundary vertices, O(n) for n simplices.
/// Throws: InputError mesh.other_domain if a point of the domain is no vertex, a boundary vertex is on no polytope, or
///         regions have other sizes.
template <int D>
MeshDomain<D> place_in_domain(const Mesh<D>& mesh, Domain<D> domain, double tolerance = 0,
                              Observer& observer = silent_observer());

}  // namespace voropack
