// The linear solvers on systems whose solution is known.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "support/allow_threads.h"
#include "voropack/linear_system.h"

namespace voropack {
namespace {

/// A grid of n x n vertices with couplings 1, a third of them `stiff`, and loads between 0 and 1; u = 1 at the first
/// `n_fixed` vertices.
LinearSystem grid_system(std::size_t n, double stiff = 1, std::size_t n_fixed = 1) {
  LinearSystem system;
  SparseMatrix& matrix = system.matrix;
  const std::size_t size = n * n;
  for (std::size_t i = 0; i < size; ++i) {
    const auto weight = [&](std::size_t j) { return (i + j) % 3 == 0 ? stiff : 1.0; };
    std::vector<std::size_t> neighbors;
    if (i >= n) neighbors.push_back(i - n);
    if (i % n > 0) neighbors.push_back(i - 1);
    if (i % n + 1 < n) neighbors.push_back(i + 1);
    if (i + n < size) neighbors.push_back(i + n);
    double sum = 0;
    for (const std::size_t j : neighbors) sum += weight(j);
    bool is_diagonal_listed = false;
    const auto list = [&](std::size_t j, double value) {
      matrix.columns.push_back(static_cast<std::uint32_t>(j));
      matrix.values.push_back(value);
    };
    for (const std::size_t j : neighbors) {
      if (j > i && !is_diagonal_listed) {
        list(i, sum);
        is_diagonal_listed = true;
      }
      list(j, -weight(j));
    }
    if (!is_diagonal_listed) list(i, sum);
    matrix.offsets.push_back(matrix.columns.size());
    system.load.push_back(static_cast<double>(i % 7) / 7);
    system.absorption.push_back(0);
    system.is_fixed.push_back(i < n_fixed ? 1 : 0);
    system.fixed_value.push_back(i < n_fixed ? 1 : 0);
  }
  return system;
}

double largest_difference(const IdVector<VertexId, double>& a, const IdVector<VertexId, double>& b) {
  double largest = 0;
  for (const VertexId v : ids(a)) largest = std::max(largest, std::abs(a[v] - b[v]));
  return largest;
}

LinearOptions iterative(PreconditionerKind preconditioner) {
  LinearOptions options;
  options.method = LinearMethod::kConjugateGradients;
  options.preconditioner = preconditioner;
  return options;
}

TEST(LinearSolver, AllMethodsFindTheSameSolution) {
  const LinearSystem system = grid_system(20, 10, 20);
  const LinearSolution direct = solve_linear_system(system);
  EXPECT_EQ(direct.report.method, "direct");
  EXPECT_LT(direct.report.residual, 1e-13);
  EXPECT_EQ(direct.values[VertexId(0)], 1);
  double scale = 0;
  for (const double value : direct.values) scale = std::max(scale, std::abs(value));
  for (const auto kind : {PreconditionerKind::kDiagonal, PreconditionerKind::kIncompleteCholesky}) {
    const LinearSolution solution = solve_linear_system(system, iterative(kind));
    EXPECT_LT(largest_difference(direct.values, solution.values), 1e-10 * scale) << solution.report.preconditioner;
    EXPECT_LE(solution.report.residuals.back(), 1e-12);
    EXPECT_LE(solution.report.residual, 2e-12);
    EXPECT_EQ(solution.report.residuals.front(), 1);
    EXPECT_EQ(solution.report.residuals.size(), static_cast<std::size_t>(solution.report.n_iterations) + 1);
  }
}

TEST(LinearSolver, IncompleteCholeskyIsExactOnATree) {
  // Without cycles there is no fill: one iteration suffices. A path is the first row of a grid.
  LinearSystem system = grid_system(30);
  for (std::size_t v = 30; v < 900; ++v) system.is_fixed[VertexId(v)] = 1;
  const LinearReport report = solve_linear_system(system, iterative(PreconditionerKind::kIncompleteCholesky)).report;
  EXPECT_EQ(report.n_unknowns, 29U);
  EXPECT_LE(report.n_iterations, 2);
}

TEST(LinearSolver, PreconditioningSavesIterations) {
  const LinearSystem system = grid_system(60, 10, 60);
  const auto iterations = [&](PreconditionerKind kind) {
    return solve_linear_system(system, iterative(kind)).report.n_iterations;
  };
  EXPECT_LT(2 * iterations(PreconditionerKind::kIncompleteCholesky), iterations(PreconditionerKind::kDiagonal));
}

/// Counts how often it is asked.
class CountingPreconditioner final : public Preconditioner {
 public:
  void apply(std::span<const double> residual, std::span<double> correction) const override {
    ++n_calls;
    std::copy(residual.begin(), residual.end(), correction.begin());
  }
  [[nodiscard]] std::string name() const override { return "none"; }
  mutable int n_calls = 0;
};

TEST(LinearSolver, TakesAPreconditionerOfTheCallers) {
  LinearOptions options = iterative(PreconditionerKind::kDiagonal);
  const auto own = std::make_shared<CountingPreconditioner>();
  options.own_preconditioner = [own](const LinearSystem&) { return own; };
  const LinearReport report = solve_linear_system(grid_system(10), options).report;
  EXPECT_EQ(report.preconditioner, "none");
  EXPECT_EQ(own->n_calls, report.n_iterations);
}

TEST(LinearSolver, AsksForAPreconditionerWhereItIteratesAndTakesNoForAnAnswer) {
  LinearOptions options = iterative(PreconditionerKind::kDiagonal);
  int n_asked = 0;
  options.own_preconditioner = [&](const LinearSystem& system) {
    EXPECT_EQ(system.matrix.size(), grid_system(10).matrix.size());
    ++n_asked;
    return nullptr;
  };
  EXPECT_EQ(solve_linear_system(grid_system(10), options).report.preconditioner, "diagonal");
  EXPECT_EQ(n_asked, 1);
  options.method = LinearMethod::kDirect;
  EXPECT_EQ(solve_linear_system(grid_system(10), options).report.preconditioner, "");
  EXPECT_EQ(n_asked, 1);
}

TEST(LinearSolver, NothingToSolveTakesNoIteration) {
  LinearSystem system = grid_system(5);
  for (double& load : system.load) load = 0;
  system.fixed_value[VertexId(0)] = 0;
  for (const auto method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
    LinearOptions options;
    options.method = method;
    const LinearSolution solution = solve_linear_system(system, options);
    EXPECT_EQ(solution.report.n_iterations, 0);
    for (const double value : solution.values) EXPECT_EQ(value, 0);
  }
}

TEST(LinearSolver, RefusesWhatItCannotSolve) {
  const auto id_of = [](const LinearSystem& system, const LinearOptions& options) {
    try {
      solve_linear_system(system, options);
    } catch (const OptionError& error) {
      return "option " + error.id();
    } catch (const NumericalError& error) {
      return "numerical " + error.id();
    }
    return std::string("solved");
  };
  LinearOptions options = iterative(PreconditionerKind::kDiagonal);
  options.max_iterations = 3;
  EXPECT_EQ(id_of(grid_system(20), options), "numerical solve.not_converged");
  options.max_iterations = 0;
  EXPECT_EQ(id_of(grid_system(20), options), "option solve.bad_option");
  options.max_iterations = 100;
  options.tolerance = 0;
  EXPECT_EQ(id_of(grid_system(20), options), "option solve.bad_option");
  LinearSystem indefinite = grid_system(3);
  for (double& value : indefinite.matrix.values) value = -value;
  options.tolerance = 1e-8;
  EXPECT_EQ(id_of(indefinite, options), "numerical solve.singular");
  options.method = LinearMethod::kDirect;
  EXPECT_EQ(id_of(indefinite, options), "numerical solve.singular");
}

TEST(LinearSolver, ChecksForAnMMatrix) {
  LinearSystem system = grid_system(4);
  EXPECT_TRUE(check_m_matrix(system).is_m_matrix);

  LinearSystem floating = system;
  floating.is_fixed[VertexId(0)] = 0;
  EXPECT_EQ(check_m_matrix(floating).n_floating, 1U);
  EXPECT_FALSE(check_m_matrix(floating).is_m_matrix);
  floating.absorption[VertexId(5)] = 1;
  EXPECT_TRUE(check_m_matrix(floating).is_m_matrix);

  // Entries (0, 1) and (1, 0) positive: two negative row sums would follow if the diagonal were not raised.
  for (double& value : system.matrix.values) value *= value == 2 ? 3 : 1;
  system.matrix.values[1] = 0.5;
  system.matrix.values[system.matrix.offsets[1]] = 0.5;
  const MatrixCheck check = check_m_matrix(system);
  EXPECT_EQ(check.n_positive_couplings, 1U);
  EXPECT_GT(check.largest_positive, 0);
  EXPECT_FALSE(check.is_m_matrix);

  LinearSystem weak = grid_system(4);
  weak.matrix.values[0] -= 1e-6;
  EXPECT_EQ(check_m_matrix(weak).n_negative_row_sums, 1U);
}

TEST(LinearSolver, ThreadsDoNotMatter) {
  const test::AllowThreads allow(8);
  const LinearSystem system = grid_system(200, 10, 200);  // Several blocks of the factorization and of sums.
  for (const auto method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
    LinearOptions options;
    options.method = method;
    const auto with_threads = [&](int n) {
      LinearSolution solution;
      run_with_threads(n, [&] { solution = solve_linear_system(system, options); });
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

}  // namespace
}  // namespace voropack
