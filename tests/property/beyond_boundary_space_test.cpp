// Coarsening beyond the boundary in space: what holds for every level, on surfaces of every kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "base/parallel.h"
#include "coarsening/edge_balls.h"
#include "geom/circumcenter.h"
#include "geom/polytope_distance.h"
#include "support/cases.h"
#include "support/curved_domains.h"
#include "support/level_checks.h"
#include "support/shared_data.h"
#include "voropack/coarsening.h"
#include "voropack/io.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

namespace d = domains;

std::map<int, double> volumes_of(const Mesh<3>& mesh) {
  std::map<int, double> volumes;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    const Vec<3>& o = mesh.points[c[0]];
    volumes[mesh.simplex_region[s]] +=
        dot(mesh.points[c[1]] - o, cross(mesh.points[c[2]] - o, mesh.points[c[3]] - o)) / 6;
  }
  return volumes;
}

/// Vertices - edges + triangles of the boundary faces of each marker; all together under marker -1.
std::map<int, long> euler_characteristics(const Mesh<3>& mesh, bool by_marker) {
  std::map<int, std::array<std::set<std::set<std::uint32_t>>, 3>> cells;
  for (const BoundaryId f : ids(mesh.boundary_vertices))
    for (const int key : {-1, by_marker ? mesh.boundary_marker[f] : -1}) {
      const auto& v = mesh.boundary_vertices[f];
      for (std::size_t i = 0; i < 3; ++i) {
        cells[key][0].insert({v[i].value()});
        cells[key][1].insert({v[i].value(), v[(i + 1) % 3].value()});
      }
      cells[key][2].insert({v[0].value(), v[1].value(), v[2].value()});
    }
  std::map<int, long> result;
  for (const auto& [key, c] : cells)
    result[key] = static_cast<long>(c[0].size()) - static_cast<long>(c[1].size()) + static_cast<long>(c[2].size());
  return result;
}

/// Of boundary vertices of `from`, the largest distance to the boundary of `to`, by trying all.
double vertex_distance(const Mesh<3>& from, const Mesh<3>& to) {
  std::set<VertexId> vertices;
  for (const auto& face : from.boundary_vertices) vertices.insert(face.begin(), face.end());
  double farthest = 0;
  for (const VertexId v : vertices) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : to.boundary_vertices)
      nearest = std::min(nearest, distance_to_triangle(from.points[v], to.points[a], to.points[b], to.points[c]));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

void expect_laws(const Mesh<3>& fine, const std::vector<SimplifiedLevel<3>>& levels,
                 const BeyondBoundaryOptions& options) {
  const std::map<int, double> fine_volumes = volumes_of(fine);
  const auto fine_euler = euler_characteristics(fine, !options.merge_markers);
  const Mesh<3>* finer = &fine;
  for (const SimplifiedLevel<3>& level : levels) {
    SCOPED_TRACE(level.mesh.points.size());
    EXPECT_EQ(find_mesh_fault(level.mesh), "");
    test::expect_nested(fine, *finer, level);
    EXPECT_LT(level.mesh.points.size(), finer->points.size());
    test::expect_certified<3>(level, nullptr);
    EXPECT_LE(level.area_change, options.max_area_change);
    const std::map<int, double> volumes = volumes_of(level.mesh);
    ASSERT_EQ(volumes.size(), fine_volumes.size());
    double change = 0;
    for (const auto& [region, volume] : volumes)
      change = std::max(change, std::abs(volume / fine_volumes.at(region) - 1));
    EXPECT_NEAR(change, level.area_change, 1e-9);
    EXPECT_EQ(euler_characteristics(level.mesh, !options.merge_markers), fine_euler);
    EXPECT_GE(level.boundary_distance * (1 + 1e-9) + 1e-12, vertex_distance(fine, level.mesh));
    ASSERT_EQ(level.prolongation.offsets.size(), finer->points.size() + 1);
    for (std::size_t row = 0; row + 1 < level.prolongation.offsets.size(); ++row) {
      double sum = 0;
      for (auto k = level.prolongation.offsets[row]; k < level.prolongation.offsets[row + 1]; ++k) {
        EXPECT_GT(level.prolongation.values[k], 0);
        sum += level.prolongation.values[k];
      }
      EXPECT_NEAR(sum, 1, 1e-12);
    }
    finer = &level.mesh;
  }
}

