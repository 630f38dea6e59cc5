// Closes facets under intersection: finds the points and segments in each, cuts it along them and triangulates it.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "domain/complex.h"
#include "domain/plane.h"
#include "geom/aabb_tree.h"
#include "geom/predicates.h"

namespace voropack::domain_impl {

namespace {

class Cutter {
 public:
  Cutter(Complex<3>& complex, FaultList<3>& faults)
      : complex_(complex), faults_(faults), names_(*complex.input), point_segments_(complex.points.size()) {
    std::vector<Box<3>> boxes;
    for (const Vec<3>& x : complex.points) boxes.emplace_back(x, x);
    points_tree_ = AabbTree<3>(std::move(boxes));
    for (Index s = 0; s < complex.segments.size(); ++s)
      for (const Index p : complex.segments[s].ends) point_segments_[p].push_back(s);
  }

  void run() {
    facet_points_.resize(complex_.facets.size());
    for (Index f = 0; f < complex_.facets.size() && !faults_.full(); ++f) cut(f);
    if (!faults_.empty()) return;
    find_overlaps();
    find_piercings();
  }

 private:
  /// Points in the facet's plane that may be in the facet, sorted.
  [[nodiscard]] std::vector<Index> candidates(const WorkFacet& facet) const {
    std::vector<Index> found = facet.points;
    for (const auto* parents : {&facet.outline, &facet.inner})
      for (const Index parent : *parents)
        for (const Index s : complex_.parent_segments[parent])
          found.insert(found.end(), complex_.segments[s].ends.begin(), complex_.segments[s].ends.end());
    Box<3> box;
    for (const Index p : facet.points) box.add(complex_.points[p]);
    box.inflate(complex_.tolerance);
    points_tree_.visit_overlaps(box, [&](Index p) {
      if (std::abs(facet.frame.height(complex_.points[p])) <= complex_.tolerance) found.push_back(p);
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  static Index local(const std::vector<Index>& found, Index p) {
    const auto it = std::lower_bound(found.begin(), found.end(), p);
    return it != found.end() && *it == p ? static_cast<Index>(it - found.begin()) : kNone;
  }

  /// The facet in its plane, and the segment behind each edge of the problem.
  PlanarProblem problem_of(const WorkFacet& facet, const std::vector<Index>& found,
                           std::vector<Index>& edge_segment) const {
    PlanarProblem problem;
    problem.even_odd = complex_.input->is_surface;
    for (const Index p : found) problem.points.push_back(facet.frame.to_plane(complex_.points[p]));
    for (const Vec<3>& hole : facet.holes) problem.holes.push_back(facet.frame.to_plane(hole));
    std::map<Index, PlanarEdge> edges;  // By segment.
    for (const Index p : found)
      for (const Index s : point_segments_[p]) {
        const Index a = local(found, complex_.segments[s].ends[0]), b = local(found, complex_.segments[s].ends[1]);
        if (a != kNone && b != kNone) edges[s].ends = {a, b};
      }
    for (const Index parent : facet.outline)
      for (const Index s : complex_.parent_segments[parent]) ++edges[s].n_outline;
    for (const Index parent : facet.inner)
      for (const Index s : complex_.parent_segments[parent]) edges[s].inner = true;
    for (const auto& [s, edge] : edges) {
      edge_segment.push_back(s);
      problem.edges.push_back(edge);
    }
    return problem;
  }

  void cut(Index f) {
    const WorkFacet& facet = complex_.facets[f];
    const std::vector<Index> found = candidates(facet);
    std::vector<Index> edge_segment;
    const PlanarProblem problem = problem_of(facet, found, edge_segment);
    const PlanarTriangulation plane = triangulate_plane(problem);
    const auto line = complex_.input->facets[facet.input].line;
    for (const auto& conflict : plane.conflicts) {
      const Index s = edge_segment[conflict.edge];
      const Vec<3> place =
          0.5 * (complex_.points[complex_.segments[s].ends[0]] + complex_.points[complex_.segments[s].ends[1]]);
      faults_.add("self_intersection",
                  fmt::format("in the plane of {}, {} meets another segment or point within the tolerance of {:.3g} "
                              "near {}",
                              names_.facet(facet.input), complex_.parent_name(complex_.segments[s].parent),
                              complex_.tolerance, place_text(place)),
                  "let them meet in common points, or move them apart", place, line);
    }
    if (!plane.conflicts.empty()) return;
    if (plane.triangles.empty()) {
      const Vec<3> place = complex_.points[facet.points.front()];
      faults_.add("zero_size_facet", fmt::format("nothing is left of {} without its holes", names_.facet(facet.input)),
                  "remove the facet, or correct its hole seeds and polygons", place, line);
      return;
    }
    const auto first = static_cast<Index>(complex_.pieces.size());
    complex_.pieces.resize(complex_.pieces.size() + plane.n_pieces, Piece{f, 0});
    for (std::size_t t = 0; t < plane.triangles.size(); ++t) {
      const auto [a, b, c] = plane.triangles[t];
      const Index piece = first + plane.triangle_piece[t];
      complex_.pieces[piece].area +=
          0.5 * cross(problem.points[b] - problem.points[a], problem.points[c] - problem.points[a]);
      complex_.triangles.push_back({found[a], found[b], found[c]});
      complex_.triangle_piece.push_back(piece);
      facet_points_[f].insert(facet_points_[f].end(), {found[a], found[b], found[c]});
    }
    auto& closure = facet_points_[f];
    std::sort(closure.begin(), closure.end());
    closure.erase(std::unique(closure.begin(), closure.end()), closure.end());
  }

  /// Closed under intersection, two overlapping facets have a piece in common, which the same segments bound.
  void find_overlaps() {
    std::vector<std::vector<Index>> bounds(complex_.pieces.size());
    for (std::size_t t = 0; t < complex_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& corners = complex_.triangles[t];
        const Index s = complex_.find_segment(corners[i], corners[(i + 1) % 3]);
        if (s != kNone) bounds[complex_.triangle_piece[t]].push_back(s);
      }
    std::map<std::vector<Index>, Index> piece_of_bounds;
    for (Index piece = 0; piece < bounds.size(); ++piece) {
      std::sort(bounds[piece].begin(), bounds[piece].end());
      const auto [it, added] = piece_of_bounds.try_emplace(bounds[piece], piece);
      if (added) continue;
      const WorkFacet& first = complex_.facets[complex_.pieces[it->second].facet];
      const WorkFacet& second = complex_.facets[complex_.pieces[piece].facet];
      Vec<3> place;
      for (const Index s : bounds[piece])
        place += 0.5 * (complex_.points[complex_.segments[s].ends[0]] + complex_.points[complex_.segments[s].ends[1]]);
      place = place / static_cast<double>(bounds[piece].size());
      faults_.add("self_intersection",
                  fmt::format("{} and {} overlap near {}", names_.facet(first.input), names_.facet(second.input),
                              place_text(place)),
                  "remove one of them, or the part that they have in common", place,
                  complex_.input->facets[second.input].line);
    }
  }

  [[nodiscard]] bool in_facet(Index f, Index p) const {
    return std::binary_search(facet_points_[f].begin(), facet_points_[f].end(), p);
  }

  void find_piercings() {
    const auto& points = complex_.points;
    std::vector<Box<3>> boxes(complex_.triangles.size());
    for (std::size_t t = 0; t < boxes.size(); ++t)
      for (const Index p : complex_.triangles[t]) boxes[t].add(points[p]);
    const AabbTree<3> tree(std::move(boxes));
    std::map<std::pair<Index, Index>, bool> reported;
    for (Index s = 0; s < complex_.segments.size() && !faults_.full(); ++s) {
      const auto [a, b] = complex_.segments[s].ends;
      Box<3> box;
      box.add(points[a]);
      box.add(points[b]);
      tree.visit_overlaps(box, [&](Index t) {
        const Index f = complex_.pieces[complex_.triangle_piece[t]].facet;
        if (in_facet(f, a) || in_facet(f, b) || !pierces(a, b, complex_.triangles[t])) return;
        if (!reported.try_emplace({complex_.segments[s].parent, f}, true).second) return;
        const PlaneFrame& frame = complex_.facets[f].frame;
        const double ha = frame.height(points[a]), hb = frame.height(points[b]);
        const Vec<3> place = points[a] + (ha != hb ? ha / (ha - hb) : 0.5) * (points[b] - points[a]);
        faults_.add("self_intersection",
                    fmt::format("{} passes through {} at {}", complex_.parent_name(complex_.segments[s].parent),
                                names_.facet(complex_.facets[f].input), place_text(place)),
                    "let them meet in common points and segments, or move one of them", place,
                    complex_.parent_line(complex_.segments[s].parent));
      });
    }
  }

  [[nodiscard]] bool pierces(Index a, Index b, const std::array<Index, 3>& t) const {
    const auto& x = complex_.points;
    const Vec<3>&p = x[t[0]], &q = x[t[1]], &r = x[t[2]];
    if (orientation(p, q, r, x[a]) * orientation(p, q, r, x[b]) > 0) return false;
    const int e0 = orientation(x[a], x[b], p, q), e1 = orientation(x[a], x[b], q, r),
              e2 = orientation(x[a], x[b], r, p);
    if (e0 == 0 && e1 == 0 && e2 == 0) return false;  // In its plane: then edges cross, or nothing does.
    return (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0);
  }

  Complex<3>& complex_;
  FaultList<3>& faults_;
  Names<3> names_;
  AabbTree<3> points_tree_;
  std::vector<std::vector<Index>> point_segments_;
  std::vector<std::vector<Index>> facet_points_;
};

}  // namespace

void cut_facets(Complex<3>& complex, FaultList<3>& faults) { Cutter(complex, faults).run(); }

}  // namespace voropack::domain_impl
