// The sphere-packing engine on small polytopes: active cells, the three forms of maximality, labels of regions.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "spheres/active_cells.h"
#include "spheres/pack_interior.h"
#include "spheres/region_labels.h"
#include "support/domains.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

using test::random_point;

template <int K>
LocalSpacing<K> graded(double f0, double b) {
  return {[=](const Vec<K>& x) { return f0 + b * norm(x); },
          [=](const Box<K>&) { return b == 0 ? std::optional<double>(f0) : std::nullopt; }, b};
}

/// All of the unit box, nothing packed yet.
template <int K>
PackingProblem<K> unit_problem(double f0, double b) {
  PackingProblem<K> p;
  for (int k = 0; k < K; ++k) {
    p.bounds.lo[k] = 0;
    p.bounds.hi[k] = 1;
  }
  p.spacing = graded<K>(f0, b);
  return p;
}

/// The sides of the unit box: region 0 inside.
template <int K>
WallLocator<K> unit_walls() {
  const DomainInput<K> input = domains::unit_box<K>();
  Walls<K> walls;
  if constexpr (K == 2) {
    for (const auto& s : input.segments) {
      walls.simplices.push_back({input.points[s.points[0]], input.points[s.points[1]]});
      walls.regions.push_back({0, Walls<K>::kOutside});
    }
  } else {
    for (const auto& f : input.facets)
      for (std::size_t k = 2; k < f.polygons[0].size(); ++k) {
        const auto& p = f.polygons[0];
        walls.simplices.push_back({input.points[p[0]], input.points[p[k - 1]], input.points[p[k]]});
        walls.regions.push_back({Walls<K>::kOutside, 0});
      }
  }
  return WallLocator<K>(std::move(walls));
}

template <int K>
void expect_packing(const std::vector<Ball<K>>& spheres, const PackingProblem<K>& p) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    EXPECT_TRUE(p.bounds.contains(spheres[i].center));
    EXPECT_EQ(spheres[i].radius, p.spacing.at(spheres[i].center));
    EXPECT_FALSE(p.balls.size() == 1 && distance(spheres[i].center, p.balls[0].center) < p.balls[0].radius);
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_FALSE(SphereSet<K>::overlap(spheres[j], spheres[i].center, spheres[i].radius));
  }
}

/// When no cell is left, no point can be added; with cells left, none is farther from a blocked point than they say.
template <int K>
void cells_hold_all_room(bool lattice, double b) {
  PackingProblem<K> p = unit_problem<K>(0.05, b);
  const WallLocator<K> walls = unit_walls<K>();
  p.walls = &walls;
  Vec<K> middle;
  for (int k = 0; k < K; ++k) middle[k] = 0.5;
  p.balls = {{middle, 0.2}};
  p.fixed = {{Vec<K>{}, p.spacing.at({})}};
  ActiveCells<K> cells(p, lattice, silent_observer());
  double openness = cells.openness();
  for (int level = 0; level < 40 && cells.size() > 0; ++level) {
    cells.throw_darts();
    cells.split();
    EXPECT_LE(cells.openness(), openness);
    openness = cells.openness();
    if (openness < 0.05) break;
  }
  expect_packing(cells.spheres().spheres(), p);
  EXPECT_EQ(cells.regions().size() + cells.first_new(), cells.spheres().size());
  Random random(3);
  BallSet<K> forbidden({});
  forbidden.add(p.balls[0]);
  int open = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec<K> x = random_point<K>(random);
    if (!p.admits(cells.spheres(), forbidden, x, p.spacing.at(x))) continue;
    ++open;
    EXPECT_GT(cells.size(), 0U);
  }
  EXPECT_LT(open, 30);  // Cells of 1/20 f leave slits only.
}
TEST(ActiveCells, HoldAllRoom) {
  cells_hold_all_room<2>(false, 0);
  cells_hold_all_room<2>(true, 0);
  cells_hold_all_room<2>(false, 0.2);
  cells_hold_all_room<3>(true, 0);
}

