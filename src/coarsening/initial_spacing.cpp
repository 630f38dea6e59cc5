#include "coarsening/initial_spacing.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"

namespace voropack {

template <int D>
VertexSpacing initial_spacing(const Mesh<D>& mesh, const Csr<VertexId, VertexId>& neighbors, InitialSpacing kind) {
  VertexSpacing spacing;
  spacing.initial.resize(mesh.points.size());
  spacing.nearest.resize(mesh.points.size());
  parallel_for(mesh.points.size(), [&](std::size_t i) {
    const VertexId v(i);
    double nearest = std::numeric_limits<double>::infinity(), sum = 0;
    for (const VertexId w : neighbors[v]) {
      const double d = distance(mesh.points[v], mesh.points[w]);
      nearest = std::min(nearest, d);
      sum += d;
    }
    const double mean = sum / static_cast<double>(neighbors[v].size());
    spacing.nearest[v] = 0.5 * nearest;
    spacing.initial[v] = 0.5 * (kind == InitialSpacing::kNearest ? nearest : mean / kMeanEdgeOverSpacing<D>);
  });
  return spacing;
}

template VertexSpacing initial_spacing(const Mesh<2>&, const Csr<VertexId, VertexId>&, InitialSpacing);
template VertexSpacing initial_spacing(const Mesh<3>&, const Csr<VertexId, VertexId>&, InitialSpacing);

}  // namespace voropack
