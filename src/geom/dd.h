// Error-free transformations of doubles, and double-double numbers built from them.
#pragma once

#include <cmath>

namespace voropack {

/// A sum hi + lo of two doubles without overlap.
struct Dd {
  double hi = 0, lo = 0;

  constexpr Dd() = default;
  constexpr Dd(double x) : hi(x) {}  // NOLINT: a double is a Dd, as an int is a double.
  constexpr Dd(double h, double l) : hi(h), lo(l) {}
};

/// Every operation on Dd below is within this of the exact result, relatively ([Joldes2017]: at most 8 u^2 + O(u^3),
/// u = 2^-53), barring overflow and underflow.
inline constexpr double kDdUnit = 0x1.0p-102;

/// hi + lo = a + b exactly [Knuth].
constexpr Dd two_sum(double a, double b) {
  const double s = a + b;
  const double bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}

/// hi + lo = a + b exactly, given |a| >= |b| or a == 0 [Dekker1971].
constexpr Dd fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

constexpr Dd two_diff(double a, double b) {
  const double s = a - b;
  const double bb = s - a;
  return {s, (a - (s - bb)) - (b + bb)};
}

/// x as the sum of two numbers of at most 26 bits [Veltkamp]. |x| < 2^996.
constexpr Dd split(double x) {
  const double c = 0x1.0000002p27 * x;
  const double hi = c - (c - x);
  return {hi, x - hi};
}

/// hi + lo = a * b exactly [Dekker1971], barring underflow. `sb` is split(b).
constexpr Dd two_prod(double a, double b, Dd sb) {
  const double p = a * b;
  const Dd sa = split(a);
  return {p, ((sa.hi * sb.hi - p) + sa.hi * sb.lo + sa.lo * sb.hi) + sa.lo * sb.lo};
}

constexpr Dd two_prod(double a, double b) { return two_prod(a, b, split(b)); }

constexpr Dd operator-(Dd a) { return {-a.hi, -a.lo}; }

constexpr Dd operator+(Dd a, Dd b) {
  const Dd s = two_sum(a.hi, b.hi);
  const Dd t = two_sum(a.lo, b.lo);
  const Dd v = fast_two_sum(s.hi, s.lo + t.hi);
  return fast_two_sum(v.hi, t.lo + v.lo);
}

constexpr Dd operator-(Dd a, Dd b) { return a + -b; }

constexpr Dd operator*(Dd a, Dd b) {
  const Dd p = two_prod(a.hi, b.hi);
  return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

constexpr Dd operator/(Dd a, Dd b) {
  // Long division: three quotients of doubles, each of the exact remainder so far.
  const double q0 = a.hi / b.hi;
  const Dd r0 = a - b * Dd(q0);
  const double q1 = r0.hi / b.hi;
  const Dd r1 = r0 - b * Dd(q1);
  return Dd(q0, 0) + Dd(q1, 0) + Dd(r1.hi / b.hi, 0);
}

constexpr double to_double(Dd a) { return a.hi + a.lo; }
constexpr double to_double(double a) { return a; }
constexpr int sign(Dd a) { return a.hi > 0 ? 1 : a.hi < 0 ? -1 : 0; }

inline Dd sqrt(Dd a) {
  if (!(a.hi > 0)) return 0.0;
  // One Newton step for 1/sqrt, in the form of [Karp1997].
  const double x = 1 / std::sqrt(a.hi);
  const double ax = a.hi * x;
  return two_sum(ax, to_double(a - two_prod(ax, ax)) * (x * 0.5));
}

}  // namespace voropack
