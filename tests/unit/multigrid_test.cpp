// Multigrid on small systems, whose operators are compared with dense matrices.
#include "voropack/multigrid.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/random.h"
#include "support/allow_threads.h"
#include "support/nested_hierarchy.h"

namespace voropack {
namespace {

using test::BoxProblem;
using test::grid_hierarchy;
using test::NestedHierarchy;

constexpr auto kSymmetric = MultigridSmoother::kSymmetricGaussSeidel;

Eigen::MatrixXd dense(const SparseMatrix& matrix, std::size_t n_columns) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<long>(matrix.size()), static_cast<long>(n_columns));
  for (std::size_t row = 0; row < matrix.size(); ++row)
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      out(static_cast<long>(row), matrix.columns[e]) += matrix.values[e];
  return out;
}

/// n_rows rows with up to 5 entries each; square ones list their diagonal.
SparseMatrix random_matrix(std::size_t n_rows, std::size_t n_columns, Random& random) {
  SparseMatrix matrix;
  for (std::size_t row = 0; row < n_rows; ++row) {
    for (std::uint32_t c = 0; c < n_columns; ++c)
      if (random.unit() * static_cast<double>(n_columns) < 3 || c == row) {
        matrix.columns.push_back(c);
        matrix.values.push_back(2 * random.unit() - 1);
      }
    matrix.offsets.push_back(matrix.columns.size());
  }
  return matrix;
}

TEST(SparseProducts, TransposeSwapsRowsAndColumns) {
  Random random(1);
  const SparseMatrix matrix = random_matrix(40, 17, random);
  const SparseMatrix transposed = transpose(matrix, 17);
  EXPECT_EQ(dense(transposed, 40), dense(matrix, 17).transpose());
  EXPECT_EQ(transpose(transposed, 40), matrix);
}

TEST(SparseProducts, GalerkinProductIsThatOfDenseMatrices) {
  Random random(2);
  const std::size_t n = 50, n_coarse = 13;
  const SparseMatrix matrix = random_matrix(n, n, random), prolongation = random_matrix(n, n_coarse, random);
  std::vector<std::uint8_t> is_fixed(n, 0), is_coarse_fixed(n_coarse, 0);
  is_fixed[3] = is_fixed[20] = is_coarse_fixed[5] = 1;
  Eigen::MatrixXd p = dense(prolongation, n_coarse);
  p.row(3).setZero();
  p.row(20).setZero();
  p.col(5).setZero();
  const SparseMatrix product = galerkin_product(matrix, prolongation, is_fixed, is_coarse_fixed);
  EXPECT_LT((dense(product, n_coarse) - p.transpose() * dense(matrix, n) * p).norm(), 1e-12);
  for (std::size_t row = 0; row < n_coarse; ++row) {
    EXPECT_TRUE(std::is_sorted(product.columns.begin() + static_cast<long>(product.offsets[row]),
                               product.columns.begin() + static_cast<long>(product.offsets[row + 1])));
  }
}

/// The matrix at free vertices, and the operator of multigrid there.
struct DenseOperators {
  Eigen::MatrixXd a, b;
};

DenseOperators operators(const LinearSystem& system, const Multigrid& multigrid) {
  std::vector<std::size_t> free;
  for (const VertexId v : ids(system.is_fixed))
    if (system.is_fixed[v] == 0) free.push_back(v.value());
  const auto n = static_cast<long>(free.size());
  const Eigen::MatrixXd all = dense(system.matrix, system.matrix.size());
  DenseOperators out{.a = Eigen::MatrixXd(n, n), .b = Eigen::MatrixXd(n, n)};
  std::vector<double> residual(system.matrix.size()), correction(system.matrix.size());
  for (long j = 0; j < n; ++j) {
    residual[free[static_cast<std::size_t>(j)]] = 1;
    multigrid.apply(residual, correction);
    residual[free[static_cast<std::size_t>(j)]] = 0;
    for (long i = 0; i < n; ++i) {
      out.a(i, j) = all(static_cast<long>(free[static_cast<std::size_t>(i)]),
                        static_cast<long>(free[static_cast<std::size_t>(j)]));
      out.b(i, j) = correction[free[static_cast<std::size_t>(i)]];
    }
    for (const VertexId v : ids(system.is_fixed)) {
      if (system.is_fixed[v] == 0) continue;
      EXPECT_EQ(correction[v.value()], 0);
    }
  }
  return out;
}

