// Check `conformity`, the part that needs no domain: the boundary complex is complete and consistent.
#include <algorithm>
#include <map>

#include "base/parallel.h"
#include "certificate/conformity.h"
#include "geom/predicates.h"

namespace voropack::judge {

Check ConformityReport::finish(double worst_area, const std::string& otherwise) const {
  Check check;
  check.name = "conformity";
  check.tested = tested_;
  check.violations = violations_;
  check.ok = violations_ == 0;
  if (worst_area >= 0) check.worst = worst_area;
  check.where = violations_ > 0 ? where_ : tested_ > 0 ? otherwise : std::string();
  return check;
}

template <int D>
std::vector<std::uint8_t> find_mesh_edges(const Subject<D>& subject, const std::vector<Edge>& edges) {
  std::vector<std::uint8_t> wanted(subject.mesh.points.size(), 0);
  for (const Edge& edge : edges)
    for (const std::uint32_t v : edge) wanted[v] = 1;
  const auto& simplices = subject.mesh.simplex_vertices;
  const std::size_t n_blocks = (simplices.size() + kBlock - 1) / kBlock;
  std::vector<std::vector<std::uint32_t>> hits(n_blocks);
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        for (std::size_t s = block * kBlock; s < std::min(simplices.size(), (block + 1) * kBlock); ++s) {
          if (!subject.topology.valid(s)) continue;
          const auto& v = simplices[SimplexId(s)];
          for (std::size_t i = 0; i < D; ++i) {
            if (wanted[v[i].value()] == 0) continue;
            for (std::size_t j = i + 1; j <= D; ++j) {
              if (wanted[v[j].value()] == 0) continue;
              const Edge edge = make_edge(v[i].value(), v[j].value());
              const auto at = std::lower_bound(edges.begin(), edges.end(), edge);
              if (at != edges.end() && *at == edge)
                hits[block].push_back(static_cast<std::uint32_t>(at - edges.begin()));
            }
          }
        }
      },
      1);
  std::vector<std::uint8_t> found(edges.size(), 0);
  for (const auto& block : hits)
    for (const std::uint32_t e : block) found[e] = 1;
  return found;
}

namespace {

template <int D>
bool cuts(const Subject<D>& subject, const BoundaryFace<D>& face) {
  return face.n_sides() == 1 ||
         (face.n_sides() == 2 && subject.topology.region(face.simplex[0]) != subject.topology.region(face.simplex[1]));
}

template <int D>
std::string sides_text(const BoundaryFace<D>& face) {
  std::string text = ", face of simplex " + std::to_string(face.simplex[0]);
  if (face.simplex[1] != kNone) text += " and simplex " + std::to_string(face.simplex[1]);
  return text;
}

template <int D>
void check_faces(const Subject<D>& subject, ConformityReport& report) {
  const auto& boundary = subject.topology.boundary();
  const bool any_listed = !boundary.empty() && boundary.front().listed;
  if (!any_listed) return;
  for (std::size_t b = 0; b < boundary.size(); ++b) {
    const BoundaryFace<D>& face = boundary[b];
    const auto text = [&](const std::string& what) {
      return [&, what] { return subject.boundary_text(static_cast<std::uint32_t>(b)) + what; };
    };
    report.tested();
    if (!face.valid)
      report.fault(kBadList, text(" has a corner that is no vertex, or the same corner twice"));
    else if (face.repeated)
      report.fault(kBadList, text(" is listed twice"));
    else if (face.n_sides() == 0)
      report.fault(kNoFace, text(" is no face of a simplex"));
    else if (!face.listed)
      report.fault(kUnlisted, text(sides_text(face) + ", is not listed as boundary"));
  }
}

/// Boundary faces without marker in a mesh where others have one. Often that is meant so: no condition is given there.
/// But readers, which list hull faces and interfaces themselves, also leave such faces around a simplex that is
/// missing, or that has strayed into another region: all of its faces are without marker.
template <int D>
class UnmarkedFaces {
 public:
  UnmarkedFaces(const Subject<D>& subject, ConformityReport& report)
      : subject_(subject), boundary_(subject.topology.boundary()), report_(report) {
    for (std::uint32_t b = 0; b < boundary_.size(); ++b) {
      const BoundaryFace<D>& face = boundary_[b];
      if (!face.valid || face.repeated || !face.listed || face.marker != 0 || !cuts(subject, face)) continue;
      std::array<std::uint32_t, D> key = face.vertices;
      std::sort(key.begin(), key.end());
      faces_.emplace_back(key, b);
      for (const std::uint32_t apex : key) ridges_.push_back({without(key, apex), apex});
    }
    std::sort(faces_.begin(), faces_.end());
    std::sort(ridges_.begin(), ridges_.end());
  }

