// Coarsening beyond the boundary: what holds for every level, on meshes of every kind, and Figure 8 on the airfoil.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "geom/predicates.h"
#include "support/cases.h"
#include "support/level_checks.h"
#include "support/shared_data.h"
#include "voropack/coarsening.h"
#include "voropack/io.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

struct Angles {
  double least = 180, largest = 0;
};

Angles angles_of(const Mesh<2>& mesh) {
  Angles angles;
  for (const auto& c : mesh.simplex_vertices)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec<2> u = mesh.points[c[(i + 1) % 3]] - mesh.points[c[i]];
      const Vec<2> v = mesh.points[c[(i + 2) % 3]] - mesh.points[c[i]];
      const double angle = 180 / std::numbers::pi * std::atan2(cross(u, v), dot(u, v));
      angles.least = std::min(angles.least, angle);
      angles.largest = std::max(angles.largest, angle);
    }
  return angles;
}

std::map<int, double> areas_of(const Mesh<2>& mesh) {
  std::map<int, double> areas;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    areas[mesh.simplex_region[s]] +=
        0.5 * cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
  }
  return areas;
}

/// The area that the boundary edges around each region enclose: no triangle is missing if those of the region have it.
std::map<int, double> enclosed_areas(const Mesh<2>& mesh) {
  std::map<std::array<VertexId, 2>, int> left;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    for (std::size_t i = 0; i < 3; ++i) left[{c[i], c[(i + 1) % 3]}] = mesh.simplex_region[s];
  }
  std::map<int, double> areas;
  for (const auto& [a, b] : mesh.boundary_vertices)
    for (const auto& edge : {std::array{a, b}, std::array{b, a}})
      if (const auto at = left.find(edge); at != left.end())
        areas[at->second] += 0.5 * cross(mesh.points[edge[0]], mesh.points[edge[1]]);
  return areas;
}

/// Boundary loops: connected components of the boundary's graph.
std::size_t n_boundary_parts(const Mesh<2>& mesh) {
  IdVector<VertexId, VertexId> root(mesh.points.size());
  for (const VertexId v : ids(mesh.points)) root[v] = v;
  const auto find = [&](VertexId v) {
    while (root[v] != v) v = root[v];
    return v;
  };
  std::size_t n = 0;
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (const auto& [a, b] : mesh.boundary_vertices) {
    for (const VertexId v : {a, b}) n += used[v.value()]++ == 0 ? 1U : 0U;
    if (find(a) != find(b)) root[find(a)] = find(b), --n;
  }
  return n;
}

void expect_empty_balls(const Mesh<2>& mesh) {
  // Delaunay: the vertex across each edge is not inside of the circumcircle. With the balls of boundary edges empty,
  // this holds for all vertices.
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    for (const SimplexId t : mesh.simplex_neighbors[s]) {
      if (t.is_none()) continue;
      for (const VertexId v : mesh.simplex_vertices[t])
        ASSERT_LE(in_circumball(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[v]), 0);
    }
  }
  for (const auto& [a, b] : mesh.boundary_vertices)
    for (const VertexId v : ids(mesh.points))
      if (v != a && v != b) {
        ASSERT_LE(in_diametral_ball(mesh.points[a], mesh.points[b], mesh.points[v]), 0);
      }
}

/// The largest distance of a vertex of one boundary from the other boundary.
double vertex_distance(const Mesh<2>& from, const Mesh<2>& to) {
  double farthest = 0;
  for (const auto& edge : from.boundary_vertices)
    for (const VertexId v : edge) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [a, b] : to.boundary_vertices) {
        const Vec<2> x = from.points[v] - to.points[a], ab = to.points[b] - to.points[a];
        nearest = std::min(nearest, norm(x - std::clamp(dot(x, ab) / norm_sq(ab), 0.0, 1.0) * ab));
      }
      farthest = std::max(farthest, nearest);
    }
  return farthest;
}

