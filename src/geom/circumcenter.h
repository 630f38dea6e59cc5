// Circumcenters: accurate ones, which stay so for slivers, and fast ones, for placing new points. Nothing topological
// is decided by either.
#pragma once

#include <array>

#include "base/lanes.h"
#include "voropack/vec.h"

namespace voropack {

/// The point at equal distance from the corners of a simplex, to within 1e-13 of the length of its edges at corner 0
/// plus one rounding of the coordinates, however flat the simplex: double precision where its error bound allows,
/// else double-double or exact arithmetic. NaN if the simplex is flat.
template <int D>
Vec<D> circumcenter(const std::array<Vec<D>, D + 1>& simplex);

/// The same relative to corner 0, before it is rounded to the coordinates' grid.
template <int D>
Vec<D> circumcenter_offset(const std::array<Vec<D>, D + 1>& simplex);

/// D! times the signed volume of a simplex: to 1e-13 relatively, however flat, and 0 only if it is flat.
template <int D>
double simplex_determinant(const std::array<Vec<D>, D + 1>& simplex);

/// Two simplices, corner by corner.
template <int D>
using SimplexPair = std::array<std::array<Lanes, D>, D + 1>;

template <int D>
SimplexPair<D> simplex_pair(const std::array<Vec<D>, D + 1>& first, const std::array<Vec<D>, D + 1>& second) {
  SimplexPair<D> pair;
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t k = 0; k < D; ++k) pair[i][k] = Lanes(first[i].coord[k], second[i].coord[k]);
  return pair;
}

/// `circumcenter_offset` and `simplex_determinant` of two simplices, to the bit.
template <int D>
struct CircumcenterPair {
  std::array<Lanes, D> offset;
  Lanes determinant;
};
template <int D>
CircumcenterPair<D> circumcenter_pair(const SimplexPair<D>& simplices);

/// The circumcenter in plain double precision: accurate while the simplex is far from flat. Not finite if it is flat.
inline Vec<2> fast_circumcenter(const std::array<Vec<2>, 3>& s) {
  const Vec<2> u = s[1] - s[0], v = s[2] - s[0];
  const double scale = 0.5 / cross(u, v), uu = norm_sq(u), vv = norm_sq(v);
  return s[0] + scale * Vec<2>{v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu};
}

inline Vec<3> fast_circumcenter(const std::array<Vec<3>, 4>& s) {
  const Vec<3> u = s[1] - s[0], v = s[2] - s[0], w = s[3] - s[0];
  const Vec<3> vw = cross(v, w);
  const double scale = 0.5 / dot(u, vw);
  return s[0] + scale * (norm_sq(u) * vw + norm_sq(v) * cross(w, u) + norm_sq(w) * cross(u, v));
}

/// The circumcenter of a triangle in space, in its plane; plain double precision. Accurate while the triangle's
/// angles are not tiny, which a bounded radius-edge ratio grants.
inline Vec<3> triangle_circumcenter(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const Vec<3> u = b - a, v = c - a, n = cross(u, v);
  return a + (0.5 / norm_sq(n)) * (norm_sq(u) * cross(v, n) + norm_sq(v) * cross(n, u));
}

}  // namespace voropack
