// Figure 3 against an independent prototype's figures, in the limit of no perturbation, and its meshes.
#include "figure3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <variant>

#include "base/parallel.h"
#include "perturbed_cube.h"
#include "support/allow_threads.h"
#include "support/shared_data.h"
#include "voropack/dual.h"
#include "voropack/io.h"

namespace voropack::app {
namespace {

class GoldenCube : public testing::TestWithParam<const char*> {};

TEST_P(GoldenCube, HasThePrototypesErrors) {
  const auto node = test::shared_data(std::string("../reference/golden/") + GetParam() + ".node");
  if (!node) GTEST_SKIP() << "no shared reference data";
  auto json_path = *node;
  std::ifstream file(json_path.replace_extension(".json"));
  const auto golden = nlohmann::json::parse(file);
  const auto mesh = std::get<Mesh<3>>(read_mesh(*node));
  const Figure3Solutions solutions = solve_figure3(mesh, silent_observer());
  const Figure3 ours = measure_figure3(mesh, solutions);
  const Figure3Details details = measure_figure3_details(mesh, solutions);
  const auto expect_relative = [&](const char* key, double value, double tolerance) {
    const double expected = golden[key].get<double>();
    EXPECT_NEAR(value, expected, tolerance * expected) << key;
  };
  expect_relative("cvm_W", ours.cvm_w, 1e-8);
  expect_relative("fem_W", ours.fem_w, 1e-6);
  expect_relative("fem_H1", ours.fem_h1, 1e-6);
  expect_relative("R_over_rho", ours.radius_ratio, 1e-5);
  expect_relative("radius_edge", ours.radius_edge, 1e-12);
  EXPECT_EQ(details.n_slivers, golden["nsliv"].get<double>());
  expect_relative("cvm_max", details.cvm_max, 1e-8);
  expect_relative("fem_max", details.fem_max, 1e-6);
  EXPECT_EQ(details.h1.fem, ours.fem_h1);
  expect_relative("cvm_H1", details.h1.cvm, 1e-6);
  expect_relative("int_H1", details.h1.interpolant, 1e-6);
  expect_relative("fem_H1ns", details.h1_without_slivers.fem, 1e-6);
  expect_relative("cvm_H1ns", details.h1_without_slivers.cvm, 1e-6);
  expect_relative("int_H1ns", details.h1_without_slivers.interpolant, 1e-6);
}

TEST(Figure3, TheoremsHoldHoweverFlatTheSlivers) {
  for (const double eps : {0.3, 0.01, 1e-4, 1e-8, 0.0}) {
    const Mesh<3> mesh = delaunay_mesh(perturbed_cube_points(8, eps, 2));
    const Figure3Solutions solutions = solve_figure3(mesh, silent_observer());
    const Figure3Details details = measure_figure3_details(mesh, solutions);
    EXPECT_NEAR(details.discrete_error, measure_figure3(mesh, solutions).cvm_w, 1e-12);
    EXPECT_LE(details.discrete_error, details.consistency_error) << eps;
    EXPECT_LE(details.consistency_error, details.bound) << eps;
  }
}

INSTANTIATE_TEST_SUITE_P(Figure3, GoldenCube,
                         testing::Values("cube_n4_eps0.01_s0", "cube_n4_eps0.0001_s0", "cube_n8_eps0.01_s0"));

struct ReferenceRow {
  double mean, deviation, min, max;
};

/// The lines of figure3.csv by n, eps and column; empty if the file is not there.
std::map<std::tuple<std::uint32_t, double, std::string>, ReferenceRow> read_reference() {
  std::map<std::tuple<std::uint32_t, double, std::string>, ReferenceRow> rows;
  const auto path = test::shared_data("../reference/figure3.csv");
  if (!path) return rows;
  std::ifstream file(*path);
  std::string line;
  std::getline(file, line);
  EXPECT_TRUE(line.starts_with("n,eps,seeds,col,paper,mean,sd,min,max"));
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    rows[{static_cast<std::uint32_t>(std::stoul(cells[0])), std::stod(cells[1]), cells[3]}] = {
        std::stod(cells[5]), std::stod(cells[6]), std::stod(cells[7]), std::stod(cells[8])};
  }
  return rows;
}

TEST(Figure3, OwnMeshesHaveThePrototypesFigures) {
  const auto reference = read_reference();
  if (reference.empty()) GTEST_SKIP() << "no shared reference data";
  const auto rows = run_figure3({.grids = {4, 8}}, silent_observer());
  ASSERT_EQ(rows.size(), 6U);
  for (const Figure3Row& row : rows) {
    ASSERT_EQ(row.meshes.size(), 24U);
    for (const Column column : kColumns) {
      const auto& expected = reference.at({row.n, row.eps, name_of(column)});
      const Summary ours = summarize(row, column);
      SCOPED_TRACE(name_of(column) + " n " + std::to_string(row.n) + " eps " + std::to_string(row.eps));
      EXPECT_GT(ours.median, expected.min);
      EXPECT_LT(ours.median, expected.max);
      // R over rho is a maximum and has heavy tails everywhere, the finite elements on the coarsest grid.
      const bool heavy_tails = column == Column::kRadiusRatio || (row.n == 4 && column != Column::kCvmW);
      if (!heavy_tails) {
        EXPECT_NEAR(ours.mean, expected.mean, 4 * expected.deviation * std::sqrt(2.0 / 24));
      }
    }
  }
}

/// The W error of the 7-point scheme on a grid.
const std::map<std::uint32_t, double> kSevenPoint = {{4, .2410636191}, {8, .0753979743}, {16, .0200773678}};

double cvm_error(std::uint32_t n, double eps) {
  const Mesh<3> mesh = delaunay_mesh(perturbed_cube_points(n, eps, 3));
  return measure_figure3(mesh, solve_figure3(mesh, silent_observer())).cvm_w;
}

TEST(Figure3, ControlVolumesTendToTheSevenPointScheme) {
  for (const auto& [n, expected] : kSevenPoint) EXPECT_NEAR(cvm_error(n, 1e-8), expected, 1e-6 * expected) << n;
}

TEST(Figure3, SliversOfAnyFlatnessLeaveControlVolumesUnchanged) {
  for (const double eps : {0.0, 1e-15, 1e-12}) EXPECT_NEAR(cvm_error(8, eps), kSevenPoint.at(8), 1e-7) << eps;
}

TEST(Figure3, NoAreaIsNegativeHoweverFlatTheSlivers) {
  for (const double eps : {0.0, 1e-15, 1e-12, 1e-8}) {
    const Mesh<3> mesh = delaunay_mesh(perturbed_cube_points(6, eps, 5));
    EXPECT_EQ(find_mesh_fault(mesh), "");
    const ControlVolumes<3> volumes = build_control_volumes(mesh);
    EXPECT_GE(*std::min_element(volumes.face_area.begin(), volumes.face_area.end()), 0) << eps;
    double sum = 0;
    for (const double volume : volumes.cell_volume) sum += volume;
    EXPECT_NEAR(sum, 1, 1e-13);
    EXPECT_LE(volumes.zeroed_area, volumes.zeroed_area_bound) << eps;
    // The certified errors themselves are what docs/theory/dual.md promises, 1e-12 h^2 each.
    EXPECT_LE(volumes.zeroed_area_bound, 1e-12 * static_cast<double>(volumes.n_zero_areas)) << eps;
    if (eps == 1e-15) {
      EXPECT_GT(volumes.zeroed_area, 0);
    }
  }
}

TEST(PerturbedCube, PointsStayOnTheirFacesAndNearTheirPlaces) {
  constexpr std::uint32_t kN = 5;
  constexpr double kEps = 0.3;
  const std::vector<Vec<3>> points = perturbed_cube_points(kN, kEps, 7);
  ASSERT_EQ(points.size(), 216U);
  Vec<3> least, largest;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::array<std::size_t, 3> step = {p / 36, p / 6 % 6, p % 6};
    for (int k = 0; k < 3; ++k) {
      const double grid = static_cast<double>(step[static_cast<std::size_t>(k)]);
      const double move = points[p][k] * kN - grid;
      if (grid == 0 || grid == kN) {
        EXPECT_EQ(points[p][k], grid / kN);
      }
      least[k] = std::min(least[k], move);
      largest[k] = std::max(largest[k], move);
    }
  }
  for (int k = 0; k < 3; ++k) {  // The whole interval is used, and no more.
    EXPECT_GE(least[k], -kEps * (1 + 1e-12));
    EXPECT_LT(least[k], -0.9 * kEps);
    EXPECT_LE(largest[k], kEps * (1 + 1e-12));
    EXPECT_GT(largest[k], 0.9 * kEps);
  }
  EXPECT_EQ(points, perturbed_cube_points(kN, kEps, 7));
  EXPECT_NE(points, perturbed_cube_points(kN, kEps, 8));
}