DomainInput<3> ball_in_box() {
  DomainInput<3> input = d::box<3>({-1, -1, -1}, {1, 1, 1});
  std::vector<std::array<double, 2>> profile;
  for (int i = 1; i < 8; ++i) {
    const double angle = std::numbers::pi * i / 8;
    profile.push_back({-0.6 * std::cos(angle), 0.6 * std::sin(angle)});
  }
  d::add_body_of_revolution(input, profile, -0.6, 0.6, 17);
  input.region_seeds = {{{0, 0, 0}, 1, std::nullopt}, {{0.9, 0.9, 0.9}, 2, std::nullopt}};
  return input;
}

TEST(BeyondBoundaryInSpace, LevelsOfEveryDomainKeepTheLaws) {
  for (const auto& one : test::all_cases<3>()) {
    SCOPED_TRACE(one.name);
    const Mesh<3> fine = test::mesh_of(one.input, 0.25 * std::cbrt(one.measure));
    BeyondBoundaryOptions options;
    options.levels = 3;
    const auto levels = coarsen_beyond_boundary(fine, options);
    EXPECT_GE(levels.size(), 1U);
    expect_laws(fine, levels, options);
  }
}

TEST(BeyondBoundaryInSpace, ACurvedBoundaryIsSimplifiedAndItsNeckStays) {
  const Mesh<3> fine = test::mesh_of(d::dumbbell(), 0.15);
  BeyondBoundaryOptions options;
  options.max_area_change = 0.2;
  const auto levels = coarsen_beyond_boundary(fine, options);
  ASSERT_GE(levels.size(), 3U);
  expect_laws(fine, levels, options);
  // Within the boundary each of its vertices stays.
  const auto within = coarsen<3>(fine);
  EXPECT_LT(3 * levels.back().mesh.points.size(), within.levels.back().mesh.points.size());
  EXPECT_LT(levels.back().boundary_distance, 0.15);
}

TEST(BeyondBoundaryInSpace, AnInterfaceStaysBetweenItsRegions) {
  const Mesh<3> fine = test::mesh_of(ball_in_box(), 0.2);
  for (const double change : {0.02, 0.2}) {
    BeyondBoundaryOptions options;
    options.max_area_change = change;
    const auto levels = coarsen_beyond_boundary(fine, options);
    ASSERT_GE(levels.size(), 1U);
    expect_laws(fine, levels, options);
  }
}

TEST(BeyondBoundaryInSpace, ASmallerVolumeChangeMovesTheBoundaryLess) {
  const Mesh<3> fine = test::mesh_of(d::dumbbell(), 0.15);
  std::vector<std::size_t> sizes;
  for (const double change : {1e-6, 0.01, 0.2}) {
    BeyondBoundaryOptions options;
    options.levels = 2;
    options.max_area_change = change;
    const auto levels = coarsen_beyond_boundary(fine, options);
    ASSERT_GE(levels.size(), 1U);
    EXPECT_LE(levels.back().area_change, change);
    sizes.push_back(levels.back().mesh.points.size());
  }
  EXPECT_GE(sizes[0], sizes[1]);
  EXPECT_GT(sizes[1], sizes[2]);
}

TEST(BeyondBoundaryInSpace, MarkersAreJoinedOnlyIfAsked) {
  DomainInput<3> input = d::dumbbell();
  for (std::size_t f = 0; f < input.facets.size(); ++f) input.facets[f].marker = static_cast<int>(f) + 1;
  const Mesh<3> fine = test::mesh_of(input, 0.15);
  BeyondBoundaryOptions options;
  options.max_area_change = 0.2;
  options.levels = 2;
  const auto kept = coarsen_beyond_boundary(fine, options);
  expect_laws(fine, kept, options);
  options.merge_markers = true;
  const auto joined = coarsen_beyond_boundary(fine, options);
  ASSERT_EQ(joined.size(), 2U);
  expect_laws(fine, joined, options);
  for (const int marker : joined.back().mesh.boundary_marker)
    EXPECT_EQ(marker, joined.back().mesh.boundary_marker[BoundaryId(0)]);
  EXPECT_LT(joined.back().mesh.points.size(), (kept.empty() ? fine : kept.back().mesh).points.size());
}

