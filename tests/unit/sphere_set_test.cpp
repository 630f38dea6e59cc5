// Conflict and ball queries against all pairs; the maximal independent set against the sequential pass; lattices
// against their definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/random.h"
#include "spheres/independent_set.h"
#include "spheres/lattice.h"
#include "spheres/sphere_set.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

using test::random_point;

/// A Lipschitz function that spans three orders of magnitude over the unit box.
template <int K>
double graded(const Vec<K>& x, double b) {
  return 0.001 + b * norm(x);
}

template <int K>
void conflicts_are_those_of_all_pairs(double b) {
  Random random(1);
  SphereSet<K> set(random_point<K>(random), b, 0.01);
  int n_conflicts = 0;
  for (int i = 0; i < 600; ++i) {
    Vec<K> x = random_point<K>(random);
    if (i % 2 == 0) x *= 0.05;  // Many near the corner, where spheres are small.
    const double f = graded(x, b);
    bool expected = false;
    for (const Ball<K>& s : set.spheres()) expected = expected || distance(s.center, x) < s.radius + f;
    ASSERT_EQ(set.conflicts(x, f), expected);
    n_conflicts += expected ? 1 : 0;
    if (!expected || i % 7 == 0) set.add({x, f});
  }
  EXPECT_GT(n_conflicts, 20);
  EXPECT_LT(n_conflicts, 600);
}
TEST(SphereSet, ConflictsAreThoseOfAllPairs) {
  conflicts_are_those_of_all_pairs<1>(0.05);
  conflicts_are_those_of_all_pairs<2>(0.05);
  conflicts_are_those_of_all_pairs<3>(0.05);
  conflicts_are_those_of_all_pairs<3>(0.4);
}

/// True where one sphere is in the way of all, no matter where it is found; and then each of them conflicts.
TEST(SphereSet, TouchingSpheresDoNotConflict) {
  SphereSet<3> set({}, 0, 0.1);
  set.add({{0, 0, 0}, 0.1});
  EXPECT_FALSE(set.conflicts({0.2, 0, 0}, 0.1));
  EXPECT_TRUE(set.conflicts({0.2 * (1 - 1e-9), 0, 0}, 0.1));
}

template <int K>
void covers_what_it_says() {
  const double b = 0.2;
  Random random(2);
  SphereSet<K> set({}, b, 0.01);
  for (int i = 0; i < 100; ++i) {
    const Vec<K> x = random_point<K>(random);
    if (!set.conflicts(x, graded(x, b))) set.add({x, graded(x, b)});
  }
  int n_covered = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec<K> m = random_point<K>(random);
    const double f = graded(m, b), r = f * random.unit();
    bool expected = false;
    for (const Ball<K>& q : set.spheres()) expected = expected || distance(m, q.center) + (1 + b) * r < q.radius + f;
    ASSERT_EQ(set.covers(m, r, f, b), expected);
    if (!expected) continue;
    ++n_covered;
    // The promise itself: no point of the ball can be added.
    for (int j = 0; j < 20; ++j) {
      Vec<K> d = random_point<K>(random, -1, 1);
      if (norm(d) > 1) d = d / norm(d);
      EXPECT_TRUE(set.conflicts(m + r * d, graded(m + r * d, b)));
    }
  }
  EXPECT_GT(n_covered, 50);
}
TEST(SphereSet, CoversWhatItSays) {
  covers_what_it_says<2>();
  covers_what_it_says<3>();
}

template <int K>
void balls_hold_what_all_balls_hold() {
  Random random(3);
  BallSet<K> set(random_point<K>(random));
  std::vector<Ball<K>> balls;
  for (int i = 0; i < 80; ++i) {
    balls.push_back({random_point<K>(random), std::pow(10, -3 * random.unit()) * 0.3});
    set.add(balls.back());
  }
  int inside = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec<K> x = random_point<K>(random, -0.2, 1.2);
    const double r = 0.05 * random.unit();
    bool forbidden = false, covered = false;
    for (const Ball<K>& b : balls) {
      forbidden = forbidden || distance_sq(x, b.center) <= b.radius * b.radius * (1 + kBallMargin);
      covered = covered || distance(x, b.center) + r < b.radius;
    }
    ASSERT_EQ(set.forbids(x), forbidden);
    ASSERT_EQ(set.covers(x, r), covered);
    inside += forbidden ? 1 : 0;
  }
  EXPECT_GT(inside, 50);
  EXPECT_LT(inside, 990);
}
TEST(BallSet, HoldsWhatAllBallsHold) {
  balls_hold_what_all_balls_hold<1>();
  balls_hold_what_all_balls_hold<2>();
  balls_hold_what_all_balls_hold<3>();
}

