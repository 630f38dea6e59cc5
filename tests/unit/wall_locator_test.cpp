// The wall locator against slow and obvious answers.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "geom/wall_locator.h"
#include "support/domains.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

using test::random_point;

/// Nested boxes, the i-th with region i inside, rotated; every other simplex listed the other way round.
template <int D>
struct NestedBoxes {
  std::vector<Box<D>> boxes;
  std::array<Vec<D>, D> rotation;
  Walls<D> walls;

  explicit NestedBoxes(std::uint64_t seed) : rotation(domains::generic_rotation<D>(seed)) {
    Random random(seed);
    Box<D> box(domains::all<D>(-1), domains::all<D>(1));
    for (int i = 0; i < 3; ++i) {
      boxes.push_back(box);
      const double shrink = 0.1 + 0.2 * random.unit();
      for (int k = 0; k < D; ++k) {
        box.lo[k] += shrink * random.unit() + 0.05;
        box.hi[k] -= shrink * random.unit() + 0.05;
      }
    }
    for (int i = 0; i < 3; ++i) {
      const DomainInput<D> input =
          domains::box<D>(boxes[static_cast<std::size_t>(i)].lo, boxes[static_cast<std::size_t>(i)].hi);
      const int outside = i == 0 ? Walls<D>::kOutside : i - 1;
      if constexpr (D == 2) {
        // Counterclockwise: the inside is on the left.
        for (const auto& s : input.segments) add({at(input, s.points[0]), at(input, s.points[1])}, {i, outside});
      } else {
        // Counterclockwise seen from outside: the normal points outside.
        for (const auto& f : input.facets) {
          const auto& p = f.polygons[0];
          for (std::size_t k = 2; k < p.size(); ++k)
            add({at(input, p[0]), at(input, p[k - 1]), at(input, p[k])}, {outside, i});
        }
      }
    }
  }
  Vec<D> turned(const Vec<D>& x) const {
    Vec<D> y;
    for (int k = 0; k < D; ++k) y[k] = dot(rotation[static_cast<std::size_t>(k)], x);
    return y;
  }
  Vec<D> at(const DomainInput<D>& input, std::uint32_t p) const { return turned(input.points[p]); }
  void add(std::array<Vec<D>, D> simplex, std::array<int, 2> regions) {
    if (walls.simplices.size() % 2 == 1) {
      std::swap(simplex[0], simplex[1]);
      std::swap(regions[0], regions[1]);
    }
    walls.simplices.push_back(simplex);
    walls.regions.push_back(regions);
  }
};

template <int D>
void region_is_the_innermost_box() {
  std::array<int, 4> seen{};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const NestedBoxes<D> nest(seed);
    const WallLocator<D> locator(nest.walls);
    Random random(seed + 100);
    for (int i = 0; i < 400; ++i) {
      const Vec<D> x = random_point<D>(random, -1.1, 1.1);
      int expected = Walls<D>::kOutside;
      for (std::size_t k = 0; k < nest.boxes.size(); ++k)
        if (nest.boxes[k].contains(x)) expected = static_cast<int>(k);
      ASSERT_EQ(locator.region(nest.turned(x)), expected) << "seed " << seed;
      ++seen[static_cast<std::size_t>(expected + 1)];
    }
  }
  for (const int n : seen) EXPECT_GT(n, 20);
}
TEST(WallLocator, RegionIsTheInnermostBoxInThePlane) { region_is_the_innermost_box<2>(); }
TEST(WallLocator, RegionIsTheInnermostBoxInSpace) { region_is_the_innermost_box<3>(); }

TEST(WallLocator, SideZeroIsWhereTheNormalPoints) {
  // Left of (0,0) -> (0,1) is x < 0; along (1,0,0) x (0,1,0) is z > 0. Seen along the wall's other side: region 2.
  const WallLocator<2> line({{{Vec<2>{0, -9}, Vec<2>{0, 9}},
                              {Vec<2>{-9, -9}, Vec<2>{-9, 9}},
                              {Vec<2>{9, -9}, Vec<2>{9, 9}},
                              {Vec<2>{-9, -9}, Vec<2>{0, -9}},
                              {Vec<2>{0, -9}, Vec<2>{9, -9}},
                              {Vec<2>{-9, 9}, Vec<2>{0, 9}},
                              {Vec<2>{0, 9}, Vec<2>{9, 9}}},
                             {{1, 2}, {-1, 1}, {2, -1}, {1, -1}, {2, -1}, {-1, 1}, {-1, 2}}});
  EXPECT_EQ(line.region({-0.5, 0.1}), 1);
  EXPECT_EQ(line.region({0.5, 0.1}), 2);
  EXPECT_EQ(line.region({-8.5, 8}), 1);
  EXPECT_EQ(line.region({8.5, -8}), 2);
  EXPECT_EQ(line.region({9.5, 0}), -1);
}

