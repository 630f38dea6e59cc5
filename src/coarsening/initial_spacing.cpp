#include "coarsening/initial_spacing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geom/box_tree.h"

namespace voropack {

namespace {

/// Between vertices on the boundary that see each other across what is outside: they share no edge. Of other pairs the
/// nearest ones do, since the mesh is boundary-conforming Delaunay.
template <int D>
void look_across_outside(const Mesh<D>& mesh, IdVector<VertexId, double>& half_nearest) {
  std::vector<std::uint8_t> is_on(mesh.points.size(), 0);
  for (const auto& face : mesh.boundary_vertices)
    for (const VertexId v : face) is_on[v.value()] = 1;
  std::vector<VertexId> vertices;
  std::vector<Box<D>> boxes;
  for (const VertexId v : ids(mesh.points)) {
    if (is_on[v.value()] == 0) continue;
    vertices.push_back(v);
    boxes.emplace_back(mesh.points[v], mesh.points[v]);
  }
  const BoxTree<D> tree(boxes);
  parallel_for(vertices.size(), [&](std::size_t i) {
    const Vec<D>& x = mesh.points[vertices[i]];
    double least_sq = 4 * half_nearest[vertices[i]] * half_nearest[vertices[i]];
    tree.for_each([&](const Box<D>& box) { return box.distance_sq(x) < least_sq; },
                  [&](std::uint32_t k) {
                    if (k != i) least_sq = std::min(least_sq, distance_sq(x, mesh.points[vertices[k]]));
                  });
    half_nearest[vertices[i]] = std::min(half_nearest[vertices[i]], 0.5 * std::sqrt(least_sq));
  });
}

}  // namespace

template <int D>
VertexSpacing initial_spacing(const Mesh<D>& mesh, const EdgeGraph& edges, InitialSpacing kind) {
  VertexSpacing spacing;
  spacing.initial.resize(mesh.points.size());
  spacing.nearest.resize(mesh.points.size());
  parallel_for(mesh.points.size(), [&](std::size_t i) {
    const VertexId v(i);
    double nearest = std::numeric_limits<double>::infinity(), sum = 0;
    for (const double d : edges.lengths(v)) {
      nearest = std::min(nearest, d);
      sum += d;
    }
    // A vertex of no simplex has no say.
    const double mean = edges.lengths(v).empty() ? nearest : sum / static_cast<double>(edges.lengths(v).size());
    spacing.nearest[v] = 0.5 * nearest;
    spacing.initial[v] = 0.5 * mean / kMeanEdgeOverSpacing<D>;
  });
  look_across_outside(mesh, spacing.nearest);
  if (kind == InitialSpacing::kNearest) spacing.initial = spacing.nearest;
  return spacing;
}

template VertexSpacing initial_spacing(const Mesh<2>&, const EdgeGraph&, InitialSpacing);
template VertexSpacing initial_spacing(const Mesh<3>&, const EdgeGraph&, InitialSpacing);

}  // namespace voropack
