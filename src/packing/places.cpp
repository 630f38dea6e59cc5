#include "packing/places.h"

#include <limits>
#include <utility>
#include <vector>

#include "geom/distance.h"

namespace voropack {

namespace {

/// Projections from one polytope to the other and back. Between parallel ones they converge at once.
constexpr int kProjections = 20;
/// Points that are this much farther apart than the nearest ones, relatively, are as good.
constexpr double kAsNear = 1e-9;

/// Keeps the point nearest to x of those it is shown.
template <int D>
class Nearest {
 public:
  explicit Nearest(const Vec<D>& x) : x_(x) {}
  void consider(const Vec<D>& y) {
    const double d = distance_sq(x_, y);
    if (d < least_sq_) best_ = y, least_sq_ = d;
  }
  void consider_segment(const Vec<D>& a, const Vec<D>& b) { consider(a + nearest_parameter(x_, a, b) * (b - a)); }
  void consider_triangle(const std::array<Vec<D>, 3>& corner, const Vec<D>& normal) requires(D == 3) {
    bool is_inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec<D>&a = corner[i], &b = corner[(i + 1) % 3];
      is_inside = is_inside && dot(cross(b - a, x_ - a), normal) >= 0;
      consider_segment(a, b);
    }
    if (is_inside) consider(x_ - dot(x_ - corner[0], normal) * normal);
  }
  [[nodiscard]] const Vec<D>& best() const { return best_; }

 private:
  Vec<D> x_, best_;
  double least_sq_ = std::numeric_limits<double>::infinity();
};

template <int D>
std::vector<PointId> points_of(const Domain<D>& domain, PolytopeId p) {
  if (p.dimension == 0) return {PointId(p.index)};
  if (p.dimension == 1) return {domain.segments[SegmentId(p.index)][0], domain.segments[SegmentId(p.index)][1]};
  const auto row = domain.facet_points[FacetId(p.index)];
  return {row.begin(), row.end()};
}

template <int D>
std::vector<SegmentId> segments_of(const Domain<D>& domain, PolytopeId p) {
  if (p.dimension == 0) return {};
  if (p.dimension == 1) return {SegmentId(p.index)};
  const auto row = domain.facet_segments[FacetId(p.index)];
  return {row.begin(), row.end()};
}

/// Nearest points are to be found among corners of one polytope and points of the other, and among their segments.
template <int D>
Gap<D> nearest_of_corners_and_segments(const Domain<D>& domain, PolytopeId p, PolytopeId q) {
  Gap<D> best{{}, std::numeric_limits<double>::infinity()};
  const auto consider = [&](const Vec<D>& x, const Vec<D>& y) {
    if (const double d = distance(x, y); d < best.size) best = {0.5 * (x + y), d};
  };
  for (const auto& [from, to] : {std::pair(p, q), std::pair(q, p)})
    for (const PointId i : points_of(domain, from))
      consider(domain.points[i], nearest_point_of(domain, to, domain.points[i]));
  for (const SegmentId s : segments_of(domain, p))
    for (const SegmentId t : segments_of(domain, q)) {
      const auto [a, b] = domain.segments[s];
      const auto [c, d] = domain.segments[t];
      const auto nearest = nearest_points(domain.points[a], domain.points[b], domain.points[c], domain.points[d]);
      consider(nearest.on_first, nearest.on_second);
    }
  return best;
}

}  // namespace

template <int D>
Vec<D> nearest_point_of(const Domain<D>& domain, PolytopeId p, const Vec<D>& x) {
  const auto corner = [&](PointId i) { return domain.points[i]; };
  Nearest<D> nearest(x);
  if (p.dimension == 0) nearest.consider(corner(PointId(p.index)));
  if (p.dimension == 1) {
    const auto [a, b] = domain.segments[SegmentId(p.index)];
    nearest.consider_segment(corner(a), corner(b));
  }
  if constexpr (D == 3)
    if (p.dimension == 2)
      for (const auto& t : domain.facet_triangles[FacetId(p.index)])
        nearest.consider_triangle({corner(t[0]), corner(t[1]), corner(t[2])},
                                  domain.facet_frame[FacetId(p.index)].normal);
  return nearest.best();
}

template <int D>
Gap<D> nearest_gap(const Domain<D>& domain, PolytopeId p, PolytopeId q, const Vec<D>& near) {
  Vec<D> on_p = nearest_point_of(domain, p, near), on_q = nearest_point_of(domain, q, on_p);
  for (int i = 0; i < kProjections; ++i) {
    const Vec<D> next = nearest_point_of(domain, p, on_q);
    if (next == on_p) break;
    on_p = next;
    on_q = nearest_point_of(domain, q, on_p);
  }
  const Gap<D> found{0.5 * (on_p + on_q), distance(on_p, on_q)};
  const Gap<D> least = nearest_of_corners_and_segments(domain, p, q);
  return found.size <= least.size * (1 + kAsNear) ? found : least;
}

template <int D>
Vec<D> nearest_common_point(const Domain<D>& domain, const Incidence<D>& incidence, PolytopeId p, PolytopeId q,
                            const Vec<D>& x) {
  Nearest<D> nearest(x);
  for (const PointId i : incidence.common_points(p, q)) nearest.consider(domain.points[i]);
  if (p.dimension == 2 && q.dimension == 2)
    for (const SegmentId s : incidence.common_segments(FacetId(p.index), FacetId(q.index)))
      nearest.consider_segment(domain.points[domain.segments[s][0]], domain.points[domain.segments[s][1]]);
  return nearest.best();
}

#define VOROPACK_INSTANTIATE(D)                                                         \
  template Vec<D> nearest_point_of(const Domain<D>&, PolytopeId, const Vec<D>&);        \
  template Gap<D> nearest_gap(const Domain<D>&, PolytopeId, PolytopeId, const Vec<D>&); \
  template Vec<D> nearest_common_point(const Domain<D>&, const Incidence<D>&, PolytopeId, PolytopeId, const Vec<D>&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