/// Independent of the code under test: to the edges by projection, to the inside by the foot of the perpendicular.
double plain_distance(const std::array<Vec<2>, 2>& s, const Vec<2>& x) {
  double t = dot(x - s[0], s[1] - s[0]) / norm_sq(s[1] - s[0]);
  t = t < 0 ? 0 : (t > 1 ? 1 : t);
  return distance(x, (1 - t) * s[0] + t * s[1]);
}
double plain_distance(const std::array<Vec<3>, 3>& s, const Vec<3>& x) {
  double best = 1e300;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec<3> a = s[i], b = s[(i + 1) % 3];
    double t = dot(x - a, b - a) / norm_sq(b - a);
    t = t < 0 ? 0 : (t > 1 ? 1 : t);
    best = std::min(best, distance(x, (1 - t) * a + t * b));
  }
  const Vec<3> n = cross(s[1] - s[0], s[2] - s[0]);
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) inside = inside && dot(cross(s[(i + 1) % 3] - s[i], x - s[i]), n) >= 0;
  return inside ? std::min(best, std::abs(dot(n, x - s[0])) / norm(n)) : best;
}

template <int D>
Walls<D> random_walls(Random& random, int n) {
  Walls<D> walls;
  for (int i = 0; i < n; ++i) {
    const Vec<D> center = random_point<D>(random, 0, 1);
    std::array<Vec<D>, D> simplex;
    for (Vec<D>& p : simplex) p = center + random_point<D>(random, -0.15, 0.15);
    walls.simplices.push_back(simplex);
    walls.regions.push_back({0, 0});
  }
  return walls;
}

template <int D>
void is_near_compares_with_the_distance() {
  Random random(7);
  const Walls<D> walls = random_walls<D>(random, 40);
  const WallLocator<D> locator(walls);
  for (int i = 0; i < 1000; ++i) {
    const Vec<D> x = random_point<D>(random, -0.3, 1.3);
    double d = 1e300;
    for (const auto& s : walls.simplices) d = std::min(d, plain_distance(s, x));
    EXPECT_TRUE(locator.is_near(x, d * (1 + 1e-9) + 1e-15));
    EXPECT_FALSE(locator.is_near(x, d * (1 - 1e-9)));
  }
}
TEST(WallLocator, IsNearComparesWithTheDistanceInThePlane) { is_near_compares_with_the_distance<2>(); }
TEST(WallLocator, IsNearComparesWithTheDistanceInSpace) { is_near_compares_with_the_distance<3>(); }

template <int D>
void touches_every_box_that_a_wall_meets() {
  Random random(8);
  const Walls<D> walls = random_walls<D>(random, 40);
  const WallLocator<D> locator(walls);
  int misses = 0;
  for (int i = 0; i < 1000; ++i) {
    // A box around a point of a wall, as thin as we like.
    const auto& s = walls.simplices[random.bits() % walls.simplices.size()];
    Vec<D> on;
    double sum = 0;
    std::array<double, D> weight;
    for (double& w : weight) sum += w = random.unit();
    for (std::size_t k = 0; k < D; ++k) on += (weight[k] / sum) * s[k];
    const double side = std::pow(10, -6 * random.unit());
    Box<D> box;
    for (int k = 0; k < D; ++k) {
      const double u = 0.01 + 0.98 * random.unit();
      box.lo[k] = on[k] - u * side;
      box.hi[k] = on[k] + (1 - u) * side;
    }
    EXPECT_TRUE(locator.touches(box));
    // A box farther from all walls than its diagonal is free, and must be seen so if no wall's box overlaps it.
    const Vec<D> x = random_point<D>(random, -0.5, 1.5);
    Box<D> free(x, x);
    free.inflate(0.005);
    bool overlaps = false;
    for (const auto& w : walls.simplices) {
      Box<D> b;
      for (const Vec<D>& p : w) b.add(p);
      overlaps = overlaps || b.overlaps(free);
    }
    if (overlaps) continue;
    EXPECT_FALSE(locator.touches(free));
    ++misses;
  }
  EXPECT_GT(misses, 100);
}
TEST(WallLocator, TouchesEveryBoxThatAWallMeetsInThePlane) { touches_every_box_that_a_wall_meets<2>(); }
TEST(WallLocator, TouchesEveryBoxThatAWallMeetsInSpace) { touches_every_box_that_a_wall_meets<3>(); }

TEST(WallLocator, WithoutWallsNothingIsNear) {
  const WallLocator<3> locator({});
  EXPECT_TRUE(locator.empty());
  EXPECT_FALSE(locator.touches({domains::all<3>(0), domains::all<3>(1)}));
  EXPECT_FALSE(locator.is_near(domains::all<3>(0), 1e9));
}

}  // namespace
}  // namespace voropack