/// The eigenvalues of B A, ascending, for symmetric B and A.
Eigen::VectorXd spectrum(const DenseOperators& of) {
  const Eigen::MatrixXd root = of.a.llt().matrixL();
  const Eigen::MatrixXd similar = root.transpose() * ((of.b + of.b.transpose()) / 2) * root;
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(similar).eigenvalues();
}

MultigridOptions small_options(MultigridSmoother smoother, bool is_single_precision = false) {
  MultigridOptions options;
  options.smoother = smoother;
  options.enough = 10;
  options.is_single_precision = is_single_precision;
  return options;
}

TEST(Multigrid, IsASymmetricPositiveDefiniteContraction) {
  for (const BoxProblem& problem : {BoxProblem{}, BoxProblem{.right = 1e6}, BoxProblem{.is_dirichlet = false},
                                    BoxProblem{.right = 100, .reaction = 1, .is_dirichlet = false}}) {
    const NestedHierarchy hierarchy = grid_hierarchy<2>(8, problem);
    for (const auto smoother : {kSymmetric, MultigridSmoother::kGaussSeidel, MultigridSmoother::kChebyshev})
      for (const auto cycle : {MultigridCycle::kV, MultigridCycle::kW})
        for (const int n_smoothing : {1, 2})
          for (const bool with_matrices : {true, false}) {
            MultigridOptions options = small_options(smoother);
            options.enough = 2;  // Three levels.
            options.cycle = cycle;
            options.n_smoothing = n_smoothing;
            const Multigrid multigrid(hierarchy.system, hierarchy.views(with_matrices), options);
            EXPECT_GE(multigrid.report().levels.size(), 3U);
            const DenseOperators dense = operators(hierarchy.system, multigrid);
            EXPECT_LT((dense.b - dense.b.transpose()).norm(), 1e-10 * dense.b.norm());
            const Eigen::VectorXd eigenvalues = spectrum(dense);
            EXPECT_GT(eigenvalues.minCoeff(), 0.5) << static_cast<int>(smoother);
            EXPECT_LT(eigenvalues.maxCoeff(), 1.2) << static_cast<int>(smoother);
          }
  }
}

TEST(Multigrid, SinglePrecisionChangesTheOperatorByItsRounding) {
  const NestedHierarchy hierarchy = grid_hierarchy<2>(16, {.right = 100});
  const auto of = [&](bool is_single) {
    const Multigrid multigrid(hierarchy.system, hierarchy.views(true), small_options(kSymmetric, is_single));
    return operators(hierarchy.system, multigrid).b;
  };
  const Eigen::MatrixXd single = of(true), full = of(false);
  EXPECT_LT((single - full).norm(), 1e-5 * full.norm());
  EXPECT_GT((single - full).norm(), 0);
}

TEST(Multigrid, TinyAndHugeNumbersFitIntoSinglePrecision) {
  NestedHierarchy hierarchy = grid_hierarchy<2>(16, {});
  std::vector<double> residual(hierarchy.system.load.raw()), unscaled(residual.size()), scaled(residual.size());
  for (const VertexId v : ids(hierarchy.system.is_fixed))
    if (hierarchy.system.is_fixed[v] != 0) residual[v.value()] = 0;
  make_multigrid(hierarchy.system, hierarchy.views(false), small_options(kSymmetric, true))->apply(residual, unscaled);
  for (const int exponent : {-300, 300}) {
    NestedHierarchy other = hierarchy;
    for (double& value : other.system.matrix.values) value = std::ldexp(value, exponent);
    std::vector<double> load = residual;
    for (double& value : load) value = std::ldexp(value, -exponent);
    make_multigrid(other.system, other.views(false), small_options(kSymmetric, true))->apply(load, scaled);
    for (std::size_t i = 0; i < scaled.size(); ++i) EXPECT_EQ(std::ldexp(scaled[i], 2 * exponent), unscaled[i]);
  }
}