/// Every ball of radius epsilon f meets a blocked point: sampled by the nearest blocked point of a fine cloud around.
template <int K>
void epsilon_forms_leave_no_ball_open(PackingForm form) {
  PackingProblem<K> p = unit_problem<K>(0.06, 0.1);
  p.form = form;
  p.epsilon = 0.25;
  const PackedInterior<K> packed = pack_interior(p, false, silent_observer());
  expect_packing(packed.spheres, p);
  EXPECT_TRUE(packed.triangulation.simplices.empty());
  SphereSet<K> set({}, p.spacing.lipschitz, 0.06);
  for (const Ball<K>& s : packed.spheres) set.add(s);
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const Vec<K> x = random_point<K>(random);
    const double f = p.spacing.at(x);
    bool blocked = set.conflicts(x, f);
    for (int j = 0; j < 100 && !blocked; ++j) {
      Vec<K> d = random_point<K>(random);
      for (int k = 0; k < K; ++k) d[k] = 2 * d[k] - 1;
      const Vec<K> y = x + (p.epsilon * f / std::max(1.0, norm(d))) * d;
      blocked = !p.bounds.contains(y) || set.conflicts(y, p.spacing.at(y));
    }
    ASSERT_TRUE(blocked);
  }
}
TEST(PackInterior, EpsilonFormsLeaveNoBallOpen) {
  for (const PackingForm form : {PackingForm::kMaximal, PackingForm::kFiltered}) {
    epsilon_forms_leave_no_ball_open<2>(form);
    epsilon_forms_leave_no_ball_open<3>(form);
  }
}

/// Without walls the bounds are region 0, and nothing outside of them is.
template <int K>
void without_walls_the_bounds_are_the_region(PackingForm form) {
  PackingProblem<K> p = unit_problem<K>(0.08, 0);
  p.bounds.hi[0] = 0.7;
  p.form = form;
  p.lattice_first = true;
  Vec<K> outside;
  for (int k = 0; k < K; ++k) outside[k] = 0.5;
  EXPECT_EQ(p.region_of(outside), 0);
  outside[0] = 0.75;
  EXPECT_EQ(p.region_of(outside), Walls<K>::kOutside);
  const PackedInterior<K> packed = pack_interior(p, true, silent_observer());
  EXPECT_GT(packed.spheres.size(), 10U);
  expect_packing(packed.spheres, p);
  EXPECT_TRUE(std::all_of(packed.regions.begin(), packed.regions.end(), [](int region) { return region == 0; }));
  EXPECT_FALSE(packed.triangulation.simplices.empty());
}
TEST(PackInterior, WithoutWallsTheBoundsAreTheRegion) {
  for (const PackingForm form : {PackingForm::kVoronoi, PackingForm::kMaximal}) {
    without_walls_the_bounds_are_the_region<2>(form);
    without_walls_the_bounds_are_the_region<3>(form);
  }
}

TEST(PackInterior, OneDimensionFillsASegment) {
  PackingProblem<1> p = unit_problem<1>(0.01, 0);
  p.fixed = {{{0.0}, 0.01}, {{1.0}, 0.01}};
  p.form = PackingForm::kMaximal;
  const auto packed = pack_interior(p, false, silent_observer());
  expect_packing(packed.spheres, p);
  // At best 49 fit; a maximal packing has at least half of the most.
  EXPECT_GE(packed.spheres.size(), 25U);
  EXPECT_LE(packed.spheres.size(), 49U);
}

TEST(Equidistribute, EqualGapsForConstantSpacing) {
  const auto at = equidistribute(1, graded<1>(0.05, 0));
  ASSERT_EQ(at.size(), 9U);
  for (std::size_t i = 0; i < at.size(); ++i) EXPECT_NEAR(at[i], 0.1 * static_cast<double>(i + 1), 1e-12);
  EXPECT_TRUE(equidistribute(1, graded<1>(0.5, 0)).empty());
  EXPECT_TRUE(equidistribute(1, graded<1>(0.26, 0)).empty());
  EXPECT_EQ(equidistribute(1, graded<1>(0.25, 0)).size(), 1U);
}