TEST(Figure3, DoesNotDependOnThreads) {
  const Figure3Options options{.grids = {4, 6}, .perturbations = {0.01}, .seeds = 3};
  std::string one, many;
  run_with_threads(1, [&] { one = figure3_csv(run_figure3(options, silent_observer())); });
  const test::AllowThreads threads(8);
  run_with_threads(8, [&] { many = figure3_csv(run_figure3(options, silent_observer())); });
  EXPECT_EQ(one, many);
}

TEST(Figure3, SummaryOfKnownValues) {
  Figure3Row row{.n = 4, .eps = 0.01, .meshes = {}};
  for (const double w : {4.0, 1.0, 2.0, 9.0}) row.meshes.push_back({.cvm_w = w});
  const Summary summary = summarize(row, Column::kCvmW);
  EXPECT_EQ(summary.mean, 4);
  EXPECT_NEAR(summary.deviation, std::sqrt(38.0 / 3), 1e-15);
  EXPECT_EQ(summary.min, 1);
  EXPECT_EQ(summary.median, 3);
  EXPECT_EQ(summary.max, 9);
}

TEST(Figure3, SummaryLeavesOutWhatCouldNotBeSolved) {
  Figure3Row row{.n = 4, .eps = 0.01, .meshes = {}};
  for (const double w : {4.0, static_cast<double>(NAN), 2.0}) row.meshes.push_back({.fem_w = w});
  EXPECT_EQ(summarize(row, Column::kFemW).n, 2U);
  EXPECT_EQ(summarize(row, Column::kFemW).mean, 3);
  row.meshes = {{.fem_w = NAN}};
  EXPECT_EQ(summarize(row, Column::kFemW).n, 0U);
  EXPECT_NE(figure3_csv({row}).find("4,0.01,0,fem_W,7.696399,,,,,\n"), std::string::npos);
  EXPECT_EQ(figure3_csv({row}).find("nan"), std::string::npos);
  EXPECT_EQ(figure3_svg({row}).find("nan"), std::string::npos);
  EXPECT_EQ(figure3_table({row}).find("nan"), std::string::npos);
}

