// Check `conformity`, the part that compares the mesh with the domain: its points are vertices, its segments chains of
// edges, its facets tiled by boundary simplices, its regions on the right sides.
#include <algorithm>
#include <functional>

#include "base/place_text.h"
#include "certificate/conformity.h"
#include "geom/tolerance.h"

namespace voropack::judge {

namespace {

/// Areas of subfacets and facet may differ by this much, relative, besides the tolerance of positions.
constexpr double kAreaTolerance = 1e-10;

/// Part of the segment from a to b; with D = 2 a part of a wall.
struct ChainEdge {
  Edge vertices;
  std::uint32_t segment = 0;
  friend auto operator<=>(const ChainEdge&, const ChainEdge&) = default;
};

template <int D>
class DomainComparison {
 public:
  DomainComparison(const Subject<D>& subject, ConformityReport& report)
      : subject_(subject),
        domain_(*subject.domain),
        report_(report),
        tolerance_(absolute_tolerance(subject.domain->box, kOnTolerance)) {}

  double run() {
    if constexpr (D == 2)
      wall_markers_tell_ = markers_tell(subject_.mesh.boundary_marker, domain_.segment_marker);
    else
      wall_markers_tell_ = markers_tell(subject_.mesh.boundary_marker, domain_.facet_marker);
    find_points();
    for (const SegmentId s : ids(domain_.segments)) chain(s);
    std::sort(chain_.begin(), chain_.end());
    if constexpr (D == 2)
      compare_subsegments();
    else
      compare_segment_edges();
    if constexpr (D == 3) compare_facets();
    return worst_area_;
  }

 private:
  /// Programs that know no markers of their own write the same one everywhere: such markers are not compared.
  template <class Mine, class Theirs>
  [[nodiscard]] static bool markers_tell(const Mine& mesh_markers, const Theirs& domain_markers) {
    const auto varied = [](const auto& markers) {
      return std::adjacent_find(markers.begin(), markers.end(), std::not_equal_to<>()) != markers.end();
    };
    return varied(mesh_markers) || !varied(domain_markers);
  }

  [[nodiscard]] std::string point_text(PointId p) const {
    return "point " + std::to_string(p.value()) + " of the domain at " + place_text(domain_.points[p], domain_.box);
  }
  [[nodiscard]] std::string segment_text(std::uint32_t s) const {
    const auto& ends = domain_.segments[SegmentId(std::size_t{s})];
    return "segment " + std::to_string(s) + " of the domain from " + place_text(domain_.points[ends[0]], domain_.box) +
           " to " + place_text(domain_.points[ends[1]], domain_.box);
  }
  [[nodiscard]] std::string edge_text(const Edge& e) const {
    return "from " + subject_.vertex_text(e[0]) + " to " + subject_.vertex_text(e[1]);
  }

  /// The vertex at each point of the domain.
  void find_points() {
    const VertexTree<D>& vertices = subject_.vertices;
    for (const PointId p : ids(domain_.points)) {
      const Vec<D>& x = domain_.points[p];
      double nearest_sq = tolerance_ * tolerance_;
      std::uint32_t nearest = kNone;
      vertices.tree.visit([&](const Box<D>& box, double) { return box.distance_sq(x) <= nearest_sq; },
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t i = begin; i < end; ++i) {
                              const double gap_sq = distance_sq(vertices.point[i], x);
                              if (gap_sq > nearest_sq || !subject_.topology.used(vertices.id[i])) continue;
                              nearest_sq = gap_sq;
                              nearest = vertices.id[i];
                            }
                          });
      report_.tested();
      point_vertex_.push_back(nearest);
      if (nearest == kNone) report_.fault(kNotCovered, [&] { return point_text(p) + " is no vertex of the mesh"; });
    }
  }

  /// Does the segment from a to b come within `tolerance_` of the box? May err towards yes.
  [[nodiscard]] bool near_box(const Vec<D>& a, const Vec<D>& b, Box<D> box) const {
    box.inflate(2 * tolerance_);
    double enter = 0;
    double leave = 1;
    for (int k = 0; k < D; ++k) {
      const double step = b[k] - a[k];
      if (step == 0) {
        if (a[k] < box.lo[k] || a[k] > box.hi[k]) return false;
        continue;
      }
      const double s = (box.lo[k] - a[k]) / step;
      const double t = (box.hi[k] - a[k]) / step;
      enter = std::max(enter, std::min(s, t));
      leave = std::min(leave, std::max(s, t));
    }
    constexpr double kRoom = 1e-9;  // Of the parameter: rounding of the divisions.
    return enter <= leave + kRoom;
  }

