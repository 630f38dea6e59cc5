// The invariants of a Domain, checked in the most obvious way. Shares no code with build_domain beyond predicates.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "geom/predicates.h"
#include "geom/tolerance.h"
#include "voropack/domain.h"

namespace voropack {

namespace {

template <int D>
class Checker {
 public:
  explicit Checker(const Domain<D>& d)
      : d_(d),
        near_(absolute_tolerance(d.box, kOnTolerance) / 4),  // Joining segments in line may halve a distance.
        flat_(2 * absolute_tolerance(d.box, kOnTolerance)) {}

  std::string run() {
    check_sizes();
    if (fault_.empty()) check_points_and_segments();
    if constexpr (D == 3)
      for (std::size_t f = 0; f < d_.facet_frame.size() && fault_.empty(); ++f) check_facet(FacetId(f));
    if (fault_.empty()) check_regions();
    if (fault_.empty()) check_ridges();
    if (fault_.empty()) check_measures();
    return fault_;
  }

 private:
  template <class... Words>
  bool expect(bool holds, fmt::format_string<Words...> words, Words&&... values) {
    if (!holds && fault_.empty()) fault_ = fmt::format(words, std::forward<Words>(values)...);
    return holds;
  }

  void check_sizes() {
    const std::size_t n = d_.points.size(), m = d_.segments.size(), k = d_.facet_frame.size(), r = d_.region_id.size();
    expect(d_.point_marker.size() == n && d_.point_region.size() == n, "arrays of points differ in length");
    expect(d_.segment_marker.size() == m && d_.segment_region.size() == m, "arrays of segments differ in length");
    expect(d_.facet_marker.size() == k && d_.facet_segments.size() == k && d_.facet_points.size() == k &&
               d_.facet_triangles.size() == k && (D == 3 || k == 0),
           "arrays of facets differ in length");
    expect(d_.wall_regions.size() == (D == 2 ? m : k), "there are {} walls", d_.wall_regions.size());
    expect(d_.region_measure.size() == r && d_.region_max_simplex.size() == r, "arrays of regions differ in length");
    for (const auto& s : d_.segments)
      expect(s[0] != s[1] && s[0].value() < n && s[1].value() < n, "a segment has ends {} and {}", s[0].value(),
             s[1].value());
    for (const SegmentId s : d_.facet_segments.values) expect(s.value() < m, "a facet lists segment {}", s.value());
    for (const PointId p : d_.facet_points.values) expect(p.value() < n, "a facet lists point {}", p.value());
    for (const auto& sides : d_.wall_regions)
      for (const RegionId side : sides)
        expect(side.is_none() || side.value() < r, "a wall has region {}", side.value());
    for (const RegionId x : d_.point_region) expect(x.is_none() || x.value() < r, "a point has region {}", x.value());
    for (const RegionId x : d_.segment_region)
      expect(x.is_none() || x.value() < r, "a segment has region {}", x.value());
  }

  // Invariant 1.
  void check_points_and_segments() {
    for (const PointId p : ids(d_.points)) {
      expect(is_finite(d_.points[p]) && d_.box.contains(d_.points[p]), "point {} is outside of the box", p.value());
      for (const PointId q : ids(d_.points))
        expect(q <= p || d_.points[p] != d_.points[q], "points {} and {} are equal", p.value(), q.value());
      for (const SegmentId s : ids(d_.segments)) {
        const auto& [a, b] = d_.segments[s];
        expect(p == a || p == b || distance_to_segment(d_.points[p], d_.points[a], d_.points[b]) > near_,
               "point {} lies inside segment {}", p.value(), s.value());
      }
    }
    for (const SegmentId s : ids(d_.segments))
      for (const SegmentId t : ids(d_.segments)) {
        if (t <= s) continue;
        const auto& [a, b] = d_.segments[s];
        const auto& [c, d] = d_.segments[t];
        const int common = (a == c || a == d) + (b == c || b == d);
        expect(common < 2, "segments {} and {} are equal", s.value(), t.value());
        expect(common > 0 || nearest_points(d_.points[a], d_.points[b], d_.points[c], d_.points[d]).length() > near_,
               "segments {} and {} cross", s.value(), t.value());
      }
  }

  [[nodiscard]] bool lists(FacetId f, PointId p) const {
    return std::binary_search(d_.facet_points[f].begin(), d_.facet_points[f].end(), p);
  }
  [[nodiscard]] bool lists(FacetId f, SegmentId s) const {
    return std::binary_search(d_.facet_segments[f].begin(), d_.facet_segments[f].end(), s);
  }
  [[nodiscard]] double distance_to(FacetId f, const Vec<D>& x) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : d_.facet_triangles[f])
      nearest = std::min(nearest, distance_to_triangle(x, d_.points[a], d_.points[b], d_.points[c]));
    return nearest;
  }

