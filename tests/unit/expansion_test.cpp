// Expansions and double-doubles against rational arithmetic.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "geom/circumcenter.h"
#include "geom/expansion.h"
#include "support/rational.h"

namespace voropack {
namespace {

using test::Rational;

Rational value(const Expansion& e) {
  Rational sum = 0;
  for (const double term : e.terms()) sum += Rational(term);
  return sum;
}

Rational value(Dd a) { return Rational(Rational(a.hi) + Rational(a.lo)); }

double random_number(Random& random) {
  return std::ldexp(2 * random.unit() - 1, static_cast<int>(random.bits() % 80) - 40);
}

TEST(Expansion, SumsAndProductsAreExact) {
  Random random(1);
  for (int round = 0; round < 40; ++round) {
    Expansion e = 1.0, f = 1.0;
    Rational re = 1, rf = 1;
    for (int step = 0; step < 4; ++step) {
      const double x = random_number(random), y = random_number(random);
      e = e * Expansion(x) + f;
      re = re * Rational(x) + rf;
      f = f - e * Expansion(y);
      rf = rf - re * Rational(y);
      if (step % 4 == 3) {
        e = e * f;
        re = re * rf;
      }
    }
    EXPECT_EQ(value(e), re);
    EXPECT_EQ(sign(e), sgn(re));
    EXPECT_EQ(value(e - e), 0);
    EXPECT_EQ((e - e).terms().size(), 0U);
    const Rational error = value(e.approximate()) - re;
    EXPECT_LE(abs(error), abs(re) * Rational(kDdUnit));
  }
}

TEST(Expansion, CopiesAndMovesOfLongOnesKeepTheValue) {
  // Terms 200 binary orders apart cannot be compressed.
  Expansion e;
  for (int k = 0; k < 60; ++k) e = e + Expansion(std::ldexp(1.0, 16 * 60 - 16 * 2 * k - 100));
  Expansion copy = e;
  Expansion moved = std::move(copy);
  EXPECT_EQ(value(moved), value(e));
  Expansion short_one = 3.0;
  moved = short_one;
  EXPECT_EQ(value(moved), 3);
  moved = Expansion(5.0);
  EXPECT_EQ(value(moved), 5);
}

TEST(Dd, OperationsAreWithinTheirUnit) {
  Random random(2);
  for (int round = 0; round < 500; ++round) {
    const Dd a = two_sum(random_number(random), 1e-17 * random_number(random));
    const Dd b = two_sum(random_number(random), 1e-17 * random_number(random));
    const Rational ra = value(a), rb = value(b);
    const auto near = [](Dd got, const Rational& expected) {
      return abs(value(got) - expected) <= abs(expected) * Rational(kDdUnit);
    };
    EXPECT_TRUE(near(a + b, ra + rb));
    EXPECT_TRUE(near(a - b, ra - rb));
    EXPECT_TRUE(near(a * b, ra * rb));
    EXPECT_TRUE(near(a / b, ra / rb));
  }
}

TEST(Circumcenter, IsAccurateForSlivers) {
  Random random(3);
  for (const double flat : {1.0, 1e-5, 1e-10, 1e-14}) {
    std::array<Vec<3>, 4> p = {Vec<3>{0, 0, 0}, Vec<3>{1, 0, 0}, Vec<3>{1, 1, 0}, Vec<3>{0, 1, 0}};
    for (Vec<3>& x : p)
      for (int k = 0; k < 3; ++k) x[k] += flat * (random.unit() - 0.5);
    const auto expected = test::exact_circumcenter<3, 4>(p);
    const Vec<3> center = circumcenter<3>(p);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(center[k], expected[static_cast<std::size_t>(k)].get_d(), 1e-12);
    std::array<std::array<Rational, 3>, 3> m;
    for (std::size_t k = 0; k < 3; ++k) m[k] = test::minus(test::exact(p[k + 1]), test::exact(p[0]));
    const double determinant = test::determinant(m).get_d();
    EXPECT_NEAR(simplex_determinant<3>(p), determinant, 1e-13 * std::abs(determinant));
  }
}

TEST(Circumcenter, OfAFlatSimplexIsNan) {
  EXPECT_TRUE(std::isnan(circumcenter<2>({Vec<2>{0, 0}, Vec<2>{0.1, 0.1}, Vec<2>{0.3, 0.3}})[0]));
  EXPECT_EQ(simplex_determinant<2>({Vec<2>{0, 0}, Vec<2>{0.1, 0.1}, Vec<2>{0.3, 0.3}}), 0);
}

}  // namespace
}  // namespace voropack