  /// All vertices on segment s in their order; each pair of successors goes to `chain_`.
  void chain(SegmentId s) {
    const auto& ends = domain_.segments[s];
    const Vec<D>& a = domain_.points[ends[0]];
    const Vec<D>& b = domain_.points[ends[1]];
    const Vec<D> step = b - a;
    const double length_sq = norm_sq(step);
    std::vector<std::pair<double, std::uint32_t>> on;
    const VertexTree<D>& vertices = subject_.vertices;
    vertices.tree.visit([&](const Box<D>& box, double) { return near_box(a, b, box); },
                        [&](std::size_t begin, std::size_t end) {
                          for (std::size_t i = begin; i < end; ++i) {
                            const double t = std::clamp(dot(vertices.point[i] - a, step) / length_sq, 0.0, 1.0);
                            if (distance_sq(vertices.point[i], a + t * step) > tolerance_ * tolerance_) continue;
                            if (subject_.topology.used(vertices.id[i])) on.emplace_back(t, vertices.id[i]);
                          }
                        });
    std::sort(on.begin(), on.end());
    const std::uint32_t first = point_vertex_[ends[0].value()];
    const std::uint32_t last = point_vertex_[ends[1].value()];
    if (first == kNone || last == kNone) return;  // Reported by find_points.
    report_.tested();
    if (on.size() < 2 || on.front().second != first || on.back().second != last) {
      report_.fault(kNotCovered,
                    [&] { return segment_text(s.value()) + " does not begin and end at the vertices of its points"; });
      return;
    }
    for (std::size_t i = 1; i < on.size(); ++i)
      chain_.push_back({make_edge(on[i - 1].second, on[i].second), s.value()});
  }

  [[nodiscard]] const ChainEdge* find_chain(const Edge& edge) const {
    const auto at = std::lower_bound(chain_.begin(), chain_.end(), ChainEdge{edge, 0});
    return at != chain_.end() && at->vertices == edge ? &*at : nullptr;
  }

