// Circumcenters in double precision, for placing new points. Nothing topological is decided by them.
#pragma once

#include <array>

#include "voropack/vec.h"

namespace voropack {

/// The circumcenter of a triangle in the plane or a tetrahedron in space. Not finite if the simplex is flat.
inline Vec<2> circumcenter(const std::array<Vec<2>, 3>& s) {
  const Vec<2> u = s[1] - s[0], v = s[2] - s[0];
  const double scale = 0.5 / cross(u, v), uu = norm_sq(u), vv = norm_sq(v);
  return s[0] + scale * Vec<2>{v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu};
}

inline Vec<3> circumcenter(const std::array<Vec<3>, 4>& s) {
  const Vec<3> u = s[1] - s[0], v = s[2] - s[0], w = s[3] - s[0];
  const Vec<3> vw = cross(v, w);
  const double scale = 0.5 / dot(u, vw);
  return s[0] + scale * (norm_sq(u) * vw + norm_sq(v) * cross(w, u) + norm_sq(w) * cross(u, v));
}

/// The circumcenter of a triangle in space, in the plane of the triangle.
inline Vec<3> circumcenter(const std::array<Vec<3>, 3>& s) {
  const Vec<3> u = s[1] - s[0], v = s[2] - s[0], n = cross(u, v);
  return s[0] + (0.5 / norm_sq(n)) * (norm_sq(u) * cross(v, n) + norm_sq(v) * cross(n, u));
}

}  // namespace voropack
