// Multigrid on packed meshes with plain hierarchies: what the contraction may be, whatever the size.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/domains.h"
#include "support/nested_hierarchy.h"
#include "voropack/multigrid.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

template <int D>
Mesh<D> packed_box(double n_vertices) {
  MeshingOptions<D> options;
  options.wishes.size = std::pow(1.2 / n_vertices, 1.0 / D);
  options.packing.interior = Interior::kRandom;
  if constexpr (D == 2)
    return make_mesh(domains::unit_square(), options).mesh;
  else
    return make_mesh(domains::unit_cube(), options).mesh;
}

struct Figures {
  double contraction = 0;
  int n_iterations = 0;
};

Figures figures_of(const test::NestedHierarchy& hierarchy, bool with_matrices, MultigridOptions options = {}) {
  options.enough = 100;
  const auto multigrid = make_multigrid(hierarchy.system, hierarchy.views(with_matrices), options);
  EXPECT_LE(multigrid->report().operator_complexity, with_matrices ? 1.35 : 2.0);
  LinearOptions linear;
  linear.method = LinearMethod::kConjugateGradients;
  linear.own_preconditioner = [multigrid](const LinearSystem&) { return multigrid; };
  linear.tolerance = 1e-8;
  return {
      .contraction = solve_by_multigrid(hierarchy.system, *multigrid, {.starts_with_full = false}).report.contraction,
      .n_iterations = solve_linear_system(hierarchy.system, linear).report.n_iterations};
}

template <int D>
void check_packed(const std::vector<double>& sizes) {
  for (const bool is_dirichlet : {true, false}) {
    std::vector<int> iterations;
    for (const double size : sizes) {
      const auto hierarchy = test::greedy_hierarchy(packed_box<D>(size), 1.8, {.is_dirichlet = is_dirichlet});
      for (const bool with_matrices : {true, false}) {
        const Figures figures = figures_of(hierarchy, with_matrices);
        EXPECT_LE(figures.contraction, 0.35) << size;
        EXPECT_LE(figures.n_iterations, 12) << size;
        if (with_matrices) iterations.push_back(figures.n_iterations);
      }
    }
    EXPECT_LE(iterations.back(), iterations.front() + 2);
  }
}

TEST(MultigridProperty, ContractionInThePlaneDoesNotDependOnTheSize) { check_packed<2>({1000, 4000, 16000}); }
TEST(MultigridProperty, ContractionInSpaceDoesNotDependOnTheSize) { check_packed<3>({2000, 12000}); }

TEST(MultigridProperty, JumpsBetweenRegionsHardlyMatter) {
  for (const double right : {1e-6, 1e3, 1e6})
    for (const bool is_dirichlet : {true, false})
      for (const bool with_matrices : {true, false}) {
        const test::BoxProblem problem{.right = right, .is_dirichlet = is_dirichlet};
        EXPECT_LE(figures_of(test::grid_hierarchy<2>(64, problem), with_matrices).n_iterations, 20) << right;
        EXPECT_LE(figures_of(test::grid_hierarchy<3>(16, problem), with_matrices).n_iterations, 20) << right;
      }
}

TEST(MultigridProperty, EverySmootherAndCycleContracts) {
  const auto hierarchy = test::greedy_hierarchy(packed_box<3>(5000), 2, {});
  for (const auto smoother :
       {MultigridSmoother::kSymmetricGaussSeidel, MultigridSmoother::kGaussSeidel, MultigridSmoother::kChebyshev})
    for (const auto cycle : {MultigridCycle::kV, MultigridCycle::kW}) {
      MultigridOptions options;
      options.smoother = smoother;
      options.cycle = cycle;
      const Figures once = figures_of(hierarchy, true, options);
      options.n_smoothing = 2;
      const Figures twice = figures_of(hierarchy, true, options);
      EXPECT_LE(once.contraction, 0.5);
      EXPECT_LT(twice.contraction, once.contraction);
      EXPECT_LE(once.n_iterations, 12);
    }
}

}  // namespace
}  // namespace voropack