/// The laws of every level, whatever was improved.
void expect_laws(const Mesh<2>& fine, const std::vector<SimplifiedLevel<2>>& levels,
                 const BeyondBoundaryOptions& options) {
  const std::map<int, double> fine_areas = areas_of(fine);
  const Mesh<2>* finer = &fine;
  for (const SimplifiedLevel<2>& level : levels) {
    SCOPED_TRACE(level.mesh.points.size());
    EXPECT_EQ(find_mesh_fault(level.mesh), "");
    test::expect_nested(fine, *finer, level);
    EXPECT_LE(level.mesh.points.size(), finer->points.size());
    expect_empty_balls(level.mesh);
    const auto areas = areas_of(level.mesh), enclosed = enclosed_areas(level.mesh);
    ASSERT_EQ(areas.size(), fine_areas.size());
    for (const auto& [region, area] : areas) {
      EXPECT_NEAR(area / fine_areas.at(region), 1, std::max(level.area_change, 0.0) + 1e-9);
      EXPECT_NEAR(enclosed.at(region) / area, 1, 1e-9);
    }
    EXPECT_LE(level.area_change, options.max_area_change);
    EXPECT_EQ(n_boundary_parts(level.mesh), n_boundary_parts(fine));
    EXPECT_LE(vertex_distance(fine, level.mesh), level.boundary_distance + 1e-12);
    if (options.improvement != LocalImprovement::kFree) {
      EXPECT_LE(level.largest_overlap, 1e-12);
      for (const VertexId u : ids(level.mesh.points))
        for (VertexId v = u; v < VertexId(level.mesh.points.size()); ++v) {
          if (u == v) continue;
          ASSERT_GE(distance(level.mesh.points[u], level.mesh.points[v]) * (1 + 1e-12),
                    level.mesh.vertex_spacing[u] + level.mesh.vertex_spacing[v]);
        }
    }
    finer = &level.mesh;
  }
}

Mesh<2> disk(double size) {
  DomainInput<2> input;
  constexpr std::uint32_t n = 120;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n;
    input.points.emplace_back(std::cos(t), std::sin(t));
    input.segments.push_back({{i, (i + 1) % n}, 1, std::nullopt});
  }
  return test::mesh_of(input, size);
}

constexpr std::array kImprovements = {LocalImprovement::kNone, LocalImprovement::kPacked, LocalImprovement::kFree};

TEST(BeyondBoundary, LevelsAreNestedConformingAndWholeOnEveryDomain) {
  for (const auto& c : test::all_cases<2>()) {
    const double size = std::sqrt(c.measure) / 16;
    const Mesh<2> fine = test::mesh_of(c.input, size);
    for (const LocalImprovement improvement : kImprovements) {
      SCOPED_TRACE(c.name);
      BeyondBoundaryOptions options;
      options.levels = 2;
      options.improvement = improvement;
      options.trials = 40;
      expect_laws(fine, coarsen_beyond_boundary(fine, options), options);
    }
  }
}

TEST(BeyondBoundary, DiskReachesNumbersOfVerticesFromBelow) {
  const Mesh<2> fine = disk(0.06);
  BeyondBoundaryOptions options;
  options.target_vertices = {fine.points.size() / 4, fine.points.size() / 12};
  options.trials = 60;
  const auto levels = coarsen_beyond_boundary(fine, options);
  expect_laws(fine, levels, options);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LE(levels[i].mesh.points.size(), options.target_vertices[i]);
    EXPECT_GE(levels[i].mesh.points.size(), options.target_vertices[i] * 3 / 4);
  }
  EXPECT_GT(levels[1].boundary_distance, 0);
}

TEST(BeyondBoundary, LevelsThatGainNothingAreLeftOut) {
  const Mesh<2> fine = test::mesh_of(domains::unit_square(), 0.2);
  BeyondBoundaryOptions options;
  options.levels = 8;
  options.trials = 20;
  const auto levels = coarsen_beyond_boundary(fine, options);
  EXPECT_GE(levels.size(), 1U);
  EXPECT_LT(levels.size(), 8U);
  expect_laws(fine, levels, options);
}

