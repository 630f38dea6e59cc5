#include "packing/traces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "packing/strands.h"

namespace voropack {

namespace {

/// Room in f that a trace leaves to whatever else is in the facet.
constexpr double kRoom = 2.2;
/// A trace keeps away from the facet's segments at its tip by so many of its own angle: nearer to them their centers
/// would have to be as small as between segment and facet.
constexpr double kClear = 2;

/// The segment's direction, turned about a spine of the facet and a facet that holds the segment; of several the least
/// turn.
std::optional<Vec<3>> turned(const Domain<3>& domain, const Incidence<3>& incidence, const TraceSite& site) {
  const Vec<3> d = incidence.direction(site.segment, site.tip);
  std::optional<Vec<3>> best;
  for (const Page& own : incidence.pages_of(site.segment))
    for (const SegmentId spine : incidence.common_segments(own.facet, site.facet)) {
      const auto [a, b] = domain.segments[spine];
      if (spine == site.segment || (a != site.tip && b != site.tip)) continue;
      const Vec<3> along = incidence.direction(spine, site.tip);
      const double rise = norm(d - dot(d, along) * along);
      for (const Page& page : incidence.pages_of(spine)) {
        if (page.facet != site.facet) continue;
        const Vec<3> image = dot(d, along) * along + rise * incidence.inward(page, spine);
        if (!best || dot(image, d) > dot(*best, d)) best = image;
      }
    }
  return best;
}

std::optional<Vec<3>> projected(const Domain<3>& domain, const Incidence<3>& incidence, const TraceSite& site) {
  const Vec<3> d = incidence.direction(site.segment, site.tip), n = domain.facet_frame[site.facet].normal;
  const Vec<3> foot = d - dot(d, n) * n;
  if (!(norm(foot) > 0.5)) return std::nullopt;
  return foot / norm(foot);
}

/// How far in angle a direction is from the sides of the sector that it is in; negative outside of all sectors.
double clearance(const Domain<3>& domain, const Incidence<3>& incidence, const TraceSite& site, const Vec<3>& d) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const PlaneFrame& frame = domain.facet_frame[site.facet];
  for (const Sector& sector : incidence.sectors(site.facet, site.tip)) {
    const double turn = std::atan2(dot(d, frame.v), dot(d, frame.u)) - sector.begin;
    const double inside = turn - kTurn * std::floor(turn / kTurn), width = sector.end - sector.begin;
    if (inside < width) return sector.first.is_none() ? kTurn : std::min(inside, width - inside);
  }
  return -1;
}

}  // namespace

std::optional<Trace> find_trace(const Domain<3>& domain, const Incidence<3>& incidence, const TraceSite& site,
                                const Spacing<3>& spacing) {
  std::optional<Vec<3>> direction = turned(domain, incidence, site);
  if (!direction) direction = projected(domain, incidence, site);
  if (!direction) return std::nullopt;
  const Vec<3> up = incidence.direction(site.segment, site.tip), tip = domain.points[site.tip];
  Trace trace{site, *direction, angle_between(up, *direction), 0};
  if (trace.angle >= kSharpAngle) return std::nullopt;
  if (clearance(domain, incidence, site, *direction) < kClear * trace.angle) return std::nullopt;

  const auto [a, b] = domain.segments[site.segment];
  const double length = distance(domain.points[a], domain.points[b]);
  const auto is_free = [&](const Vec<3>& x, double room) {
    for (const SegmentId s : domain.facet_segments[site.facet]) {
      const auto [p, q] = domain.segments[s];
      if (p != site.tip && q != site.tip && distance_to_segment(x, domain.points[p], domain.points[q]) < room)
        return false;
    }
    return std::ranges::none_of(domain.facet_points[site.facet],
                                [&](PointId p) { return p != site.tip && distance(x, domain.points[p]) < room; });
  };
  double t = 0, f = 0;
  for (; t < length; t += 0.25 * f) {
    const Vec<3> below = tip + t * trace.direction;
    f = std::min(spacing(below), spacing(tip + t * up));
    if (t > 0 && !is_free(below, kRoom * spacing(below))) break;
    trace.length = t;
    if (t * 2 * std::sin(trace.angle / 2) >= kTieApart * std::max(spacing(below), spacing(tip + t * up))) break;
  }
  if (t >= length && is_free(tip + length * trace.direction, kRoom * f)) trace.length = length;
  if (trace.length < kRoom * spacing(tip)) return std::nullopt;
  return trace;
}

void add_trace(Domain<3>& domain, const Trace& trace) {
  const PointId end = domain.points.push_back(domain.points[trace.site.tip] + trace.length * trace.direction);
  domain.point_marker.push_back(0);
  domain.point_region.push_back(RegionId::none());
  const SegmentId line = domain.segments.push_back({trace.site.tip, end});
  domain.segment_marker.push_back(0);
  domain.segment_region.push_back(RegionId::none());
  const auto append = [&](auto& rows, auto id) {
    std::remove_reference_t<decltype(rows)> longer;
    for (const FacetId f : ids(domain.facet_frame)) {
      std::vector row(rows[f].begin(), rows[f].end());
      if (f == trace.site.facet) row.push_back(id);
      longer.push_row(row);
    }
    rows = std::move(longer);
  };
  append(domain.facet_segments, line);
  append(domain.facet_points, end);
}

}  // namespace voropack