TEST(BeyondBoundaryInSpace, CreasesStayIfTheyAreFeatures) {
  const Mesh<3> fine = test::mesh_of(d::box_with_through_hole(), 0.5);
  BeyondBoundaryOptions options;
  options.merge_markers = true;
  options.feature_angle_deg = 60;
  options.levels = 2;
  options.max_area_change = 0.3;
  const auto levels = coarsen_beyond_boundary(fine, options);
  ASSERT_GE(levels.size(), 1U);
  expect_laws(fine, levels, options);
  for (const auto& level : levels) EXPECT_LT(level.boundary_distance, 1e-9);
}

TEST(BeyondBoundaryInSpace, ThreadsDoNotMatter) {
  const Mesh<3> fine = test::mesh_of(ball_in_box(), 0.25);
  BeyondBoundaryOptions options;
  options.max_area_change = 0.1;
  std::vector<SimplifiedLevel<3>> one, two;
  run_with_threads(1, [&] { one = coarsen_beyond_boundary(fine, options); });
  run_with_threads(2, [&] { two = coarsen_beyond_boundary(fine, options); });
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].mesh, two[i].mesh);
    EXPECT_EQ(one[i].prolongation.values, two[i].prolongation.values);
    EXPECT_EQ(one[i].boundary_distance, two[i].boundary_distance);
  }
}

TEST(BeyondBoundaryInSpace, SharedSurfacesKeepTheLaws) {
  for (const char* name : {"plc/surfaces/sphere.off", "plc/surfaces/eight.off"}) {
    const auto path = test::shared_data(name);
    if (!path) GTEST_SKIP() << "no shared data";
    SCOPED_TRACE(name);
    const Mesh<3> fine = make_mesh(std::get<DomainInput<3>>(read_domain(*path))).mesh;
    BeyondBoundaryOptions options;
    options.merge_markers = true;
    options.feature_angle_deg = 40;
    options.max_area_change = 0.2;
    const auto levels = coarsen_beyond_boundary(fine, options);
    EXPECT_GE(levels.size(), 2U);
    expect_laws(fine, levels, options);
  }
}

TEST(BeyondBoundaryInSpace, NothingHasNoLevels) { EXPECT_TRUE(coarsen_beyond_boundary(Mesh<3>{}).empty()); }

TEST(BeyondBoundaryInSpace, NumbersOfVerticesAreComeCloseToFromBelow) {
  const Mesh<3> fine = test::mesh_of(d::dumbbell(), 0.15);
  for (const std::vector<std::size_t>& wished : {std::vector<std::size_t>{900}, {1000, 500, 250}}) {
    BeyondBoundaryOptions options;
    options.max_area_change = 0.2;
    options.target_vertices = wished;
    const auto levels = coarsen_beyond_boundary(fine, options);
    expect_laws(fine, levels, options);
    ASSERT_EQ(levels.size(), wished.size());
    for (std::size_t i = 0; i < levels.size(); ++i) {
      EXPECT_LE(levels[i].mesh.points.size(), wished[i]);
      EXPECT_GE(static_cast<double>(levels[i].mesh.points.size()), 0.95 * static_cast<double>(wished[i]));
    }
  }
}

TEST(BeyondBoundaryInSpace, TheNumberNearestAboveIsTakenWhereNoneIsBelow) {
  const Mesh<3> fine = test::mesh_of(d::dumbbell(), 0.15);
  BeyondBoundaryOptions options;
  options.target_vertices = {5};
  const auto levels = coarsen_beyond_boundary(fine, options);
  expect_laws(fine, levels, options);
  ASSERT_EQ(levels.size(), 1U);
  EXPECT_GT(levels[0].mesh.points.size(), 5U);
}