  // Invariants 2 and 3.
  void check_facet(FacetId f) {
    if constexpr (D == 3) {
      const PlaneFrame& frame = d_.facet_frame[f];
      const auto points = d_.facet_points[f];
      const auto segments = d_.facet_segments[f];
      expect(std::is_sorted(points.begin(), points.end()) && std::is_sorted(segments.begin(), segments.end()),
             "lists of facet {} are not sorted", f.value());
      const Vec<3> across = cross(frame.u, frame.v) - frame.normal;
      expect(norm(across) < kFrameSlack && std::abs(norm(frame.normal) - 1) < kFrameSlack &&
                 std::abs(norm(frame.u) - 1) < kFrameSlack && std::abs(dot(frame.u, frame.v)) < kFrameSlack,
             "the frame of facet {} is not orthonormal", f.value());
      for (const PointId p : points)
        expect(std::abs(frame.height(d_.points[p])) <= flat_, "point {} is off facet {}", p.value(), f.value());
      check_triangles(f);
      for (const PointId p : ids(d_.points))
        expect(lists(f, p) || distance_to(f, d_.points[p]) > near_, "facet {} does not list point {} in it", f.value(),
               p.value());
      for (const SegmentId s : ids(d_.segments)) check_segment_and(f, s);
      for (const FacetId g : ids<FacetId>(d_.facet_frame.size()))
        for (const auto& [a, b, c] : d_.facet_triangles[g]) {
          if (g == f) break;
          const Vec<3> middle = (d_.points[a] + d_.points[b] + d_.points[c]) / 3;
          const double height =
              2 * norm(cross(d_.points[b] - d_.points[a], d_.points[c] - d_.points[a])) / d_.diameter();
          // The middle of a thin triangle is near to its sides, which the facets may share.
          expect(height < 100 * flat_ || distance_to(f, middle) > near_, "facets {} and {} overlap", f.value(),
                 g.value());
        }
    }
  }

  void check_triangles(FacetId f) {
    std::map<std::pair<PointId, PointId>, int> n_triangles;
    std::map<PointId, int> used;
    for (const auto& t : d_.facet_triangles[f]) {
      const PlaneFrame& frame = d_.facet_frame[f];
      std::array<Vec<2>, 3> x;
      for (std::size_t i = 0; i < 3; ++i) {
        expect(lists(f, t[i]), "a triangle of facet {} has corner {}", f.value(), t[i].value());
        ++n_triangles[std::minmax(t[i], t[(i + 1) % 3])];
        ++used[t[i]];
        if constexpr (D == 3) x[i] = frame.to_plane(d_.points[t[i]]);
      }
      expect(orientation(x[0], x[1], x[2]) > 0, "a triangle of facet {} is not positively oriented", f.value());
    }
    expect(used.size() == d_.facet_points[f].size(), "the triangles of facet {} miss a point", f.value());
    std::map<std::pair<PointId, PointId>, SegmentId> listed;
    for (const SegmentId s : d_.facet_segments[f]) {
      const auto ends = std::minmax(d_.segments[s][0], d_.segments[s][1]);
      listed[ends] = s;
      expect(n_triangles.count(ends) > 0, "segment {} is no edge of the triangles of facet {}", s.value(), f.value());
    }
    for (const auto& [ends, n] : n_triangles)
      expect(n == 2 || (n == 1 && listed.count(ends) > 0), "the edge {}, {} of facet {} belongs to {} triangles",
             ends.first.value(), ends.second.value(), f.value(), n);
  }

  void check_segment_and(FacetId f, SegmentId s) {
    if constexpr (D == 3) {
      if (lists(f, s)) return;
      const auto& [a, b] = d_.segments[s];
      const Vec<3>&xa = d_.points[a], &xb = d_.points[b];
      const bool touches = lists(f, a) || lists(f, b);
      expect(!(lists(f, a) && lists(f, b)) || distance_to(f, 0.5 * (xa + xb)) > near_,
             "facet {} does not list segment {} in it", f.value(), s.value());
      if (touches) return;
      for (const auto& [p, q, r] : d_.facet_triangles[f]) {
        const Vec<3>&x = d_.points[p], &y = d_.points[q], &z = d_.points[r];
        const int side_a = orientation(x, y, z, xa), side_b = orientation(x, y, z, xb);
        const int e0 = orientation(xa, xb, x, y), e1 = orientation(xa, xb, y, z), e2 = orientation(xa, xb, z, x);
        const bool through = (e0 > 0 && e1 > 0 && e2 > 0) || (e0 < 0 && e1 < 0 && e2 < 0);
        expect(side_a * side_b > 0 || !through, "segment {} passes through facet {}", s.value(), f.value());
      }
    }
  }

