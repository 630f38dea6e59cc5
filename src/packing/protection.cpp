#include "packing/protection.h"

#include <cmath>
#include <numbers>

#include "geom/distance.h"
#include "geom/polytope_distance.h"

namespace voropack {

namespace {

/// A corner's radius in f at the corner: room for two spheres, and for arcs of 45 degrees between them.
constexpr double kCornerRadius = 2.7;
/// A corner's sphere that is wider than this in f would carry triangles much longer than wide.
constexpr double kWideCorner = 4;
/// A corner's sphere reaches at most this part of the way along its segments, and to others of its facets.
constexpr double kCornerShare = 0.4;
/// And this part of the way to the nearest kept center: as far as if that were the rim for twice the f.
constexpr double kKeptShare = 0.5;
/// A point shared by two polytopes is protected when they fail within this many ball radii of it; farther away
/// smaller spheres are cheaper.
constexpr double kNear = 4;
/// A center this near to a protecting sphere, relative to its radius, is there by symmetry.
constexpr double kTie = 1e-7;
/// A center is beside a corner of a simplex when it is this near, relative to the radius of the simplex's ball.
constexpr double kBeside = 0.2;
/// A corner's sphere shrinks by this factor if something that does not touch the corner comes too near.
constexpr double kCornerShrink = 0.7;
/// One round shrinks f at most and at least by these factors.
constexpr double kLeastShrink = 0.8, kMostShrink = 0.3;

/// The least angle between the directions of two polytopes; pi if there is one only.
template <class Polytopes, class Direction>
double least_angle_between(const Polytopes& polytopes, Direction&& direction) {
  double least = std::numbers::pi;
  for (std::size_t i = 0; i < polytopes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, angle_between(direction(polytopes[i]), direction(polytopes[j])));
  return least;
}

}  // namespace

template <int D>
bool Protection<D>::narrow_corners(const Vec<D>& center, double radius, const Spacing<D>& spacing) {
  bool narrowed = false;
  for (const auto& [p, before] : before_.corners) {
    const double f = spacing(domain_.points[p]);
    if (distance(center, domain_.points[p]) > before + radius || before <= kWideCorner * f) continue;
    if (!narrowed_.insert(p).second) continue;
    corners.at(p) = free_radius(p, spacing);
    narrowed = true;
  }
  return narrowed;
}

template <int D>
double Protection<D>::least_angle(SegmentId spine, const std::vector<Page>& pages) const {
  return least_angle_between(pages, [&](const Page& page) { return incidence.inward(page, spine); });
}

template <int D>
double Protection<D>::least_angle(PointId tip, const std::vector<SegmentId>& segments) const {
  return least_angle_between(segments, [&](SegmentId s) { return incidence.direction(s, tip); });
}

/// How far the center is from the line or plane of the ball's polytope.
template <int D>
double Protection<D>::height(const Intrusion<D>& it) const {
  if (it.ball_carrier.dimension == 1) {
    const auto [a, b] = domain_.segments[SegmentId(it.ball_carrier.index)];
    const Vec<D> start = domain_.points[a], along = incidence.direction(SegmentId(it.ball_carrier.index), a);
    const Vec<D> to = it.position - start;
    return norm(to - dot(to, along) * along);
  }
  if constexpr (D == 3)
    return std::abs(domain_.facet_frame[FacetId(it.ball_carrier.index)].height(it.position));
  else
    return 0;
}

/// The radius at which the ball would be clear of the center. For a center beside a corner of the ball's simplex: the
/// ball shrinks about that corner, since the center's polytope comes as near wherever they are tied. Else the ball may
/// be anywhere below the center.
template <int D>
double Protection<D>::clear_radius(const Intrusion<D>& it) const {
  const Vec<D> to = it.position - it.nearest;
  const double above = height(it);
  if (norm(to) > kBeside * it.ball.radius) return above;
  return std::max(above, 0.5 * norm_sq(to) * it.ball.radius / dot(to, it.ball.center - it.nearest));
}

/// By T5 only the arc between two centers on the sphere is too long, and it is there alone that f shrinks: not along
/// the whole triangle, which reaches to the corner.
template <int D>
auto Protection<D>::shorten_arc(const Intrusion<D>& it) -> Cap {
  const std::pair<PointId, FacetId> place{*it.ball_corner, FacetId(it.ball_carrier.index)};
  if (!before_.short_arcs.contains(place) && !incidence.is_sharp_at(it.ball_carrier, place.first)) {
    short_arcs.insert(place);
    return std::nullopt;
  }
  const Vec<D> apex = domain_.points[*it.ball_corner];
  const double radius = corner_radius(*it.ball_corner), cosine = 0.5 * radius / it.ball.radius;
  const double half = radius * std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const Vec<D> middle = apex + (radius / it.ball.radius) * (it.ball.center - apex);
  const double factor = std::clamp(0.9 * height(it) / half, kMostShrink, kLeastShrink);
  return SpacingCap<D>{middle, factor * half, factor * half, std::array{it.carrier, it.ball_carrier}};
}

// f has to be small where the ball that comes in the place of this one will be, and no farther: what is small around
// large balls asks for many spheres, and for free ones that are near to each other beside a corner's wide fans.
template <int D>
auto Protection<D>::shrink(const Intrusion<D>& it, double wanted, const Spacing<D>& spacing) -> Cap {
  if (it.ball_corner) return shorten_arc(it);
  const double factor = std::clamp(0.9 * wanted / it.ball.radius, kMostShrink, kLeastShrink);
  return SpacingCap<D>{it.ball.center, factor * it.ball.radius, factor * spacing(it.ball.center),
                       std::array{it.carrier, it.ball_carrier}};
}

template <int D>
double Protection<D>::free_radius(PointId p, const Spacing<D>& spacing) const {
  const double radius = kCornerRadius * spacing(domain_.points[p]);
  return kept.empty() ? radius : std::min(radius, kKeptShare * kept.nearest(domain_, incidence, p));
}

template <int D>
bool Protection<D>::open_corner(PointId p, const Spacing<D>& spacing) {
  if (before_.corners.contains(p)) return false;
  double radius = free_radius(p, spacing);
  for (const SegmentId s : incidence.segments_at(p)) {
    const auto [a, b] = domain_.segments[s];
    radius = std::min(radius, kCornerShare * distance(domain_.points[a], domain_.points[b]));
  }
  for (const FacetId f : incidence.facets_at(p))
    for (const SegmentId s : domain_.facet_segments[f]) {
      const auto [a, b] = domain_.segments[s];
      if (a == p || b == p) continue;
      radius =
          std::min(radius, kCornerShare * distance_to_segment(domain_.points[p], domain_.points[a], domain_.points[b]));
    }
  corners.emplace(p, radius);
  return true;
}

/// A corner's sphere that reaches something which does not touch the corner is too large.
template <int D>
bool Protection<D>::shrink_corner(const Intrusion<D>& it) {
  const auto shrink_if_foreign = [&](const std::optional<PointId>& corner, PolytopeId other) {
    if (!corner || incidence.contains(other, PolytopeId(*corner))) return false;
    const auto before = before_.corners.find(*corner);
    if (before == before_.corners.end()) return false;
    corners.at(*corner) = kCornerShrink * before->second;
    return true;
  };
  const bool by_center = shrink_if_foreign(it.center_corner, it.ball_carrier);
  return shrink_if_foreign(it.ball_corner, it.carrier) || by_center;
}

template <int D>
auto Protection<D>::between_segments(const Intrusion<D>& it, const Spacing<D>& spacing) -> Cap {
  const SegmentId s(it.carrier.index), t(it.ball_carrier.index);
  for (const PointId p : incidence.common_points(it.carrier, it.ball_carrier))
    if (!before_.fans.joined(p, s, t)) {
      fans.join(p, s, t);
      return std::nullopt;
    }
  return shrink(it, height(it), spacing);
}

template <int D>
bool Protection<D>::ask_for_traces(PointId tip, PolytopeId a, PolytopeId b) {
  bool is_new = false;
  if constexpr (D == 3) {
    const auto ask = [&](PolytopeId lines, PolytopeId facet) {
      if (facet.dimension != 2) return;
      for (const SegmentId s : incidence.segments_at(tip)) {
        const TraceSite site{tip, s, FacetId(facet.index)};
        if (!incidence.contains(lines, PolytopeId(s)) || incidence.contains(facet, PolytopeId(s))) continue;
        if (incidence.given(PolytopeId(s)) != PolytopeId(s) || before_.tried_sites.contains(site)) continue;
        is_new = true;
        if (tried_sites_.insert(site).second) new_sites_.push_back(site);
      }
    };
    ask(a, b);
    ask(b, a);
  }
  return is_new;
}

template <int D>
void Protection<D>::add_traces(const Spacing<D>& spacing) {
  if constexpr (D == 3) {
    for (const TraceSite& site : new_sites_) {
      const std::optional<Trace> trace = find_trace(domain_, incidence, site, spacing);
      if (!trace) continue;
      add_trace(domain_, *trace);
      trace_facets_.push_back(site.facet);
      incidence = Incidence<D>(domain_, trace_facets_);
      kept = KeptCenters<D>(domain_, incidence, kept_vertices_);
      fans.join(site.tip, site.segment, SegmentId(domain_.segments.size() - 1));
    }
    new_sites_.clear();
  }
}

template <int D>
auto Protection<D>::at_point(const Intrusion<D>& it, const Spacing<D>& spacing) -> Cap {
  if constexpr (D == 3)
    for (const PointId p : incidence.common_points(it.carrier, it.ball_carrier))
      if (ask_for_traces(p, it.carrier, it.ball_carrier)) return std::nullopt;
  if constexpr (D == 3)
    for (const PointId p : incidence.common_points(it.carrier, it.ball_carrier))
      if (distance(domain_.points[p], it.position) < kNear * it.ball.radius && open_corner(p, spacing))
        return std::nullopt;
  return shrink(it, clear_radius(it), spacing);
}

// The book principle: with x turned into the page of triangle t, pow_t(x) = pow_t(x') + 4 x_r c_r sin^2(angle / 2),
// where x_r and c_r are the distances of x and of t's circumcenter from the spine.
template <int D>
auto Protection<D>::between_pages(const Intrusion<D>& it, SegmentId spine, const Spacing<D>& spacing) -> Cap {
  if constexpr (D == 2) {
    return at_point(it, spacing);
  } else {
    const Vec<3> start = domain_.points[domain_.segments[spine][0]];
    const auto page_of = [&](PolytopeId facet, const Vec<3>& x) {
      std::optional<Page> best;
      for (const Page& p : incidence.pages_of(spine))
        if (p.facet == FacetId(facet.index) && dot(x - start, incidence.inward(p, spine)) > 0) best = p;
      return best;
    };
    const auto p = page_of(it.carrier, it.position), q = page_of(it.ball_carrier, it.ball.center);
    if (!p || !q) return at_point(it, spacing);
    if (!before_.books.joined(spine, *p, *q)) {
      books.join(spine, *p, *q);
      return std::nullopt;
    }
    const auto [a, b] = domain_.segments[spine];
    for (const PointId end : {a, b})
      if (ask_for_traces(end, it.carrier, it.ball_carrier)) return std::nullopt;
    for (const PointId end : {a, b})
      if (distance(domain_.points[end], it.position) < kNear * it.ball.radius && open_corner(end, spacing))
        return std::nullopt;
    const Vec<3> inward_p = incidence.inward(*p, spine), inward_q = incidence.inward(*q, spine);
    const double half = std::sin(0.5 * angle_between(inward_p, inward_q));
    const double x_r = dot(it.position - start, inward_p), c_r = dot(it.ball.center - start, inward_q);
    return shrink(it, 2 * half * std::sqrt(x_r * c_r), spacing);
  }
}

template <int D>
auto Protection<D>::adapt(const Intrusion<D>& it, const Spacing<D>& spacing) -> Cap {
  if (shrink_corner(it)) return std::nullopt;
  const bool is_tie = std::abs(distance(it.position, it.ball.center) - it.ball.radius) < kTie * it.ball.radius;
  if (is_tie && it.carrier.dimension == 1 && !before_.shaken.contains(SegmentId(it.carrier.index))) {
    shaken.insert(SegmentId(it.carrier.index));
    return std::nullopt;
  }
  if (incidence.contains(it.ball_carrier, it.carrier) || incidence.contains(it.carrier, it.ball_carrier))
    return shrink(it, 0.75 * it.ball.radius, spacing);
  if (it.carrier.dimension == 0) return shrink(it, height(it), spacing);
  if (it.carrier.dimension == 1 && it.ball_carrier.dimension == 1) return between_segments(it, spacing);
  if constexpr (D == 3) {
    if (it.carrier.dimension == 2 && it.ball_carrier.dimension == 2) {
      // The common segment that is nearest to the center, if there is one.
      std::optional<SegmentId> nearest;
      double least = 0;
      for (const SegmentId s : incidence.common_segments(FacetId(it.carrier.index), FacetId(it.ball_carrier.index))) {
        const auto [a, b] = domain_.segments[s];
        const double d = distance_to_segment(it.position, domain_.points[a], domain_.points[b]);
        if (!nearest || d < least) nearest = s, least = d;
      }
      if (nearest) return between_pages(it, *nearest, spacing);
    }
  }
  return at_point(it, spacing);
}

template class Protection<2>;
template class Protection<3>;

}  // namespace voropack
