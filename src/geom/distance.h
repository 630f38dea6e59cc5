// Nearest points of segments and angles between directions, in floating point.
#pragma once

#include "voropack/vec.h"

namespace voropack {

/// The parameter in [0, 1] of the point of segment ab that is nearest to x; 0 if a == b.
template <int D>
double nearest_parameter(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b) {
  const Vec<D> e = b - a;
  const double length_sq = norm_sq(e);
  if (!(length_sq > 0)) return 0;
  return std::clamp(dot(x - a, e) / length_sq, 0.0, 1.0);
}

/// The nearest points of two segments.
template <int D>
struct SegmentPair {
  Vec<D> on_first, on_second;
  [[nodiscard]] double length() const { return distance(on_first, on_second); }
};
template <int D>
SegmentPair<D> nearest_points(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d);

/// The angle between two directions in radians, accurate also near 0 and pi.
template <int D>
double angle_between(const Vec<D>& u, const Vec<D>& v);

/// The angle in radians between direction u and the cone of all combinations of v and w with weights >= 0; 0 if u is
/// in it.
double angle_to_cone(const Vec<3>& u, const Vec<3>& v, const Vec<3>& w);

}  // namespace voropack
