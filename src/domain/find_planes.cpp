// The planes of facets, and points moved onto the planes that facets share.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "domain/attach.h"
#include "domain/complex.h"
#include "domain/flatten.h"
#include "domain/outline.h"
#include "domain/plane.h"
#include "domain/precision.h"
#include "domain/sheets.h"
#include "geom/tolerance.h"

namespace voropack::domain_impl {

namespace {

/// Each round frees the points where planes cannot be met from one of them; in the first ones, only the worst points:
/// others may fail because of them. In the last rounds it frees them from all planes. Few inputs need more than one.
constexpr int kMaxRounds = 12;
constexpr int kCarefulRounds = 6;
constexpr double kWorst = 0.25;

/// The points that are extreme in eight directions of the plane, and across the longest line between two of them: one
/// of them is nearly as far from any line as the farthest point.
std::vector<Index> extreme_points(const std::vector<Vec<3>>& points, const std::vector<Index>& candidates,
                                  const PlaneFrame& frame) {
  std::vector<Index> extremes;
  const auto add_extremes = [&](const Vec<2>& direction) {
    const auto along = [&](Index p) { return dot(frame.to_plane(points[p]), direction); };
    const auto [lo, hi] = std::ranges::minmax_element(candidates, {}, along);
    extremes.push_back(*lo);
    extremes.push_back(*hi);
    return frame.to_plane(points[*hi]) - frame.to_plane(points[*lo]);
  };
  Vec<2> longest;
  for (const Vec<2>& direction : {Vec<2>{1, 0}, Vec<2>{0, 1}, Vec<2>{1, 1}, Vec<2>{1, -1}}) {
    const Vec<2> line = add_extremes(direction);
    if (norm_sq(line) > norm_sq(longest)) longest = line;
  }
  add_extremes({-longest[1], longest[0]});
  std::sort(extremes.begin(), extremes.end());
  extremes.erase(std::unique(extremes.begin(), extremes.end()), extremes.end());
  return extremes;
}

/// Finds the largest polygon of a facet and the plane of its vector area; false if it has none.
bool measure(const Complex<3>& complex, WorkFacet& facet) {
  Vec<3> normal;
  const std::vector<Index>* largest = nullptr;
  for (const auto& polygon : facet.polygons) {
    const Vec<3> area = area_vector(complex.points, polygon);
    if (largest == nullptr || norm(area) > norm(normal)) {
      normal = area;
      largest = &polygon;
    }
  }
  Box<3> box;
  if (largest != nullptr)
    for (const Index p : *largest) box.add(complex.points[p]);
  if (largest == nullptr || norm(normal) <= 0.5 * complex.tolerance * box.diagonal()) return false;
  Vec<3> center;
  for (const Index p : *largest) center += complex.points[p] / static_cast<double>(largest->size());
  std::vector<Vec<3>> positions;
  for (const Index p : facet.points) positions.push_back(complex.points[p]);
  facet.frame = plane_frame(normal, center, positions);
  facet.extremes = extreme_points(complex.points, *largest, facet.frame);
  facet.area = norm(normal);
  return true;
}

/// Relative to the size of the domain; but more where the file shows that its coordinates were rounded more coarsely,
/// far from the origin, though not without limit.
double default_distance(const Complex<3>& complex) {
  const double diagonal = complex.box.diagonal();
  const double rounding = 2 * coordinate_unit(*complex.input);
  return std::max(kMergeDistance * diagonal, std::min(rounding, kMaxDefaultMergeDistance * diagonal));
}

class PlaneFinder {
 public:
  PlaneFinder(Complex<3>& complex, const DomainOptions& options, FaultList<3>& faults)
      : complex_(complex), options_(options), faults_(faults), names_(*complex.input), original_(complex.points) {
    limits_.distance =
        (options.merge_distance ? *options.merge_distance : default_distance(complex)) + complex.tolerance;
    limits_.sine = std::sin(options.merge_angle_deg * std::numbers::pi / 180) + kCoplanarAngle;
  }

  void run() {
    measure_facets();
    if (!faults_.empty()) return;
    for (Sheet& sheet : find_sheets(complex_, limits_, options_.merge_coplanar)) add_sheet(std::move(sheet));
    check_planarity();
    if (!faults_.empty()) return;
    if (std::any_of(sheets_.begin(), sheets_.end(), [&](const Sheet& s) { return is_noisy(s); })) {
      flatten();
      if (complex_.input->is_surface) join();
    }
    assign_planes();
    report();
    replace_facets();
  }

