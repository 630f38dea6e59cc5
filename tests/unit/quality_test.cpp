// The quality figures on meshes whose figures are known, and their laws on others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/circumcenter.h"
#include "quality/cell_balls.h"
#include "quality/spread.h"
#include "support/allow_threads.h"
#include "support/delaunay_mesh.h"
#include "voropack/dual.h"
#include "voropack/quality.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

template <int D>
QualityReport measure(const Mesh<D>& mesh) {
  return measure_quality(mesh, build_control_volumes(mesh));
}

Mesh<3> regular_tetrahedron() {
  return delaunay_mesh<3>({Vec<3>{1, 1, 1}, Vec<3>{1, -1, -1}, Vec<3>{-1, 1, -1}, Vec<3>{-1, -1, 1}});
}

TEST(Quality, OfTheRegularTetrahedron) {
  const QualityReport q = measure(regular_tetrahedron());
  EXPECT_NEAR(q.radius_edge.max, std::sqrt(3.0 / 8), 1e-14);
  EXPECT_NEAR(q.angle_deg.min, 60, 1e-12);
  EXPECT_NEAR(q.angle_deg.max, 60, 1e-12);
  EXPECT_NEAR(q.angle_deg.mean, 60, 1e-9);
  ASSERT_TRUE(q.dihedral_deg);
  EXPECT_NEAR(q.dihedral_deg->min, std::acos(1.0 / 3) * 180 / M_PI, 1e-12);
  EXPECT_NEAR(q.dihedral_deg->max, q.dihedral_deg->min, 1e-12);
  EXPECT_NEAR(q.edge_length.mean, std::sqrt(8.0), 1e-14);
  EXPECT_NEAR(q.volume_sum, 8.0 / 3, 1e-14);
  EXPECT_NEAR(q.domain_volume, 8.0 / 3, 1e-14);
  EXPECT_EQ(q.n_boundary_simplices, 4U);
  EXPECT_EQ(q.n_dual_faces, 6U);
}

