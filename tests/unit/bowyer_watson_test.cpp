#include "geom/bowyer_watson.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include "base/random.h"
#include "geom/hilbert.h"
#include "support/delaunay_checks.h"
#include "voropack/error.h"

namespace voropack {
namespace {

const std::vector<Vec<3>> kCorner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

template <int K>
std::string thrown_id(BowyerWatson<K>& kernel, const std::vector<Vec<K>>& points) {
  try {
    kernel.insert(points);
  } catch (const InputError& error) {
    EXPECT_FALSE(error.faults().front().fix.empty());
    return error.id();
  }
  return "none";
}

TEST(BowyerWatson, OneTetrahedronHasFourFacesAtInfinity) {
  BowyerWatson<3> kernel;
  kernel.insert(kCorner);
  EXPECT_EQ(kernel.n_vertices(), 4U);
  EXPECT_EQ(kernel.n_slots(), 5U);
  EXPECT_EQ(test::find_structure_fault<3>(kernel, kCorner), "");
  EXPECT_EQ(test::sorted_simplices<3>(kernel), (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
}

TEST(BowyerWatson, PointInsideSplitsATetrahedronIntoFour) {
  BowyerWatson<3> kernel;
  kernel.insert(kCorner);
  const std::vector<Vec<3>> inside = {{0.1, 0.1, 0.1}};
  kernel.insert(inside);
  EXPECT_EQ(test::sorted_simplices<3>(kernel),
            (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {1, 2, 3, 4}}));
}

TEST(BowyerWatson, SquareIsCutAtItsLexicographicallyLargestCorner) {
  // The perturbation moves (1, 1) out of the circle through the other three.
  BowyerWatson<2> kernel;
  const std::vector<Vec<2>> points = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  kernel.insert(points);
  EXPECT_EQ(test::sorted_simplices<2>(kernel), (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {1, 2, 3}}));
}

TEST(BowyerWatson, CubeNeedsNoFlatTetrahedron) {
  std::vector<Vec<3>> points;
  for (int i = 0; i < 8; ++i) points.push_back({i & 1, i >> 1 & 1, i >> 2 & 1});
  BowyerWatson<3> kernel;
  kernel.insert(points);
  EXPECT_EQ(test::find_structure_fault<3>(kernel, points), "");
  EXPECT_TRUE(test::has_empty_balls<3>(kernel, points));
}

TEST(BowyerWatson, RefusesPointsInAHyperplane) {
  BowyerWatson<3> kernel;
  EXPECT_EQ(thrown_id<3>(kernel, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 2, 0}}), "delaunay.degenerate");
  EXPECT_EQ(thrown_id<3>(kernel, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}), "delaunay.degenerate");
  EXPECT_EQ(thrown_id<3>(kernel, {{1, 2, 3}}), "delaunay.degenerate");
  BowyerWatson<2> plane;
  EXPECT_EQ(thrown_id<2>(plane, {{0, 0}, {1, 1}, {2, 2}}), "delaunay.degenerate");
  // Nothing was inserted, so a better batch succeeds.
  EXPECT_EQ(thrown_id<3>(kernel, kCorner), "none");
  EXPECT_EQ(kernel.n_vertices(), 4U);
}

TEST(BowyerWatson, NamesDuplicatePoints) {
  BowyerWatson<3> kernel;
  std::vector<Vec<3>> points = kCorner;
  points.push_back({1, 0, 0});
  try {
    kernel.insert(points);
    FAIL() << "duplicate points were accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.id(), "delaunay.duplicate_points");
    EXPECT_NE(error.faults().front().message.find("points 1 and 4"), std::string::npos);
    EXPECT_EQ(error.faults().front().position, (std::vector<double>{1, 0, 0}));
  }
}

TEST(BowyerWatson, RefusesDuplicatesOfEarlierBatches) {
  BowyerWatson<2> kernel;
  kernel.insert(std::vector<Vec<2>>{{0, 0}, {1, 0}, {0, 1}, {0.25, 0.25}});
  EXPECT_EQ(thrown_id<2>(kernel, {{0.5, 0.125}, {0.25, 0.25}}), "delaunay.duplicate_points");
}

TEST(BowyerWatson, RefusesCoordinatesThatAreNotFinite) {
  BowyerWatson<2> kernel;
  EXPECT_EQ(thrown_id<2>(kernel, {{0, 0}, {1, 0}, {0, std::numeric_limits<double>::quiet_NaN()}}),
            "delaunay.not_finite");
  EXPECT_EQ(thrown_id<2>(kernel, {{0, 0}, {1, 0}, {0, std::numeric_limits<double>::infinity()}}),
            "delaunay.not_finite");
}

