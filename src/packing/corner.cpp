#include "packing/corner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "geom/distance.h"

namespace voropack {

namespace {

/// Where a facet meets nothing at a small angle in a corner, the arcs there are at least this long in radii, however
/// small f is because of other facets: the triangle of corner and arc, and the simplices around it, count as the
/// interior's, and have half of the radius as their circumradius. Nothing comes near to such arcs, mostly (T5).
constexpr double kLeastArc = 0.35;

/// The least angle between a page and the others of its book.
double angle_to_others(const Incidence<3>& incidence, SegmentId spine, const std::vector<Page>& pages,
                       const Page& page) {
  double least = std::numbers::pi;
  for (const Page& other : pages)
    if (other != page)
      least = std::min(least, angle_between(incidence.inward(page, spine), incidence.inward(other, spine)));
  return least;
}

}  // namespace

Vec<3> point_of_arc(const Domain<3>& domain, const FanArc& fan, double radius, double arc_length) {
  const PlaneFrame& frame = domain.facet_frame[fan.facet];
  const double angle = fan.sector.begin + arc_length / radius;
  return domain.points[fan.apex] + radius * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
}

std::vector<FanArc> pack_corners(const Domain<3>& domain, const Protection<3>& protection, const Spacing<3>& spacing,
                                 std::uint64_t seed) {
  std::vector<FanArc> fans;
  std::vector<Strand<3>> strands;
  std::vector<Tie> ties;
  for (const auto& [apex, corner_radius] : protection.corners) {
    const double radius = corner_radius;
    std::map<std::pair<SegmentId, Page>, StrandEnd> ends;
    for (const FacetId facet : protection.incidence.facets_at(apex)) {
      const bool needs_short = protection.short_arcs.contains({apex, facet});
      const double least_arc =
          needs_short || protection.incidence.is_sharp_at(PolytopeId(facet), apex) ? 0 : kLeastArc * radius;
      for (const Sector& sector : protection.incidence.sectors(facet, apex)) {
        const auto strand = static_cast<std::uint32_t>(strands.size());
        if (!sector.first.is_none()) {
          const auto side = [&](SegmentId s, bool sector_follows) {
            return (domain.segments[s][0] == apex) == sector_follows ? 0 : 1;
          };
          ends[{sector.first, {facet, side(sector.first, true)}}] = {strand, false};
          ends[{sector.second, {facet, side(sector.second, false)}}] = {strand, true};
        }
        const FanArc fan{apex, facet, sector, {}};
        fans.push_back(fan);
        strands.push_back({.length = radius * (sector.end - sector.begin),
                           .at = [&domain, fan, radius](double t) { return point_of_arc(domain, fan, radius, t); },
                           .longest_step = radius * std::numbers::pi / 2,
                           .least_step = least_arc,
                           .positions = {},
                           .kept = {}});
      }
    }
    for (const SegmentId s : protection.incidence.segments_at(apex)) {
      const auto* groups = protection.books.of(s);
      if (groups == nullptr) continue;
      for (const auto& pages : *groups) {
        Tie tie{{}, protection.least_angle(s, pages), 0};
        for (const Page& page : pages) {
          StrandEnd end = ends.at({s, page});
          end.angle = angle_to_others(protection.incidence, s, pages, page);
          tie.ends.push_back(end);
        }
        ties.push_back(std::move(tie));
      }
    }
  }
  std::vector<PackedStrand> arcs = pack_strands(strands, ties, spacing, kTieJitter, seed);
  for (std::size_t i = 0; i < fans.size(); ++i) fans[i].arc = std::move(arcs[i]);
  return fans;
}

}  // namespace voropack
