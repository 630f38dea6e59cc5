#include "mesh_domain/boundary_complex.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "mesh/faces.h"

namespace voropack {

namespace {

using Edge = std::array<std::uint32_t, 2>;

Edge edge_of(VertexId a, VertexId b) { return a < b ? Edge{a.value(), b.value()} : Edge{b.value(), a.value()}; }

template <int D>
double distance_to_line(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b) {
  const Vec<D> along = b - a;
  const double length_sq = norm_sq(along);
  if (!(length_sq > 0)) return distance(x, a);
  return distance(x, a + (dot(x - a, along) / length_sq) * along);
}

/// The regions on both sides of each boundary face, the smaller id first; kNoRegion where there is none.
template <int D>
class FaceRegions {
 public:
  using Pair = std::array<int, 2>;
  static constexpr int kNoRegion = std::numeric_limits<int>::min();

  FaceRegions(const Mesh<D>& mesh, const BoundaryZone<D>& zone)
      : pairs_(mesh.boundary_vertices.size(), Pair{kNoRegion, kNoRegion}) {
    struct Side {
      std::uint32_t face;
      int region;
    };
    const auto find_sides = [&](SimplexId s, std::vector<Side>& sides) {
      for (int i = 0; i <= D; ++i)
        if (const std::uint32_t f = zone.faces.find(face_vertices<D>(mesh, s, i)); f != zone.faces.kAbsent)
          sides.push_back({f, mesh.simplex_region[s]});
    };
    for (const Side& side : zone.template collect<Side>(find_sides)) {
      Pair& pair = pairs_[side.face];
      pair[pair[0] == kNoRegion ? 0 : 1] = side.region;
      if (pair[1] != kNoRegion && pair[1] < pair[0]) std::swap(pair[0], pair[1]);
    }
  }
  [[nodiscard]] const Pair& operator[](std::size_t face) const { return pairs_[face]; }

 private:
  std::vector<Pair> pairs_;
};

/// An edge where facets end, or that the mesh lists.
struct FeatureEdge {
  Edge ends;
  std::optional<int> marker;
  std::vector<std::uint32_t> sides;  ///< What meets there: patches in 3D, the pair of regions in 2D. Sorted.
};

template <int D>
class ComplexFinder {
 public:
  ComplexFinder(const Mesh<D>& mesh, const BoundaryZone<D>& zone, double tolerance)
      : mesh_(mesh), tolerance_(tolerance), regions_(mesh, zone) {}

  BoundaryComplex<D> run() {
    if constexpr (D == 3) {
      find_edges();
      join_patches();
      find_patches();
    } else {
      list_segments();
    }
    find_corners();
    walk_chains();
    for (const VertexId v : ids(mesh_.points))
      if (is_corner_[v.value()] != 0) result_.corners.push_back(v);
    return std::move(result_);
  }

 private:
  struct EdgeFaces {
    Edge ends;
    std::vector<std::uint32_t> faces;
    std::optional<int> marker;
    bool is_listed = false, is_feature = false;
  };

  [[nodiscard]] const Vec<D>& point(std::uint32_t v) const { return mesh_.points[VertexId(v)]; }

  void list_segments() requires(D == 2) {
    std::map<FaceRegionsPair, std::uint32_t> number;
    for (const BoundaryId f : ids(mesh_.boundary_vertices)) {
      const auto& [a, b] = mesh_.boundary_vertices[f];
      const auto [it, is_new] = number.emplace(regions_[f.value()], static_cast<std::uint32_t>(number.size()));
      features_.push_back({edge_of(a, b), mesh_.boundary_marker[f], {it->second}});
    }
  }

