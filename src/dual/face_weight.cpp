#include "dual/face_weight.h"

#include <cmath>
#include <limits>
#include <tuple>

#include "geom/expansion.h"
#include "geom/number_vec.h"

// With a, b, c the corners of the face, all relative to a, and n = b x c, O_d = n.d, O_e = n.e (docs/theory/dual.md):
//
//   interior   q = I / (2 O_d (-O_e)),      I = |e|^2 O_d - |d|^2 O_e + |c|^2 b.(d x e) - |b|^2 c.(d x e)
//   boundary   q = P / (2 |n|^2 O_d),       P = |d|^2 |n|^2 - d.(|b|^2 (c x n) + |c|^2 (n x b))
//
// and in 2D, for the edge ab with the triangles abd and bae:
//
//   interior   q = I / (2 O_d (-O_e)),      I = |e|^2 O_d - |d|^2 O_e + |b|^2 (d x e), O_d = b x d, O_e = b x e
//   boundary   q = P / (2 O_d),             P = |d|^2 - b.d
//
// Each polynomial is evaluated in double with a bound of its error, then in double-double, then exactly.

namespace voropack {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kUnit = 0x1.0p-53;  // The largest relative error of one operation on doubles.

template <int D>
using Face = std::array<Vec<D>, D>;

/// The simplices' corners off the face: above and below for an interior face, above alone for a boundary face.
template <int D, std::size_t N>
using Apexes = std::array<Vec<D>, N>;

/// q = numerator / (2 above below), and the squared lengths |b|^2, |c|^2, |d|^2, |e|^2 that bound the errors (those
/// that there are).
template <class S, std::size_t N>
struct Quotient {
  S numerator, above, below;
  std::array<S, N> length_sq;
};

template <class S>
auto quotient(const Face<3>& face, const Apexes<3, 2>& apex) {
  const auto b = difference<S>(face[1], face[0]), c = difference<S>(face[2], face[0]);
  const auto d = difference<S>(apex[0], face[0]), e = difference<S>(apex[1], face[0]);
  const auto n = cross<S>(b, c), w = cross<S>(d, e);
  const S o_d = dot<S>(n, d), o_e = dot<S>(n, e);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c), dd = dot<S>(d, d), ee = dot<S>(e, e);
  return Quotient<S, 4>{(ee * o_d - dd * o_e) + (cc * dot<S>(b, w) - bb * dot<S>(c, w)), o_d, -o_e, {bb, cc, dd, ee}};
}

template <class S>
auto quotient(const Face<2>& face, const Apexes<2, 2>& apex) {
  const auto b = difference<S>(face[1], face[0]);
  const auto d = difference<S>(apex[0], face[0]), e = difference<S>(apex[1], face[0]);
  const S o_d = cross<S>(b, d), o_e = cross<S>(b, e);
  const S bb = dot<S>(b, b), dd = dot<S>(d, d), ee = dot<S>(e, e);
  return Quotient<S, 3>{(ee * o_d - dd * o_e) + bb * cross<S>(d, e), o_d, -o_e, {bb, dd, ee}};
}

template <class S>
auto quotient(const Face<3>& face, const Apexes<3, 1>& apex) {
  const auto b = difference<S>(face[1], face[0]), c = difference<S>(face[2], face[0]);
  const auto d = difference<S>(apex[0], face[0]);
  const auto n = cross<S>(b, c);
  const auto cn = cross<S>(c, n), nb = cross<S>(n, b);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c), dd = dot<S>(d, d), nn = dot<S>(n, n);
  return Quotient<S, 3>{dd * nn - (bb * dot<S>(d, cn) + cc * dot<S>(d, nb)), dot<S>(n, d), nn, {bb, cc, dd}};
}

template <class S>
auto quotient(const Face<2>& face, const Apexes<2, 1>& apex) {
  const auto b = difference<S>(face[1], face[0]), d = difference<S>(apex[0], face[0]);
  const S bb = dot<S>(b, b), dd = dot<S>(d, d);
  return Quotient<S, 2>{dd - dot<S>(b, d), cross<S>(b, d), S(1.0), {bb, dd}};
}

/// Squares of bounds of the absolute errors of a Quotient's numbers, in units of the arithmetic's relative error.
struct QuotientBound {
  double numerator_sq, above_sq, below_sq;
  double edge_sq;  ///< L^2 of FaceWeight; 1 in 2D, where q has no unit.
};

constexpr double square(double x) { return x * x; }

// The factors are derived in docs/theory/dual.md, "Error bounds", and rounded up for the rounding of the bounds.
inline QuotientBound error_bound(const Face<3>&, double b, double c, double d, double e) {
  const double bc = b * c;
  return {square(40) * (bc * (d * e) * (b + c + d + e)), square(12) * (bc * d), square(12) * (bc * e), std::max(b, c)};
}

inline QuotientBound error_bound(const Face<2>&, double b, double d, double e) {
  return {square(24) * (b * (d * e) * (b + d + e)), square(6) * (b * d), square(6) * (b * e), 1};
}

inline QuotientBound error_bound(const Face<3>&, double b, double c, double d) {
  const double bc = b * c;
  return {square(48) * (bc * bc * (d * (b + c + d))), square(12) * (bc * d), square(20 * bc), std::max(b, c)};
}

