#include "certificate/sharp_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "base/disjoint_sets.h"
#include "geom/tolerance.h"

namespace voropack::judge {

namespace {

/// Chains of edges that turn by less than this (radians) at a vertex are straight.
constexpr double kStraight = 1e-6;

/// A projection that is shorter than this, relative to the vector, may be rounding.
constexpr double kNoise = 1e-6;

template <int D>
double angle_of(const Vec<D>& u, const Vec<D>& v) {
  return 2 * std::atan2(norm(norm(v) * u - norm(u) * v), norm(norm(v) * u + norm(u) * v));
}

/// Directions from a point into a polytope: one for an edge, two for the sides of a triangle.
template <int D>
struct Cone {
  std::array<Vec<D>, 2> side;
  int n = 1;
};

/// The angle between direction u and the nearest direction of a cone.
template <int D>
double angle_to(const Vec<D>& u, const Cone<D>& cone) {
  double least = angle_of(u, cone.side[0]);
  if (cone.n == 1) return least;
  least = std::min(least, angle_of(u, cone.side[1]));
  if constexpr (D == 3) {
    const Vec<3> normal = cross(cone.side[0], cone.side[1]);
    const Vec<3> foot = u - (dot(u, normal) / norm_sq(normal)) * normal;
    const bool inside = dot(cross(cone.side[0], foot), normal) > 0 && dot(cross(foot, cone.side[1]), normal) > 0;
    // A direction at a right angle to the cone's plane has a foot of rounding noise, which points anywhere.
    const bool has_foot = norm_sq(foot) > kNoise * kNoise * norm_sq(u);
    if (inside && has_foot) least = std::min(least, angle_of(u, foot));
  }
  return least;
}

/// Cones that meet in their tip only are nearest to each other along a side of one of them.
template <int D>
double angle_of(const Cone<D>& a, const Cone<D>& b) {
  double least = std::numbers::pi;
  for (int i = 0; i < a.n; ++i) least = std::min(least, angle_to<D>(a.side[static_cast<std::size_t>(i)], b));
  for (int i = 0; i < b.n; ++i) least = std::min(least, angle_to<D>(b.side[static_cast<std::size_t>(i)], a));
  return least;
}

}  // namespace

template <int D>
struct SharpFeatures<D>::Builder {
  using Edge = std::array<std::uint32_t, 2>;

  Builder(const Mesh<D>& the_mesh, const Topology<D>& topology) : mesh(the_mesh), boundary(topology.boundary()) {
    find_edges(topology);
    find_segments();
    if constexpr (D == 3) find_facets();
    collect_closures();
  }

  static Edge edge_of(std::uint32_t a, std::uint32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }
  [[nodiscard]] const Vec<D>& point(std::uint32_t v) const { return mesh.points[VertexId(v)]; }