  void find_edges() requires(D == 3) {
    struct Side {
      std::uint64_t edge;  ///< Both ends.
      std::uint32_t face;
      auto operator<=>(const Side&) const = default;
    };
    std::vector<Side> sides;
    sides.reserve(3 * mesh_.boundary_vertices.size());
    for (const BoundaryId f : ids(mesh_.boundary_vertices)) {
      const auto& face = mesh_.boundary_vertices[f];
      for (std::size_t i = 0; i < 3; ++i) {
        const Edge ends = edge_of(face[i], face[(i + 1) % 3]);
        sides.push_back({std::uint64_t{ends[0]} << 32U | ends[1], f.value()});
      }
    }
    parallel_sort(sides.begin(), sides.end());
    std::map<Edge, std::optional<int>> listed;
    for (const EdgeId e : ids(mesh_.segment_edges))
      listed[edge_of(mesh_.segment_edges[e][0], mesh_.segment_edges[e][1])] = mesh_.segment_edge_marker[e];
    for (std::size_t i = 0; i < sides.size();) {
      const std::uint64_t number = sides[i].edge;
      EdgeFaces edge{
          {static_cast<std::uint32_t>(number >> 32U), static_cast<std::uint32_t>(number)}, {}, {}, false, false};
      for (; i < sides.size() && sides[i].edge == number; ++i) edge.faces.push_back(sides[i].face);
      if (const auto it = listed.find(edge.ends); it != listed.end()) {
        edge.is_listed = true;
        edge.marker = it->second;
        listed.erase(it);
      }
      edge.is_feature = edge.is_listed || is_crease(edge);
      edges_.push_back(std::move(edge));
    }
    // Of no face: inside a region.
    for (const auto& [ends, marker] : listed) edges_.push_back({ends, {}, marker, true, true});
  }

  [[nodiscard]] bool is_crease(const EdgeFaces& edge) const requires(D == 3) {
    if (edge.faces.size() != 2) return true;
    const auto [f, g] = std::array{edge.faces[0], edge.faces[1]};
    if (mesh_.boundary_marker[BoundaryId(f)] != mesh_.boundary_marker[BoundaryId(g)]) return true;
    if (regions_[f] != regions_[g]) return true;
    return height(f, apex(g, edge.ends)) > tolerance_ || height(g, apex(f, edge.ends)) > tolerance_ ||
           dot(inward(f, edge.ends), inward(g, edge.ends)) > 0;
  }

  [[nodiscard]] std::uint32_t apex(std::uint32_t f, const Edge& edge) const requires(D == 3) {
    for (const VertexId v : mesh_.boundary_vertices[BoundaryId(f)])
      if (v.value() != edge[0] && v.value() != edge[1]) return v.value();
    return edge[0];
  }
  [[nodiscard]] Vec<3> inward(std::uint32_t f, const Edge& edge) const requires(D == 3) {
    const Vec<3> along = point(edge[1]) - point(edge[0]), to = point(apex(f, edge)) - point(edge[0]);
    return to - (dot(to, along) / norm_sq(along)) * along;
  }
  [[nodiscard]] Vec<3> normal(std::uint32_t f) const requires(D == 3) {
    const auto& [a, b, c] = mesh_.boundary_vertices[BoundaryId(f)];
    return cross(point(b.value()) - point(a.value()), point(c.value()) - point(a.value()));
  }
  [[nodiscard]] double height(std::uint32_t f, std::uint32_t v) const requires(D == 3) {
    const Vec<3> n = normal(f);
    return std::abs(dot(n, point(v) - point(mesh_.boundary_vertices[BoundaryId(f)][0].value()))) / norm(n);
  }

