// Cocircular points of a facet get the triangles that the Delaunay triangulation in space has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/random.h"
#include "packing/tied_polygons.h"
#include "voropack/delaunay.h"

namespace voropack {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Points on a circle of radius 25, some of them inside it, placed in a plane of space.
struct PlanePoints {
  std::vector<Vec<2>> in_plane;
  std::vector<Vec<3>> in_space;
  void add(const Vec<2>& x, const Vec<3>& u, const Vec<3>& v) {
    in_plane.push_back(x);
    in_space.push_back(x[0] * u + x[1] * v);
  }
};

PlanePoints circle(const Vec<3>& u, const Vec<3>& v) {
  PlanePoints points;
  for (int x = -25; x <= 25; ++x)
    for (int y = -25; y <= 25; ++y)
      if (x * x + y * y == 625) points.add({double(x), double(y)}, u, v);
  return points;
}

struct Settled {
  std::vector<Triangle> triangles;
  std::vector<TiedPolygon> polygons;
};

Settled settle(const PlanePoints& points) {
  Triangulation<2> plane = delaunay_triangulation(points.in_plane);
  Settled result{plane.simplices, {}};
  result.polygons = settle_tied_polygons(points.in_plane, points.in_space, plane.neighbors, result.triangles);
  return result;
}

double area(const PlanePoints& points, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    const double twice =
        cross(points.in_plane[t[1]] - points.in_plane[t[0]], points.in_plane[t[2]] - points.in_plane[t[0]]);
    EXPECT_GT(twice, 0);
    sum += 0.5 * twice;
  }
  return sum;
}

/// Faces of the Delaunay triangulation of the points and of others that are outside their circle's ball.
std::set<Triangle> faces_in_space(const PlanePoints& points, std::uint64_t seed) {
  std::vector<Vec<3>> all = points.in_space;
  const double radius = norm(all[0]);
  for (std::uint64_t i = 0; all.size() < points.in_space.size() + 200; ++i) {
    Vec<3> x;
    for (int k = 0; k < 3; ++k) x[k] = 3.2 * radius * (to_unit(hash_words(seed, i, k)) - 0.5);
    if (norm(x) > 1.01 * radius) all.push_back(x);
  }
  std::set<Triangle> faces;
  for (const auto& s : delaunay_triangulation(all).simplices)
    for (std::size_t skip = 0; skip < 4; ++skip) {
      Triangle f{};
      for (std::size_t i = 0, n = 0; i < 4; ++i)
        if (i != skip) f[n++] = s[i];
      std::sort(f.begin(), f.end());
      faces.insert(f);
    }
  return faces;
}

TEST(TiedPolygons, TrianglesAreThoseInSpace) {
  // Planes in which integers have exact coordinates, the last one tilted.
  const std::array<std::array<Vec<3>, 2>, 3> frames = {
      {{Vec<3>{1, 0, 0}, Vec<3>{0, 1, 0}}, {Vec<3>{0, 0, 1}, Vec<3>{1, 0, 0}}, {Vec<3>{3, 4, 0}, Vec<3>{0, 0, 5}}}};
  for (const auto& [u, v] : frames) {
    const PlanePoints points = circle(u, v);
    const Settled settled = settle(points);
    ASSERT_EQ(settled.polygons.size(), 1U);
    EXPECT_EQ(settled.polygons[0].points.size(), points.in_plane.size());
    EXPECT_EQ(settled.polygons[0].triangles.size(), points.in_plane.size() - 2);
    const double whole = area(points, delaunay_triangulation(points.in_plane).simplices);
    EXPECT_NEAR(area(points, settled.triangles), whole, 1e-9 * whole);
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const std::set<Triangle> faces = faces_in_space(points, seed);
      for (Triangle t : settled.triangles) {
        std::sort(t.begin(), t.end());
        EXPECT_TRUE(faces.contains(t)) << t[0] << ' ' << t[1] << ' ' << t[2];
      }
    }
  }
}

TEST(TiedPolygons, LeavesAloneWhatIsNotCoplanarExactly) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  const PlanePoints points = circle({c, s, 0}, {-s * s, c * s, c});
  const Settled settled = settle(points);
  EXPECT_TRUE(settled.polygons.empty());
  EXPECT_EQ(settled.triangles, delaunay_triangulation(points.in_plane).simplices);
}

TEST(TiedPolygons, LeavesAloneWhatIsNotCocircular) {
  PlanePoints points;
  for (std::size_t i = 0; i < 100; ++i)
    points.add({to_unit(hash_words(5, i, 0)), to_unit(hash_words(5, i, 1))}, {1, 0, 0}, {0, 1, 0});
  const Settled settled = settle(points);
  EXPECT_TRUE(settled.polygons.empty());
  EXPECT_EQ(settled.triangles, delaunay_triangulation(points.in_plane).simplices);
}

TEST(TiedPolygons, FindsEachOfMany) {
  PlanePoints points;
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 4; ++y) points.add({x + 0.01 * x * x, y + 0.02 * y * y}, {0, 1, 0}, {0, 0, 1});
  const Settled settled = settle(points);
  ASSERT_EQ(settled.polygons.size(), 15U);
  for (const TiedPolygon& p : settled.polygons) {
    EXPECT_EQ(p.points.size(), 4U);
    EXPECT_EQ(p.triangles.size(), 2U);
  }
}

}  // namespace
}  // namespace voropack