TEST(Multigrid, WithoutLevelsItIsTheDirectSolver) {
  for (const bool is_dirichlet : {true, false}) {
    const NestedHierarchy hierarchy = grid_hierarchy<2>(8, {.is_dirichlet = is_dirichlet});
    const Multigrid multigrid(hierarchy.system, {}, small_options(kSymmetric));
    const Eigen::VectorXd eigenvalues = spectrum(operators(hierarchy.system, multigrid));
    EXPECT_NEAR(eigenvalues.minCoeff(), 1, 1e-10);
    EXPECT_NEAR(eigenvalues.maxCoeff(), 1, 1e-10);
    EXPECT_EQ(multigrid.report().n_floating, is_dirichlet ? 0U : 1U);
  }
}

TEST(Multigrid, ACoarseLevelWithAllVerticesSolvesInOneCycle) {
  const LinearSystem system = grid_hierarchy<2>(8, {}).system;
  SparseMatrix identity;
  std::vector<VertexId> finest_vertex;
  for (std::uint32_t v = 0; v < system.matrix.size(); ++v) {
    identity.columns.push_back(v);
    identity.values.push_back(1);
    identity.offsets.push_back(v + 1);
    finest_vertex.emplace_back(v);
  }
  const std::vector<MultigridLevel> levels = {{.prolongation = &identity, .finest_vertex = finest_vertex}};
  for (const auto smoother : {kSymmetric, MultigridSmoother::kGaussSeidel, MultigridSmoother::kChebyshev}) {
    const Multigrid multigrid(system, levels, small_options(smoother));
    EXPECT_EQ(multigrid.report().levels.size(), 2U);
    EXPECT_NEAR(multigrid.report().operator_complexity, 2, 1e-12);
    const Eigen::VectorXd eigenvalues = spectrum(operators(system, multigrid));
    EXPECT_NEAR(eigenvalues.minCoeff(), 1, 1e-10);
    EXPECT_NEAR(eigenvalues.maxCoeff(), 1, 1e-10);
  }
}

double largest_difference(const IdVector<VertexId, double>& a, const IdVector<VertexId, double>& b) {
  double largest = 0;
  for (const VertexId v : ids(a)) largest = std::max(largest, std::abs(a[v] - b[v]));
  return largest;
}

double largest_value(const IdVector<VertexId, double>& a) {
  return largest_difference(a, IdVector<VertexId, double>(a.size()));
}

LinearOptions preconditioned(std::shared_ptr<const Multigrid> multigrid) {
  LinearOptions options;
  options.method = LinearMethod::kConjugateGradients;
  options.own_preconditioner = [multigrid](const LinearSystem&) { return multigrid; };
  options.tolerance = 1e-10;
  return options;
}

TEST(Multigrid, FindsTheSolutionAloneAndAsPreconditioner) {
  LinearOptions direct;
  direct.method = LinearMethod::kDirect;
  for (const BoxProblem& problem : {BoxProblem{}, BoxProblem{.right = 1e6}, BoxProblem{.is_dirichlet = false}}) {
    const NestedHierarchy hierarchy = grid_hierarchy<3>(16, problem);
    const LinearSystem& system = hierarchy.system;
    const IdVector<VertexId, double> expected = solve_linear_system(system, direct).values;
    const auto multigrid = make_multigrid(system, hierarchy.views(true), small_options(kSymmetric, true));
    for (const bool starts_with_full : {true, false}) {
      const LinearSolution alone =
          solve_by_multigrid(system, *multigrid, {.tolerance = 1e-10, .starts_with_full = starts_with_full});
      EXPECT_LT(largest_difference(alone.values, expected), 1e-8 * largest_value(expected));
      EXPECT_EQ(alone.report.residuals.size(), static_cast<std::size_t>(alone.report.n_iterations) + 1);
      EXPECT_LE(alone.report.residual, 1e-10);
      EXPECT_GT(alone.report.contraction, 0);
      EXPECT_LT(alone.report.contraction, 0.35);
    }
    const LinearSolution with = solve_linear_system(system, preconditioned(multigrid));
    EXPECT_LT(largest_difference(with.values, expected), 1e-8 * largest_value(expected));
    EXPECT_EQ(with.report.preconditioner, "multigrid");
    EXPECT_LE(with.report.n_iterations, 12);
  }
}