TEST(Quality, OfTheUnitGrid) {
  const auto q = measure(delaunay_mesh(perturbed_grid<3>(4, 0)));
  EXPECT_EQ(q.n_vertices, 125U);
  EXPECT_EQ(q.n_cells, 125U);
  EXPECT_NEAR(q.volume_sum, 1, 1e-14);
  EXPECT_NEAR(q.radius_edge.max, std::sqrt(3.0) / 2, 1e-14);
  EXPECT_NEAR(q.edge_length.max, 0.25, 1e-15);
  // Cells are boxes: cubes, and halves, quarters and eighths of a cube. Halves are the longest: 1 x 1 x 1/2.
  EXPECT_NEAR(q.cell_aspect.min, std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(q.cell_aspect.max, 3, 1e-6);
  EXPECT_NEAR(q.min_face_area, 1.0 / 64, 1e-15);
  EXPECT_EQ(q.n_negative_faces, 0U);
}

TEST(Quality, OfTheSquareGrid) {
  const auto q = measure(delaunay_mesh(perturbed_grid<2>(4, 0)));
  EXPECT_NEAR(q.angle_deg.min, 45, 1e-12);
  EXPECT_NEAR(q.angle_deg.max, 90, 1e-12);
  EXPECT_NEAR(q.angle_deg.mean, 60, 0.01);
  EXPECT_FALSE(q.dihedral_deg);
  EXPECT_NEAR(q.cell_aspect.min, std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(q.cell_aspect.max, std::sqrt(5.0), 1e-6);
  // Two angles of 45 degrees for each of 90.
  EXPECT_EQ(q.angle_deg.histogram.bins[9], 2 * q.angle_deg.histogram.bins[18]);
}

TEST(Quality, FlatSliversHaveTheirTrueFigures) {
  for (const double eps : {1e-4, 1e-10, 1e-14}) {
    const auto q = measure(delaunay_mesh(perturbed_grid<3>(4, eps)));
    // Slivers are flat by the perturbation, but their spheres are those of the cubes.
    EXPECT_LT(q.dihedral_deg->min, 360 * eps);
    EXPECT_GT(q.dihedral_deg->max, 180 - 360 * eps - 1e-9);
    EXPECT_NEAR(q.radius_edge.max, std::sqrt(3.0) / 2, 4 * eps + 1e-12);
    EXPECT_NEAR(q.cell_aspect.max, 3, 20 * eps + 1e-6);
  }
}

TEST(Quality, RegionsAreCountedAndMeasured) {
  const auto mesh =
      delaunay_mesh<3>(perturbed_grid<3>(4, 1e-2, 1, true), [](const Vec<3>& x) { return x[0] < 0.5 ? 7 : 3; });
  const auto q = measure(mesh);
  ASSERT_EQ(q.regions.size(), 2U);
  EXPECT_EQ(q.regions[0].id, 3);
  EXPECT_EQ(q.regions[1].id, 7);
  EXPECT_EQ(q.regions[0].n_simplices + q.regions[1].n_simplices, mesh.simplex_vertices.size());
  for (const auto& region : q.regions) EXPECT_NEAR(region.volume, 0.5, 1e-14);
}

TEST(Quality, SpreadsAreOrderedAndCountEverything) {
  const auto mesh = delaunay_mesh(perturbed_grid<3>(5, 0.02));
  const auto q = measure(mesh);
  for (const auto& spread : {q.radius_edge, q.edge_length, q.angle_deg, *q.dihedral_deg, q.cell_aspect}) {
    EXPECT_LE(spread.min, spread.mean);
    EXPECT_LE(spread.mean, spread.max);
    EXPECT_LE(spread.p99, spread.max);
    EXPECT_GE(spread.p99, spread.min);
  }
  const auto total = [](const QualityReport::Spread& s) {
    std::uint64_t n = 0;
    for (const auto k : s.histogram.bins) n += k;
    return n;
  };
  EXPECT_EQ(total(q.radius_edge), q.n_simplices);
  EXPECT_EQ(total(*q.dihedral_deg), 6 * q.n_simplices);
  EXPECT_EQ(total(q.cell_aspect), q.n_cells);
  // Each interior face counts once, with three angles: 4 n = 2 interior + boundary.
  EXPECT_EQ(total(q.angle_deg), 3 * (4 * q.n_simplices + q.n_boundary_simplices) / 2);
}

TEST(Quality, ReentrantCornersGetFiniteFigures) {
  // Three quarters of a square: the cell at the corner is not convex.
  auto mesh = delaunay_mesh(perturbed_grid<2>(4, 0));
  Mesh<2> ell;
  ell.points = mesh.points;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    Vec<2> mean;
    for (const VertexId v : mesh.simplex_vertices[s]) mean += mesh.points[v] / 3;
    if (mean[0] > 0.5 && mean[1] > 0.5) continue;
    ell.simplex_vertices.push_back(mesh.simplex_vertices[s]);
    ell.simplex_region.push_back(1);
  }
  test::connect(ell);
  const auto q = measure(ell);
  EXPECT_NEAR(q.volume_sum, 0.75, 1e-14);
  // The kernel of the corner's cell is a square of a quarter of a grid cell.
  EXPECT_NEAR(q.cell_aspect.max, std::sqrt(2.0) * 2, 1e-6);
}

TEST(Quality, AnyNumberOfThreadsGivesTheSameReport) {
  const test::AllowThreads allow(8);
  const auto mesh = delaunay_mesh(perturbed_grid<3>(10, 1e-2));
  const auto volumes = build_control_volumes(mesh);
  QualityReport one, eight;
  run_with_threads(1, [&] { one = measure_quality(mesh, volumes); });
  run_with_threads(8, [&] { eight = measure_quality(mesh, volumes); });
  const auto same = [](const QualityReport::Spread& a, const QualityReport::Spread& b) {
    return a.min == b.min && a.mean == b.mean && a.p99 == b.p99 && a.max == b.max &&
           a.histogram.bins == b.histogram.bins;
  };
  EXPECT_TRUE(same(one.radius_edge, eight.radius_edge));
  EXPECT_TRUE(same(*one.dihedral_deg, *eight.dihedral_deg));
  EXPECT_TRUE(same(one.angle_deg, eight.angle_deg));
  EXPECT_TRUE(same(one.cell_aspect, eight.cell_aspect));
  EXPECT_EQ(one.domain_volume, eight.domain_volume);
  EXPECT_EQ(one.volume_sum, eight.volume_sum);
}

PointRows<3> rows_of(const std::vector<Vec<3>>& points) {
  PointRows<3> rows;
  for (const Vec<3>& p : points) rows.push_back(p.coord);
  return rows;
}

TEST(CircumcenterPair, IsThatOfEachToTheBit) {
  Random random(6);
  const auto tetrahedron = [&](double height) {
    std::array<Vec<3>, 4> p;
    for (Vec<3>& x : p) x = {random.unit(), random.unit(), height * random.unit()};
    return p;
  };
  // Flat ones leave double precision, each in either place.
  for (int round = 0; round < 400; ++round) {
    const auto p = tetrahedron(round % 2 == 0 ? 1 : 1e-13), q = tetrahedron(round % 4 < 2 ? 1 : 1e-13);
    const CircumcenterPair<3> pair = circumcenter_pair<3>(simplex_pair<3>(p, q));
    for (std::size_t lane = 0; lane < 2; ++lane) {
      const auto& one = lane == 0 ? p : q;
      EXPECT_EQ(pair.determinant[lane], simplex_determinant<3>(one)) << round;
      const Vec<3> offset = circumcenter_offset<3>(one);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(pair.offset[k][lane], offset.coord[k]) << round;
    }
  }
}

TEST(RowPairs, TheLargestIsTheFirstOfEquals) {
  for (std::size_t n = 1; n < 8; ++n) {
    for (std::size_t largest = 0; largest < n; ++largest) {
      RowPairs<1> rows;
      for (std::size_t k = 0; k < n; ++k) rows.push_back(RowPairs<1>::Row{k < largest ? -1.0 : 2.0});
      const auto place = rows.largest([](const Lanes& x) { return x * Lanes(3.0); });
      EXPECT_EQ(place.value, 6) << largest << " of " << n;
      EXPECT_EQ(place.row, largest) << "of " << n;
      EXPECT_EQ(rows[n - 1][0], 2);
    }
  }
}

TEST(CellBalls, TheEnclosingBallIsSmallest) {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec<3>> points;
    for (int k = 0; k < 24; ++k) points.push_back({random.unit(), 2 * random.unit(), random.unit()});
    const Ball<3> ball = smallest_enclosing_ball<3>(rows_of(points));
    // Optimal if and only if the center is in the convex hull of the points on the sphere: no direction leads away from
    // all of them.
    std::vector<Vec<3>> towards;
    for (const Vec<3>& p : points) {
      EXPECT_LE(distance(p, ball.center), ball.radius * (1 + 1e-8));
      if (distance(p, ball.center) > ball.radius * (1 - 1e-6)) {
        towards.push_back((p - ball.center) / ball.radius);
      }
    }
    for (int probe = 0; probe < 200; ++probe) {
      const Vec<3> direction = {random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5};
      double best = -1;
      for (const auto& t : towards) best = std::max(best, -dot(t, direction));
      EXPECT_GT(best, -1e-6);
    }
  }
}