  void run() {
    if (std::ranges::none_of(boundary_, [](const BoundaryFace<D>& face) { return face.marker != 0; })) return;
    for (const auto& [key, b] : faces_) {
      const auto ridge = without(key, key[0]);
      for (auto at = std::lower_bound(ridges_.begin(), ridges_.end(), Ridge{ridge, 0});
           at != ridges_.end() && at->vertices == ridge; ++at)
        if (at->apex != key[0]) look_at(key, b, at->apex);
    }
  }

 private:
  using Key = std::array<std::uint32_t, D>;

  /// A face as one of its vertices and the others.
  struct Ridge {
    std::array<std::uint32_t, D - 1> vertices;
    std::uint32_t apex;
    friend auto operator<=>(const Ridge&, const Ridge&) = default;
  };

  static std::array<std::uint32_t, D - 1> without(const Key& key, std::uint32_t vertex) {
    std::array<std::uint32_t, D - 1> rest{};
    std::copy_if(key.begin(), key.end(), rest.begin(), [&](std::uint32_t v) { return v != vertex; });
    return rest;
  }

  /// The number of the unmarked face with these vertices, or kNone.
  [[nodiscard]] std::uint32_t find(Key key) const {
    std::sort(key.begin(), key.end());
    const auto at = std::lower_bound(faces_.begin(), faces_.end(), std::pair(key, 0U));
    return at != faces_.end() && at->first == key ? at->second : kNone;
  }

  /// Whether face b is one of the D + 1 of the simplex between it and `apex`, all of them unmarked.
  void look_at(const Key& key, std::uint32_t b, std::uint32_t apex) {
    const BoundaryFace<D>& face = boundary_[b];
    for (std::size_t i = 0; i < D; ++i) {
      Key other = key;
      other[i] = apex;
      const std::uint32_t found = find(other);
      if (found == kNone || boundary_[found].n_sides() != face.n_sides()) return;
    }
    const auto text = [&](const char* what) {
      return [this, b, what] { return subject_.boundary_text(b) + sides_text(boundary_[b]) + what; };
    };
    if (face.n_sides() == 1 ? is_void(face, apex) : is_stray(face, apex))
      report_.fault(kUnlisted,
                    text(face.n_sides() == 1
                             ? ", belongs to no facet: only faces without marker surround a missing simplex"
                             : ", belongs to no facet: only faces without marker part a simplex from its region"));
  }

  /// Whether the only simplex of the face is on the other side of it than `apex`.
  [[nodiscard]] bool is_void(const BoundaryFace<D>& face, std::uint32_t apex) const {
    auto corners = subject_.topology.corners(face.simplex[0]);
    const int own = side(corners);
    corners[face.corner[0]] = subject_.point(apex);
    return side(corners) == -own;
  }

  /// Whether the simplex of the face and `apex` is there, and its region is elsewhere, too.
  [[nodiscard]] bool is_stray(const BoundaryFace<D>& face, std::uint32_t apex) {
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& corners = subject_.mesh.simplex_vertices[SimplexId(face.simplex[k])];
      if (corners[face.corner[k]].value() != apex) continue;
      if (region_size(subject_.topology.region(face.simplex[k])) > 1) return true;
    }
    return false;
  }

  /// Counted when first asked for: few meshes have a face for which it matters.
  [[nodiscard]] std::size_t region_size(int region) {
    if (region_size_.empty())
      for (std::size_t s = 0; s < subject_.mesh.simplex_vertices.size(); ++s)
        ++region_size_[subject_.topology.region(s)];
    return region_size_.at(region);
  }

  [[nodiscard]] static int side(const std::array<Vec<D>, D + 1>& x) {
    if constexpr (D == 2)
      return orientation(x[0], x[1], x[2]);
    else
      return orientation(x[0], x[1], x[2], x[3]);
  }

  const Subject<D>& subject_;
  const std::vector<BoundaryFace<D>>& boundary_;
  ConformityReport& report_;
  std::vector<std::pair<Key, std::uint32_t>> faces_;  ///< Vertices and number of each, sorted.
  std::vector<Ridge> ridges_;                         ///< Sorted.
  std::map<int, std::size_t> region_size_;            ///< Simplices of each region.
};

