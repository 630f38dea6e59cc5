#include "geom/distance.h"

#include <algorithm>
#include <cmath>

namespace voropack {

template <int D>
SegmentPair<D> nearest_points(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d) {
  const auto at = [](const Vec<D>& p, const Vec<D>& q, double t) {
    return t <= 0.5 ? p + t * (q - p) : q + (1 - t) * (p - q);
  };
  // Where neither end is nearest, the segments cross in the plane that their directions span. Otherwise the distance is
  // that of one of the four ends.
  SegmentPair<D> best{a, at(c, d, nearest_parameter(a, c, d))};
  const auto consider = [&](const SegmentPair<D>& pair) {
    if (pair.length() < best.length()) best = pair;
  };
  consider({b, at(c, d, nearest_parameter(b, c, d))});
  consider({at(a, b, nearest_parameter(c, a, b)), c});
  consider({at(a, b, nearest_parameter(d, a, b)), d});
  const Vec<D> u = b - a, v = d - c, w = c - a;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
  const double det = uu * vv - uv * uv;
  if (det > 0) {
    const double s = (dot(w, u) * vv - dot(w, v) * uv) / det;
    const double t = (dot(w, u) * uv - dot(w, v) * uu) / det;
    // One more projection onto each removes most of the error of a small determinant.
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
      const Vec<D> y = at(c, d, nearest_parameter(at(a, b, s), c, d));
      consider({at(a, b, nearest_parameter(y, a, b)), y});
    }
  }
  return best;
}

template SegmentPair<2> nearest_points(const Vec<2>&, const Vec<2>&, const Vec<2>&, const Vec<2>&);
template SegmentPair<3> nearest_points(const Vec<3>&, const Vec<3>&, const Vec<3>&, const Vec<3>&);

template <int D>
double angle_between(const Vec<D>& u, const Vec<D>& v) {
  // Kahan's formula: no cancellation for small and large angles.
  const double lu = norm(u), lv = norm(v);
  const Vec<D> x = lv * u, y = lu * v;
  return 2 * std::atan2(norm(x - y), norm(x + y));
}

template double angle_between(const Vec<2>&, const Vec<2>&);
template double angle_between(const Vec<3>&, const Vec<3>&);

double angle_to_cone(const Vec<3>& u, const Vec<3>& v, const Vec<3>& w) {
  const double to_sides = std::min(angle_between(u, v), angle_between(u, w));
  const Vec<3> n = cross(v, w);
  const double nn = norm_sq(n);
  if (!(nn > 0)) return to_sides;
  const Vec<3> projected = u - (dot(u, n) / nn) * n;
  const bool inside = dot(cross(v, projected), n) >= 0 && dot(cross(projected, w), n) >= 0;
  return inside ? std::min(to_sides, std::atan2(std::abs(dot(u, n)) / std::sqrt(nn), norm(projected))) : to_sides;
}

}  // namespace voropack
