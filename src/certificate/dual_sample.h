// Check `dual_nonnegative`, and what it shares with the other checks of control volumes.
#pragma once

#include "certificate/checks.h"

namespace voropack::judge {

/// Two different vertices of the mesh, finite.
template <int D>
bool valid_edge(const Subject<D>& subject, const std::array<VertexId, 2>& edge) {
  for (const VertexId v : edge)
    if (v.is_none() || v.value() >= subject.mesh.points.size() || !subject.topology.finite(v.value())) return false;
  return edge[0] != edge[1];
}

/// `complete`: the arrays of dual faces have equal lengths.
template <int D>
Check check_dual_nonnegative(const Subject<D>& subject, bool complete);

}  // namespace voropack::judge
