#include "certificate/geometry.h"

#include <algorithm>

namespace voropack::judge {

namespace {

/// An unevaluated sum of two doubles: 106 significant bits (Dekker 1971, Knuth's two-sum).
struct DoubleDouble {
  double hi = 0;
  double lo = 0;

  DoubleDouble() = default;
  DoubleDouble(double h, double l = 0) : hi(h), lo(l) {}  // NOLINT(google-explicit-constructor): a number type.

  static DoubleDouble two_sum(double a, double b) {
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
  }
  static DoubleDouble renormalized(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
  }
  friend DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = two_sum(a.hi, b.hi);
    const DoubleDouble t = two_sum(a.lo, b.lo);
    const DoubleDouble r = renormalized(s.hi, s.lo + t.hi);
    return renormalized(r.hi, r.lo + t.lo);
  }
  friend DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + DoubleDouble(-b.hi, -b.lo); }
  friend DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const double p = a.hi * b.hi;
    return renormalized(p, std::fma(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi));
  }
  friend DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
    const double q1 = a.hi / b.hi;
    const DoubleDouble r = a - b * DoubleDouble(q1);
    const double q2 = r.hi / b.hi;
    const DoubleDouble s = r - b * DoubleDouble(q2);
    return DoubleDouble(q1) + DoubleDouble(q2) + DoubleDouble(s.hi / b.hi);
  }
};

double to_double(double x) { return x; }
double to_double(DoubleDouble x) { return x.hi + x.lo; }

template <class T>
T exact_difference(double a, double b) {
  return T(a) - T(b);
}

/// Edge vectors e_k from corner 0, their cofactor vectors n_k (e_j . n_k = det if j == k, else 0) and the determinant.
template <int D, class T>
struct Frame {
  std::array<std::array<T, D>, D> e, n;
  T det{};

  explicit Frame(const std::array<Vec<D>, D + 1>& p) {
    for (std::size_t k = 0; k < D; ++k)
      for (std::size_t i = 0; i < D; ++i) e[k][i] = exact_difference<T>(p[k + 1].coord[i], p[0].coord[i]);
    if constexpr (D == 2) {
      n[0] = {e[1][1], T(0.0) - e[1][0]};
      n[1] = {T(0.0) - e[0][1], e[0][0]};
    } else {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& u = e[(k + 1) % 3];
        const auto& v = e[(k + 2) % 3];
        for (std::size_t i = 0; i < 3; ++i) n[k][i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
      }
    }
    det = inner(e[0], n[0]);
  }

  static T inner(const std::array<T, D>& a, const std::array<T, D>& b) {
    T s = a[0] * b[0];
    for (std::size_t i = 1; i < D; ++i) s = s + a[i] * b[i];
    return s;
  }
};

/// The circumcenter is p_0 + sum_k |e_k|^2 n_k / (2 det).
///
/// Error: each component of the numerator is a sum of products that passed at most 11 roundings and whose absolute
/// values sum to at most prod |e| * sum |e|; the determinant passed 8 on products below sqrt(3) prod |e|. Divided, and
/// with the norm at most sqrt(3) times a component, the offset is off by less than
/// 40 u prod |e| (sum |e| + 2 R) / (2 det), u the unit roundoff of T.
template <int D, class T>
Circumball<D> solve(const std::array<Vec<D>, D + 1>& p, double unit_roundoff) {
  const Frame<D, T> frame(p);
  std::array<T, D> offset{};
  double product = 1;  // Of lengths, as that of their squares leaves the range of doubles.
  double sum_sq = 0;   // At least (sum |e|)^2 / D.
  for (std::size_t k = 0; k < D; ++k) {
    const T square = Frame<D, T>::inner(frame.e[k], frame.e[k]);
    product *= std::sqrt(to_double(square));
    sum_sq += to_double(square);
    for (std::size_t i = 0; i < D; ++i) offset[i] = offset[i] + square * frame.n[k][i];
  }
  const T scale = T(0.5) / frame.det;
  for (std::size_t i = 0; i < D; ++i) offset[i] = offset[i] * scale;

  Circumball<D> ball;
  double largest = 0;
  for (std::size_t i = 0; i < D; ++i) {
    ball.offset.coord[i] = to_double(offset[i]);
    ball.center.coord[i] = to_double(T(p[0].coord[i]) + offset[i]);
    largest = std::max({largest, std::abs(p[0].coord[i]), std::abs(ball.center.coord[i])});
  }
  ball.radius = std::sqrt(to_double(Frame<D, T>::inner(offset, offset)));
  ball.determinant = to_double(frame.det);
  T rest = T(1.0);
  const T twice_scale = scale + scale;
  for (std::size_t k = 0; k < D; ++k) {
    const T coordinate = Frame<D, T>::inner(offset, frame.n[k]) * twice_scale;
    ball.barycentric[k + 1] = to_double(coordinate);
    rest = rest - coordinate;
  }
  ball.barycentric[0] = to_double(rest);
  const double sum = std::sqrt(D * sum_sq);
  ball.error = 40 * unit_roundoff * product * (sum + 2 * ball.radius) / (2 * std::abs(ball.determinant)) +
               4 * kUnitRoundoff * (largest + ball.radius);
  return ball;
}