/// The unit square cut by a wall from (0.5, 0) to (0.5, 1): regions 0 and 1.
struct CutSquare {
  DelaunayKernel<2> kernel;
  std::vector<Vec<2>> points = {Vec<2>{0, 0}, Vec<2>{0.5, 0},   Vec<2>{1, 0},      Vec<2>{1, 1},     Vec<2>{0.5, 1},
                                Vec<2>{0, 1}, Vec<2>{0.5, 0.5}, Vec<2>{0.2, 0.55}, Vec<2>{0.8, 0.45}};
  std::vector<ProtectedFace<2>> faces = {{{0, 1}, {0, -1}}, {{1, 2}, {1, -1}}, {{2, 3}, {1, -1}}, {{3, 4}, {1, -1}},
                                         {{4, 5}, {0, -1}}, {{5, 0}, {0, -1}}, {{1, 6}, {0, 1}},  {{4, 6}, {1, 0}}};
};

TEST(RegionLabels, FollowTheWalls) {
  CutSquare c;
  c.kernel.insert(c.points);
  const RegionLabels<2> labels = label_regions<2>(c.kernel, c.faces);
  EXPECT_TRUE(labels.missing_faces.empty());
  EXPECT_TRUE(labels.leaking_faces.empty());
  std::array<int, 2> count{};
  for (std::uint32_t s = 0; s < c.kernel.n_slots(); ++s) {
    if (!c.kernel.is_finite(s)) {
      EXPECT_EQ(labels.region[s], Walls<2>::kOutside);
      continue;
    }
    double x = 0;
    for (const std::uint32_t v : c.kernel.corners(s)) x += c.points[v][0] / 3;
    EXPECT_EQ(labels.region[s], x < 0.5 ? 0 : 1);
    ++count[static_cast<std::size_t>(labels.region[s])];
  }
  EXPECT_EQ(count[0], 5);
  EXPECT_EQ(count[1], 5);
  const Triangulation<2> t = export_triangulation(c.kernel, labels.region);
  ASSERT_EQ(t.simplices.size(), 10U);
  for (std::uint32_t s = 0; s < 10; ++s)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t n = t.neighbors[s][i];
      if (n == Triangulation<2>::kNoNeighbor) continue;
      EXPECT_EQ(std::count(t.neighbors[n].begin(), t.neighbors[n].end(), s), 1);
    }
}

TEST(RegionLabels, WithoutFacesAllThatIsFiniteIsRegionZero) {
  CutSquare c;
  c.kernel.insert(c.points);
  const RegionLabels<2> labels = label_regions<2>(c.kernel, {});
  EXPECT_TRUE(labels.missing_faces.empty());
  for (std::uint32_t s = 0; s < c.kernel.n_slots(); ++s)
    EXPECT_EQ(labels.region[s], c.kernel.is_finite(s) ? 0 : Walls<2>::kOutside);
  EXPECT_EQ(export_triangulation(c.kernel, labels.region).simplices.size(), 10U);
}

TEST(RegionLabels, NamesFacesThatAreMissing) {
  CutSquare c;
  c.faces.push_back({{7, 8}, {0, 0}});
  c.faces.push_back({{0, 3}, {0, 0}});  // The long diagonal is no edge.
  c.kernel.insert(c.points);
  EXPECT_EQ(label_regions<2>(c.kernel, c.faces).missing_faces, std::vector<std::uint32_t>({8, 9}));
}

TEST(RegionLabels, NamesFacesThatLeak) {
  CutSquare c;
  std::swap(c.faces[6].regions[0], c.faces[6].regions[1]);
  c.kernel.insert(c.points);
  const auto labels = label_regions<2>(c.kernel, c.faces);
  EXPECT_TRUE(labels.missing_faces.empty());
  EXPECT_NE(std::count(labels.leaking_faces.begin(), labels.leaking_faces.end(), 6U), 0);
}

}  // namespace
}  // namespace voropack
