// The edges of a simplicial mesh as a graph: who is beside whom, and how far.
#pragma once

#include <vector>

#include "voropack/index.h"
#include "voropack/mesh.h"

namespace voropack {

struct EdgeGraph {
  Csr<VertexId, VertexId> neighbors;  ///< The vertices that share an edge with each vertex, ascending.
  /// The length of the edge to each of `neighbors.values`, rounded down: what changes by no more than a multiple of it
  /// does so of the length itself.
  std::vector<float> length;

  [[nodiscard]] std::span<const float> lengths(VertexId v) const {
    return {length.data() + neighbors.offsets[v.value()], length.data() + neighbors.offsets[v.value() + 1]};
  }
};

/// O(n), in parallel.
template <int D>
EdgeGraph build_edge_graph(const Mesh<D>& mesh);

/// The largest function below f that grows by at most `lipschitz` along every edge. Blocks of consecutive vertices are
/// swept until nothing changes in them, in parallel and in rounds. There is one such function, so that it does not
/// matter in which order values fall: the same bits for any number of threads.
void make_lipschitz(const EdgeGraph& graph, double lipschitz, IdVector<VertexId, double>& f);

/// The first is `growth` times f made Lipschitz, each other one `growth` times the one before made Lipschitz, to the
/// bit; growth >= 1. Only vertices on which it is not clear from f that nothing changes are looked at again.
std::vector<IdVector<VertexId, double>> grown_lipschitz(const EdgeGraph& graph, double lipschitz,
                                                        const IdVector<VertexId, double>& f, double growth,
                                                        std::size_t n_levels);

}  // namespace voropack