/// A circumcenter whose error exceeds this fraction of the radius is computed again in double-double arithmetic.
constexpr double kEnough = 1e-11;

/// Bound for double-double operations as written above: a few times 2^-104.
constexpr double kDoubleDoubleRoundoff = 0x1p-101;

}  // namespace

template <int D>
Circumball<D> circumball(const std::array<Vec<D>, D + 1>& p) {
  const Circumball<D> ball = solve<D, double>(p, kUnitRoundoff);
  if (ball.error <= kEnough * ball.radius) return ball;
  return solve<D, DoubleDouble>(p, kDoubleDoubleRoundoff);
}

template <int D>
std::array<std::array<double, D + 1>, 2> barycentric(const std::array<Vec<D>, D + 1>& p, const Vec<D>& x,
                                                     const Vec<D>& y) {
  const Frame<D, double> frame(p);
  const std::array<Vec<D>, 2> offset = {x - p[0], y - p[0]};
  const double scale = 1 / frame.det;
  std::array<std::array<double, D + 1>, 2> result{};
  for (std::size_t i = 0; i < 2; ++i) {
    result[i][0] = 1;
    for (std::size_t k = 0; k < D; ++k) {
      result[i][k + 1] = Frame<D, double>::inner(offset[i].coord, frame.n[k]) * scale;
      result[i][0] -= result[i][k + 1];
    }
  }
  return result;
}

template <int D>
double height(const std::array<Vec<D>, D + 1>& p, std::size_t corner) {
  const Frame<D, double> frame(p);
  std::array<double, D> normal{};
  for (std::size_t k = 0; k < D; ++k)
    for (std::size_t i = 0; i < D; ++i)
      if (corner == 0 || corner == k + 1) normal[i] += frame.n[k][i];
  return std::abs(frame.det) / std::sqrt(Frame<D, double>::inner(normal, normal));
}

template <int D>
DiametralBall<D> diametral_ball(const Vec<D>& a, const Vec<D>& b) {
  DiametralBall<D> ball;
  ball.center = 0.5 * (a + b);
  ball.radius_sq = 0.25 * distance_sq(a, b);
  double largest = 0;
  for (int k = 0; k < D; ++k) largest = std::max({largest, std::abs(a[k]), std::abs(b[k])});
  ball.error = 8 * kUnitRoundoff * largest;
  ball.degenerate = a == b;
  return ball;
}

DiametralBall<3> diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const Vec<3> u = b - a, v = c - a;
  const Vec<3> n = cross(u, v);
  const double uu = norm_sq(u), vv = norm_sq(v), nn = norm_sq(n);
  DiametralBall<3> ball;
  // Nearly collinear by doubles: decide exactly, in the three coordinate planes.
  if (!(nn > 1e-20 * uu * vv)) {
    ball.degenerate = true;
    for (int k = 0; k < 3; ++k) {
      const auto flat = [k](const Vec<3>& p) { return Vec<2>{p[(k + 1) % 3], p[(k + 2) % 3]}; };
      if (orientation(flat(a), flat(b), flat(c)) != 0) ball.degenerate = false;
    }
  }
  const Vec<3> offset = (vv * cross(n, u) + uu * cross(v, n)) * (0.5 / nn);
  ball.center = a + offset;
  ball.radius_sq = norm_sq(offset);
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::max({largest, std::abs(a[k]), std::abs(ball.center[k])});
  // As for `solve`, but the normal enters twice, each time with relative error |u||v|/|n| roundings.
  ball.error = 100 * kUnitRoundoff * (std::sqrt(uu) + std::sqrt(vv) + std::sqrt(ball.radius_sq)) * (uu * vv / nn) +
               4 * kUnitRoundoff * largest;
  return ball;
}

template Circumball<2> circumball(const std::array<Vec<2>, 3>&);
template Circumball<3> circumball(const std::array<Vec<3>, 4>&);
template std::array<std::array<double, 3>, 2> barycentric(const std::array<Vec<2>, 3>&, const Vec<2>&, const Vec<2>&);
template std::array<std::array<double, 4>, 2> barycentric(const std::array<Vec<3>, 4>&, const Vec<3>&, const Vec<3>&);
template double height(const std::array<Vec<2>, 3>&, std::size_t);
template double height(const std::array<Vec<3>, 4>&, std::size_t);
template DiametralBall<2> diametral_ball(const Vec<2>&, const Vec<2>&);
template DiametralBall<3> diametral_ball(const Vec<3>&, const Vec<3>&);

}  // namespace voropack::judge
