#include "domain/angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "domain/volumes.h"
#include "geom/distance.h"
#include "geom/tolerance.h"

namespace voropack::domain_impl {

namespace {

template <int D>
class AngleCheck {
 public:
  AngleCheck(const Domain<D>& domain, double min_angle_deg)
      : domain_(domain),
        limit_((min_angle_deg - kAngleSlackDeg) * std::numbers::pi / 180),
        point_segments_(domain.points.size()) {
    for (const SegmentId s : ids(domain.segments))
      for (const PointId p : domain.segments[s]) point_segments_[p.value()].push_back(s);
  }

  struct Finding {
    double angle = 0;
    Vec<D> place;
  };
  using Pair = std::pair<PolytopeId, PolytopeId>;

  std::map<Pair, Finding> run() {
    for (const PointId p : ids(domain_.points)) between_segments(p);
    if constexpr (D == 3) {
      for (const FacetId f : ids<FacetId>(domain_.facet_segments.size())) between_segments_and(f);
      between_facets();
    }
    return std::move(findings_);
  }

 private:
  void note(PolytopeId a, PolytopeId b, double angle, const Vec<D>& place) {
    if (angle >= limit_) return;
    const auto [it, added] = findings_.try_emplace(std::minmax(a, b), Finding{angle, place});
    if (!added && angle < it->second.angle) it->second = {angle, place};
  }

  [[nodiscard]] Vec<D> away(SegmentId s, PointId p) const {
    const auto& [a, b] = domain_.segments[s];
    return p == a ? domain_.points[b] - domain_.points[a] : domain_.points[a] - domain_.points[b];
  }

  void between_segments(PointId p) {
    const auto& at = point_segments_[p.value()];
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        note(PolytopeId(at[j]), PolytopeId(at[i]), angle_between(away(at[i], p), away(at[j], p)), domain_.points[p]);
  }

  // Segments at the points of a facet that are not in it. The nearest direction in the facet is in one of its triangles
  // there.
  void between_segments_and(FacetId f) {
    const auto own = domain_.facet_segments[f];
    for (const auto& triangle : domain_.facet_triangles[f])
      for (std::size_t i = 0; i < 3; ++i) {
        const PointId p = triangle[i];
        const Vec<3>& x = domain_.points[p];
        const Vec<3> v = domain_.points[triangle[(i + 1) % 3]] - x, w = domain_.points[triangle[(i + 2) % 3]] - x;
        for (const SegmentId s : point_segments_[p.value()]) {
          if (std::binary_search(own.begin(), own.end(), s)) continue;
          const double angle = angle_to_cone(away(s, p), v, w);
          // At a side of the facet it is the angle between two segments, which is noted as such.
          if (angle < limit_ && !at_segment_of(own, p, s, angle)) note(PolytopeId(s), PolytopeId(f), angle, x);
        }
      }
  }

  [[nodiscard]] bool at_segment_of(std::span<const SegmentId> own, PointId p, SegmentId s, double angle) const {
    for (const SegmentId other : point_segments_[p.value()])
      if (std::binary_search(own.begin(), own.end(), other) &&
          angle_between(away(s, p), away(other, p)) <= angle + kAngleSlackDeg * std::numbers::pi / 180)
        return true;
    return false;
  }

  void between_facets() {
    std::vector<std::array<std::uint32_t, 2>> ridges;
    std::map<std::pair<PointId, PointId>, SegmentId> of_ends;
    for (const SegmentId s : ids(domain_.segments)) {
      const auto& [a, b] = domain_.segments[s];
      ridges.push_back({a.value(), b.value()});
      of_ends[std::minmax(a, b)] = s;
    }
    std::vector<std::vector<std::pair<double, FacetId>>> around(ridges.size());
    std::vector<Vec<3>> start(ridges.size());
    for (const FacetId f : ids<FacetId>(domain_.facet_triangles.size()))
      for (const auto& triangle : domain_.facet_triangles[f])
        for (std::size_t i = 0; i < 3; ++i) {
          const PointId a = triangle[i], b = triangle[(i + 1) % 3];
          const auto it = of_ends.find(std::minmax(a, b));
          if (it == of_ends.end()) continue;
          const std::size_t s = it->second.value();
          const auto& ends = domain_.segments[it->second];
          const Vec<3> axis = domain_.points[ends[1]] - domain_.points[ends[0]];
          const Vec<3> edge = domain_.points[b] - domain_.points[a];
          const Vec<3> inward = cross(domain_.facet_frame[f].normal, edge);
          if (around[s].empty()) start[s] = inward;
          double angle = std::atan2(dot(cross(start[s], inward), axis) / norm(axis), dot(start[s], inward));
          if (angle < 0) angle += 2 * std::numbers::pi;
          around[s].emplace_back(angle, f);
        }
    for (std::size_t s = 0; s < around.size(); ++s) {
      auto& fins = around[s];
      std::sort(fins.begin(), fins.end());
      const auto& [a, b] = domain_.segments[SegmentId(s)];
      const Vec<3> place = 0.5 * (domain_.points[a] + domain_.points[b]);
      for (std::size_t i = 0; i < fins.size() && fins.size() > 1; ++i) {
        const auto& [angle, f] = fins[i];
        const auto& [next_angle, g] = fins[(i + 1) % fins.size()];
        double between = next_angle - angle;
        if (i + 1 == fins.size()) between += 2 * std::numbers::pi;
        if (f != g) note(PolytopeId(f), PolytopeId(g), between, place);
      }
    }
  }

  const Domain<D>& domain_;
  double limit_;
  std::vector<std::vector<SegmentId>> point_segments_;
  std::map<Pair, Finding> findings_;
};

}  // namespace

template <int D>
void check_angles(const Domain<D>& domain, const PolytopeNames& names, double min_angle_deg, FaultList<D>& faults) {
  if (!(min_angle_deg > 0)) return;
  using Check = AngleCheck<D>;
  const auto findings = Check(domain, min_angle_deg).run();
  std::vector<std::pair<typename Check::Pair, typename Check::Finding>> sorted(findings.begin(), findings.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second.angle < b.second.angle; });
  const auto name = [&](PolytopeId id) { return id.dimension == 1 ? names.segment[id.index] : names.facet[id.index]; };
  const auto line = [&](PolytopeId id) {
    return id.dimension == 1 ? names.segment_line[id.index] : names.facet_line[id.index];
  };
  for (const auto& [pair, finding] : sorted)
    faults.add(
        "small_angle",
        fmt::format("{} and {} meet at {:.6g} degrees at {}, less than {:g}{}", name(pair.first), name(pair.second),
                    finding.angle * 180 / std::numbers::pi, place_text(finding.place), min_angle_deg,
                    sorted.size() > 1 ? fmt::format(" (one of {} such pairs)", sorted.size()) : ""),
        "widen the angle, or allow it by a smaller limit", finding.place, line(pair.first));
}

template void check_angles(const Domain<2>&, const PolytopeNames&, double, FaultList<2>&);
template void check_angles(const Domain<3>&, const PolytopeNames&, double, FaultList<3>&);

}  // namespace voropack::domain_impl