  void compare_subsegments() {
    std::vector<std::uint8_t> seen(chain_.size(), 0);
    const auto& boundary = subject_.topology.boundary();
    for (std::size_t b = 0; b < boundary.size(); ++b) {
      const BoundaryFace<D>& face = boundary[b];
      if (!face.valid || face.repeated) continue;
      const ChainEdge* part = find_chain(make_edge(face.vertices[0], face.vertices[1]));
      if (part == nullptr) {
        off_domain(b, " lies on no segment of the domain");
        continue;
      }
      seen[static_cast<std::size_t>(part - chain_.data())] = 1;
      const SegmentId s(std::size_t{part->segment});
      compare_marker(b, domain_.segment_marker[s]);
      const auto& ends = domain_.segments[s];
      const Vec<D> direction = domain_.points[ends[1]] - domain_.points[ends[0]];
      const Vec<D> here = subject_.point(face.vertices[1]) - subject_.point(face.vertices[0]);
      compare_regions(b, part->segment, dot(direction, here) > 0);
    }
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      if (seen[i] != 0) continue;
      report_.fault(kNotCovered, [&] {
        return segment_text(chain_[i].segment) + " is not covered " + edge_text(chain_[i].vertices);
      });
    }
  }

  void compare_segment_edges() {
    std::vector<Edge> edges;
    for (const ChainEdge& part : chain_) edges.push_back(part.vertices);
    const std::vector<std::uint8_t> found = find_mesh_edges(subject_, edges);
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      report_.tested();
      if (found[i] != 0) continue;
      report_.fault(kNotCovered, [&] {
        return segment_text(chain_[i].segment) + " is no union of edges of the mesh " + edge_text(chain_[i].vertices);
      });
    }
    const auto& listed = subject_.mesh.segment_edges;
    if (listed.empty()) return;
    std::vector<std::uint8_t> seen(chain_.size(), 0);
    const bool marked = subject_.mesh.segment_edge_marker.size() == listed.size() &&
                        markers_tell(subject_.mesh.segment_edge_marker, domain_.segment_marker);
    for (const EdgeId e : ids(listed)) {
      const Edge edge = make_edge(listed[e][0].value(), listed[e][1].value());
      const ChainEdge* part = find_chain(edge);
      if (part == nullptr) {
        report_.fault(kOffDomain, [&] {
          return "segment edge " + std::to_string(e.value()) + ' ' + edge_text(edge) +
                 " lies on no segment of the domain, or skips a vertex";
        });
        continue;
      }
      seen[static_cast<std::size_t>(part - chain_.data())] = 1;
      const int marker = domain_.segment_marker[SegmentId(std::size_t{part->segment})];
      if (marked && subject_.mesh.segment_edge_marker[e] != marker) {
        report_.fault(kWrongMarker, [&] {
          return "segment edge " + std::to_string(e.value()) + ' ' + edge_text(edge) + " has marker " +
                 std::to_string(subject_.mesh.segment_edge_marker[e]) + ", its segment " + std::to_string(marker);
        });
      }
    }
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      if (seen[i] != 0) continue;
      report_.fault(kUnlisted, [&] {
        return segment_text(chain_[i].segment) + " is not listed " + edge_text(chain_[i].vertices);
      });
    }
  }

  void off_domain(std::size_t b, const std::string& what) {
    report_.tested();
    report_.fault(kOffDomain, [&] { return subject_.boundary_text(static_cast<std::uint32_t>(b)) + what; });
  }

  void compare_marker(std::size_t b, int marker) {
    const BoundaryFace<D>& face = subject_.topology.boundary()[b];
    report_.tested();
    if (!face.listed || !wall_markers_tell_ || face.marker == marker) return;
    report_.fault(kWrongMarker, [&] {
      return subject_.boundary_text(static_cast<std::uint32_t>(b)) + " should have marker " + std::to_string(marker);
    });
  }

  /// `along`: the face's own vertex order has its positive side where the wall's side 0 is.
  void compare_regions(std::size_t b, std::uint32_t wall, bool along) {
    const BoundaryFace<D>& face = subject_.topology.boundary()[b];
    if (face.n_sides() == 0) return;  // Reported as no face of a simplex.
    std::array<std::uint32_t, 2> on_side{kNone, kNone};
    for (std::size_t k = 0; k < 2; ++k) {
      if (face.simplex[k] == kNone) continue;
      std::array<Vec<D>, D + 1> p;
      for (std::size_t i = 0; i < D; ++i) p[i] = subject_.point(face.vertices[i]);
      p[D] = subject_.mesh.points[subject_.mesh.simplex_vertices[SimplexId(face.simplex[k])][face.corner[k]]];
      const int sign = certain_orientation<D>(p).sign;
      if (sign != 0) on_side[(sign > 0) == along ? 0 : 1] = face.simplex[k];
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const RegionId expected = domain_.wall_regions[wall][side];
      const std::uint32_t s = on_side[side];
      const bool good = expected.is_none() == (s == kNone) &&
                        (s == kNone || subject_.topology.region(s) == domain_.region_id[expected]);
      if (good) continue;
      report_.fault(kWrongRegion, [&] {
        const std::string found =
            s == kNone ? "no simplex"
                       : "simplex " + std::to_string(s) + " of region " + std::to_string(subject_.topology.region(s));
        const std::string wanted =
            expected.is_none() ? "the outside" : "region " + std::to_string(domain_.region_id[expected]);
        return subject_.boundary_text(static_cast<std::uint32_t>(b)) + " has " + found + " where the domain has " +
               wanted;
      });
    }
  }

  void compare_facets();
  [[nodiscard]] std::uint32_t find_facet(const BoundaryFace<D>& face) const;
  void match_facet_edges(const std::vector<std::uint32_t>& facet_of);
  [[nodiscard]] std::string facet_text(std::uint32_t f) const {
    return "facet " + std::to_string(f) + " of the domain (marker " +
           std::to_string(domain_.facet_marker[FacetId(std::size_t{f})]) + ')';
  }

  const Subject<D>& subject_;
  const Domain<D>& domain_;
  ConformityReport& report_;
  double tolerance_;
  bool wall_markers_tell_ = true;
  double worst_area_ = -1;
  std::vector<std::uint32_t> point_vertex_;                                  ///< [n domain points]
  std::vector<ChainEdge> chain_;                                             ///< Sorted.
  BoxTree<D> triangle_tree_;                                                 ///< 3D: over the triangles of all facets.
  std::vector<std::pair<std::uint32_t, std::array<PointId, 3>>> triangles_;  ///< Facet and corners.
};

/// A facet that holds the whole face; of several (they differ by less than the tolerance) one of the same marker.
template <int D>
std::uint32_t DomainComparison<D>::find_facet(const BoundaryFace<D>& face) const {
  std::uint32_t best = kNone;
  if constexpr (D == 3) {
    Vec<3> center;
    for (const std::uint32_t v : face.vertices) center += subject_.point(v) / 3;
    const double reach_sq = 4 * tolerance_ * tolerance_;
    triangle_tree_.visit([&](const Box<3>& box, double) { return box.distance_sq(center) <= reach_sq; },
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i) {
                             const auto& [facet, corners] = triangles_[triangle_tree_.order()[i]];
                             const PlaneFrame& frame = domain_.facet_frame[FacetId(std::size_t{facet})];
                             bool flat = true;
                             for (const std::uint32_t v : face.vertices)
                               flat = flat && std::abs(frame.height(subject_.point(v))) <= tolerance_;
                             if (!flat) continue;
                             const Vec<2> x = frame.to_plane(center);
                             bool inside = true;
                             for (std::size_t k = 0; k < 3; ++k) {
                               const Vec<2> a = frame.to_plane(domain_.points[corners[k]]);
                               const Vec<2> b = frame.to_plane(domain_.points[corners[(k + 1) % 3]]);
                               inside = inside && cross(b - a, x - a) >= -tolerance_ * norm(b - a);
                             }
                             if (!inside) continue;
                             const bool same_marker = domain_.facet_marker[FacetId(std::size_t{facet})] == face.marker;
                             if (best == kNone || same_marker) best = facet;
                           }
                         });
  }
  return best;
}

