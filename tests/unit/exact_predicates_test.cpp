#include "geom/exact_predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/random.h"
#include "geom/filtered_predicates.h"
#include "geom/predicates.h"

namespace voropack {
namespace {

/// Points of a lattice, exact or with rounded coordinates, some moved by one unit in the last place, so that most
/// determinants are zero or nearly so.
template <int K>
std::array<Vec<K>, 5> nearly_degenerate_points(Random& random, double step, double offset) {
  std::array<Vec<K>, 5> points;
  for (Vec<K>& p : points)
    for (int k = 0; k < K; ++k) {
      p[k] = offset + step * static_cast<double>(random.bits() % 3);
      if (random.bits() % 8 == 0) p[k] = std::nextafter(p[k], random.bits() % 2 == 0 ? -1e300 : 1e300);
    }
  return points;
}

struct Count {
  int zero = 0;
  int other = 0;
  void add(int sign) { ++(sign == 0 ? zero : other); }
};

class ExactPredicates : public testing::Test {
 protected:
  template <int K, class Check>
  void for_degenerate_points(Check&& check) {
    Random random(1);
    for (const auto& [step, offset] : {std::array{1.0, 0.0}, std::array{0.1, 7.0}, std::array{0.1, 0.0},
                                       std::array{1e-7, 1.0}, std::array{1e-60, 0.0}, std::array{1e60, 0.0}})
      for (int i = 0; i < 2000; ++i) check(nearly_degenerate_points<K>(random, step, offset));
    EXPECT_GT(count_.zero, 1000);
    EXPECT_GT(count_.other, 1000);
  }
  Count count_;
};

TEST_F(ExactPredicates, AgreeWithCgalIn2D) {
  FilteredPredicates<2> filtered;
  for_degenerate_points<2>([&](const std::array<Vec<2>, 5>& p) {
    const int o = orientation(p[0], p[1], p[2]);
    count_.add(o);
    ASSERT_EQ(orientation_exact(p[0], p[1], p[2]), o);
    ASSERT_EQ(filtered.orientation(p[0], p[1], p[2]), o);
    const int side = in_circumball(p[0], p[1], p[2], p[3]);
    count_.add(side);
    ASSERT_EQ(in_circumball_exact(p[0], p[1], p[2], p[3]), side);
    ASSERT_EQ(filtered.in_circumball(p[0], p[1], p[2], p[3]), side);
  });
}

TEST_F(ExactPredicates, AgreeWithCgalIn3D) {
  FilteredPredicates<3> filtered;
  for_degenerate_points<3>([&](const std::array<Vec<3>, 5>& p) {
    const int o = orientation(p[0], p[1], p[2], p[3]);
    count_.add(o);
    ASSERT_EQ(orientation_exact(p[0], p[1], p[2], p[3]), o);
    ASSERT_EQ(filtered.orientation(p[0], p[1], p[2], p[3]), o);
    const int side = in_circumball(p[0], p[1], p[2], p[3], p[4]);
    count_.add(side);
    ASSERT_EQ(in_circumball_exact(p[0], p[1], p[2], p[3], p[4]), side);
    ASSERT_EQ(filtered.in_circumball(p[0], p[1], p[2], p[3], p[4]), side);
  });
}

TEST_F(ExactPredicates, StaticFilterAgreesToo) {
  FilteredPredicates<3> filtered;
  filtered.set_box(Box<3>({0, 0, 0}, {1, 1, 1}));
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    std::array<Vec<3>, 5> p;
    for (Vec<3>& q : p) q = {random.unit(), random.unit(), 0.5 + std::ldexp(random.unit(), -(i % 60))};
    ASSERT_EQ(filtered.orientation(p[0], p[1], p[2], p[3]), orientation(p[0], p[1], p[2], p[3]));
    ASSERT_EQ(filtered.in_circumball(p[0], p[1], p[2], p[3], p[4]), in_circumball(p[0], p[1], p[2], p[3], p[4]));
  }
}

TEST_F(ExactPredicates, HandleCoordinatesThatDoNotFitIntegers) {
  const Vec<3> a{0, 0, 1e-200}, b{1, 0, 0}, c{0, 1, 0}, d{0.5, 0.5, 1e-250};
  EXPECT_EQ(orientation_exact(a, b, c, d), orientation(a, b, c, d));
  EXPECT_NE(orientation_exact(a, b, c, d), 0);
  EXPECT_EQ(orientation_exact(a, b, c, Vec<3>{0, 0, 1}), 1);
}

}  // namespace
}  // namespace voropack
