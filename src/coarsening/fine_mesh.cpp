#include "coarsening/fine_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/random.h"
#include "coarsening/initial_spacing.h"
#include "geom/hilbert.h"
#include "mesh/incidence.h"

namespace voropack {

template <int D>
Csr<VertexId, VertexId> vertex_neighbors(const Mesh<D>& mesh) {
  const std::size_t n = mesh.points.size();
  const Csr<VertexId, SimplexId> around = invert_incidence(mesh.simplex_vertices, n);
  constexpr std::size_t kBlock = 4096;
  struct Part {
    std::vector<VertexId> values;
    std::vector<std::uint32_t> counts;
  };
  std::vector<Part> parts((n + kBlock - 1) / kBlock);
  parallel_for(
      parts.size(),
      [&](std::size_t block) {
        std::vector<VertexId> found;
        for (std::size_t v = block * kBlock; v < std::min(n, (block + 1) * kBlock); ++v) {
          found.clear();
          for (const SimplexId s : around[VertexId(v)])
            for (const VertexId w : mesh.simplex_vertices[s])
              if (w.value() != v) found.push_back(w);
          std::sort(found.begin(), found.end());
          found.erase(std::unique(found.begin(), found.end()), found.end());
          parts[block].values.insert(parts[block].values.end(), found.begin(), found.end());
          parts[block].counts.push_back(static_cast<std::uint32_t>(found.size()));
        }
      },
      1);
  Csr<VertexId, VertexId> result;
  result.offsets.assign(1, 0);
  result.offsets.reserve(n + 1);
  for (const Part& part : parts) {
    for (const std::uint32_t count : part.counts) result.offsets.push_back(result.offsets.back() + count);
    result.values.insert(result.values.end(), part.values.begin(), part.values.end());
  }
  return result;
}

template <int D>
void make_lipschitz(const Mesh<D>& mesh, const Csr<VertexId, VertexId>& neighbors, double lipschitz,
                    IdVector<VertexId, double>& f) {
  const std::size_t n = mesh.points.size();
  // Whether a neighbor has become less since the vertex was looked at.
  std::vector<std::uint8_t> is_stale(n, 1);
  bool changed = true;
  const auto visit = [&](VertexId v) {
    if (is_stale[v.value()] == 0) return;
    is_stale[v.value()] = 0;
    double least = f[v];
    for (const VertexId w : neighbors[v]) {
      const double room = least - f[w];
      if (room <= 0) continue;
      const double rise_sq = lipschitz * lipschitz * distance_sq(mesh.points[v], mesh.points[w]);
      if (rise_sq < room * room) least = f[w] + std::sqrt(rise_sq);
    }
    if (least >= f[v]) return;
    f[v] = least;
    changed = true;
    for (const VertexId w : neighbors[v]) is_stale[w.value()] = 1;
  };
  while (changed) {
    changed = false;
    for (std::size_t v = 0; v < n; ++v) visit(VertexId(v));
    for (std::size_t v = n; v-- > 0;) visit(VertexId(v));
  }
}

template <int D>
FineMesh<D>::FineMesh(const Mesh<D>& fine, MeshDomain<D> domain_and_carriers, const CoarseningOptions& options,
                      std::vector<std::uint8_t> outside)
    : mesh(fine),
      place(std::move(domain_and_carriers)),
      incidence(place.domain),
      neighbors(vertex_neighbors(fine)),
      is_outside(std::move(outside)) {
  for (const VertexId v : ids(fine.points)) {
    if (!neighbors[v].empty()) continue;
    is_outside.resize(fine.points.size(), 0);
    is_outside[v.value()] = 1;
  }
  VertexSpacing spacing = initial_spacing(fine, neighbors, options.initial);
  initial = std::move(spacing.initial);
  floor = std::move(spacing.nearest);
  sort_vertices(options);
}

/// From the boundary inwards: by the number of edges to it.
template <int D>
std::vector<std::uint32_t> steps_from_boundary(const MeshDomain<D>& place, const Csr<VertexId, VertexId>& neighbors) {
  constexpr std::uint32_t kFar = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> steps(place.carrier.size(), kFar);
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
        if (steps[w.value()] == kFar) {
          steps[w.value()] = step;
          next.push_back(w);
        }
    front.swap(next);
  }
  return steps;
}

template <int D>
void FineMesh<D>::sort_vertices(const CoarseningOptions& options) {
  const std::size_t n = mesh.points.size();
  std::vector<std::uint32_t> order;
  if (options.order == CoarseningOrder::kRandom) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(n);
    for (std::uint32_t i = 0; i < n; ++i) keys[i] = {hash_words(options.seed, i), i};
    parallel_sort(keys.begin(), keys.end());
    for (const auto& [key, i] : keys) order.push_back(i);
  } else {
    order = hilbert_order<D>(mesh.points.raw());
    if (options.order == CoarseningOrder::kFront) {
      const std::vector<std::uint32_t> steps = steps_from_boundary(place, neighbors);
      std::stable_sort(order.begin(), order.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return steps[a] < steps[b]; });
    }
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

template struct FineMesh<2>;
template struct FineMesh<3>;
template Csr<VertexId, VertexId> vertex_neighbors(const Mesh<2>&);
template Csr<VertexId, VertexId> vertex_neighbors(const Mesh<3>&);
template void make_lipschitz(const Mesh<2>&, const Csr<VertexId, VertexId>&, double, IdVector<VertexId, double>&);
template void make_lipschitz(const Mesh<3>&, const Csr<VertexId, VertexId>&, double, IdVector<VertexId, double>&);

}  // namespace voropack
