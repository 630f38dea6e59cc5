#include "packing/incidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "geom/distance.h"

namespace voropack {

namespace {

template <class I, class T>
Csr<I, T> to_rows(const std::vector<std::vector<T>>& lists) {
  Csr<I, T> rows;
  for (const auto& list : lists) rows.push_row(list);
  return rows;
}

/// The directed edges of a facet's triangles: of those along a segment, the facet lies to the left.
std::set<std::array<PointId, 2>> directed_edges(const Domain<3>& domain, FacetId facet) {
  std::set<std::array<PointId, 2>> edges;
  for (const auto& t : domain.facet_triangles[facet])
    for (std::size_t i = 0; i < 3; ++i) edges.insert({t[i], t[(i + 1) % 3]});
  return edges;
}

}  // namespace

template <int D>
Incidence<D>::Incidence(const Domain<D>& domain, std::vector<FacetId> trace_facets)
    : domain_(&domain), trace_facets_(std::move(trace_facets)) {
  std::vector<std::vector<SegmentId>> segments(domain.points.size());
  for (const SegmentId s : ids(domain.segments))
    for (const PointId p : domain.segments[s]) segments[p.value()].push_back(s);
  point_segments_ = to_rows<PointId>(segments);

  std::vector<std::vector<FacetId>> facets(domain.points.size());
  std::vector<std::vector<Page>> pages(domain.segments.size());
  if constexpr (D == 3) {
    for (const FacetId f : ids(domain.facet_frame)) {
      for (const PointId p : domain.facet_points[f]) facets[p.value()].push_back(f);
      const auto edges = directed_edges(domain, f);
      for (const SegmentId s : domain.facet_segments[f]) {
        const auto [a, b] = domain.segments[s];
        const bool is_trace = s.value() + trace_facets_.size() >= domain.segments.size();
        if (is_trace || edges.contains({a, b})) pages[s.value()].push_back({f, 0});
        if (is_trace || edges.contains({b, a})) pages[s.value()].push_back({f, 1});
      }
    }
  }
  point_facets_ = to_rows<PointId>(facets);
  segment_pages_ = to_rows<SegmentId>(pages);
}

template <int D>
PolytopeId Incidence<D>::given(PolytopeId p) const {
  if (p.dimension > 1) return p;
  const std::size_t n = (p.dimension == 0 ? domain_->points.size() : domain_->segments.size()) - trace_facets_.size();
  return p.index < n ? p : PolytopeId(trace_facets_[p.index - n]);
}

template <int D>
std::span<const PointId> Incidence<D>::points_of(PolytopeId p) const {
  if (p.dimension == 1) return domain_->segments[SegmentId(p.index)];
  return domain_->facet_points[FacetId(p.index)];
}

template <int D>
std::vector<PointId> Incidence<D>::common_points(PolytopeId a, PolytopeId b) const {
  const auto sorted = [&](PolytopeId p) {
    if (p.dimension == 0) return std::vector<PointId>{PointId(p.index)};
    std::vector<PointId> points(points_of(p).begin(), points_of(p).end());
    std::sort(points.begin(), points.end());
    return points;
  };
  const std::vector<PointId> of_a = sorted(a), of_b = sorted(b);
  std::vector<PointId> common;
  std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(common));
  return common;
}

template <int D>
std::vector<PolytopeId> Incidence<D>::holders(PolytopeId p) const {
  p = given(p);
  std::vector<PolytopeId> result;
  if (p.dimension == 0) {
    for (const SegmentId s : segments_at(PointId(p.index))) result.push_back(PolytopeId(s));
    for (const FacetId f : facets_at(PointId(p.index))) result.push_back(PolytopeId(f));
  } else if (p.dimension < D) {
    result.push_back(p);
    if (p.dimension == 1)
      for (const Page& page : pages_of(SegmentId(p.index))) result.push_back(PolytopeId(page.facet));
  }
  return result;
}

template <int D>
std::vector<SegmentId> Incidence<D>::common_segments(FacetId f, FacetId g) const {
  const auto of_f = domain_->facet_segments[f], of_g = domain_->facet_segments[g];
  std::vector<SegmentId> common;
  std::set_intersection(of_f.begin(), of_f.end(), of_g.begin(), of_g.end(), std::back_inserter(common));
  return common;
}

template <int D>
bool Incidence<D>::contains(PolytopeId upper, PolytopeId lower) const {
  if (upper == lower) return true;
  if (upper.dimension <= lower.dimension) return false;
  if (lower.dimension == 0) return std::ranges::count(points_of(upper), PointId(lower.index)) > 0;
  return std::ranges::binary_search(domain_->facet_segments[FacetId(upper.index)], SegmentId(lower.index));
}

