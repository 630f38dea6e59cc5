// Patches of what carries a marker inside the domain: faces, else segments, else points.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "dual/patch_shares.h"
#include "mesh/faces.h"

namespace voropack {

namespace {

/// The faces inside with one of the markers, each from both of its sides.
template <int D>
std::vector<FaceSide<D>> inner_faces(const Mesh<D>& mesh, const std::set<int>& markers,
                                     const std::vector<FaceSide<D>>& hull) {
  std::map<FaceKey<D>, int> marked;
  const auto by_key = [](const FaceSide<D>& face, const FaceKey<D>& key) { return face.key < key; };
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    const FaceKey<D> key = sorted<D>(mesh.boundary_vertices[b]);
    const auto on_hull = std::lower_bound(hull.begin(), hull.end(), key, by_key);
    const bool is_inside = on_hull == hull.end() || on_hull->key != key;
    if (is_inside && markers.contains(mesh.boundary_marker[b])) marked.emplace(key, mesh.boundary_marker[b]);
  }
  std::vector<FaceSide<D>> sides;
  if (marked.empty()) return sides;
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const auto found = marked.find(sorted<D>(face_vertices(mesh, s, i)));
      if (found != marked.end()) sides.push_back({found->first, mesh.simplex_region[s], found->second, 0.5});
    }
  return sides;
}

/// The regions of the simplices that have each point or segment of `wanted`.
template <int D, std::size_t N>
std::map<std::array<VertexId, N>, std::set<int>> regions_around(const Mesh<D>& mesh,
                                                                const std::map<std::array<VertexId, N>, int>& wanted) {
  std::vector<std::uint8_t> is_wanted(mesh.points.size());
  for (const auto& [vertices, marker] : wanted)
    for (const VertexId v : vertices) is_wanted[v.value()] = 1;
  std::map<std::array<VertexId, N>, std::set<int>> regions;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& corners = mesh.simplex_vertices[s];
    for (std::size_t i = 0; i <= D; ++i) {
      if (is_wanted[corners[i].value()] == 0) continue;
      if constexpr (N == 1) {
        regions[{corners[i]}].insert(mesh.simplex_region[s]);
      } else {
        for (std::size_t j = 0; j < i; ++j) {
          const std::array<VertexId, N> edge = {std::min(corners[i], corners[j]), std::max(corners[i], corners[j])};
          if (wanted.contains(edge)) regions[edge].insert(mesh.simplex_region[s]);
        }
      }
    }
  }
  return regions;
}

void add_segments(const Mesh<3>& mesh, const std::set<int>& markers, std::vector<Share<3>>& shares) {
  std::map<std::array<VertexId, 2>, int> wanted;
  for (const EdgeId e : ids(mesh.segment_edges))
    if (markers.contains(mesh.segment_edge_marker[e])) {
      const auto [a, b] = mesh.segment_edges[e];
      wanted[{std::min(a, b), std::max(a, b)}] = mesh.segment_edge_marker[e];
    }
  if (wanted.empty()) return;
  for (const auto& [segment, regions] : regions_around(mesh, wanted))
    for (const int region : regions)
      add_segment_shares(mesh, segment, wanted.at(segment), region, 1.0 / static_cast<double>(regions.size()), shares);
}
void add_segments(const Mesh<2>&, const std::set<int>&, std::vector<Share<2>>&) {}  // They are faces.

template <int D>
void add_points(const Mesh<D>& mesh, const std::set<int>& markers, std::vector<Share<D>>& shares) {
  std::map<std::array<VertexId, 1>, int> wanted;
  for (const VertexId v : ids(mesh.vertex_marker)) {
    const bool is_point = mesh.vertex_carrier_dimension.empty() || mesh.vertex_carrier_dimension[v] == 0;
    if (is_point && markers.contains(mesh.vertex_marker[v])) wanted[{v}] = mesh.vertex_marker[v];
  }
  if (wanted.empty()) return;
  for (const auto& [vertex, regions] : regions_around(mesh, wanted))
    for (const int region : regions) {
      const double area = 1.0 / static_cast<double>(regions.size());
      shares.push_back({vertex[0], wanted.at(vertex), region, area, area * mesh.points[vertex[0]]});
    }
}

}  // namespace

template <int D>
void add_inner_shares(const Mesh<D>& mesh, const std::set<int>& markers, const std::vector<FaceSide<D>>& hull,
                      std::vector<Share<D>>& shares) {
  std::set<int> left = markers;
  auto remove_found = [&, next = shares.size()]() mutable {
    for (; next != shares.size(); ++next) left.erase(shares[next].marker);
  };
  for (const FaceSide<D>& side : inner_faces(mesh, left, hull)) add_face_shares(mesh, side, shares);
  remove_found();
  add_segments(mesh, left, shares);
  remove_found();
  add_points(mesh, left, shares);
}

template void add_inner_shares(const Mesh<2>&, const std::set<int>&, const std::vector<FaceSide<2>>&,
                               std::vector<Share<2>>&);
template void add_inner_shares(const Mesh<3>&, const std::set<int>&, const std::vector<FaceSide<3>>&,
                               std::vector<Share<3>>&);

}  // namespace voropack
