// The parts that the parallel insertion is made of, and the merging of sets by several threads.
#include <gtest/gtest.h>

#include <set>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "geom/box_partition.h"
#include "geom/slot_pool.h"
#include "support/allow_threads.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

TEST(SlotPool, GivesEachSlotOnce) {
  SlotPool pool;
  pool.give(10, 20);
  pool.give(3, 4);
  EXPECT_EQ(pool.take(), 3U);
  SlotPool share = pool.split_off(4);
  EXPECT_EQ(share.size(), 4U);
  EXPECT_EQ(pool.size(), 6U);
  EXPECT_EQ(pool.split_off(100).size(), 6U);
  EXPECT_EQ(pool.size(), 0U);
  pool.give(share);
  std::set<std::uint32_t> taken;
  while (pool.size() > 0) taken.insert(pool.take());
  EXPECT_EQ(taken, (std::set<std::uint32_t>{10, 11, 12, 13}));
}

TEST(BoxPartition, SharesTheSample) {
  const std::vector<Vec<3>> points = test::random_points<3>(64000);
  const BoxPartition<3> halves(points, 4, 0.5);
  ASSERT_EQ(halves.n_parts(), 16U);
  std::vector<std::size_t> count(16, 0);
  for (const Vec<3>& p : points) ++count[halves.place_of(p).part];
  for (const std::size_t n : count) EXPECT_EQ(n, 4000U);
  std::size_t n_first = 0;
  const BoxPartition<3> thirds(points, 2, 1.0 / 3);
  for (const Vec<3>& p : points) n_first += thirds.place_of(p).part == 0 ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(n_first), 64000.0 / 9, 2.0);
}

/// A point can move less than its depth along an axis without leaving its part.
TEST(BoxPartition, DepthIsTheDistanceFromThePlanes) {
  const std::vector<Vec<2>> points = test::random_points<2>(1000);
  const BoxPartition<2> boxes(points, 3, 1.0 / 3);
  for (const Vec<2>& p : points) {
    const double depth = boxes.place_of(p).depth;
    bool leaves = false;
    for (int k = 0; k < 2; ++k)
      for (const double sign : {-1.0, 1.0}) {
        Vec<2> moved = p;
        moved[k] += sign * 0.999 * depth;
        EXPECT_EQ(boxes.place_of(moved).part, boxes.place_of(p).part);
        moved[k] = p[k] + sign * 1.001 * depth;
        leaves = leaves || boxes.place_of(moved).part != boxes.place_of(p).part;
      }
    EXPECT_TRUE(leaves || depth == 0);
  }
}

TEST(BoxPartition, EqualPointsAreInOnePart) {
  const BoxPartition<2> boxes(std::vector<Vec<2>>(100, Vec<2>{1, 2}), 3, 0.5);
  EXPECT_EQ(boxes.place_of({1, 2}).part, boxes.n_parts() - 1);
}

/// Chains 0, m, 2m, ..; 1, m + 1, ..: the root of each is its smallest number.
TEST(DisjointSets, RootsAreTheSmallestNumbers) {
  constexpr std::size_t kChains = 7, kNumbers = 70'000;
  const test::AllowThreads allow(8);
  DisjointSets sets(kNumbers);
  run_with_threads(8, [&] {
    parallel_for(kNumbers - kChains, [&](std::size_t i) {
      const auto from = static_cast<std::uint32_t>(hash_words(1, i) % (kNumbers - kChains));
      sets.join(from, static_cast<std::uint32_t>(from + kChains));
      sets.join(static_cast<std::uint32_t>(i + kChains), static_cast<std::uint32_t>(i));
    });
  });
  for (std::uint32_t i = 0; i < kNumbers; ++i) EXPECT_EQ(sets.find(i), i % kChains);
}

}  // namespace
}  // namespace voropack
