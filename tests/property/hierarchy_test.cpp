// What hierarchies are asked for beside levels: numbers of vertices, boundaries of the user's own, intersections.
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "support/cases.h"
#include "support/level_checks.h"
#include "voropack/coarsening.h"

namespace voropack {
namespace {

template <int D>
void expect_certified(const CoarseningHierarchy<D>& hierarchy) {
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    SCOPED_TRACE(i + 1);
    test::expect_certified(hierarchy.levels[i], &hierarchy.domain_of(i));
  }
}

template <int D>
void numbers_are_reached_from_below() {
  const Mesh<D> finest = test::mesh_of(domains::two_material_box<D>(), D == 2 ? 0.04 : 0.12, Interior::kRandom);
  const std::size_t n = finest.points.size();
  CoarseningOptions options;
  options.target_vertices = {n / 3, n / 8};
  const CoarseningHierarchy<D> hierarchy = coarsen(finest, options);
  ASSERT_EQ(hierarchy.levels.size(), 2U);
  test::expect_nested(finest, hierarchy);
  expect_certified(hierarchy);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LE(hierarchy.levels[i].mesh.points.size(), options.target_vertices[i]);
    EXPECT_GE(hierarchy.levels[i].mesh.points.size(), options.target_vertices[i] * 3 / 4);
  }
  EXPECT_LT(hierarchy.levels[0].growth, hierarchy.levels[1].growth);
}
TEST(Hierarchy, NumbersAreReachedFromBelowInThePlane) { numbers_are_reached_from_below<2>(); }
TEST(Hierarchy, NumbersAreReachedFromBelowInSpace) { numbers_are_reached_from_below<3>(); }

/// The box of two materials without its interface, from level 2 on.
template <int D>
void levels_take_boundaries_of_their_own() {
  const Mesh<D> finest = test::mesh_of(domains::two_material_box<D>(), D == 2 ? 0.04 : 0.12);
  DomainInput<D> box = domains::unit_box<D>();
  const Domain<D> two = build_domain(domains::two_material_box<D>());
  for (Vec<D>& x : box.points)
    for (int k = 0; k < D; ++k) x[k] = x[k] < 0.5 ? two.box.lo[k] : two.box.hi[k];
  const std::vector<LevelBoundary<D>> boundaries = {{2, build_domain(box)}};
  CoarseningOptions options;
  options.levels = 3;
  const CoarseningHierarchy<D> hierarchy = coarsen<D>(finest, boundaries, options);
  ASSERT_GE(hierarchy.levels.size(), 2U);
  test::expect_nested(finest, hierarchy);
  expect_certified(hierarchy);
  const auto n_regions = [](const Mesh<D>& mesh) {
    return std::set<int>(mesh.simplex_region.begin(), mesh.simplex_region.end()).size();
  };
  EXPECT_EQ(n_regions(hierarchy.levels[0].mesh), 2U);
  EXPECT_EQ(n_regions(hierarchy.levels[1].mesh), 1U);
  EXPECT_EQ(hierarchy.levels[0].boundary_distance, 0);
  EXPECT_GT(hierarchy.levels[1].boundary_distance, 0.3);  // From the interface to the hull.
}
TEST(Hierarchy, LevelsTakeBoundariesOfTheirOwnInThePlane) { levels_take_boundaries_of_their_own<2>(); }
TEST(Hierarchy, LevelsTakeBoundariesOfTheirOwnInSpace) { levels_take_boundaries_of_their_own<3>(); }

TEST(Hierarchy, RefusesBoundariesThatDoNotFit) {
  const Mesh<2> finest = test::mesh_of(domains::unit_square(), 0.1);
  const Domain<2> square = build_domain(domains::unit_square());
  DomainInput<2> moved = domains::unit_square();
  moved.points[0] = {-0.3, -0.1};
  EXPECT_THROW(coarsen<2>(finest, {{1, build_domain(moved)}}), InputError);
  EXPECT_THROW(coarsen<2>(finest, {{9, square}}), OptionError);
  EXPECT_THROW(coarsen<2>(finest, {{1, square}, {1, square}}), OptionError);
  // Level 2 would be larger than level 1.
  DomainInput<2> corner;
  corner.points = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  for (std::uint32_t i = 0; i < 3; ++i) corner.segments.push_back({{i, (i + 1) % 3}, 1, std::nullopt});
  EXPECT_THROW(coarsen<2>(finest, {{1, build_domain(corner)}, {2, square}}), InputError);
}

/// The area that two triangles have in common, by clipping one against the sides of the other.
double common_area(const std::array<Vec<2>, 3>& a, const std::array<Vec<2>, 3>& b) {
  std::vector<Vec<2>> polygon(a.begin(), a.end());
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec<2> p = b[i], along = b[(i + 1) % 3] - p;
    std::vector<Vec<2>> kept;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec<2> x = polygon[k], y = polygon[(k + 1) % polygon.size()];
      const double hx = cross(along, x - p), hy = cross(along, y - p);
      if (hx >= 0) kept.push_back(x);
      if ((hx < 0) != (hy < 0)) kept.push_back(x + (hx / (hx - hy)) * (y - x));
    }
    polygon = kept;
  }
  double twice = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k)
    twice += cross(polygon[k] - polygon[0], polygon[(k + 1) % polygon.size()] - polygon[0]);
  return 0.5 * twice;
}

