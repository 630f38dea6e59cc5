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

/// The Delaunay triangulation of `points` alone, such as for tests and other programs' point sets.
/// Identical points are an InputError delaunay.duplicate_points.
template <int D>
Triangulation<D> delaunay_triangulation(const std::vector<Vec<D>>& points);

}  // namespace voropack