TEST(Multigrid, AHeldVertexDoesNotSlowNeumannConditionsDown) {
  // Holding one vertex adds an eigenvalue near 0 that coarse levels may not know of: here no coarse level has it.
  NestedHierarchy hierarchy = grid_hierarchy<2>(64, {.is_dirichlet = false});
  LinearSystem& system = hierarchy.system;
  const auto iterations = [&] {
    const auto multigrid = make_multigrid(system, hierarchy.views(true), small_options(kSymmetric, true));
    EXPECT_EQ(multigrid->report().n_floating, 1U);
    return solve_linear_system(system, preconditioned(multigrid)).report.n_iterations;
  };
  const int at_corner = iterations();
  system.is_fixed[VertexId(0)] = 0;
  const int nowhere = iterations();  // Singular, and consistent.
  system.is_fixed[VertexId(65 * 31 + 31)] = 1;
  const int inside = iterations();
  EXPECT_LE(std::max({at_corner, nowhere, inside}), 10);
}

TEST(Multigrid, FullMultigridAndACycleReachTheDiscretizationError) {
  // -Laplace u = 1 on grids of 64 and 32 boxes: errors of second order differ by 3/4 of the coarser one's, so that the
  // finer one's is a third of the difference.
  const NestedHierarchy fine = grid_hierarchy<2>(64, {}), coarse = grid_hierarchy<2>(32, {});
  const auto u = solve_linear_system(fine.system).values, u_coarse = solve_linear_system(coarse.system).values;
  double difference = 0;
  for (std::size_t v = 0; v < u_coarse.size(); ++v)
    difference = std::max(difference, std::abs(u_coarse[VertexId(v)] - u[VertexId(2 * (v % 33) + 65 * 2 * (v / 33))]));
  const Multigrid multigrid(fine.system, fine.views(true), small_options(kSymmetric));
  const auto error_after_two = [&](bool starts_with_full) {
    // The second cycle is the last: its residual is below the tolerance.
    for (double tolerance = 0.5;; tolerance /= 1.1) {
      const LinearSolution solution = solve_by_multigrid(
          fine.system, multigrid, {.tolerance = tolerance, .max_cycles = 2, .starts_with_full = starts_with_full});
      if (solution.report.n_iterations == 2) return largest_difference(solution.values, u);
    }
  };
  EXPECT_LT(error_after_two(true), difference / 3);
  EXPECT_GT(error_after_two(false), difference / 3);
}

TEST(Multigrid, SmoothsACoarsestLevelThatIsTooLarge) {
  const NestedHierarchy hierarchy = grid_hierarchy<2>(32, {});
  std::vector<MultigridLevel> levels = hierarchy.views(true);
  levels.resize(1);
  MultigridOptions options = small_options(kSymmetric);
  options.max_direct = 100;
  const auto multigrid = make_multigrid(hierarchy.system, levels, options);
  EXPECT_FALSE(multigrid->report().is_coarsest_direct);
  const LinearReport report = solve_linear_system(hierarchy.system, preconditioned(multigrid)).report;
  EXPECT_LE(report.residual, 1e-10);
  EXPECT_LE(report.n_iterations, 25);
}

TEST(Multigrid, StopsAtTheFirstLevelThatIsSmallEnough) {
  const NestedHierarchy hierarchy = grid_hierarchy<2>(64, {});
  MultigridOptions options;
  options.enough = 300;
  const MultigridReport report = Multigrid(hierarchy.system, hierarchy.views(false), options).report();
  ASSERT_EQ(report.levels.size(), 3U);
  EXPECT_EQ(report.levels[0].n_unknowns, 63U * 63U);
  EXPECT_EQ(report.levels[2].n_unknowns, 15U * 15U);
  EXPECT_FALSE(report.levels[0].is_galerkin);
  EXPECT_TRUE(report.levels[1].is_galerkin);
  EXPECT_GT(report.operator_complexity, 1.2);
  EXPECT_LT(report.operator_complexity, 1.4);
}