template <int D>
std::array<Vec<D>, D + 1> corners_of(const Mesh<D>& mesh, SimplexId s) {
  std::array<Vec<D>, D + 1> x;
  for (std::size_t i = 0; i <= D; ++i) x[i] = mesh.points[mesh.simplex_vertices[s][i]];
  return x;
}

TEST(Hierarchy, IntersectionsAreThoseOfPositiveArea) {
  const Mesh<2> finest = test::mesh_of(domains::l_shape<2>(), 0.1, Interior::kRandom);
  CoarseningOptions options;
  options.levels = 2;
  const CoarseningHierarchy<2> hierarchy = coarsen(finest, options);
  const Mesh<2>* finer = &finest;
  for (const CoarseLevel<2>& level : hierarchy.levels) {
    const auto counts = count_intersections(*finer, level);
    for (const SimplexId s : ids(level.mesh.simplex_vertices)) {
      std::uint32_t n = 0;
      for (const SimplexId t : ids(finer->simplex_vertices))
        if (common_area(corners_of(level.mesh, s), corners_of(*finer, t)) > 1e-13) ++n;
      EXPECT_EQ(counts[s], n);
    }
    finer = &level.mesh;
  }
}

/// Of a mesh with itself: each simplex meets itself and only touches others.
template <int D>
void a_mesh_meets_itself_once() {
  CoarseLevel<D> level;
  level.mesh = test::mesh_of(domains::l_shape<D>(), 0.4);  // A lattice: full of parallel edges.
  for (const VertexId v : ids(level.mesh.points)) level.finer_vertex.push_back(v);
  for (const std::uint32_t n : count_intersections(level.mesh, level)) EXPECT_EQ(n, 1U);
}
TEST(Hierarchy, AMeshMeetsItselfOnceInThePlane) { a_mesh_meets_itself_once<2>(); }
TEST(Hierarchy, AMeshMeetsItselfOnceInSpace) { a_mesh_meets_itself_once<3>(); }

struct HalfSpace {
  Vec<3> normal;  ///< Of length 1, inwards.
  double offset;
  [[nodiscard]] double depth(const Vec<3>& x) const { return dot(normal, x) - offset; }
};

void add_half_spaces(const std::array<Vec<3>, 4>& t, std::vector<HalfSpace>& out) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec<3> a = t[(i + 1) % 4], b = t[(i + 2) % 4], c = t[(i + 3) % 4];
    Vec<3> normal = cross(b - a, c - a);
    normal = normal / (dot(normal, t[i] - a) > 0 ? norm(normal) : -norm(normal));
    out.push_back({normal, dot(normal, a)});
  }
}

/// How deep the middle of the corners of the intersection lies in it: corners are where three of the eight planes meet.
double common_depth(const std::array<Vec<3>, 4>& a, const std::array<Vec<3>, 4>& b) {
  std::vector<HalfSpace> spaces;
  add_half_spaces(a, spaces);
  add_half_spaces(b, spaces);
  const auto depth = [&](const Vec<3>& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const HalfSpace& h : spaces) least = std::min(least, h.depth(x));
    return least;
  };
  Vec<3> sum;
  double n = 0;
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = i + 1; j < 8; ++j)
      for (std::size_t k = j + 1; k < 8; ++k) {
        const Vec<3>&p = spaces[i].normal, &q = spaces[j].normal, &r = spaces[k].normal;
        const double volume = dot(p, cross(q, r));
        if (std::abs(volume) < 1e-6) continue;
        const Vec<3> x =
            (spaces[i].offset * cross(q, r) + spaces[j].offset * cross(r, p) + spaces[k].offset * cross(p, q)) / volume;
        if (depth(x) < -1e-9) continue;
        sum += x;
        n += 1;
      }
  return n > 0 ? depth(sum / n) : -1;
}

TEST(Hierarchy, IntersectionsInSpaceHaveDepth) {
  const Mesh<3> finest = test::mesh_of(domains::l_shape<3>(), 0.35, Interior::kRandom);
  CoarseningOptions options;
  options.levels = 1;
  const CoarseningHierarchy<3> hierarchy = coarsen(finest, options);
  ASSERT_EQ(hierarchy.levels.size(), 1U);
  const CoarseLevel<3>& level = hierarchy.levels[0];
  const auto counts = count_intersections(finest, level);
  for (std::size_t i = 0; i < level.mesh.simplex_vertices.size(); i += 5) {
    const SimplexId s(i);
    std::uint32_t n_deep = 0, n_any = 0;
    for (const SimplexId t : ids(finest.simplex_vertices)) {
      const double depth = common_depth(corners_of(level.mesh, s), corners_of(finest, t));
      if (depth > 4e-6) ++n_deep;
      if (depth > -1e-8) ++n_any;  // Those that touch, too.
    }
    EXPECT_GE(counts[s], n_deep);
    EXPECT_LE(counts[s], n_any);
  }
}

}  // namespace
}  // namespace voropack
