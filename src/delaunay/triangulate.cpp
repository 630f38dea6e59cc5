#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "geom/hilbert.h"
#include "geom/kernel.h"
#include "spheres/region_labels.h"
#include "voropack/delaunay.h"

namespace voropack {

namespace {

[[noreturn]] void throw_not_conforming(std::size_t n) {
  throw InternalError(Fault{.id = "delaunay.not_conforming",
                            .message = fmt::format("{} protected simplices are not in the Delaunay triangulation", n),
                            .fix = "report this with the input; a smaller --feature-factor may help meanwhile"});
}

/// Triangulates the centers and keeps what lies in regions.
template <int D>
Triangulation<D> triangulate_regions(const Domain<D>& domain, const Packing<D>& packing) {
  DelaunayKernel<D> kernel;
  kernel.insert(packing.center.raw());
  const RegionLabels<D> labels = label_regions<D>(kernel, protected_faces(domain, packing));
  if (!labels.missing_faces.empty() || !labels.leaking_faces.empty())
    throw_not_conforming(labels.missing_faces.size() + labels.leaking_faces.size());
  return export_triangulation(kernel, labels.region);
}

/// Vertices along a Hilbert curve: position in the mesh by sphere.
template <int D>
std::vector<std::uint32_t> vertex_order(const Packing<D>& packing) {
  Box<D> box;
  for (const Vec<D>& x : packing.center) box.add(x);
  const std::vector<std::uint32_t> sphere_at = hilbert_order<D>(packing.center.raw(), box);
  std::vector<std::uint32_t> order(sphere_at.size());
  parallel_for(order.size(), [&](std::size_t v) { order[sphere_at[v]] = static_cast<std::uint32_t>(v); });
  return order;
}

/// Rotates the corners so that the smallest comes first, keeping orientation: the same mesh gets the same bytes
/// whatever made it.
template <int D>
void canonicalize(std::array<std::uint32_t, D + 1>& corners, std::array<std::uint32_t, D + 1>& neighbors) {
  // Sort by selection; an odd number of swaps is mended by swapping the last two.
  bool odd = false;
  for (std::size_t i = 0; i <= D; ++i) {
    const auto least = static_cast<std::size_t>(
        std::min_element(corners.begin() + static_cast<std::ptrdiff_t>(i), corners.end()) - corners.begin());
    if (least == i) continue;
    std::swap(corners[i], corners[least]);
    std::swap(neighbors[i], neighbors[least]);
    odd = !odd;
  }
  if (!odd) return;
  std::swap(corners[D - 1], corners[D]);
  std::swap(neighbors[D - 1], neighbors[D]);
}

/// Simplices by their corners, the smallest first: along the same curve. Position in the mesh by simplex. The corners
/// are canonical.
template <int D>
std::vector<std::uint32_t> simplex_order(const std::vector<std::array<std::uint32_t, D + 1>>& simplices,
                                         std::size_t n_vertices) {
  std::vector<std::uint32_t> first(n_vertices + 1, 0);
  for (const auto& corners : simplices) ++first[corners[0] + 1];
  for (std::size_t v = 0; v < n_vertices; ++v) first[v + 1] += first[v];
  std::vector<std::uint32_t> sorted(simplices.size()), next(first.begin(), first.end() - 1);
  for (std::uint32_t s = 0; s < simplices.size(); ++s) sorted[next[simplices[s][0]]++] = s;
  std::vector<std::uint32_t> order(simplices.size());
  parallel_for(n_vertices, [&](std::size_t v) {
    std::sort(sorted.begin() + first[v], sorted.begin() + first[v + 1],
              [&](std::uint32_t a, std::uint32_t b) { return simplices[a] < simplices[b]; });
    for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) order[sorted[i]] = i;
  });
  return order;
}

template <int D>
int marker_of(const Domain<D>& domain, PolytopeId carrier) {
  switch (carrier.dimension) {
    case 0:
      return domain.point_marker[PointId(carrier.index)];
    case 1:
      return domain.segment_marker[SegmentId(carrier.index)];
    case 2:
      return D == 3 ? domain.facet_marker[FacetId(carrier.index)] : 0;
    default:
      return 0;
  }
}

template <int D>
void add_vertices(const Domain<D>& domain, const Packing<D>& packing, const std::vector<std::uint32_t>& order,
                  Mesh<D>& mesh) {
  const std::size_t n = order.size();
  mesh.points.resize(n);
  mesh.vertex_spacing.resize(n);
  mesh.vertex_marker.resize(n);
  mesh.vertex_carrier_dimension.resize(n);
  parallel_for(n, [&](std::size_t i) {
    const SphereId s(i);
    const VertexId v(order[i]);
    mesh.points[v] = packing.center[s];
    mesh.vertex_spacing[v] = packing.radius[s];
    mesh.vertex_carrier_dimension[v] = static_cast<std::uint8_t>(packing.carrier[s].dimension);
    mesh.vertex_marker[v] = marker_of(domain, packing.carrier[s]);
  });
}

template <int D>
void add_simplices(const Domain<D>& domain, Triangulation<D>&& t, const std::vector<std::uint32_t>& order,
                   Mesh<D>& mesh) {
  parallel_for(t.simplices.size(), [&](std::size_t s) {
    for (std::uint32_t& v : t.simplices[s]) v = order[v];
    canonicalize<D>(t.simplices[s], t.neighbors[s]);
  });
  const std::vector<std::uint32_t> position = simplex_order<D>(t.simplices, order.size());
  const std::size_t n = t.simplices.size();
  mesh.simplex_vertices.resize(n);
  mesh.simplex_neighbors.resize(n);
  mesh.simplex_region.resize(n);
  parallel_for(n, [&](std::size_t s) {
    const SimplexId id(position[s]);
    for (std::size_t i = 0; i <= D; ++i) {
      const std::uint32_t neighbor = t.neighbors[s][i];
      mesh.simplex_vertices[id][i] = VertexId(t.simplices[s][i]);
      mesh.simplex_neighbors[id][i] =
          neighbor == Triangulation<D>::kNoNeighbor ? SimplexId::none() : SimplexId(position[neighbor]);
    }
    mesh.simplex_region[id] = domain.region_id[RegionId(static_cast<std::size_t>(t.regions[s]))];
  });
}

template <int D>
void add_boundary(const Domain<D>& domain, const Packing<D>& packing, const std::vector<std::uint32_t>& order,
                  Mesh<D>& mesh) {
  for (const auto& simplex : wall_simplices(packing)) {
    std::array<VertexId, D> corners;
    for (std::size_t i = 0; i < D; ++i) corners[i] = VertexId(order[simplex.spheres[i].value()]);
    mesh.boundary_vertices.push_back(corners);
    mesh.boundary_marker.push_back(domain.wall_marker(simplex.carrier.index));
  }
  if constexpr (D == 3)
    for (const auto& simplex : packing.subsegments) {
      mesh.segment_edges.push_back(
          {VertexId(order[simplex.spheres[0].value()]), VertexId(order[simplex.spheres[1].value()])});
      mesh.segment_edge_marker.push_back(domain.segment_marker[SegmentId(simplex.carrier.index)]);
    }
}

}  // namespace

