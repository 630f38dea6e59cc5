// The predicates against rational arithmetic: random, nearly degenerate and exactly degenerate input.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "geom/predicates.h"
#include "support/rational.h"

namespace voropack {
namespace {

using test::determinant;
using test::exact;
using test::exact_circumcenter;
using test::inner;
using test::minus;
using test::Rational;

template <int D, std::size_t N>
int exact_orientation(const std::array<Vec<D>, N>& p) {
  std::array<std::array<Rational, D>, D> m;
  for (std::size_t k = 0; k < D; ++k) m[k] = minus(exact(p[k + 1]), exact(p[0]));
  return sgn(determinant(m));
}

/// Of e against the smallest sphere through p: in the affine hull of p, so it serves for circum- and diametral balls.
template <int D, std::size_t N>
int exact_in_ball(const std::array<Vec<D>, N>& p, const Vec<D>& e) {
  const auto center = exact_circumcenter<D, N>(p);
  const auto to_sphere = minus(exact(p[0]), center), to_e = minus(exact(e), center);
  return sgn(Rational(inner(to_sphere, to_sphere) - inner(to_e, to_e)));
}

/// Inputs of growing malice: `noise` 1 is random, 1e-16 nearly and 0 exactly degenerate.
class Points {
 public:
  explicit Points(std::uint64_t seed) : random_(seed) {}

  template <int D>
  Vec<D> noisy(Vec<D> p, double noise) {
    for (int k = 0; k < D; ++k) p[k] += noise * (2 * random_.unit() - 1);
    return p;
  }
  template <int D>
  Vec<D> grid_point() {
    Vec<D> p;
    for (int k = 0; k < D; ++k) p[k] = 0.1 * static_cast<double>(random_.bits() % 4);
    return p;
  }

 private:
  Random random_;
};

constexpr std::array kNoises = {1.0, 1e-3, 1e-9, 1e-15, 1e-17, 0.0};
constexpr int kRounds = 60;

TEST(Predicates, OrientationIsThatOfRationalArithmetic) {
  Points points(1);
  int n_zero = 0;
  for (const double noise : kNoises) {
    for (int round = 0; round < kRounds; ++round) {
      std::array<Vec<3>, 4> p;
      for (Vec<3>& x : p) x = points.noisy(points.grid_point<3>(), noise);
      const int expected = exact_orientation(p);
      EXPECT_EQ(orientation(p[0], p[1], p[2], p[3]), expected);
      EXPECT_EQ(orientation(p[1], p[0], p[2], p[3]), -expected);
      std::array<Vec<2>, 3> q;
      for (Vec<2>& x : q) x = points.noisy(points.grid_point<2>(), noise);
      EXPECT_EQ(orientation(q[0], q[1], q[2]), exact_orientation(q));
      n_zero += expected == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(n_zero, 5) << "no degenerate case was tried";
}

TEST(Predicates, InCircumballIsThatOfRationalArithmetic) {
  Points points(2);
  int n_zero = 0;
  for (const double noise : kNoises) {
    for (int round = 0; round < kRounds; ++round) {
      std::array<Vec<3>, 4> p;
      for (Vec<3>& x : p) x = points.noisy(points.grid_point<3>(), noise);
      if (exact_orientation(p) < 0) std::swap(p[0], p[1]);
      const Vec<3> e = points.noisy(points.grid_point<3>(), noise);
      if (exact_orientation(p) > 0) {
        const int expected = exact_in_ball(p, e);
        EXPECT_EQ(in_circumball(p[0], p[1], p[2], p[3], e), expected);
        n_zero += expected == 0 ? 1 : 0;
      }
      std::array<Vec<2>, 3> q;
      for (Vec<2>& x : q) x = points.noisy(points.grid_point<2>(), noise);
      if (exact_orientation(q) < 0) std::swap(q[0], q[1]);
      const Vec<2> f = points.noisy(points.grid_point<2>(), noise);
      if (exact_orientation(q) > 0) {
        EXPECT_EQ(in_circumball(q[0], q[1], q[2], f), exact_in_ball(q, f));
      }
    }
  }
  EXPECT_GT(n_zero, 3) << "no degenerate case was tried";
}

TEST(Predicates, InDiametralBallIsThatOfRationalArithmetic) {
  Points points(3);
  int n_zero = 0;
  for (const double noise : kNoises) {
    for (int round = 0; round < kRounds; ++round) {
      std::array<Vec<3>, 3> p;
      for (Vec<3>& x : p) x = points.noisy(points.grid_point<3>(), noise);
      const Vec<3> e = points.noisy(points.grid_point<3>(), noise);
      if (p[0] != p[1]) {
        const int expected = exact_in_ball<3, 2>({p[0], p[1]}, e);
        EXPECT_EQ(in_diametral_ball(p[0], p[1], e), expected);
        n_zero += expected == 0 ? 1 : 0;
      }
      const auto u = minus(exact(p[1]), exact(p[0])), v = minus(exact(p[2]), exact(p[0]));
      const auto n = test::outer(u, v);
      if (inner(n, n) != 0) {
        EXPECT_EQ(in_diametral_ball(p[0], p[1], p[2], e), exact_in_ball(p, e));
      }
      std::array<Vec<2>, 3> q;
      for (Vec<2>& x : q) x = points.noisy(points.grid_point<2>(), noise);
      if (q[0] != q[1]) {
        EXPECT_EQ(in_diametral_ball(q[0], q[1], q[2]), (exact_in_ball<2, 2>({q[0], q[1]}, q[2])));
      }
    }
  }
  EXPECT_GT(n_zero, 5) << "no degenerate case was tried";
}

TEST(Predicates, AreExactFarFromTheOrigin) {
  // One ulp at 1e6 decides.
  const Vec<2> a = {1e6, 1e6}, b = {1e6 + 1, 1e6 + 1}, c = {1e6 + 2, 1e6 + 2};
  EXPECT_EQ(orientation(a, b, c), 0);
  EXPECT_EQ(orientation(a, b, Vec<2>{c[0], std::nextafter(c[1], 2e6)}), 1);
  EXPECT_EQ(orientation(a, b, Vec<2>{c[0], std::nextafter(c[1], 0)}), -1);
}

}  // namespace
}  // namespace voropack