  /// Faces across edges that are no features, as long as all of them lie in the plane of the largest one.
  void join_patches() requires(D == 3) {
    const std::size_t n = mesh_.boundary_vertices.size();
    DisjointSets sets(n);
    for (const EdgeFaces& edge : edges_)
      if (!edge.is_feature) sets.join(edge.faces[0], edge.faces[1]);
    std::vector<std::uint32_t> largest(n);
    std::iota(largest.begin(), largest.end(), 0U);
    for (std::uint32_t f = 0; f < n; ++f) {
      std::uint32_t& best = largest[sets.find(f)];
      if (norm_sq(normal(f)) > norm_sq(normal(best))) best = f;
    }
    std::vector<std::uint8_t> is_curved(n, 0);
    for (std::uint32_t f = 0; f < n; ++f)
      for (const VertexId v : mesh_.boundary_vertices[BoundaryId(f)])
        if (height(largest[sets.find(f)], v.value()) > tolerance_) is_curved[sets.find(f)] = 1;
    patch_.assign(n, 0);
    std::vector<std::uint32_t> number(n, kNone);
    for (std::uint32_t f = 0; f < n; ++f) {
      const auto root = static_cast<std::uint32_t>(sets.find(f));
      const bool alone = is_curved[root] != 0;
      if (alone || number[root] == kNone) {
        number[root] = static_cast<std::uint32_t>(result_.patches.size());
        BoundaryPatch patch;
        patch.normal = normal(alone ? f : largest[root]);
        patch.marker = mesh_.boundary_marker[BoundaryId(f)];
        result_.patches.push_back(std::move(patch));
      }
      patch_[f] = number[root];
    }
    for (EdgeFaces& edge : edges_)
      if (!edge.is_feature && patch_[edge.faces[0]] != patch_[edge.faces[1]]) edge.is_feature = true;
  }

  void find_patches() requires(D == 3) {
    for (const BoundaryId f : ids(mesh_.boundary_vertices)) {
      BoundaryPatch& patch = result_.patches[patch_[f.value()]];
      std::array<VertexId, 3> face = mesh_.boundary_vertices[f];
      if (dot(normal(f.value()), patch.normal) < 0) std::swap(face[1], face[2]);
      patch.faces.push_back(face);
    }
    for (const EdgeFaces& edge : edges_) {
      if (!edge.is_feature) continue;
      FeatureEdge feature{edge.ends, edge.marker, {}};
      for (const std::uint32_t f : edge.faces) feature.sides.push_back(patch_[f]);
      std::sort(feature.sides.begin(), feature.sides.end());
      add_to_patches(edge);
      features_.push_back(std::move(feature));
    }
  }

  /// An edge that a patch has once is a part of its outline.
  void add_to_patches(const EdgeFaces& edge) requires(D == 3) {
    for (const std::uint32_t f : edge.faces) {
      BoundaryPatch& patch = result_.patches[patch_[f]];
      const auto same = std::ranges::count_if(edge.faces, [&](std::uint32_t g) { return patch_[g] == patch_[f]; });
      std::array<VertexId, 2> ends = {VertexId(edge.ends[0]), VertexId(edge.ends[1])};
      if (same > 1) {
        if (patch.inner_feature_edges.empty() || patch.inner_feature_edges.back() != ends)
          patch.inner_feature_edges.push_back(ends);
        continue;
      }
      const Vec<3> along = point(edge.ends[1]) - point(edge.ends[0]);
      if (dot(cross(along, inward(f, edge.ends)), patch.normal) < 0) std::swap(ends[0], ends[1]);
      patch.outline.push_back(ends);
    }
  }

  void find_corners() {
    const std::size_t n = mesh_.points.size();
    is_corner_.assign(n, 0);
    list_features_at_vertices();
    for (std::uint32_t v = 0; v < n; ++v) is_corner_[v] = is_corner(v) ? 1 : 0;
  }

  void list_features_at_vertices() {
    std::vector<std::uint64_t>& offsets = features_at_.offsets;
    offsets.assign(mesh_.points.size() + 2, 0);
    for (const FeatureEdge& feature : features_)
      for (const std::uint32_t v : feature.ends) ++offsets[v + 2];
    for (std::size_t v = 2; v < offsets.size(); ++v) offsets[v] += offsets[v - 1];
    features_at_.values.resize(offsets.back());
    // Where row v begins stands at v + 1 until the row is filled, which moves it to the end.
    for (std::uint32_t e = 0; e < features_.size(); ++e)
      for (const std::uint32_t v : features_[e].ends) features_at_.values[offsets[v + 1]++] = e;
    offsets.pop_back();
  }