 private:
  [[nodiscard]] bool is_noisy(const Sheet& sheet) const { return sheet.deviation > kVisibleNoise * complex_.tolerance; }

  void measure_facets() {
    std::vector<WorkFacet> kept;
    for (WorkFacet& facet : complex_.facets) {
      if (measure(complex_, facet)) {
        kept.push_back(std::move(facet));
        continue;
      }
      // The neighbors of a triangle without area meet along its longest side.
      if (complex_.input->is_surface && facet.points.size() == 3) {
        note_thin(facet);
        continue;
      }
      const Vec<3> place = facet.points.empty() ? Vec<3>{} : complex_.points[facet.points.front()];
      faults_.add("zero_size_facet",
                  fmt::format("{} has no area (within the tolerance of {:.3g}) near {}", names_.facet(facet.input),
                              complex_.tolerance, place_text(place)),
                  "remove it, or correct its corners", place, complex_.input->facets[facet.input].line);
    }
    if (kept.empty() && faults_.empty())
      faults_.add("empty", fmt::format("no facet has any area (within the tolerance of {:.3g})", complex_.tolerance),
                  "give the boundary of at least one region");
    complex_.facets = std::move(kept);
  }

  void add_sheet(Sheet sheet) {
    for (const Index f : sheet.facets) complex_.facets[f].sheet = static_cast<Index>(sheets_.size());
    sheets_.push_back(std::move(sheet));
  }

  /// A facet that is alone in its sheet may be anything; in the others find_sheets has looked at all points.
  void check_planarity() {
    std::vector<const Sheet*> order(complex_.facets.size(), nullptr);
    for (const Sheet& sheet : sheets_)
      if (sheet.deviation > limits_.distance && sheet.facets.size() == 1) order[sheet.facets.front()] = &sheet;
    for (const Sheet* sheet : order)
      if (sheet != nullptr) refuse(*sheet);
  }

  void refuse(const Sheet& sheet) {
    const auto height = [&](Index p) { return std::abs(sheet.frame.height(complex_.points[p])); };
    const Index worst = *std::max_element(sheet.points.begin(), sheet.points.end(),
                                          [&](Index p, Index q) { return height(p) < height(q); });
    const Index input = complex_.facets[sheet.facets.front()].input;
    faults_.add("nonplanar_facet",
                fmt::format("{} is not planar: point {} at {} is {:.3g} away from its plane, more than {:.3g}",
                            names_.facet(input), names_.number(complex_.point_input[worst]),
                            place_text(complex_.points[worst]), height(worst), limits_.distance),
                "move its points into one plane, split it into triangles, or raise the merge distance",
                complex_.points[worst], complex_.input->facets[input].line);
  }

  /// Moves points until all sheets are planar. Where that is impossible, the smallest sheets are given up.
  void flatten() {
    const Attacher attacher(complex_);
    for (Sheet& sheet : sheets_) attach(sheet, attacher);
    for (int round = 0;; ++round) {
      std::vector<const Sheet*> constraints;
      std::vector<Index> index;
      for (Index s = 0; s < sheets_.size(); ++s)
        if (sheets_[s].points.size() > 3) {
          constraints.push_back(&sheets_[s]);
          index.push_back(s);
        }
      FlatPoints flat = flatten_sheets(original_, constraints, complex_.tolerance, limits_.distance,
                                       round < kCarefulRounds ? kWorst : 0);
      if (flat.failed.empty()) {
        complex_.points = std::move(flat.positions);
        return;
      }
      give_up(flat.failed, round < kMaxRounds, index, attacher);
    }
  }

  /// Frees each of the failed points from its smallest sheet, or from all.
  void give_up(const std::vector<Index>& failed, bool one, const std::vector<Index>& constraints,
               const Attacher& attacher) {
    std::vector<std::vector<Index>> at(complex_.points.size());
    for (const Index s : constraints)
      for (const Index p : sheets_[s].points) at[p].push_back(s);
    std::map<Index, std::vector<Index>> freed;
    const auto smaller = [&](Index s, Index t) { return sheets_[s].points.size() < sheets_[t].points.size(); };
    for (const Index p : failed)
      for (const Index s : one ? std::vector{*std::min_element(at[p].begin(), at[p].end(), smaller)} : at[p])
        freed[s].push_back(p);
    for (const auto& [s, points] : freed) shrink(s, points, attacher);
  }