TEST(CellBalls, ManyPointsHaveTheBallOfTheirHull) {
  // The corners of a box and hundreds of points inside, more than a cell has.
  Random random(2);
  std::vector<Vec<3>> points;
  for (int k = 0; k < 300; ++k) points.push_back({random.unit(), 2 * random.unit(), 3 * random.unit()});
  for (unsigned corner = 0; corner < 8; ++corner)
    points.push_back({corner & 1U ? 1.0 : 0.0, corner & 2U ? 2.0 : 0.0, corner & 4U ? 3.0 : 0.0});
  const Ball<3> ball = smallest_enclosing_ball<3>(rows_of(points));
  EXPECT_NEAR(ball.radius, std::sqrt(14.0) / 2, 1e-8);
  EXPECT_NEAR(distance(ball.center, Vec<3>{0.5, 1.0, 1.5}), 0, 1e-8);
}

TEST(CellBalls, ManyTangentPlanesHaveTheBallThatTheyTouch) {
  Random random(3);
  const Vec<3> center = {0.1, -0.2, 0.05};
  HalfSpaceRows<3> half_spaces;
  for (int k = 0; k < 300; ++k) {
    Vec<3> normal = {random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5};
    normal = normal / norm(normal);
    half_spaces.push_back(HalfSpaceRows<3>::Row{normal[0], normal[1], normal[2], dot(normal, center) + 0.7});
  }
  const Ball<3> ball = largest_inscribed_ball<3>(half_spaces, 1);
  EXPECT_NEAR(ball.radius, 0.7, 1e-8);
  EXPECT_NEAR(distance(ball.center, center), 0, 1e-7);
}