  [[nodiscard]] bool is_corner(std::uint32_t v) const {
    const auto at = features_at_[VertexId(v)];
    const auto& dimension = mesh_.vertex_carrier_dimension;
    if (!dimension.empty() && dimension[VertexId(v)] == 0) return true;
    if (at.empty()) return false;
    if (at.size() != 2) return true;
    const FeatureEdge &a = features_[at[0]], &b = features_[at[1]];
    if (a.marker != b.marker || a.sides != b.sides) return true;
    const std::uint32_t p = other_end(a, v), q = other_end(b, v);
    return distance_to_line(point(v), point(p), point(q)) > tolerance_ ||
           dot(point(p) - point(v), point(q) - point(v)) > 0;
  }

  static std::uint32_t other_end(const FeatureEdge& edge, std::uint32_t v) {
    return edge.ends[0] == v ? edge.ends[1] : edge.ends[0];
  }

  void walk_chains() {
    std::vector<std::uint8_t> used(features_.size(), 0);
    const auto walk = [&](std::uint32_t start, std::uint32_t first) {
      std::vector<VertexId> row = {VertexId(start)};
      std::uint32_t v = start, e = first;
      for (;;) {
        used[e] = 1;
        v = other_end(features_[e], v);
        row.push_back(VertexId(v));
        if (is_corner_[v] != 0 || v == start) break;
        const auto at = features_at_[VertexId(v)];
        e = at[0] == e ? at[1] : at[0];
      }
      if (v == start) {  // Closed without a corner: a polygon so fine that no angle shows.
        is_corner_[start] = 1;
        add_chain(row, 0, row.size() / 2, features_[first].marker);
        add_chain(row, row.size() / 2, row.size() - 1, features_[first].marker);
      } else {
        add_chain(row, 0, row.size() - 1, features_[first].marker);
      }
    };
    for (std::uint32_t v = 0; v < is_corner_.size(); ++v)
      if (is_corner_[v] != 0)
        for (const std::uint32_t e : features_at_[VertexId(v)])
          if (used[e] == 0) walk(v, e);
    for (std::uint32_t e = 0; e < features_.size(); ++e)
      if (used[e] == 0) walk(features_[e].ends[0], e);
  }

  /// Small angles add up: a row is cut at the vertex that is farthest from a straight line.
  void add_chain(const std::vector<VertexId>& row, std::size_t begin, std::size_t end, std::optional<int> marker) {
    is_corner_[row[begin].value()] = is_corner_[row[end].value()] = 1;
    std::size_t farthest = begin;
    double worst = tolerance_;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double d = distance_to_line(mesh_.points[row[i]], mesh_.points[row[begin]], mesh_.points[row[end]]);
      if (d > worst) worst = d, farthest = i;
    }
    if (farthest != begin) {
      add_chain(row, begin, farthest, marker);
      add_chain(row, farthest, end, marker);
      return;
    }
    result_.chains.push_back(
        {{row.begin() + static_cast<std::ptrdiff_t>(begin), row.begin() + static_cast<std::ptrdiff_t>(end) + 1},
         marker});
  }

  using FaceRegionsPair = typename FaceRegions<D>::Pair;
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  const Mesh<D>& mesh_;
  double tolerance_;
  FaceRegions<D> regions_;
  std::vector<EdgeFaces> edges_;      ///< 3D.
  std::vector<std::uint32_t> patch_;  ///< 3D: of each face.
  std::vector<FeatureEdge> features_;
  Csr<VertexId, std::uint32_t> features_at_;
  std::vector<std::uint8_t> is_corner_;  ///< By vertex.
  BoundaryComplex<D> result_;
};

}  // namespace

template <int D>
BoundaryComplex<D> find_boundary_complex(const Mesh<D>& mesh, const BoundaryZone<D>& zone, double tolerance) {
  return ComplexFinder<D>(mesh, zone, tolerance).run();
}

template BoundaryComplex<2> find_boundary_complex(const Mesh<2>&, const BoundaryZone<2>&, double);
template BoundaryComplex<3> find_boundary_complex(const Mesh<3>&, const BoundaryZone<3>&, double);

}  // namespace voropack