inline QuotientBound error_bound(const Face<2>&, double b, double d) {
  return {square(10) * (d * (b + d)), square(6) * (b * d), 0, 1};
}

/// q if the bounds certify its sign and its size; NaN otherwise, also after an overflow or underflow.
template <class FaceType, class S, std::size_t N>
inline double certified(const FaceType& face, const Quotient<S, N>& q, double unit) {
  const QuotientBound bound =
      std::apply([&](const auto&... x) { return error_bound(face, to_double(x)...); }, q.length_sq);
  const double numerator = to_double(q.numerator), above = to_double(q.above), below = to_double(q.below);
  const double unit_sq = unit * unit;
  const double numerator_sq = unit_sq * bound.numerator_sq;
  const double above_sq = unit_sq * bound.above_sq, below_sq = unit_sq * bound.below_sq;
  // The denominators are known to 1/8, so that the true one is at least (7/8)^2 of this one.
  const bool signs = above > 0 && below > 0 && square(above) > 64 * above_sq && square(below) > 64 * below_sq &&
                     square(numerator) > numerator_sq;
  if (!signs) return kNan;
  const double denominator = 2 * above * below;
  const double value = numerator / denominator;
  // error <= 2 (|error of numerator| / denominator + |value| (relative errors of above and below)), squared by
  // (x + y + z)^2 <= 3 (x^2 + y^2 + z^2) and cleared of the denominator.
  const double error_sq =
      12 * (numerator_sq + 4 * square(value) * (above_sq * square(below) + below_sq * square(above)));
  return error_sq * bound.edge_sq < square(kFaceWeightError) * square(denominator) ? value : kNan;
}

/// The quotient of exact numbers. NaN if a simplex is not on its side of the face.
template <std::size_t N>
Dd divide(const Quotient<Expansion, N>& q) {
  if (sign(q.above) <= 0 || sign(q.below) <= 0) return kNan;
  return q.numerator.approximate() / (Dd(2.0) * q.above.approximate() * q.below.approximate());
}

/// Face and apexes brought to about unit size. In 3D q is one over a length: q = q(scaled) * scale. In 2D it has no
/// unit.
template <int D, std::size_t N>
struct Scaled {
  double q_scale;
  Face<D> face;
  Apexes<D, N> apex;

  Scaled(const Face<D>& f, const Apexes<D, N>& a) : face(f), apex(a) {
    const double scale = std::min(unit_scale(f, f[0]), unit_scale(a, f[0]));
    q_scale = D == 3 ? scale : 1;
    for (Vec<D>& p : face) p *= scale;
    for (Vec<D>& p : apex) p *= scale;
  }
};

template <int D, std::size_t N>
[[gnu::noinline]] FaceWeight careful_weight(const Face<D>& face, const Apexes<D, N>& apex) {
  const Scaled<D, N> unit(face, apex);
  double value = certified(unit.face, quotient<Dd>(unit.face, unit.apex), kDdUnit);
  if (std::isnan(value)) value = to_double(divide(quotient<Expansion>(unit.face, unit.apex)));
  return {value * unit.q_scale, true};
}

template <int D, std::size_t N>
inline FaceWeight weight(const Face<D>& face, const Apexes<D, N>& apex) {
  const double fast = certified(face, quotient<double>(face, apex), kUnit);
  if (!std::isnan(fast)) return {fast, false};
  return careful_weight<D>(face, apex);
}

template <int D, std::size_t N>
Dd exact_weight(const Face<D>& face, const Apexes<D, N>& apex) {
  const Scaled<D, N> unit(face, apex);
  const Dd q = divide(quotient<Expansion>(unit.face, unit.apex));
  return {q.hi * unit.q_scale, q.lo * unit.q_scale};
}

}  // namespace

template <int D>
FaceWeight interior_weight(const Face<D>& face, const Vec<D>& above, const Vec<D>& below) {
  return weight<D>(face, Apexes<D, 2>{above, below});
}

template <int D>
FaceWeight boundary_weight(const Face<D>& face, const Vec<D>& above) {
  return weight<D>(face, Apexes<D, 1>{above});
}

template <int D>
Dd exact_interior_weight(const Face<D>& face, const Vec<D>& above, const Vec<D>& below) {
  return exact_weight<D>(face, Apexes<D, 2>{above, below});
}

template <int D>
Dd exact_boundary_weight(const Face<D>& face, const Vec<D>& above) {
  return exact_weight<D>(face, Apexes<D, 1>{above});
}

template FaceWeight interior_weight<2>(const Face<2>&, const Vec<2>&, const Vec<2>&);
template FaceWeight interior_weight<3>(const Face<3>&, const Vec<3>&, const Vec<3>&);
template FaceWeight boundary_weight<2>(const Face<2>&, const Vec<2>&);
template FaceWeight boundary_weight<3>(const Face<3>&, const Vec<3>&);
template Dd exact_interior_weight<2>(const Face<2>&, const Vec<2>&, const Vec<2>&);
template Dd exact_interior_weight<3>(const Face<3>&, const Vec<3>&, const Vec<3>&);
template Dd exact_boundary_weight<2>(const Face<2>&, const Vec<2>&);
template Dd exact_boundary_weight<3>(const Face<3>&, const Vec<3>&);

}  // namespace voropack