TEST(BeyondBoundary, ImprovementImprovesTheWorstAngle) {
  const Mesh<2> fine = disk(0.06);
  BeyondBoundaryOptions options;
  options.target_vertices = {fine.points.size() / 6};
  options.improvement = LocalImprovement::kNone;
  const Angles packed = angles_of(coarsen_beyond_boundary(fine, options)[0].mesh);
  options.improvement = LocalImprovement::kFree;
  const Angles improved = angles_of(coarsen_beyond_boundary(fine, options)[0].mesh);
  EXPECT_GT(improved.least, packed.least);
}

TEST(BeyondBoundary, SameSeedGivesTheSameLevels) {
  const Mesh<2> fine = disk(0.1);
  BeyondBoundaryOptions options;
  options.levels = 2;
  options.trials = 30;
  const auto a = coarsen_beyond_boundary(fine, options), b = coarsen_beyond_boundary(fine, options);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(a[i].mesh, b[i].mesh);
  options.seed = 2;
  EXPECT_NE(coarsen_beyond_boundary(fine, options)[0].mesh, a[0].mesh);
}

TEST(BeyondBoundary, RefusesWhatItCannotDo) {
  const Mesh<2> fine = disk(0.3);
  const auto refuses = [&](auto change) {
    BeyondBoundaryOptions options;
    change(options);
    EXPECT_THROW(coarsen_beyond_boundary(fine, options), OptionError);
  };
  refuses([](auto& o) { o.levels = 0; });
  refuses([](auto& o) { o.growth = 1; });
  refuses([](auto& o) { o.lipschitz = 1; });
  refuses([](auto& o) { o.restarts = 0; });
  refuses([](auto& o) { o.trials = -1; });
  refuses([](auto& o) { o.max_area_change = 0; });
  refuses([](auto& o) { o.target_vertices = {10, 20}; });
}

TEST(BeyondBoundary, AirfoilBeatsFigure8) {
  const auto path = test::shared_data("airfoil/airfoil.node");
  if (!path) GTEST_SKIP() << "no shared data";
  const auto fine = std::get<Mesh<2>>(read_mesh(*path));
  BeyondBoundaryOptions options;
  options.target_vertices = {1039, 416, 217, 86};
  const auto levels = coarsen_beyond_boundary(fine, options);
  expect_laws(fine, levels, options);
  constexpr std::array<double, 4> kLeast = {21, 22, 22, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i + 1);
    EXPECT_LE(levels[i].mesh.points.size(), options.target_vertices[i]);
    const Angles angles = angles_of(levels[i].mesh);
    EXPECT_GE(angles.least, kLeast[i]);
    EXPECT_LE(angles.largest, 128);
  }
}

TEST(BeyondBoundary, PackedAirfoilBeatsFigure8) {
  const auto path = test::shared_data("airfoil/airfoil.node");
  if (!path) GTEST_SKIP() << "no shared data";
  const auto fine = std::get<Mesh<2>>(read_mesh(*path));
  BeyondBoundaryOptions options;
  options.target_vertices = {1039, 416, 217, 86};
  options.improvement = LocalImprovement::kPacked;
  constexpr std::array<double, 4> kPaper = {15.45, 20.09, 20.21, 17.38};
  const auto levels = coarsen_beyond_boundary(fine, options);
  expect_laws(fine, levels, options);
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i + 1);
    EXPECT_LE(levels[i].mesh.points.size(), options.target_vertices[i]);
    EXPECT_EQ(levels[i].largest_overlap, 0);
    EXPECT_GT(angles_of(levels[i].mesh).least, kPaper[i]);
  }
}

}  // namespace
}  // namespace voropack
