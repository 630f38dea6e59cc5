// f_0: the spacing function that a mesh of unknown origin was made with, as far as its edges tell.
#pragma once

#include "mesh/edge_graph.h"
#include "voropack/coarsening.h"
#include "voropack/index.h"
#include "voropack/mesh.h"

namespace voropack {

/// [n_vertices] both.
struct VertexSpacing {
  IdVector<VertexId, double> initial;  ///< f_0.
  IdVector<VertexId, double> nearest;  ///< Half the distance to the nearest neighbor: with it all vertices fit.
};

/// Mean edges of a level are longer than 2 f by this: a maximal packing is not a tight one. Measured on levels 1 to 3
/// of squares and cubes, uniform and graded, with lattices and without: 1.18 to 1.25 and 1.32 to 1.40.
template <int D>
inline constexpr double kMeanEdgeOverSpacing = D == 2 ? 1.2 : 1.35;

/// O(n), in parallel.
template <int D>
VertexSpacing initial_spacing(const Mesh<D>& mesh, const EdgeGraph& edges, InitialSpacing kind);

}  // namespace voropack