/// A vertex inside a facet (in the plane: inside a segment) has boundary faces of one marker around it, a vertex inside
/// a region has none.
template <int D>
void check_carriers(const Subject<D>& subject, ConformityReport& report) {
  const auto& carrier = subject.mesh.vertex_carrier_dimension;
  if (carrier.size() != subject.mesh.points.size()) return;
  std::vector<std::uint32_t> first_face(carrier.size(), kNone);
  const auto& boundary = subject.topology.boundary();
  for (std::size_t b = 0; b < boundary.size(); ++b) {
    if (!boundary[b].valid || !boundary[b].listed) continue;
    for (const std::uint32_t v : boundary[b].vertices) {
      const auto text = [&](const char* what) {
        return
            [&, what] { return subject.boundary_text(static_cast<std::uint32_t>(b)) + what + subject.vertex_text(v); };
      };
      const int dimension = carrier[VertexId(v)];
      if (dimension == D) report.fault(kOffDomain, text(" has a corner that claims to lie inside a region: "));
      if (dimension != D - 1) continue;
      if (first_face[v] == kNone) first_face[v] = static_cast<std::uint32_t>(b);
      if (boundary[first_face[v]].marker != boundary[b].marker)
        report.fault(kWrongMarker, text(" has another marker than its neighbors around "));
    }
  }
}

template <int D>
std::string edge_text(const Subject<D>& subject, const Edge& edge) {
  return "the edge from " + subject.vertex_text(edge[0]) + " to " + subject.vertex_text(edge[1]);
}

/// The edges of segments are edges of the mesh, and facets end or change their marker only there.
void check_segment_edges(const Subject<3>& subject, ConformityReport& report) {
  std::vector<Edge> edges;
  for (const auto& edge : subject.mesh.segment_edges) {
    bool good = edge[0] != edge[1];
    for (const VertexId v : edge)
      good = good && !v.is_none() && v.value() < subject.mesh.points.size() && subject.topology.finite(v.value());
    if (good)
      edges.push_back(make_edge(edge[0].value(), edge[1].value()));
    else
      report.fault(kBadList, [&] { return std::string("a segment edge names no two vertices"); });
  }
  if (edges.empty()) return;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const std::vector<std::uint8_t> found = find_mesh_edges(subject, edges);
  report.tested(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (found[e] == 0)
      report.fault(kNoFace, [&] { return edge_text(subject, edges[e]) + " of a segment is no edge of a simplex"; });

  std::vector<std::pair<Edge, int>> borders;
  for (const BoundaryFace<3>& face : subject.topology.boundary()) {
    if (!face.valid || face.repeated || !face.listed) continue;
    for (std::size_t i = 0; i < 3; ++i)
      borders.emplace_back(make_edge(face.vertices[i], face.vertices[(i + 1) % 3]), face.marker);
  }
  std::sort(borders.begin(), borders.end());
  for (std::size_t i = 0; i < borders.size();) {
    std::size_t j = i + 1;
    while (j < borders.size() && borders[j].first == borders[i].first) ++j;
    const Edge& edge = borders[i].first;
    const bool smooth = j - i == 2 && borders[i].second == borders[i + 1].second;
    report.tested();
    if (!smooth && !std::binary_search(edges.begin(), edges.end(), edge)) {
      const bool ends = j - i == 1;
      report.fault(ends ? kUnmatchedEdge : kWrongMarker, [&] {
        return edge_text(subject, edge) + " is on no segment, but " +
               (ends ? "a facet ends there"
                     : "facets meet or change their marker there, marker " + std::to_string(borders[i].second) +
                           " and " + std::to_string(borders[j - 1].second));
      });
    }
    i = j;
  }
}

}  // namespace

template <int D>
Check check_conformity(const Subject<D>& subject, const Duplicates& duplicates) {
  ConformityReport report;
  check_faces(subject, report);
  UnmarkedFaces<D>(subject, report).run();
  check_carriers(subject, report);
  if constexpr (D == 3) check_segment_edges(subject, report);
  if (duplicates.tally.violations > 0) {
    report.fault(
        kDuplicateVertex,
        [&] {
          const auto& ids = duplicates.tally.worst.ids;
          return subject.vertex_text(std::min(ids[0], ids[1])) + " and " +
                 subject.vertex_text(std::max(ids[0], ids[1])) +
                 " are at the same place: simplices on both sides are glued by coordinates only";
        },
        duplicates.tally.violations);
  }
  double worst_area = -1;
  if (subject.domain != nullptr) worst_area = compare_with_domain(subject, report);
  return report.finish(worst_area, subject.domain != nullptr ? "every polytope of the domain is a union of simplices"
                                                             : "every boundary and interface face is listed");
}

template std::vector<std::uint8_t> find_mesh_edges(const Subject<2>&, const std::vector<Edge>&);
template std::vector<std::uint8_t> find_mesh_edges(const Subject<3>&, const std::vector<Edge>&);
template Check check_conformity(const Subject<2>&, const Duplicates&);
template Check check_conformity(const Subject<3>&, const Duplicates&);

}  // namespace voropack::judge
