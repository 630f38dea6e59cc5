// Vertices that no simplex has, such as the center of a circle in a mesh of Gmsh: they have no cell and no spacing.
//
// `refine` and `solve` leave them out before they begin. `coarsen` does not: prolongations have a row for every vertex
// of the mesh given, so there they stay in the finest mesh and no level takes them (src/coarsening/fine_mesh.h).
#pragma once

#include <string>
#include <vector>

#include "voropack/index.h"
#include "voropack/mesh.h"

namespace voropack::app {

/// Ascending: the vertices in no simplex, boundary simplex or segment edge. O(n).
template <int D>
std::vector<VertexId> unused_vertices(const Mesh<D>& mesh);

/// The mesh without these vertices; the order of the others stays.
template <int D>
Mesh<D> without(Mesh<D> mesh, const std::vector<VertexId>& unused);

/// "2 vertices of no simplex: 0, 7 (counted from 0)".
std::string unused_in_words(const std::vector<VertexId>& unused);

}  // namespace voropack::app