template <int D>
void DomainComparison<D>::compare_facets() {
  if constexpr (D == 3) {
    std::vector<double> wanted(domain_.facet_frame.size(), 0), covered(wanted.size(), 0), border(wanted.size(), 0);
    for (const FacetId f : ids(domain_.facet_frame)) {
      for (const auto& corners : domain_.facet_triangles[f]) {
        triangles_.emplace_back(f.value(), corners);
        const Vec<3>& a = domain_.points[corners[0]];
        wanted[f.value()] += 0.5 * norm(cross(domain_.points[corners[1]] - a, domain_.points[corners[2]] - a));
      }
      for (const SegmentId s : domain_.facet_segments[f])
        border[f.value()] += distance(domain_.points[domain_.segments[s][0]], domain_.points[domain_.segments[s][1]]);
    }
    triangle_tree_ = BoxTree<3>(
        triangles_.size(),
        [&](std::size_t i) {
          Box<3> box;
          for (const PointId p : triangles_[i].second) box.add(domain_.points[p]);
          return box;
        },
        [](std::size_t) { return 0.0; });

    const auto& boundary = subject_.topology.boundary();
    std::vector<std::uint32_t> facet_of(boundary.size(), kNone);
    for (std::size_t b = 0; b < boundary.size(); ++b) {
      const BoundaryFace<3>& face = boundary[b];
      if (!face.valid || face.repeated) continue;
      const std::uint32_t f = facet_of[b] = find_facet(face);
      if (f == kNone) {
        off_domain(b, " lies on no facet of the domain");
        continue;
      }
      compare_marker(b, domain_.facet_marker[FacetId(std::size_t{f})]);
      const Vec<3>& a = subject_.point(face.vertices[0]);
      const Vec<3> normal = cross(subject_.point(face.vertices[1]) - a, subject_.point(face.vertices[2]) - a);
      covered[f] += 0.5 * norm(normal);
      compare_regions(b, f, dot(normal, domain_.facet_frame[FacetId(std::size_t{f})].normal) > 0);
    }
    for (std::size_t f = 0; f < wanted.size(); ++f) {
      report_.tested();
      const double off = std::abs(covered[f] - wanted[f]);
      worst_area_ = std::max(worst_area_, off / wanted[f]);
      // Vertices may be off the border by the tolerance of positions, which a longer border multiplies.
      const double position = std::max(subject_.topology.resolution(), 1e-4 * tolerance_);
      if (off <= kAreaTolerance * wanted[f] + position * border[f]) continue;
      report_.fault(kFacetArea, [&] {
        return facet_text(static_cast<std::uint32_t>(f)) + " has area " + number(wanted[f]) +
               ", its boundary simplices " + number(covered[f]);
      });
    }
    match_facet_edges(facet_of);
  }
}

/// Inside a facet, each edge of a boundary simplex belongs to two of them; elsewhere it is part of a segment.
template <int D>
void DomainComparison<D>::match_facet_edges(const std::vector<std::uint32_t>& facet_of) {
  if constexpr (D == 3) {
    std::vector<std::pair<std::uint32_t, Edge>> edges;
    for (std::size_t b = 0; b < facet_of.size(); ++b) {
      if (facet_of[b] == kNone) continue;
      const auto& v = subject_.topology.boundary()[b].vertices;
      for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(facet_of[b], make_edge(v[i], v[(i + 1) % 3]));
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t j = i + 1;
      while (j < edges.size() && edges[j] == edges[i]) ++j;
      const bool good = j - i == 2 || (j - i == 1 && find_chain(edges[i].second) != nullptr);
      if (!good)
        report_.fault(kUnmatchedEdge, [&] {
          return facet_text(edges[i].first) + " has " + std::to_string(j - i) + " boundary simplices at the edge " +
                 edge_text(edges[i].second);
        });
      i = j;
    }
  }
}

}  // namespace

template <int D>
double compare_with_domain(const Subject<D>& subject, ConformityReport& report) {
  return DomainComparison<D>(subject, report).run();
}

template double compare_with_domain(const Subject<2>&, ConformityReport&);
template double compare_with_domain(const Subject<3>&, ConformityReport&);

}  // namespace voropack::judge