template <int D>
Vec<D> Incidence<D>::direction(SegmentId s, PointId p) const {
  const auto [a, b] = domain_->segments[s];
  const Vec<D> along = domain_->points[p == a ? b : a] - domain_->points[p];
  return along / norm(along);
}

template <int D>
std::vector<Sector> Incidence<D>::sectors(FacetId f, PointId p) const {
  if constexpr (D == 2) {
    return {};
  } else {
    constexpr double kTurn = 2 * std::numbers::pi;
    struct Ray {
      double angle;
      SegmentId segment;
      bool facet_follows;  ///< The facet lies counterclockwise of the ray.
    };
    const PlaneFrame& frame = domain_->facet_frame[f];
    std::vector<Ray> rays;
    for (const SegmentId s : segments_at(p)) {
      if (!contains(PolytopeId(f), PolytopeId(s))) continue;
      const Vec<3> d = direction(s, p);
      const int ahead = domain_->segments[s][0] == p ? 0 : 1;
      const bool follows = std::ranges::count(pages_of(s), Page{f, ahead}) > 0;
      rays.push_back({std::atan2(dot(d, frame.v), dot(d, frame.u)), s, follows});
    }
    if (rays.empty()) return {{0, kTurn, {}, {}}};
    std::sort(rays.begin(), rays.end(), [](const Ray& a, const Ray& b) { return a.angle < b.angle; });
    std::vector<Sector> result;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!rays[i].facet_follows) continue;
      const Ray& next = rays[(i + 1) % rays.size()];
      double end = next.angle;
      if (i + 1 == rays.size()) end += kTurn;
      result.push_back({rays[i].angle, end, rays[i].segment, next.segment});
    }
    return result;
  }
}

template <int D>
Vec<D> Incidence<D>::inward(const Page& page, SegmentId s) const {
  if constexpr (D == 2) {
    return {};
  } else {
    const Vec<3> across = cross(domain_->facet_frame[page.facet].normal, direction(s, domain_->segments[s][0]));
    return (page.side == 0 ? 1 : -1) / norm(across) * across;
  }
}

template <int D>
double Incidence<D>::angle_at(PointId p, PolytopeId a, PolytopeId b) const {
  if (a.dimension == 1 && b.dimension == 1)
    return angle_between(direction(SegmentId(a.index), p), direction(SegmentId(b.index), p));
  double least = std::numbers::pi;
  if constexpr (D == 3) {
    const auto cones = [&](FacetId f, auto&& visit) {
      for (const auto& t : domain_->facet_triangles[f])
        for (std::size_t i = 0; i < 3; ++i)
          if (t[i] == p)
            visit(domain_->points[t[(i + 1) % 3]] - domain_->points[p],
                  domain_->points[t[(i + 2) % 3]] - domain_->points[p]);
    };
    if (a.dimension > b.dimension) std::swap(a, b);
    cones(FacetId(b.index), [&](const Vec<3>& v, const Vec<3>& w) {
      if (a.dimension == 1) {
        least = std::min(least, angle_to_cone(direction(SegmentId(a.index), p), v, w));
        return;
      }
      // Two cones that meet in their tip only are nearest along a side of one of them.
      cones(FacetId(a.index), [&](const Vec<3>& x, const Vec<3>& y) {
        least = std::min(
            {least, angle_to_cone(x, v, w), angle_to_cone(y, v, w), angle_to_cone(v, x, y), angle_to_cone(w, x, y)});
      });
    });
  }
  return least;
}

template <int D>
std::optional<double> Incidence<D>::meeting_angle(PolytopeId a, PolytopeId b) const {
  if (a.dimension == 0 || b.dimension == 0 || contains(a, b) || contains(b, a)) return std::nullopt;
  double least = std::numeric_limits<double>::infinity();
  if constexpr (D == 3) {
    if (a.dimension == 2 && b.dimension == 2) {
      for (const SegmentId s : common_segments(FacetId(a.index), FacetId(b.index)))
        for (const Page& p : pages_of(s))
          for (const Page& q : pages_of(s))
            if (p.facet == FacetId(a.index) && q.facet == FacetId(b.index))
              least = std::min(least, angle_between(inward(p, s), inward(q, s)));
      if (std::isfinite(least)) return least;
    }
  }
  for (const PointId p : common_points(a, b)) least = std::min(least, angle_at(p, a, b));
  if (!std::isfinite(least)) return std::nullopt;
  return least;
}

template <int D>
bool Incidence<D>::form_sharp_feature(PolytopeId a, PolytopeId b) const {
  a = given(a);
  b = given(b);
  if (a.dimension >= D || b.dimension >= D) return false;
  const std::optional<double> angle = meeting_angle(a, b);
  return angle && *angle < kSharpAngle;
}

template class Incidence<2>;
template class Incidence<3>;

}  // namespace voropack
