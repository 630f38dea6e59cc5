#include "coarsening/fine_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/random.h"
#include "coarsening/initial_spacing.h"
#include "geom/hilbert.h"

namespace voropack {

template <int D>
FineMesh<D>::FineMesh(const Mesh<D>& fine, MeshDomain<D> domain_and_carriers, const CoarseningOptions& options,
                      std::vector<std::uint8_t> outside)
    : mesh(fine),
      place(std::move(domain_and_carriers)),
      incidence(place.domain),
      edges(build_edge_graph(fine)),
      is_outside(std::move(outside)) {
  for (const VertexId v : ids(fine.points)) {
    if (!edges.neighbors[v].empty()) continue;
    is_outside.resize(fine.points.size(), 0);
    is_outside[v.value()] = 1;
  }
  VertexSpacing spacing = initial_spacing(fine, edges, options.initial);
  initial = std::move(spacing.initial);
  floor = std::move(spacing.nearest);
  sort_vertices(options);
  group_interior();
}

constexpr std::uint32_t kNoKey = std::numeric_limits<std::uint32_t>::max();

/// From the boundary inwards: by the number of edges to it.
template <int D>
std::vector<std::uint32_t> steps_from_boundary(const MeshDomain<D>& place, const Csr<VertexId, VertexId>& neighbors) {
  std::vector<std::uint32_t> steps(place.carrier.size(), kNoKey);
  std::vector<VertexId> front, next;
  for (const VertexId v : ids(place.carrier))
    if (place.carrier[v].dimension < D) {
      steps[v.value()] = 0;
      front.push_back(v);
    }
  for (std::uint32_t step = 1; !front.empty(); ++step) {
    next.clear();
    for (const VertexId v : front)
      for (const VertexId w : neighbors[v])
        if (steps[w.value()] == kNoKey) {
          steps[w.value()] = step;
          next.push_back(w);
        }
    front.swap(next);
  }
  return steps;
}

/// Stable: a counting sort. Vertices without a key come last.
std::vector<std::uint32_t> sorted_by(const std::vector<std::uint32_t>& keys, const std::vector<std::uint32_t>& order) {
  const auto bucket = [&](std::uint32_t i) { return keys[i] == kNoKey ? keys.size() : keys[i]; };
  std::vector<std::uint32_t> next(keys.size() + 2, 0);
  for (std::uint32_t i = 0; i < keys.size(); ++i) ++next[bucket(i) + 1];
  for (std::size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
  std::vector<std::uint32_t> result(order.size());
  for (const std::uint32_t i : order) result[next[bucket(i)]++] = i;
  return result;
}

template <int D>
void FineMesh<D>::sort_vertices(const CoarseningOptions& options) {
  const std::size_t n = mesh.points.size();
  curve = hilbert_order<D>(mesh.points.raw());
  std::vector<std::uint32_t> order;
  if (options.order == CoarseningOrder::kRandom) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(n);
    for (std::uint32_t i = 0; i < n; ++i) keys[i] = {hash_words(options.seed, i), i};
    parallel_sort(keys.begin(), keys.end());
    for (const auto& [key, i] : keys) order.push_back(i);
  } else {
    order = options.order == CoarseningOrder::kFront ? sorted_by(steps_from_boundary(place, edges.neighbors), curve)
                                                     : curve;
  }
  point_vertices.resize(place.domain.points.size());
  std::vector<std::vector<VertexId>> in_facet(D == 3 ? place.domain.facet_frame.size() : 0);
  for (const std::uint32_t i : order) {
    const VertexId v(i);
    const PolytopeId carrier = place.carrier[v];
    if (carrier.dimension == 0) point_vertices[carrier.index] = v;
    if (carrier.dimension == 2 && D == 3) in_facet[carrier.index].push_back(v);
    if (is_interior(v)) interior.push_back(v);
  }
  for (const auto& row : in_facet) facet_vertices.push_row(row);
}

template <int D>
void FineMesh<D>::group_interior() {
  std::vector<VertexId> along_curve;
  along_curve.reserve(interior.size());
  std::vector<std::uint32_t> number(mesh.points.size());
  for (const std::uint32_t v : curve)
    if (is_interior(VertexId(v))) {
      number[v] = static_cast<std::uint32_t>(along_curve.size());
      along_curve.push_back(VertexId(v));
    }
  groups = VertexGroups<D>(std::move(along_curve), mesh.points);
  number_in_groups.resize(interior.size());
  parallel_for(interior.size(), [&](std::size_t i) { number_in_groups[i] = number[interior[i].value()]; });
}

template struct FineMesh<2>;
template struct FineMesh<3>;

}  // namespace voropack
