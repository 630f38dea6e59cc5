// A Delaunay triangulation in which vertices come and go: it is always that of the points which are there.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "spheres/movable_mesh.h"
#include "support/point_sets.h"
#include "voropack/delaunay.h"

namespace voropack {
namespace {

using test::random_points;

/// The simplices as sets of points.
template <int D>
using Simplices = std::set<std::set<std::uint32_t>>;

template <int D>
Simplices<D> simplices_of(const Triangulation<D>& t, const std::vector<std::uint32_t>& name) {
  Simplices<D> result;
  for (const auto& s : t.simplices) {
    std::set<std::uint32_t> corners;
    for (const std::uint32_t v : s) corners.insert(name[v]);
    result.insert(corners);
  }
  return result;
}

/// Of the points with these numbers.
template <int D>
Simplices<D> expected(const std::vector<Vec<D>>& points, const std::vector<std::uint32_t>& numbers) {
  std::vector<Vec<D>> there;
  for (const std::uint32_t i : numbers) there.push_back(points[i]);
  return simplices_of<D>(delaunay_triangulation(there), numbers);
}

std::vector<std::uint32_t> numbers_to(std::size_t n, std::optional<std::uint32_t> without = {}) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < n; ++i)
    if (i != without) numbers.push_back(i);
  return numbers;
}

template <int D>
void expect_mutual_neighbors(const Triangulation<D>& t) {
  for (std::uint32_t s = 0; s < t.simplices.size(); ++s)
    for (const std::uint32_t n : t.neighbors[s])
      EXPECT_TRUE(n == Triangulation<D>::kNoNeighbor || std::ranges::count(t.neighbors[n], s) == 1);
}

template <int D>
void test_insertions_and_removals() {
  const std::size_t n = 60;
  std::vector<Vec<D>> points = random_points<D>(n, D);
  const Triangulation<D> start = delaunay_triangulation(points);
  MovableMesh<D> mesh(points, start);
  const auto more = random_points<D>(20, 7);
  std::size_t n_removed = 0;
  for (const Vec<D>& x : more) {
    const auto before = simplices_of<D>(mesh.to_triangulation(), numbers_to(points.size()));
    const auto mark = mesh.mark();
    if (!mesh.insert(0.5 * (x + points[0]), 0)) continue;
    points.push_back(0.5 * (x + points[0]));
    expect_mutual_neighbors(mesh.to_triangulation());
    EXPECT_EQ(simplices_of<D>(mesh.to_triangulation(), numbers_to(points.size())),
              expected(points, numbers_to(points.size())));
    // Away with one of its neighbors, unless that is on the hull.
    const auto at = static_cast<std::uint32_t>(mesh.size() - 1);
    for (const std::uint32_t v : mesh[at].corner) {
      const auto trial = mesh.mark();
      if (!mesh.remove(v, at)) continue;
      ++n_removed;
      expect_mutual_neighbors(mesh.to_triangulation());
      EXPECT_EQ(simplices_of<D>(mesh.to_triangulation(), numbers_to(points.size())),
                expected(points, numbers_to(points.size(), v)));
      mesh.undo(trial);
    }
    mesh.undo(mark);
    points.pop_back();
    EXPECT_EQ(simplices_of<D>(mesh.to_triangulation(), numbers_to(points.size())), before);
  }
  EXPECT_GT(n_removed, 5U);
}
TEST(MovableMesh2, IsDelaunayAfterEveryChange) { test_insertions_and_removals<2>(); }
TEST(MovableMesh3, IsDelaunayAfterEveryChange) { test_insertions_and_removals<3>(); }

TEST(MovableMesh3, RefusesWhatIsOutsideAndCornersOfTheHull) {
  const std::vector<Vec<3>> points = {Vec<3>{0, 0, 0}, Vec<3>{1, 0, 0}, Vec<3>{0, 1, 0}, Vec<3>{0, 0, 1}};
  MovableMesh<3> mesh(points, delaunay_triangulation(points));
  EXPECT_FALSE(mesh.insert({1.0, 1.0, 1.0}, 0));
  EXPECT_FALSE(mesh.remove(0, 0));
  EXPECT_EQ(mesh.size(), 1U);
  EXPECT_TRUE(mesh.insert({0.2, 0.2, 0.2}, 0));
  EXPECT_EQ(mesh.to_triangulation().simplices.size(), 4U);
}

}  // namespace
}  // namespace voropack
