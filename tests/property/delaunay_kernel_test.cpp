// BowyerWatson gives the same simplices as CGAL's Delaunay triangulations, for any set of points and order of
// insertion.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_data_structure_2.h>
#include <CGAL/Triangulation_data_structure_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <gtest/gtest.h>

#include "geom/bowyer_watson.h"
#include "support/delaunay_checks.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

using Epick = CGAL::Exact_predicates_inexact_constructions_kernel;

template <int K>
using SimplexSet = std::vector<std::array<std::uint32_t, K + 1>>;

SimplexSet<2> reference(const std::vector<Vec<2>>& points) {
  using Tds = CGAL::Triangulation_data_structure_2<CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Epick>>;
  std::vector<std::pair<Epick::Point_2, std::uint32_t>> input;
  for (const Vec<2>& p : points) input.emplace_back(Epick::Point_2(p[0], p[1]), input.size());
  CGAL::Delaunay_triangulation_2<Epick, Tds> dt(input.begin(), input.end());
  SimplexSet<2> all;
  for (const auto f : dt.finite_face_handles()) {
    all.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
    std::sort(all.back().begin(), all.back().end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

SimplexSet<3> reference(const std::vector<Vec<3>>& points) {
  using Tds = CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Epick>,
                                                   CGAL::Delaunay_triangulation_cell_base_3<Epick>>;
  std::vector<std::pair<Epick::Point_3, std::uint32_t>> input;
  for (const Vec<3>& p : points) input.emplace_back(Epick::Point_3(p[0], p[1], p[2]), input.size());
  CGAL::Delaunay_triangulation_3<Epick, Tds> dt(input.begin(), input.end());
  SimplexSet<3> all;
  for (const auto c : dt.finite_cell_handles()) {
    all.push_back({c->vertex(0)->info(), c->vertex(1)->info(), c->vertex(2)->info(), c->vertex(3)->info()});
    std::sort(all.back().begin(), all.back().end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

using namespace test;

template <int K>
void expect_delaunay(const std::vector<Vec<K>>& points, const char* what) {
  SCOPED_TRACE(what);
  BowyerWatson<K> kernel;
  kernel.insert(points);
  EXPECT_EQ(test::find_structure_fault<K>(kernel, points), "");
  EXPECT_EQ((test::sorted_simplices<K>(kernel)), reference(points));
  if (points.size() < 200) {
    EXPECT_TRUE(test::has_empty_balls<K>(kernel, points));
  }
}

template <class Dimension>
class DelaunayKernel : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(DelaunayKernel, Dimensions);

TYPED_TEST(DelaunayKernel, EqualsCgalOnRandomPoints) {
  constexpr int K = TypeParam::value;
  for (std::size_t n : {K + 1, K + 2, 8, 20, 60, 150}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) expect_delaunay(random_points<K>(n, seed), "random");
  }
  expect_delaunay(random_points<K>(5000), "many");
}

TYPED_TEST(DelaunayKernel, EqualsCgalOnClusters) {
  constexpr int K = TypeParam::value;
  expect_delaunay(clustered_points<K>(180), "few");
  expect_delaunay(clustered_points<K>(3000), "many");
}

TYPED_TEST(DelaunayKernel, EqualsCgalOnLattices) {
  constexpr int K = TypeParam::value;
  expect_delaunay(grid_points<K>(K == 2 ? 13 : 5, 1.0), "small grid");
  expect_delaunay(grid_points<K>(K == 2 ? 30 : 8, 1.0), "grid of integers");
  expect_delaunay(grid_points<K>(K == 2 ? 30 : 8, 0.1), "grid of rounded numbers");
  expect_delaunay(centered_points<K>(K == 2 ? 20 : 7, 1.0), "centered grid of integers");
  expect_delaunay(centered_points<K>(K == 2 ? 20 : 7, 0.1), "centered grid of rounded numbers");
}

TYPED_TEST(DelaunayKernel, EqualsCgalOnSpheres) {
  constexpr int K = TypeParam::value;
  expect_delaunay(sphere_points<K>(150), "few rounded points");
  expect_delaunay(sphere_points<K>(2000), "many rounded points");
  expect_delaunay(cospherical_points<K>(), "exactly cospherical");
}

TYPED_TEST(DelaunayKernel, EqualsCgalOnBoxes) {
  constexpr int K = TypeParam::value;
  expect_delaunay(box_points<K>(3, 50), "small box");
  expect_delaunay(box_points<K>(8, 500), "box with exact faces");
  expect_delaunay(box_points<K>(10, 0), "box without points inside");
}

TYPED_TEST(DelaunayKernel, EqualsCgalAtAllScales) {
  constexpr int K = TypeParam::value;
  for (const double scale : {1e-150, 1e-60, 1e-6, 1e6, 1e60}) {
    expect_delaunay(moved(random_points<K>(100), scale, 0), "random");
    expect_delaunay(moved(grid_points<K>(4, 1.0), scale, 0), "grid");
  }
  expect_delaunay(moved(random_points<K>(1000), 1.0, 1e6), "far from the origin");
  expect_delaunay(moved(random_points<K>(1000), 1e-6, 1e6), "far from the origin, few digits left");
  expect_delaunay(moved(centered_points<K>(5, 0.1), 1.0, 1e6), "lattice far from the origin");
}

TYPED_TEST(DelaunayKernel, FirstPointsMayLieInAHyperplane) {
  constexpr int K = TypeParam::value;
  std::vector<Vec<K>> points = grid_points<K>(9, 1.0);
  if constexpr (K == 3) std::erase_if(points, [](const Vec<K>& p) { return p[2] != 0; });
  if constexpr (K == 2) std::erase_if(points, [](const Vec<K>& p) { return p[1] != 0; });
  Vec<K> apex = points[3];
  apex[K - 1] = -2;
  points.push_back(apex);
  expect_delaunay(points, "pyramid");
}

TYPED_TEST(DelaunayKernel, IsTheSameForAnyOrderOfThePoints) {
  constexpr int K = TypeParam::value;
  std::vector<Vec<K>> points = centered_points<K>(K == 2 ? 9 : 5, 0.1);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    shuffle(points, seed);
    expect_delaunay(points, "shuffled lattice");
  }
}

TYPED_TEST(DelaunayKernel, BatchesEqualOneInsertion) {
  constexpr int K = TypeParam::value;
  for (const bool lattice : {false, true}) {
    std::vector<Vec<K>> points = lattice ? centered_points<K>(K == 2 ? 24 : 9, 0.1) : random_points<K>(1100);
    shuffle(points, 5);
    points.resize(1100);
    BowyerWatson<K> kernel;
    const std::span<const Vec<K>> all(points);
    kernel.insert(all.first(1000));
    for (std::size_t first = 1000; first < 1100; first += 10) {
      std::vector<std::uint32_t> hints(10, kNoHint);
      for (std::size_t i = 0; i < 8; ++i) hints[i] = static_cast<std::uint32_t>(37 * (first + i) % 1000);
      kernel.insert(all.subspan(first, 10), hints);
    }
    EXPECT_EQ(test::find_structure_fault<K>(kernel, points), "");
    EXPECT_EQ((test::sorted_simplices<K>(kernel)), reference(points));
  }
}

TYPED_TEST(DelaunayKernel, CreatedSlotsAreTheDifference) {
  constexpr int K = TypeParam::value;
  using Corners = typename BowyerWatson<K>::Corners;
  const std::vector<Vec<K>> points = random_points<K>(700);
  const std::span<const Vec<K>> all(points);
  BowyerWatson<K> kernel;
  std::vector<Corners> before;  // By slot; empty slots hold zeros.
  for (std::size_t first = 0; first < points.size(); first += first == 0 ? 500 : 10) {
    kernel.insert(all.subspan(first, first == 0 ? 500 : 10));
    if (first == 520) continue;  // Two batches together.
    std::vector<std::uint32_t> expected;
    std::vector<Corners> now(kernel.n_slots(), Corners{});
    before.resize(now.size(), Corners{});
    for (std::uint32_t s = 0; s < kernel.n_slots(); ++s) {
      if (!kernel.is_alive(s)) continue;
      now[s] = kernel.corners(s);
      // No point leaves, so a simplex that was destroyed never comes back.
      if (now[s] != before[s]) expected.push_back(s);
    }
    EXPECT_EQ(kernel.take_created(), expected);
    EXPECT_TRUE(kernel.take_created().empty());
    before = now;
  }
}

TYPED_TEST(DelaunayKernel, TheSameCallsGiveTheSameSlots) {
  constexpr int K = TypeParam::value;
  const std::vector<Vec<K>> points = random_points<K>(3000);
  BowyerWatson<K> a, b;
  for (BowyerWatson<K>* kernel : {&a, &b}) {
    kernel->insert(std::span<const Vec<K>>(points).first(2000));
    kernel->insert(std::span<const Vec<K>>(points).subspan(2000), std::vector<std::uint32_t>(1000, 7));
  }
  ASSERT_EQ(a.n_slots(), b.n_slots());
  for (std::uint32_t s = 0; s < a.n_slots(); ++s) {
    EXPECT_EQ(a.corners(s), b.corners(s));
    EXPECT_EQ(a.neighbors(s), b.neighbors(s));
  }
}

/// A cavity with more vertices than the table of edges can hold.
TEST(DelaunayKernel3, LinksLargeCavities) {
  std::vector<Vec<3>> points = sphere_points<3>(3000);
  BowyerWatson<3> kernel;
  kernel.insert(points);
  for (const Vec<3>& p : {Vec<3>{0, 0, 0}, Vec<3>{100, 20, 30}}) {
    kernel.insert(std::span(&p, 1));
    points.push_back(p);
  }
  EXPECT_EQ(test::find_structure_fault<3>(kernel, points), "");
  EXPECT_EQ(test::sorted_simplices<3>(kernel), reference(points));
}

}  // namespace
}  // namespace voropack
