// Insertion in parallel gives the simplices of the insertion of one point after the other, in the same slots for any
// number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "geom/bowyer_watson.h"
#include "geom/parallel_insertion.h"
#include "support/allow_threads.h"
#include "support/delaunay_checks.h"
#include "support/point_sets.h"
#include "voropack/error.h"

namespace voropack {
namespace {

using namespace test;

template <int K>
struct PointSet {
  std::string name;
  std::vector<Vec<K>> points;
};

/// Large enough for a round in parallel.
template <int K>
constexpr std::size_t kMany = K == 2 ? 40'000 : 60'000;

/// In random order.
template <int K>
std::vector<PointSet<K>> point_sets() {
  const int side = K == 2 ? 140 : 31;
  std::vector<PointSet<K>> sets = {{"random", random_points<K>(kMany<K>)},
                                   {"lattice of integers", centered_points<K>(side, 1.0)},
                                   {"lattice of rounded numbers", centered_points<K>(side, 0.1)},
                                   {"clusters", clustered_points<K>(kMany<K>)},
                                   {"planes", plane_points<K>(kMany<K>, 3)},
                                   {"box", box_points<K>(K == 2 ? 5000 : 60, kMany<K> / 2)}};
  for (PointSet<K>& set : sets) shuffle(set.points, 7);
  return sets;
}

template <int K>
BowyerWatson<K> inserted_by(int n_threads, const std::vector<Vec<K>>& points) {
  const AllowThreads allow(8);
  BowyerWatson<K> kernel;
  run_with_threads(n_threads, [&] { kernel.insert(points); });
  return kernel;
}

/// Small batches are inserted one point after the other.
template <int K>
BowyerWatson<K> inserted_in_turn(const std::vector<Vec<K>>& points) {
  BowyerWatson<K> kernel;
  const std::span<const Vec<K>> all(points);
  for (std::size_t next = 0; next < points.size(); next += kLeastParallelRound<K>)
    kernel.insert(all.subspan(next, std::min(kLeastParallelRound<K>, points.size() - next)));
  EXPECT_EQ(kernel.n_inserted_in_parallel(), 0U);
  return kernel;
}

template <int K>
void expect_same_slots(BowyerWatson<K>& a, BowyerWatson<K>& b) {
  ASSERT_EQ(a.n_slots(), b.n_slots());
  EXPECT_EQ(a.n_inserted_in_parallel(), b.n_inserted_in_parallel());
  std::size_t n_different = 0;
  for (std::uint32_t s = 0; s < a.n_slots(); ++s) {
    bool same = a.is_alive(s) == b.is_alive(s);
    if (a.is_alive(s)) same = same && a.corners(s) == b.corners(s) && a.neighbors(s) == b.neighbors(s);
    n_different += same ? 0 : 1;
  }
  EXPECT_EQ(n_different, 0U);
  for (std::uint32_t v = 0; v < a.n_vertices(); ++v) n_different += a.slot_of_vertex(v) == b.slot_of_vertex(v) ? 0 : 1;
  EXPECT_EQ(n_different, 0U);
  EXPECT_EQ(a.take_created(), b.take_created());
}

template <class Dimension>
class ParallelInsertion : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ParallelInsertion, Dimensions);

TYPED_TEST(ParallelInsertion, EqualsInsertionInTurn) {
  constexpr int K = TypeParam::value;
  for (const auto& [name, points] : point_sets<K>()) {
    SCOPED_TRACE(name);
    const BowyerWatson<K> kernel = inserted_by<K>(8, points);
    EXPECT_GT(kernel.n_inserted_in_parallel(), points.size() / 20);
    EXPECT_EQ(sorted_simplices<K>(kernel), sorted_simplices<K>(inserted_in_turn<K>(points)));
  }
}

TYPED_TEST(ParallelInsertion, EqualsCgal) {
  constexpr int K = TypeParam::value;
  for (const auto& [name, points] : point_sets<K>()) {
    SCOPED_TRACE(name);
    CgalDelaunay<K> reference;
    reference.insert(points);
    EXPECT_EQ(sorted_simplices<K>(inserted_by<K>(2, points)), sorted_simplices<K>(reference));
  }
}

TYPED_TEST(ParallelInsertion, FillsTheSameSlotsForAnyNumberOfThreads) {
  constexpr int K = TypeParam::value;
  for (const auto& [name, points] : point_sets<K>()) {
    SCOPED_TRACE(name);
    BowyerWatson<K> one = inserted_by<K>(1, points);
    for (const int n_threads : {2, 8}) {
      BowyerWatson<K> copy = one, several = inserted_by<K>(n_threads, points);
      expect_same_slots<K>(copy, several);
    }
  }
}

TYPED_TEST(ParallelInsertion, KeepsTheStructure) {
  constexpr int K = TypeParam::value;
  const std::vector<Vec<K>> points = random_points<K>(kMany<K>, 8);
  const BowyerWatson<K> kernel = inserted_by<K>(8, points);
  EXPECT_GT(kernel.n_inserted_in_parallel(), points.size() / 2);
  EXPECT_EQ(find_structure_fault<K>(kernel, points), "");
}

TYPED_TEST(ParallelInsertion, TakesNearlyAllPointsOfLargeSets) {
  constexpr int K = TypeParam::value;
  const std::vector<Vec<K>> points = random_points<K>(4 * kMany<K>);
  EXPECT_GT(inserted_by<K>(2, points).n_inserted_in_parallel(), points.size() * 8 / 10);
}

TYPED_TEST(ParallelInsertion, LeavesSmallSetsToTheSequentialInsertion) {
  constexpr int K = TypeParam::value;
  EXPECT_EQ(inserted_by<K>(2, random_points<K>(kLeastParallelRound<K>)).n_inserted_in_parallel(), 0U);
}

/// A second large batch meets slots that take_created has seen.
TYPED_TEST(ParallelInsertion, CreatedSlotsAreTheDifference) {
  constexpr int K = TypeParam::value;
  const std::vector<Vec<K>> points = random_points<K>(2 * kMany<K>, 9);
  const std::span<const Vec<K>> all(points);
  const AllowThreads allow(8);
  BowyerWatson<K> kernel;
  kernel.insert(all.first(kLeastParallelRound<K>));
  EXPECT_EQ(kernel.n_inserted_in_parallel(), 0U);
  kernel.take_created();
  std::vector<typename BowyerWatson<K>::Corners> before(kernel.n_slots());
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s)
    if (kernel.is_alive(s)) before[s] = kernel.corners(s);
  kernel.insert(all.subspan(kLeastParallelRound<K>));
  EXPECT_GT(kernel.n_inserted_in_parallel(), points.size() / 2);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s)
    if (kernel.is_alive(s) && (s >= before.size() || kernel.corners(s) != before[s])) expected.push_back(s);
  EXPECT_EQ(kernel.take_created(), expected);
  EXPECT_EQ(sorted_simplices<K>(kernel), sorted_simplices<K>(inserted_by<K>(1, points)));
}

TYPED_TEST(ParallelInsertion, NamesDuplicatePoints) {
  constexpr int K = TypeParam::value;
  std::vector<Vec<K>> points = random_points<K>(kMany<K>);
  points[points.size() / 2] = points[17];
  for (const int n_threads : {1, 8}) {
    try {
      inserted_by<K>(n_threads, points);
      ADD_FAILURE() << "no error";
    } catch (const InputError& error) {
      ASSERT_EQ(error.faults().size(), 1U);
      EXPECT_EQ(error.faults()[0].id, "delaunay.duplicate_points");
      EXPECT_NE(error.faults()[0].message.find("points 17 and " + std::to_string(points.size() / 2)),
                std::string::npos);
    }
  }
}

}  // namespace
}  // namespace voropack