  // Invariant 4.
  void check_regions() {
    std::vector<char> on_wall(d_.points.size(), 0), segment_on_wall(d_.segments.size(), D == 2 ? 1 : 0);
    if constexpr (D == 2)
      for (const auto& s : d_.segments)
        for (const PointId p : s) on_wall[p.value()] = 1;
    for (const PointId p : d_.facet_points.values) on_wall[p.value()] = 1;
    for (const SegmentId s : d_.facet_segments.values) segment_on_wall[s.value()] = 1;
    for (std::size_t w = 0; w < d_.n_walls(); ++w)
      expect(!d_.wall_regions[w][0].is_none() || !d_.wall_regions[w][1].is_none(), "wall {} bounds no region", w);
    for (const PointId p : ids(d_.points))
      expect(d_.point_region[p].is_none() == (on_wall[p.value()] != 0), "point {} is {} a wall, but has {} region",
             p.value(), on_wall[p.value()] != 0 ? "on" : "off", d_.point_region[p].is_none() ? "no" : "a");
    for (const SegmentId s : ids(d_.segments))
      expect(d_.segment_region[s].is_none() == (segment_on_wall[s.value()] != 0),
             "segment {} is {} a wall, but has {} region", s.value(), segment_on_wall[s.value()] != 0 ? "on" : "off",
             d_.segment_region[s].is_none() ? "no" : "a");
  }

  struct Side {
    double angle;
    RegionId clockwise, counterclockwise;
  };

  // Between neighbors around a ridge there is one region.
  void check_ridges() {
    std::map<std::uint32_t, std::vector<Side>> around;
    if constexpr (D == 2) {
      for (const SegmentId s : ids(d_.segments))
        for (std::size_t end = 0; end < 2; ++end) {
          const PointId p = d_.segments[s][end];
          const Vec<2> x = d_.points[d_.segments[s][1 - end]] - d_.points[p];
          const auto& sides = d_.wall_regions[s.value()];
          around[p.value()].push_back({std::atan2(x[1], x[0]), sides[1 - end], sides[end]});
        }
    } else {
      std::map<std::pair<PointId, PointId>, SegmentId> of_ends;
      for (const SegmentId s : ids(d_.segments)) of_ends[std::minmax(d_.segments[s][0], d_.segments[s][1])] = s;
      for (const FacetId f : ids<FacetId>(d_.facet_frame.size()))
        for (const auto& t : d_.facet_triangles[f])
          for (std::size_t i = 0; i < 3; ++i) {
            const auto it = of_ends.find(std::minmax(t[i], t[(i + 1) % 3]));
            if (it == of_ends.end()) continue;
            const auto& ends = d_.segments[it->second];
            const Vec<3> axis = d_.points[ends[1]] - d_.points[ends[0]];
            const bool along = ends[0] == t[i];
            const Vec<3> inward = cross(d_.facet_frame[f].normal, along ? axis : -axis);
            int smallest = 0;
            for (int k = 1; k < 3; ++k)
              if (std::abs(axis[k]) < std::abs(axis[smallest])) smallest = k;
            Vec<3> pole;
            pole[smallest] = 1;
            const Vec<3> x = cross(axis, pole), y = cross(axis, x);
            const auto& sides = d_.wall_regions[f.value()];
            around[it->second.value()].push_back({std::atan2(dot(inward, y) * norm(x), dot(inward, x) * norm(y)),
                                                  sides[along ? 1 : 0], sides[along ? 0 : 1]});
          }
    }
    for (auto& [ridge, sides] : around) {
      std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.angle < b.angle; });
      for (std::size_t i = 0; i < sides.size(); ++i)
        expect(sides[i].counterclockwise == sides[(i + 1) % sides.size()].clockwise,
               "walls around {} {} disagree on the region between them", D == 2 ? "point" : "segment", ridge);
    }
  }

  void check_measures() {
    std::vector<double> measure(d_.region_id.size(), 0);
    const Vec<D> center = d_.box.center();
    const auto add = [&](std::size_t wall, double signed_measure) {
      const auto& [left, right] = d_.wall_regions[wall];
      if (!left.is_none()) measure[left.value()] += signed_measure;
      if (!right.is_none()) measure[right.value()] -= signed_measure;
    };
    if constexpr (D == 2) {
      for (const SegmentId s : ids(d_.segments))
        add(s.value(), 0.5 * cross(d_.points[d_.segments[s][0]] - center, d_.points[d_.segments[s][1]] - center));
    } else {
      for (const FacetId f : ids<FacetId>(d_.facet_frame.size()))
        for (const auto& [a, b, c] : d_.facet_triangles[f])
          add(f.value(), -dot(d_.points[a] - center, cross(d_.points[b] - center, d_.points[c] - center)) / 6);
    }
    const double slack = 100 * kOnTolerance * std::pow(d_.diameter(), D);
    for (const RegionId r : ids(d_.region_id)) {
      expect(d_.region_measure[r] > 0, "region {} has measure {}", r.value(), d_.region_measure[r]);
      expect(std::abs(measure[r.value()] - d_.region_measure[r]) <= slack,
             "region {} has measure {}, its walls enclose {}", r.value(), d_.region_measure[r], measure[r.value()]);
    }
  }

  static constexpr double kFrameSlack = 1e-12;  ///< Unit vectors after a few operations.

  const Domain<D>& d_;
  double near_, flat_;
  std::string fault_;
};

}  // namespace

template <int D>
std::string find_domain_fault(const Domain<D>& domain) {
  return Checker<D>(domain).run();
}

template std::string find_domain_fault(const Domain<2>&);
template std::string find_domain_fault(const Domain<3>&);

}  // namespace voropack