TEST(BallSet, KeepsAMarginAroundABall) {
  BallSet<2> set({});
  set.add({{0, 0}, 1});
  EXPECT_TRUE(set.forbids({1, 0}));
  EXPECT_TRUE(set.forbids({1 + 0.4 * kBallMargin, 0}));
  EXPECT_FALSE(set.forbids({1 + 0.6 * kBallMargin, 0}));
}

template <int K>
void lattice_has_its_distance_and_covering_radius() {
  using Family = LatticeFamily<K>;
  const Family family(Vec<K>{}, 0.1, 0.1, 5);
  for (const int cls : {0, 1}) {
    const double s = family.side(cls);
    Box<K> box;
    for (int k = 0; k < K; ++k) {
      box.lo[k] = -0.6;
      box.hi[k] = 0.7;
    }
    std::vector<Vec<K>> points;
    family.visit(cls, box, [&](const Vec<K>& x) { points.push_back(x); });
    double least = 1e300;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) least = std::min(least, distance(points[i], points[j]));
    EXPECT_NEAR(least, Family::kDistance * s, 3 * Family::kJitter * s);
    Random random(4);
    double farthest = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec<K> x = random_point<K>(random, -0.6 + s, 0.7 - s);
      double nearest = 1e300;
      for (const Vec<K>& p : points) nearest = std::min(nearest, distance(x, p));
      farthest = std::max(farthest, nearest);
    }
    EXPECT_LE(farthest, Family::kCovering * s * (1 + 1e-5));
    EXPECT_GE(farthest, Family::kCovering * s * 0.9);
  }
}
TEST(Lattice, HasItsDistanceAndCoveringRadius) {
  lattice_has_its_distance_and_covering_radius<2>();
  lattice_has_its_distance_and_covering_radius<3>();
}

/// A class carries a maximal packing for every f of the range that it is chosen for.
template <int K>
void class_for_gives_maximal_packings() {
  using Family = LatticeFamily<K>;
  const Family family(Vec<K>{}, 1, 1, 5);
  EXPECT_EQ(family.class_for(1, 1), 0);
  Random random(6);
  int found = 0;
  for (int i = 0; i < 1000; ++i) {
    const double lo = std::pow(10, -2 * random.unit()), hi = lo * (1 + 0.1 * random.unit());
    const auto cls = family.class_for(lo, hi);
    if (!cls) continue;
    ++found;
    const double s = family.side(*cls), jitter = 2 * Family::kJitter * s;
    EXPECT_GE(Family::kDistance * s - jitter, 2 * hi);
    EXPECT_LT(Family::kCovering * s + jitter, 2 * lo);
  }
  EXPECT_GT(found, 500);
  EXPECT_FALSE(family.class_for(0.5, 0.9)) << "no lattice serves such a range";
}
TEST(Lattice, ClassForGivesMaximalPackings) {
  class_for_gives_maximal_packings<2>();
  class_for_gives_maximal_packings<3>();
}

/// Cells that tile a box share out its lattice points.
TEST(Lattice, BoxesThatTileShareOutThePoints) {
  const LatticeFamily<3> family({0.1, 0.2, 0.3}, 0.1, 0.1, 5);
  std::vector<Vec<3>> whole, parts;
  family.visit(0, {{-1, -1, -1}, {1, 1, 1}}, [&](const Vec<3>& x) { whole.push_back(x); });
  for (unsigned i = 0; i < 8; ++i) {
    Box<3> box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = (i >> k & 1U) != 0 ? 0.25 : -1;
      box.hi[k] = (i >> k & 1U) != 0 ? 1 : 0.25;
    }
    family.visit(0, box, [&](const Vec<3>& x) { parts.push_back(x); });
  }
  std::sort(whole.begin(), whole.end());
  std::sort(parts.begin(), parts.end());
  EXPECT_GT(whole.size(), 100U);
  EXPECT_EQ(whole, parts);
}

}  // namespace
}  // namespace voropack