template <int K>
void expect_curve_steps_to_neighbors() {
  // The cells of the corner of the grid that the curve visits first, sorted by key, must form a path.
  constexpr std::uint32_t n = 8;
  std::vector<std::pair<std::uint64_t, std::array<std::uint32_t, K>>> cells;
  for (std::uint32_t i = 0; i < (K == 2 ? n * n : n * n * n); ++i) {
    std::array<std::uint32_t, K> cell{i % n, i / n % n};
    if constexpr (K == 3) cell[2] = i / (n * n);
    cells.emplace_back(hilbert_key<K>(cell), cell);
  }
  std::sort(cells.begin(), cells.end());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].first, i);
    int steps = 0;
    for (std::size_t k = 0; i > 0 && k < K; ++k)
      steps += std::abs(static_cast<int>(cells[i].second[k]) - static_cast<int>(cells[i - 1].second[k]));
    EXPECT_EQ(steps, i > 0 ? 1 : 0);
  }
}

TEST(Hilbert, CurveStepsToNeighbors) {
  expect_curve_steps_to_neighbors<2>();
  expect_curve_steps_to_neighbors<3>();
}

TEST(Hilbert, OrdersArePermutationsAndOrderClustersToo) {
  Random random(1);
  std::vector<Vec<2>> points = {{0, 0}, {1, 1}};
  // A cluster far below the curve's resolution.
  for (int i = 0; i < 1000; ++i) points.push_back({0.5 + 1e-13 * random.unit(), 0.5 + 1e-13 * random.unit()});
  for (const auto& order : {hilbert_order<2>(points), insertion_rounds(points.size()), insertion_rounds(50000)}) {
    const std::set<std::uint32_t> all(order.begin(), order.end());
    EXPECT_GE(order.size(), points.size());
    EXPECT_EQ(all.size(), order.size());
    EXPECT_EQ(*all.rbegin(), order.size() - 1);
  }
  const std::vector<std::uint32_t> order = hilbert_order<2>(points);
  double length = 0;
  for (std::size_t i = 1; i < order.size(); ++i) length += distance(points[order[i]], points[order[i - 1]]);
  // sqrt(2) to and from the cluster, and about sqrt(1000) * 1e-13 within, where a random order has 500 * 1e-13.
  EXPECT_LT(length - std::sqrt(2.0), 60e-13);
}

template <int K>
void expect_order_by_key(const std::vector<Vec<K>>& points) {
  Box<K> box;
  for (const Vec<K>& x : points) box.add(x);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t i = 0; i < points.size(); ++i) keys.emplace_back(hilbert_key<K>(points[i], box), i);
  std::sort(keys.begin(), keys.end());
  const std::vector<std::uint32_t> order = hilbert_order<K>(points, box);
  ASSERT_EQ(order.size(), points.size());
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], keys[i].second);
}

template <int K>
void expect_order_by_key() {
  Random random(2);
  // Every other point is in a cluster whose keys begin with the same digits.
  std::vector<Vec<K>> points(60000);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < K; ++k) points[i][k] = i % 2 == 0 ? random.unit() : 0.3 + 1e-5 * random.unit();
  points[100] = points[4] = points[7];
  expect_order_by_key<K>(points);
  // Almost in order: a few are elsewhere, at first the last one.
  std::vector<Vec<K>> almost;
  for (const std::uint32_t i : hilbert_order<K>(points)) almost.push_back(points[i]);
  std::swap(almost.front(), almost.back());
  for (int i = 0; i < 1000; ++i) std::swap(almost[random.bits() % 60000], almost[random.bits() % 60000]);
  expect_order_by_key<K>(almost);
}

TEST(Hilbert, OrdersManyPointsByTheirKeys) {
  expect_order_by_key<2>();
  expect_order_by_key<3>();
}

TEST(Hilbert, AcceptsEmptyAndIdenticalInput) {
  EXPECT_TRUE(hilbert_order<3>(std::vector<Vec<3>>{}).empty());
  EXPECT_EQ(hilbert_order<3>(std::vector<Vec<3>>(100, Vec<3>{1, 2, 3})).size(), 100U);
}

}  // namespace
}  // namespace voropack