TEST(BeyondBoundaryInSpace, NumbersOfVerticesFallAndAreNotZero) {
  const Mesh<3> fine = test::mesh_of(d::unit_box<3>(), 0.5);
  for (const std::vector<std::size_t>& wished : {std::vector<std::size_t>{0}, {10, 10}, {10, 20}}) {
    BeyondBoundaryOptions options;
    options.target_vertices = wished;
    EXPECT_THROW(coarsen_beyond_boundary(fine, options), OptionError);
  }
}

/// Of the dual face of ab in the simplex abpq, with the sign that the certificate measures.
double dual_area_at(const Vec<3>& a, const Vec<3>& b, const Vec<3>& p, const Vec<3>& q) {
  const Vec<3> m = 0.5 * (a + b), along = (b - a) / distance(a, b);
  const Vec<3> of_p = triangle_circumcenter(a, b, p), of_q = triangle_circumcenter(a, b, q);
  const Vec<3> c = fast_circumcenter(std::array<Vec<3>, 4>{a, b, p, q});
  const double area = 0.5 * dot(along, cross(of_p - m, c - m) + cross(c - m, of_q - m));
  return dot(along, cross(p - a, q - a)) > 0 ? area : -area;
}

TEST(EdgeBalls, AreRefusedWhereTheSimplexOfBothTrianglesHasANegativeDualFace) {
  // Two triangles over the edge (-1, 0, 0), (1, 0, 0), bent upwards on both sides; only the region above has them.
  const Vec<3> a{-1, 0, 0}, b{1, 0, 0};
  std::size_t n_refused = 0, n_lifted = 0;
  for (const double height : {0.5, 0.7, 0.9})
    for (const double other : {1.2, 1.6, 2.4, 4.0})
      for (double turn = 0.05; turn < 1.5; turn += 0.05) {
        const Vec<3> p{0.1, -height, 0}, q{-0.2, other * std::cos(turn), other * std::sin(turn)};
        if (height * other <= 1.1) continue;
        const auto balls = edge_balls(a, b, p, q, {true, true});
        const double area = dual_area_at(a, b, p, q);
        if (!balls) {
          ++n_refused;
          continue;
        }
        ASSERT_EQ(balls->n, 3U);
        for (const Ball<3>& ball : balls->balls)
          for (const Vec<3>& x : {a, b}) EXPECT_NEAR(distance(ball.center, x), ball.radius, 1e-12);
        // Balls through p and q, too: nothing else can be at ab, and so the area is the simplex's.
        if (std::abs(distance(balls->balls[1].center, q) - balls->balls[1].radius) < 1e-9) {
          EXPECT_GT(area, 0);
        }
        // No center lies beyond the other triangle.
        const Vec<3> over_q{0, -std::sin(turn), std::cos(turn)};
        EXPECT_GE(dot(balls->balls[1].center, over_q), -1e-12);
        ++n_lifted;
      }
  EXPECT_GT(n_refused, 10U);
  EXPECT_GT(n_lifted, 10U);
}

TEST(EdgeBalls, AreAbsentInPlanesAndOneWhereNoAngleIsObtuse) {
  const Vec<3> a{-1, 0, 0}, b{1, 0, 0};
  EXPECT_EQ(edge_balls(a, b, {0, -0.5, 0}, {0, 2.5, 0}, {true, true})->n, 0U);
  EXPECT_EQ(edge_balls(a, b, {0, -1.5, 0}, {0, 1.5, 0.2}, {true, true})->n, 1U);
  EXPECT_EQ(edge_balls(a, b, {0, -0.9, 0}, {0, 2.5, 0.2}, {true, true})->n, 3U);
  // It bends towards z > 0, which is side 1 of (b-a) x (p-a); without a region there nothing is lifted.
  EXPECT_EQ(edge_balls(a, b, {0, -0.9, 0}, {0, 2.5, 0.2}, {true, false})->n, 1U);
  EXPECT_EQ(edge_balls(a, b, {0, -0.9, 0}, {0, 2.5, 0.2}, {false, true})->n, 3U);
}

}  // namespace
}  // namespace voropack
