// The certificate's own geometry: filtered signs, circumballs with error bounds. Nothing here is shared with the stages
// that make meshes.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "geom/predicates.h"
#include "voropack/vec.h"

namespace voropack::judge {

/// Half an ulp of 1: the largest relative error of one rounded operation.
inline constexpr double kUnitRoundoff = std::numeric_limits<double>::epsilon() / 2;

/// Sign and approximate value of a determinant whose sign is certain.
struct SignedValue {
  int sign = 0;
  double value = 0;
};

// Semi-static filters. A determinant is a sum of monomials in coordinate differences. With m_k the largest |difference|
// on axis k and M the largest of all, a result that passed k roundings on every path is off by at most gamma_k times
// the sum of the absolute monomials, gamma_k = k u / (1 - k u):
//   2D orientation  2 monomials  m_x m_y            2 + 1 + 1 = 4 roundings        2 gamma_4   <  0.9e-15
//   2D in-circle    6 monomials  m_x m_y 2 M^2      4 + 2 + 2 + 3 = 11 roundings  12 gamma_11  <  1.5e-14
//   3D orientation  6 monomials  m_x m_y m_z        3 + 2 + 3 = 8 roundings        6 gamma_8   <  5.4e-15
//   3D in-sphere   24 monomials  m_x m_y m_z 3 M^2  5 + 3 + 2 + 3 + 4 = 17        72 gamma_17  <  1.4e-13
// The constants below leave some room, which also covers the rounding of the bound itself; kTiny and kHuge keep every
// product far from underflow and overflow. Whatever the filter cannot decide is decided by geom/predicates.h.
inline constexpr double kTiny = 1e-50;
inline constexpr double kHuge = 1e50;

inline SignedValue certain_orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  const Vec<2> p = b - a, q = c - a;
  const double mx = std::max(std::abs(p[0]), std::abs(q[0])), my = std::max(std::abs(p[1]), std::abs(q[1]));
  const double det = p[0] * q[1] - p[1] * q[0];
  if (std::min(mx, my) > kTiny && std::max(mx, my) < kHuge && std::abs(det) > 1e-15 * mx * my)
    return {det > 0 ? 1 : -1, det};
  return {orientation(a, b, c), det};
}

inline SignedValue certain_orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  const Vec<3> p = b - a, q = c - a, r = d - a;
  Vec<3> m;
  for (int k = 0; k < 3; ++k) m[k] = std::max({std::abs(p[k]), std::abs(q[k]), std::abs(r[k])});
  const double det =
      p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
  if (std::min({m[0], m[1], m[2]}) > kTiny && std::max({m[0], m[1], m[2]}) < kHuge &&
      std::abs(det) > 6e-15 * m[0] * m[1] * m[2])
    return {det > 0 ? 1 : -1, det};
  return {orientation(a, b, c, d), det};
}

template <int D>
SignedValue certain_orientation(const std::array<Vec<D>, D + 1>& p) {
  if constexpr (D == 2)
    return certain_orientation(p[0], p[1], p[2]);
  else
    return certain_orientation(p[0], p[1], p[2], p[3]);
}

/// +1 if e is strictly inside the circumball of the positively oriented simplex p. The value is the negative power of
/// e times the simplex's determinant; `size` receives M, the largest coordinate difference to e.
inline SignedValue certain_in_circumball(const std::array<Vec<2>, 3>& p, const Vec<2>& e, double& size) {
  const Vec<2> a = p[0] - e, b = p[1] - e, c = p[2] - e;
  const double mx = std::max({std::abs(a[0]), std::abs(b[0]), std::abs(c[0])});
  const double my = std::max({std::abs(a[1]), std::abs(b[1]), std::abs(c[1])});
  size = std::max(mx, my);
  const double det = norm_sq(a) * (b[0] * c[1] - b[1] * c[0]) + norm_sq(b) * (c[0] * a[1] - c[1] * a[0]) +
                     norm_sq(c) * (a[0] * b[1] - a[1] * b[0]);
  if (std::min(mx, my) > kTiny && size < kHuge && std::abs(det) > 1.6e-14 * mx * my * size * size)
    return {det > 0 ? 1 : -1, det};
  return {in_circumball(p[0], p[1], p[2], e), det};
}