  /// The edges that segments consist of: in the plane the boundary itself, in space those that the mesh lists, or
  /// where boundary faces meet at an angle or with different markers.
  void find_edges(const Topology<D>& topology) {
    if constexpr (D == 2) {
      for (const BoundaryFace<D>& f : boundary)
        if (f.valid && !f.repeated) edges.push_back({edge_of(f.vertices[0], f.vertices[1]), f.marker});
    } else {
      std::map<Edge, std::vector<std::uint32_t>> around;
      for (std::uint32_t b = 0; b < boundary.size(); ++b)
        if (boundary[b].valid && !boundary[b].repeated)
          for (std::size_t i = 0; i < 3; ++i)
            around[edge_of(boundary[b].vertices[i], boundary[b].vertices[(i + 1) % 3])].push_back(b);
      if (mesh.segment_edges.empty()) {
        for (const auto& [edge, faces] : around)
          if (!is_smooth(faces)) edges.push_back({edge, 0});
      }
      for (const EdgeId e : ids(mesh.segment_edges)) {
        const auto [a, b] = mesh.segment_edges[e];
        const bool valid = a != b && !a.is_none() && !b.is_none() && a.value() < mesh.points.size() &&
                           b.value() < mesh.points.size() && topology.finite(a.value()) && topology.finite(b.value());
        const bool has_marker = e.value() < mesh.segment_edge_marker.size();
        if (valid) edges.push_back({edge_of(a.value(), b.value()), has_marker ? mesh.segment_edge_marker[e] : 0});
      }
      faces_of_edge = std::move(around);
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }

  [[nodiscard]] Vec<D> normal(std::uint32_t b) const {
    if constexpr (D == 2) {
      return {};
    } else {
      const auto& v = boundary[b].vertices;
      return cross(point(v[1]) - point(v[0]), point(v[2]) - point(v[0]));
    }
  }

  [[nodiscard]] bool is_smooth(const std::vector<std::uint32_t>& faces) const {
    if (faces.size() != 2 || boundary[faces[0]].marker != boundary[faces[1]].marker) return false;
    const double angle = angle_of(normal(faces[0]), normal(faces[1]));
    return std::min(angle, std::numbers::pi - angle) <= kCoplanarAngle;
  }

  /// Joins edges at vertices where just two meet, of one marker and straight, unless the mesh says that a point of the
  /// domain is there.
  void find_segments() {
    std::vector<std::vector<std::uint32_t>> at(mesh.points.size());
    for (std::uint32_t e = 0; e < edges.size(); ++e)
      for (const std::uint32_t v : edges[e].first) at[v].push_back(e);
    DisjointSets sets(edges.size());
    is_corner.assign(mesh.points.size(), false);
    for (std::uint32_t v = 0; v < at.size(); ++v) {
      if (at[v].empty()) continue;
      is_corner[v] = true;
      if (at[v].size() != 2 || edges[at[v][0]].second != edges[at[v][1]].second) continue;
      if (v < mesh.vertex_carrier_dimension.size() && mesh.vertex_carrier_dimension[VertexId(v)] == 0) continue;
      const auto away = [&](std::uint32_t e) {
        return point(edges[e].first[0] == v ? edges[e].first[1] : edges[e].first[0]) - point(v);
      };
      if (std::numbers::pi - angle_of(away(at[v][0]), away(at[v][1])) > kStraight) continue;
      sets.join(at[v][0], at[v][1]);
      is_corner[v] = false;
    }
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
      polytope_of_edge.push_back(sets.find(e));
      edge_index[edges[e].first] = e;
    }
    edges_at = std::move(at);
  }

  void find_facets() {
    DisjointSets sets(boundary.size());
    for (const auto& [edge, faces] : faces_of_edge)
      if (!edge_index.contains(edge))
        for (std::size_t i = 1; i < faces.size(); ++i) sets.join(faces[0], faces[i]);
    const auto first = static_cast<std::uint32_t>(edges.size());
    polytope_of_face.assign(boundary.size(), kNone);
    faces_at.resize(mesh.points.size());
    for (std::uint32_t b = 0; b < boundary.size(); ++b) {
      if (!boundary[b].valid || boundary[b].repeated) continue;
      polytope_of_face[b] = first + sets.find(b);
      for (const std::uint32_t v : boundary[b].vertices) faces_at[v].push_back(b);
    }
    for (const auto& [edge, faces] : faces_of_edge)
      if (const auto it = edge_index.find(edge); it != edge_index.end())
        for (const std::uint32_t b : faces) contained.insert({polytope_of_edge[it->second], polytope_of_face[b]});
  }

  void collect_closures() {
    closures.resize(mesh.points.size());
    for (std::uint32_t v = 0; v < closures.size(); ++v) {
      for (const std::uint32_t e : edges_at[v]) closures[v].push_back(polytope_of_edge[e]);
      if constexpr (D == 3)
        for (const std::uint32_t b : faces_at[v]) closures[v].push_back(polytope_of_face[b]);
      std::sort(closures[v].begin(), closures[v].end());
      closures[v].erase(std::unique(closures[v].begin(), closures[v].end()), closures[v].end());
    }
  }

  std::map<Pair, double> find_angles() {
    if constexpr (D == 3) between_pages();
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
      if (closures[v].size() > 1) at_vertex(v);
    std::map<Pair, double> sharp;
    for (const auto& [pair, angle] : angles)
      if (angle < kSharpAngle) sharp.emplace(pair, angle);
    return sharp;
  }

  void note(std::uint32_t p, std::uint32_t q, double angle) {
    const auto [it, added] = angles.try_emplace(std::minmax(p, q), angle);
    if (!added) it->second = std::min(it->second, angle);
  }