  /// Takes the facets at some points (sorted) out of a sheet: on their own they may be planar. A facet that already is
  /// on its own is split into triangles, which always are.
  void shrink(Index s, const std::vector<Index>& points, const Attacher& attacher) {
    const Sheet sheet = std::move(sheets_[s]);
    sheets_[s] = Sheet{};
    const auto touches = [&](Index f) {
      const auto& own = complex_.facets[f].points;
      return std::any_of(own.begin(), own.end(),
                         [&](Index p) { return std::binary_search(points.begin(), points.end(), p); });
    };
    Sheet rest;
    std::vector<Index> removed;
    for (const Index f : sheet.facets) (touches(f) ? removed : rest.facets).push_back(f);
    if (rest.facets.size() > 1 || (rest.facets.size() == 1 && complex_.facets[rest.facets[0]].points.size() > 3)) {
      fit_sheet(complex_, rest);
      // Points that only touch the sheet are let go, if it is they that failed.
      if (!removed.empty()) attach(rest, attacher);
      sheets_[s] = std::move(rest);
    } else {
      removed.insert(removed.end(), rest.facets.begin(), rest.facets.end());
    }
    for (const Index f : removed) {
      complex_.facets[f].sheet.reset();
      if (complex_.facets[f].points.size() == 3) continue;
      if (sheet.facets.size() == 1) {
        split_.push_back(f);
        continue;
      }
      Sheet alone{{f}, {}, {}};
      fit_sheet(complex_, alone);
      attach(alone, attacher);
      add_sheet(std::move(alone));
    }
  }

  void join() {
    const EdgeCounts counts = count_edges(complex_);
    for (const Sheet& sheet : sheets_)
      if (is_noisy(sheet) && sheet.facets.size() > 1)
        join_outlines(complex_, sheet, counts, 4 * (sheet.deviation + complex_.tolerance));
  }

  /// Lets the points that a sheet touches move along with it, if the input has noise. In a surface, facets name the
  /// points that they touch, but for those that noise keeps off the side of a triangle.
  void attach(Sheet& sheet, const Attacher& attacher) const {
    if (complex_.input->is_surface && !is_noisy(sheet)) return;
    Sheet with = sheet;
    attacher.attach(with, complex_.input->is_surface ? sheet.deviation : limits_.distance);
    if (with.points.size() == sheet.points.size()) return;
    fit_points(original_, with);
    if (with.deviation <= limits_.distance) sheet = std::move(with);
  }

  void note_thin(const WorkFacet& facet) {
    if (n_thin_++ == 0) first_thin_ = facet.input;
  }

  /// Gives every facet the plane of its sheet, turned as the facet itself. Drops those that have no area any longer.
  void assign_planes() {
    std::vector<std::array<PlaneFrame, 2>> frames(sheets_.size());
    for (Index s = 0; s < sheets_.size(); ++s) {
      Sheet& sheet = sheets_[s];
      if (sheet.points.empty()) continue;
      fit_points(complex_.points, sheet);
      std::vector<Vec<3>> positions;
      for (const Index p : sheet.points) positions.push_back(complex_.points[p]);
      frames[s] = {sheet.frame, plane_frame(-sheet.frame.normal, sheet.frame.origin, positions)};
    }
    for (WorkFacet& facet : complex_.facets) {
      if (facet.points.empty()) continue;
      if (!measure(complex_, facet)) {
        note_thin(facet);
        facet.points.clear();
      } else if (facet.sheet) {
        const auto& [front, back] = frames[*facet.sheet];
        facet.frame = dot(facet.frame.normal, front.normal) < 0 ? back : front;
      }
    }
  }

  void replace_facets() {
    std::sort(split_.begin(), split_.end());
    std::vector<WorkFacet> facets;
    for (Index f = 0; f < complex_.facets.size(); ++f) {
      WorkFacet& facet = complex_.facets[f];
      if (facet.points.empty()) continue;
      if (std::binary_search(split_.begin(), split_.end(), f))
        append_triangles(facet, facets);
      else
        facets.push_back(std::move(facet));
    }
    complex_.facets = std::move(facets);
  }