inline SignedValue certain_in_circumball(const std::array<Vec<3>, 4>& p, const Vec<3>& e, double& size) {
  const Vec<3> a = p[0] - e, b = p[1] - e, c = p[2] - e, d = p[3] - e;
  Vec<3> m;
  for (int k = 0; k < 3; ++k) m[k] = std::max({std::abs(a[k]), std::abs(b[k]), std::abs(c[k]), std::abs(d[k])});
  size = std::max({m[0], m[1], m[2]});
  const double ab = a[0] * b[1] - b[0] * a[1], bc = b[0] * c[1] - c[0] * b[1], cd = c[0] * d[1] - d[0] * c[1];
  const double da = d[0] * a[1] - a[0] * d[1], ac = a[0] * c[1] - c[0] * a[1], bd = b[0] * d[1] - d[0] * b[1];
  const double abc = a[2] * bc - b[2] * ac + c[2] * ab, bcd = b[2] * cd - c[2] * bd + d[2] * bc;
  const double cda = c[2] * da + d[2] * ac + a[2] * cd, dab = d[2] * ab + a[2] * bd + b[2] * da;
  const double det = (norm_sq(c) * dab - norm_sq(d) * abc) + (norm_sq(a) * bcd - norm_sq(b) * cda);
  if (std::min({m[0], m[1], m[2]}) > kTiny && size < kHuge &&
      std::abs(det) > 1.5e-13 * m[0] * m[1] * m[2] * size * size)
    return {det > 0 ? 1 : -1, det};
  return {in_circumball(p[0], p[1], p[2], p[3], e), det};
}

/// Circumcenter and circumradius of a simplex, in double-double arithmetic where double precision does not suffice.
template <int D>
struct Circumball {
  Vec<D> center;
  Vec<D> offset;  ///< From corner 0 to the center, before the center is rounded to the coordinates' grid.
  double radius;
  double error;                           ///< Bound on the distance between `center` and the true circumcenter.
  std::array<double, D + 1> barycentric;  ///< Of the center: negative i means beyond the face opposite to corner i.
  double determinant;                     ///< D! times the simplex's measure.
};

/// `p` must be positively oriented.
template <int D>
Circumball<D> circumball(const std::array<Vec<D>, D + 1>& p);

/// Barycentric coordinates of two points at once.
template <int D>
std::array<std::array<double, D + 1>, 2> barycentric(const std::array<Vec<D>, D + 1>& p, const Vec<D>& x,
                                                     const Vec<D>& y);

/// Distance of `corner` from the plane of the opposite face.
template <int D>
double height(const std::array<Vec<D>, D + 1>& p, std::size_t corner);

/// The smallest ball through two or three points: center, squared radius and an error bound of the center.
template <int D>
struct DiametralBall {
  Vec<D> center;
  double radius_sq = 0;
  double error = 0;
  bool degenerate = false;  ///< The corners of a triangle are collinear, or those of an edge equal.
};
template <int D>
DiametralBall<D> diametral_ball(const Vec<D>& a, const Vec<D>& b);
DiametralBall<3> diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c);

/// The normal of a simplex's face that points to the corner `inside`, as long as twice the face's measure (in the
/// plane: as the edge). Its side is exact: simplices may be flat but for rounding.
inline Vec<2> inward_normal(const std::array<Vec<2>, 2>& face, const Vec<2>& inside) {
  const Vec<2> normal = {face[0][1] - face[1][1], face[1][0] - face[0][0]};
  return certain_orientation(face[0], face[1], inside).sign < 0 ? -normal : normal;
}
inline Vec<3> inward_normal(const std::array<Vec<3>, 3>& face, const Vec<3>& inside) {
  const Vec<3> normal = cross(face[1] - face[0], face[2] - face[0]);
  return certain_orientation(face[0], face[1], face[2], inside).sign < 0 ? -normal : normal;
}

}  // namespace voropack::judge
