#include "coarsening/chained_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "voropack/error.h"

namespace voropack {

namespace {

struct Side {
  std::uint32_t from, to;
  int region;
  friend auto operator<=>(const Side&, const Side&) = default;
};

struct BoundaryEdge {
  std::array<std::uint32_t, 2> vertices;
  std::array<int, 2> regions;  ///< Left and right.
  int marker;
};

/// Directed edges between boundary vertices with the region to their left.
std::vector<Side> find_sides(const Mesh<2>& mesh, const std::vector<std::uint8_t>& on_boundary,
                             const std::vector<int>& region_id) {
  std::vector<Side> sides;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = c[i].value(), b = c[(i + 1) % 3].value();
      if (on_boundary[a] == 0 || on_boundary[b] == 0) continue;
      const auto region = std::lower_bound(region_id.begin(), region_id.end(), mesh.simplex_region[s]);
      sides.push_back({a, b, static_cast<int>(region - region_id.begin())});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

int region_left_of(const std::vector<Side>& sides, std::uint32_t a, std::uint32_t b) {
  const auto at = std::lower_bound(sides.begin(), sides.end(), Side{a, b, kOutside});
  return at != sides.end() && at->from == a && at->to == b ? at->region : kOutside;
}

std::vector<BoundaryEdge> find_edges(const Mesh<2>& mesh, const std::vector<Side>& sides) {
  std::vector<BoundaryEdge> edges;
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    const std::uint32_t u = mesh.boundary_vertices[b][0].value(), v = mesh.boundary_vertices[b][1].value();
    const std::array<int, 2> regions = {region_left_of(sides, u, v), region_left_of(sides, v, u)};
    if (regions[0] == kOutside && regions[1] == kOutside)
      throw InputError(
          Fault{.id = "coarsen.not_an_edge",
                .message = fmt::format("boundary edge {} is no edge of the mesh (vertices {}, {}; all counted from 0)",
                                       b.value(), u, v),
                .fix = "mesh the domain anew"});
    edges.push_back({{u, v}, regions, mesh.boundary_marker[b]});
  }
  return edges;
}

/// Follows edges from vertex to vertex.
class Tracer {
 public:
  Tracer(const std::vector<BoundaryEdge>& edges, std::size_t n_vertices) : edges_(edges), used_(edges.size(), 0) {
    IdVector<BoundaryId, std::array<VertexId, 2>> ends;
    for (const BoundaryEdge& e : edges)
      ends.push_back({VertexId(std::size_t{e.vertices[0]}), VertexId(std::size_t{e.vertices[1]})});
    at_.resize(n_vertices);
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      for (const std::uint32_t v : edges[e].vertices) at_[v].push_back(e);
  }

  /// Neither passed nor left out on any level: another number of edges than two, or another kind of edge beyond.
  [[nodiscard]] bool is_anchor(std::uint32_t v) const {
    if (at_[v].empty()) return false;
    return at_[v].size() != 2 || !same_kind(at_[v][0], at_[v][1], v);
  }

  /// By how much the boundary turns at v; 0 unless two edges meet there.
  [[nodiscard]] double turn_deg(std::uint32_t v, const std::vector<Vec<2>>& points) const {
    if (at_[v].size() != 2) return 0;
    const auto beyond = [&](std::uint32_t e) {
      return points[edges_[e].vertices[0] == v ? edges_[e].vertices[1] : edges_[e].vertices[0]] - points[v];
    };
    const Vec<2> a = beyond(at_[v][0]), b = beyond(at_[v][1]);
    return 180 - std::abs(std::atan2(cross(a, b), dot(a, b))) * 180 / std::numbers::pi;
  }

  void trace_all(std::vector<std::uint8_t>& anchors, std::vector<VertexChain>& chains) {
    for (std::uint32_t v = 0; v < at_.size(); ++v)
      if (anchors[v] != 0)
        for (const std::uint32_t e : at_[v])
          if (used_[e] == 0) chains.push_back(trace(e, v, anchors));
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
      if (used_[e] == 0) chains.push_back(trace(e, edges_[e].vertices[0], anchors));
  }

 private:
  /// The regions on the two sides of an edge when it is walked from v.
  [[nodiscard]] std::array<int, 2> regions_from(std::uint32_t e, std::uint32_t v) const {
    const auto& r = edges_[e].regions;
    return edges_[e].vertices[0] == v ? r : std::array<int, 2>{r[1], r[0]};
  }
  [[nodiscard]] bool same_kind(std::uint32_t a, std::uint32_t b, std::uint32_t v) const {
    const auto ra = regions_from(a, v), rb = regions_from(b, v);
    return edges_[a].marker == edges_[b].marker && ra[0] == rb[1] && ra[1] == rb[0];
  }