  /// Facets that have a segment in common meet there, at the dihedral angle.
  void between_pages() {
    for (const auto& [edge, faces] : faces_of_edge) {
      if (!edge_index.contains(edge)) continue;
      const Vec<D> start = point(edge[0]), axis = point(edge[1]) - start;
      const auto inward = [&](std::uint32_t b) {
        Vec<D> d;
        for (const std::uint32_t v : boundary[b].vertices)
          if (v != edge[0] && v != edge[1]) d = point(v) - start;
        return d - (dot(d, axis) / norm_sq(axis)) * axis;
      };
      for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const std::uint32_t p = polytope_of_face[faces[i]], q = polytope_of_face[faces[j]];
          if (p == q) continue;
          note(p, q, angle_of(inward(faces[i]), inward(faces[j])));
          share_segment.insert(std::minmax(p, q));
        }
    }
  }

  /// Polytopes that have a point in common, neither in the other. On the inside of a segment all of them contain it.
  void at_vertex(std::uint32_t v) {
    if (edges_at[v].size() == 2 && !is_corner[v] && !has_stranger(v)) return;
    std::vector<std::pair<std::uint32_t, Cone<D>>> cones;
    for (const std::uint32_t e : edges_at[v]) {
      const Edge& edge = edges[e].first;
      cones.push_back({polytope_of_edge[e], {{point(edge[0] == v ? edge[1] : edge[0]) - point(v)}, 1}});
    }
    if constexpr (D == 3)
      for (const std::uint32_t b : faces_at[v]) {
        Cone<D> cone{{}, 0};
        for (const std::uint32_t w : boundary[b].vertices)
          if (w != v) cone.side[static_cast<std::size_t>(cone.n++)] = point(w) - point(v);
        cones.push_back({polytope_of_face[b], cone});
      }
    for (std::size_t i = 0; i < cones.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const std::uint32_t p = cones[i].first, q = cones[j].first;
        if (p == q || contained.contains({p, q}) || contained.contains({q, p})) continue;
        if (share_segment.contains(std::minmax(p, q))) continue;
        note(p, q, angle_of<D>(cones[i].second, cones[j].second));
      }
  }

  /// A polytope at v that neither is the segment through v nor contains it.
  [[nodiscard]] bool has_stranger(std::uint32_t v) const {
    const std::uint32_t segment = polytope_of_edge[edges_at[v][0]];
    return std::ranges::any_of(closures[v], [&](std::uint32_t p) {
      return p != segment && !contained.contains({segment, p});
    });
  }

  const Mesh<D>& mesh;
  const std::vector<BoundaryFace<D>>& boundary;
  std::vector<std::pair<Edge, int>> edges;  // Of segments, with markers; sorted.
  std::map<Edge, std::uint32_t> edge_index;
  std::map<Edge, std::vector<std::uint32_t>> faces_of_edge;
  std::vector<std::vector<std::uint32_t>> edges_at, faces_at, closures;  // By vertex.
  std::vector<bool> is_corner;                                           // By vertex: where segments end.
  std::vector<std::uint32_t> polytope_of_edge, polytope_of_face;
  std::set<Pair> contained;  // Segment, facet.
  std::set<Pair> share_segment;
  std::map<Pair, double> angles;
};

template <int D>
SharpFeatures<D>::SharpFeatures(const Mesh<D>& mesh, const Topology<D>& topology) {
  Builder builder(mesh, topology);
  angles_ = builder.find_angles();
  std::set<std::uint32_t> partners;
  for (const auto& [pair, angle] : angles_) partners.insert({pair.first, pair.second});
  carrier_.assign(mesh.points.size(), kNone);
  first_ = {0};
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    const auto& closure = builder.closures[v];
    if (!builder.edges_at[v].empty()) {
      if (!builder.is_corner[v]) carrier_[v] = builder.polytope_of_edge[builder.edges_at[v][0]];
    } else if (closure.size() == 1) {
      carrier_[v] = closure[0];
    }
    for (const std::uint32_t p : closure)
      if (partners.contains(p)) closures_.push_back(p);
    first_.push_back(static_cast<std::uint32_t>(closures_.size()));
  }
}

template <int D>
std::optional<double> SharpFeatures<D>::angle(std::uint32_t u, std::uint32_t v) const {
  std::optional<double> least;
  for (const std::uint32_t p : polytopes_of(u))
    for (const std::uint32_t q : polytopes_of(v))
      if (const auto found = between(p, q); found && (!least || *found < *least)) least = found;
  return least;
}

template <int D>
std::optional<double> SharpFeatures<D>::carrier_angle(std::uint32_t u, std::uint32_t v) const {
  if (carrier_[u] == kNone || carrier_[v] == kNone) return std::nullopt;
  return between(carrier_[u], carrier_[v]);
}

template class SharpFeatures<2>;
template class SharpFeatures<3>;

}  // namespace voropack::judge