TEST(Multigrid, ThreadsDoNotMatter) {
  const test::AllowThreads allow(8);
  const NestedHierarchy hierarchy = grid_hierarchy<2>(160, {.right = 1e3});  // Several blocks of all loops.
  for (const auto smoother : {kSymmetric, MultigridSmoother::kGaussSeidel, MultigridSmoother::kChebyshev}) {
    const auto with_threads = [&](int n) {
      LinearSolution solution;
      run_with_threads(n, [&] {
        const Multigrid multigrid(hierarchy.system, hierarchy.views(false), small_options(smoother, true));
        solution = solve_by_multigrid(hierarchy.system, multigrid);
      });
      return solution;
    };
    const LinearSolution one = with_threads(1);
    for (const int n : {2, 8}) {
      const LinearSolution many = with_threads(n);
      EXPECT_EQ(one.values, many.values) << n;
      EXPECT_EQ(one.report.residuals, many.report.residuals) << n;
    }
  }
}

TEST(Multigrid, RefusesWhatItCannotUse) {
  const NestedHierarchy hierarchy = grid_hierarchy<2>(8, {});
  const auto id_of = [](auto&& work) {
    try {
      work();
    } catch (const OptionError& error) {
      return "option " + error.id();
    } catch (const InputError& error) {
      return "input " + error.id();
    } catch (const NumericalError& error) {
      return "numerical " + error.id();
    }
    return std::string("done");
  };
  const auto with_options = [&](auto&& change) {
    return id_of([&] {
      MultigridOptions options;
      change(options);
      make_multigrid(hierarchy.system, hierarchy.views(true), options);
    });
  };
  EXPECT_EQ(with_options([](MultigridOptions&) {}), "done");
  EXPECT_EQ(with_options([](MultigridOptions& o) { o.n_smoothing = 0; }), "option multigrid.bad_option");
  EXPECT_EQ(with_options([](MultigridOptions& o) { o.chebyshev_degree = 0; }), "option multigrid.bad_option");
  EXPECT_EQ(with_options([](MultigridOptions& o) { o.chebyshev_range = 1; }), "option multigrid.bad_option");

  const auto with_levels = [&](auto&& change) {
    return id_of([&] {
      std::vector<MultigridLevel> levels = hierarchy.views(true);
      change(levels);
      make_multigrid(hierarchy.system, levels);
    });
  };
  const std::vector<VertexId> outside(25, VertexId(1000));
  EXPECT_EQ(with_levels([](auto& levels) { levels[0].prolongation = nullptr; }), "input multigrid.bad_level");
  EXPECT_EQ(with_levels([](auto& levels) { std::swap(levels[0], levels[1]); }), "input multigrid.bad_level");
  EXPECT_EQ(with_levels([](auto& levels) { levels[0].matrix = levels[1].matrix; }), "input multigrid.bad_level");
  EXPECT_EQ(with_levels([&](auto& levels) { levels[0].finest_vertex = outside; }), "input multigrid.bad_level");

  LinearSystem unsymmetric = hierarchy.system;
  unsymmetric.is_symmetric = false;
  EXPECT_EQ(id_of([&] { make_multigrid(unsymmetric, hierarchy.views(true)); }), "input multigrid.unsymmetric");

  LinearSystem negative = hierarchy.system;
  for (double& value : negative.matrix.values) value = -value;
  EXPECT_EQ(id_of([&] { make_multigrid(negative, hierarchy.views(false)); }), "numerical multigrid.singular");

  const Multigrid multigrid(hierarchy.system, hierarchy.views(true), small_options(kSymmetric));
  const auto solved_with = [&](const MultigridSolveOptions& options) {
    return id_of([&] { solve_by_multigrid(hierarchy.system, multigrid, options); });
  };
  EXPECT_EQ(solved_with({.tolerance = 0}), "option multigrid.bad_option");
  EXPECT_EQ(solved_with({.max_cycles = 0}), "option multigrid.bad_option");
  EXPECT_EQ(solved_with({.tolerance = 1e-12, .max_cycles = 2}), "numerical multigrid.not_converged");
}

}  // namespace
}  // namespace voropack