  /// The triangles of a constrained Delaunay triangulation of the facet in its approximate plane.
  void append_triangles(const WorkFacet& facet, std::vector<WorkFacet>& facets) {
    PlanarProblem problem;
    problem.even_odd = complex_.input->is_surface;
    for (const Index p : facet.points) problem.points.push_back(facet.frame.to_plane(complex_.points[p]));
    for (const Vec<3>& hole : facet.holes) problem.holes.push_back(facet.frame.to_plane(hole));
    const auto local = [&](Index p) {
      return static_cast<Index>(std::lower_bound(facet.points.begin(), facet.points.end(), p) - facet.points.begin());
    };
    std::map<std::array<Index, 2>, PlanarEdge> edges;
    const auto edge = [&](Index p, Index q) -> PlanarEdge& {
      std::array<Index, 2> ends = {local(p), local(q)};
      if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
      PlanarEdge& found = edges[ends];
      found.ends = ends;
      return found;
    };
    for (const auto& corners : facet.polygons)
      for (std::size_t i = 0; i < corners.size(); ++i) ++edge(corners[i], corners[(i + 1) % corners.size()]).n_outline;
    for (const auto& [p, q] : facet.inner_edges) edge(p, q).inner = true;
    for (const auto& [ends, found] : edges) problem.edges.push_back(found);
    const PlanarTriangulation plane = triangulate_plane(problem);
    if (plane.triangles.empty()) {
      const Vec<3>& place = complex_.points[facet.points.front()];
      faults_.add("self_intersection",
                  fmt::format("polygons of {} meet each other near {}", names_.facet(facet.input), place_text(place)),
                  "let them meet in common points only", place, complex_.input->facets[facet.input].line);
    }
    for (const auto& triangle : plane.triangles) {
      WorkFacet part;
      part.input = facet.input;
      part.marker = facet.marker;
      for (const Index i : triangle) part.points.push_back(facet.points[i]);
      part.polygons.push_back(part.points);
      std::sort(part.points.begin(), part.points.end());
      const auto has = [&](Index p) { return std::binary_search(part.points.begin(), part.points.end(), p); };
      for (const auto& ends : facet.inner_edges)
        if (has(ends[0]) && has(ends[1])) part.inner_edges.push_back(ends);
      if (measure(complex_, part)) facets.push_back(std::move(part));
    }
  }

  void report() {
    if (n_thin_ > 0)
      complex_.warnings.push_back(
          fmt::format("dropped {} facets without area, the first is {}", n_thin_, names_.facet(first_thin_)));
    if (!split_.empty())
      complex_.warnings.push_back(
          fmt::format("split {} facets into triangles, since moving points by up to {:.3g} does not make them planar; "
                      "the first is {}",
                      split_.size(), limits_.distance,
                      names_.facet(complex_.facets[*std::min_element(split_.begin(), split_.end())].input)));
    PlaneMerge merge{limits_.distance, options_.merge_angle_deg};
    Index farthest = 0;
    for (Index p = 0; p < original_.size(); ++p) {
      const double moved = distance(original_[p], complex_.points[p]);
      if (moved == 0) continue;
      ++merge.n_moved;
      if (moved <= merge.largest_displacement) continue;
      merge.largest_displacement = moved;
      farthest = p;
    }
    if (merge.n_moved == 0) return;
    complex_.merge = merge;
    complex_.warnings.push_back(fmt::format(
        "moved {} points onto the planes of their facets, at most by {:.3g}: point {} at {} (allowed: {:.3g})",
        merge.n_moved, merge.largest_displacement, names_.number(complex_.point_input[farthest]),
        place_text(original_[farthest]), limits_.distance));
  }

  Complex<3>& complex_;
  const DomainOptions& options_;
  FaultList<3>& faults_;
  Names<3> names_;
  MergeLimits limits_;
  std::vector<Vec<3>> original_;
  std::vector<Sheet> sheets_;
  std::vector<Index> split_;
  std::size_t n_thin_ = 0;
  Index first_thin_ = kNone;
};

}  // namespace

void find_planes(Complex<3>& complex, const DomainOptions& options, FaultList<3>& faults) {
  PlaneFinder(complex, options, faults).run();
}

}  // namespace voropack::domain_impl