TEST(Figure3, SolutionIsHarmonicWithTheGivenGradient) {
  constexpr double kStep = 1e-4;
  for (const Vec<3>& x : perturbed_cube_points(2, 0.2, 1)) {
    const Vec<3> gradient = figure3_gradient(x);
    double laplacian = 0;
    for (int k = 0; k < 3; ++k) {
      Vec<3> step;
      step[k] = kStep;
      const double ahead = figure3_solution(x + step), behind = figure3_solution(x - step);
      EXPECT_NEAR(gradient[k], (ahead - behind) / (2 * kStep), 1e-5);
      laplacian += (ahead - 2 * figure3_solution(x) + behind) / (kStep * kStep);
    }
    EXPECT_NEAR(laplacian, 0, 1e-4);
  }
}

TEST(Figure3, PaperValuesAreThoseOfItsTable) {
  EXPECT_EQ(paper_value(8, 0.001, Column::kRadiusRatio), 166051);
  EXPECT_EQ(paper_value(4, 0.0001, Column::kFemH1), 291.6406);
  EXPECT_EQ(paper_value(16, 0.01, Column::kCvmW), 0.02155074);
  EXPECT_FALSE(paper_value(32, 0.01, Column::kCvmW));
}

}  // namespace
}  // namespace voropack::app