  VertexChain trace(std::uint32_t e, std::uint32_t from, const std::vector<std::uint8_t>& anchors) {
    VertexChain chain;
    chain.regions = regions_from(e, from);
    chain.marker = edges_[e].marker;
    chain.vertices.push_back(from);
    std::uint32_t v = from;
    for (;;) {
      used_[e] = 1;
      v = edges_[e].vertices[0] == v ? edges_[e].vertices[1] : edges_[e].vertices[0];
      chain.is_closed = v == from && anchors[v] == 0;
      if (!chain.is_closed) chain.vertices.push_back(v);
      if (v == from || anchors[v] != 0) return chain;
      e = at_[v][0] == e ? at_[v][1] : at_[v][0];
    }
  }

  const std::vector<BoundaryEdge>& edges_;
  std::vector<std::uint8_t> used_;
  std::vector<std::vector<std::uint32_t>> at_;  ///< Edges at a vertex.
};

void add_places(ChainedMesh& out) {
  std::vector<std::vector<ChainPlace>> rows(out.points.size());
  for (std::uint32_t c = 0; c < out.chains.size(); ++c)
    for (std::uint32_t k = 0; k < out.chains[c].vertices.size(); ++k) rows[out.chains[c].vertices[k]].push_back({c, k});
  for (const auto& row : rows) out.places.push_row(row);
}

}  // namespace

ChainedMesh find_chains(const Mesh<2>& mesh, double feature_angle_deg) {
  ChainedMesh out;
  const std::size_t n = mesh.points.size();
  out.points = mesh.points.raw();
  out.region_id = mesh.simplex_region.raw();
  std::sort(out.region_id.begin(), out.region_id.end());
  out.region_id.erase(std::unique(out.region_id.begin(), out.region_id.end()), out.region_id.end());
  out.region_area.assign(out.region_id.size(), 0);
  out.vertex_region.assign(n, kOutside);
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto at = std::lower_bound(out.region_id.begin(), out.region_id.end(), mesh.simplex_region[s]);
    const auto& c = mesh.simplex_vertices[s];
    const auto region = static_cast<std::size_t>(at - out.region_id.begin());
    out.region_area[region] +=
        0.5 * cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
    for (const VertexId v : c) out.vertex_region[v.value()] = static_cast<int>(region);
  }
  std::vector<std::uint8_t> on_boundary(n, 0);
  for (const auto& edge : mesh.boundary_vertices)
    for (const VertexId v : edge) on_boundary[v.value()] = 1;
  const std::vector<BoundaryEdge> edges = find_edges(mesh, find_sides(mesh, on_boundary, out.region_id));
  Tracer tracer(edges, n);
  out.is_anchor.assign(n, 0);
  for (std::uint32_t v = 0; v < n; ++v) {
    const bool is_point = !mesh.vertex_carrier_dimension.empty() && on_boundary[v] == 0 &&
                          mesh.vertex_carrier_dimension[VertexId(std::size_t{v})] == 0;
    const bool is_corner = tracer.turn_deg(v, out.points) > feature_angle_deg;
    out.is_anchor[v] = tracer.is_anchor(v) || is_point || is_corner ? 1 : 0;
  }
  tracer.trace_all(out.is_anchor, out.chains);
  add_places(out);
  return out;
}

double chain_deviation(const ChainedMesh& mesh, const VertexChain& chain, std::size_t from, std::size_t to) {
  const std::size_t n = chain.vertices.size();
  const Vec<2> a = mesh.points[chain.vertices[from]];
  const Vec<2> ab = mesh.points[chain.vertices[to]] - a;
  double farthest_sq = 0;
  for (std::size_t k = (from + 1) % n; k != to; k = (k + 1) % n) {
    const Vec<2> x = mesh.points[chain.vertices[k]] - a;
    const double t = std::clamp(dot(x, ab) / norm_sq(ab), 0.0, 1.0);
    farthest_sq = std::max(farthest_sq, norm_sq(x - t * ab));
  }
  return std::sqrt(farthest_sq);
}

double chain_area(const ChainedMesh& mesh, const VertexChain& chain, std::size_t from, std::size_t to) {
  const std::size_t n = chain.vertices.size();
  const Vec<2> a = mesh.points[chain.vertices[from]];
  double twice = 0;
  for (std::size_t k = from; k != to; k = (k + 1) % n)
    twice += cross(mesh.points[chain.vertices[k]] - a, mesh.points[chain.vertices[(k + 1) % n]] - a);
  return 0.5 * twice;
}

}  // namespace voropack