template <int D>
PackingMesh<D> triangulate_packing(const Domain<D>& domain, Packing<D> packing, Observer& observer) {
  observer.begin_stage("delaunay");
  Triangulation<D> triangulation =
      packing.triangulation.simplices.empty() ? triangulate_regions(domain, packing) : std::move(packing.triangulation);
  observer.check_cancelled();
  const std::vector<std::uint32_t> order = vertex_order(packing);
  Mesh<D> mesh;
  add_vertices(domain, packing, order, mesh);
  add_simplices(domain, std::move(triangulation), order, mesh);
  add_boundary(domain, packing, order, mesh);
  IdVector<SphereId, VertexId> vertex_of_sphere(order.size());
  for (const SphereId s : ids(vertex_of_sphere)) vertex_of_sphere[s] = VertexId(order[s.value()]);
  return {std::move(mesh), std::move(vertex_of_sphere)};
}

template <int D>
Mesh<D> triangulate(const Domain<D>& domain, Packing<D> packing, Observer& observer) {
  return triangulate_packing(domain, std::move(packing), observer).mesh;
}

template <int D>
Triangulation<D> delaunay_triangulation(const std::vector<Vec<D>>& points) {
  DelaunayKernel<D> kernel;
  kernel.insert(points);
  std::vector<int> region(kernel.n_slots());
  for (std::uint32_t slot = 0; slot < kernel.n_slots(); ++slot) region[slot] = kernel.is_finite(slot) ? 0 : -1;
  return export_triangulation(kernel, region);
}

template PackingMesh<2> triangulate_packing(const Domain<2>&, Packing<2>, Observer&);
template PackingMesh<3> triangulate_packing(const Domain<3>&, Packing<3>, Observer&);
template Mesh<2> triangulate(const Domain<2>&, Packing<2>, Observer&);
template Mesh<3> triangulate(const Domain<3>&, Packing<3>, Observer&);
template Triangulation<2> delaunay_triangulation(const std::vector<Vec<2>>&);
template Triangulation<3> delaunay_triangulation(const std::vector<Vec<3>>&);

}  // namespace voropack