TEST(Spread, ThePercentileIsTheNearestRankWhereverTheBinsLie) {
  Random random(4);
  for (const std::size_t n : {1U, 2U, 99U, 100U, 101U, 200'000U}) {
    std::vector<double> values(n);
    for (double& value : values) value = 3 * random.unit() - 1;
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const double expected = sorted[static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(n))) - 1];
    // All bins in use; values beyond both ends; all values in one bin; no width.
    for (const auto& [lo, hi] :
         {std::pair(-1.0, 2.0), std::pair(0.0, 1.0), std::pair(-99.0, 999.0), std::pair(0.0, 0.0)}) {
      const auto spread = measure_spread(values, lo, hi, 40);
      EXPECT_EQ(spread.p99, expected) << n << " values, bins of " << lo << " to " << hi;
      EXPECT_EQ(spread.min, sorted.front());
      EXPECT_EQ(spread.max, sorted.back());
    }
  }
}

TEST(Spread, AngleTalliesForgetNothingWhenTheyMerge) {
  // Not a multiple of the batches in which angles are counted.
  Random random(5);
  AngleTally one, first, second;
  double least = 180, greatest = 0, sum = 0;
  constexpr int kAngles = 1'001;
  for (int k = 0; k < kAngles; ++k) {
    const double angle = M_PI * random.unit(), scale = 0.1 + random.unit();
    least = std::min(least, angle * 180 / M_PI);
    greatest = std::max(greatest, angle * 180 / M_PI);
    sum += angle * 180 / M_PI;
    for (AngleTally* tally : {&one, k % 3 == 0 ? &first : &second})
      tally->add(scale * std::cos(angle), scale * std::sin(angle));
  }
  first.merge(second);
  const auto whole = one.spread_deg(), merged = first.spread_deg();
  EXPECT_EQ(whole.mean, merged.mean);
  EXPECT_EQ(whole.histogram.bins, merged.histogram.bins);
  EXPECT_NEAR(merged.min, least, 1e-10);
  EXPECT_NEAR(merged.max, greatest, 1e-10);
  EXPECT_NEAR(merged.mean, sum / kAngles, 0.01);
}

TEST(CellBalls, TheInscribedBallOfABox) {
  // Doubled and redundant constraints do no harm.
  HalfSpaceRows<3> box;
  for (const double slack : {0.0, 0.0, 1.0}) {
    for (int k = 0; k < 3; ++k) {
      std::array<double, 4> row{};
      row[static_cast<std::size_t>(k)] = 1;
      row[3] = 1.0 + k + slack;
      box.push_back(row);
      row[static_cast<std::size_t>(k)] = -1;
      row[3] = 2.0 + slack;
      box.push_back(row);
    }
  }
  const Ball<3> ball = largest_inscribed_ball<3>(box, 10);
  EXPECT_NEAR(ball.radius, 1.5, 1e-8);
  EXPECT_NEAR(ball.center[0], -0.5, 1e-8);
}

}  // namespace
}  // namespace voropack
