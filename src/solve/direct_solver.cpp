#include "solve/direct_solver.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "solve/vectors.h"

namespace voropack {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// The matrix at free vertices, by columns: its lower triangle where it is symmetric, else all of it, transposed.
Matrix free_matrix(const LinearSystem& system, const std::vector<VertexId>& free_vertices) {
  const SparseMatrix& matrix = system.matrix;
  std::vector<int> unknown(matrix.size(), -1);
  for (std::size_t u = 0; u < free_vertices.size(); ++u) unknown[free_vertices[u].value()] = static_cast<int>(u);
  const auto n = static_cast<Eigen::Index>(free_vertices.size());
  Matrix result(n, n);
  for (std::size_t u = 0; u < free_vertices.size(); ++u) {
    const std::size_t row = free_vertices[u].value();
    result.startVec(static_cast<Eigen::Index>(u));
    // Row u right of the diagonal is column u below it.
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if ((matrix.columns[e] >= row || !system.is_symmetric) && unknown[matrix.columns[e]] >= 0)
        result.insertBack(unknown[matrix.columns[e]], static_cast<Eigen::Index>(u)) = matrix.values[e];
  }
  result.finalize();
  return result;
}

}  // namespace

struct DirectSolver::Factors {
  std::optional<Eigen::SimplicialLDLT<Matrix, Eigen::Lower>> cholesky;
  Eigen::SparseLU<Matrix, Eigen::COLAMDOrdering<int>> lu;

  Factors(const Matrix& matrix, bool is_symmetric) {
    if (is_symmetric) {
      cholesky.emplace(matrix);
      if (cholesky->info() != Eigen::Success || !(cholesky->vectorD().minCoeff() > 0))
        throw NumericalError(Fault{.id = "solve.singular",
                                   .message = "the matrix is not positive definite",
                                   .fix = "check the mesh for negative dual faces, and the conditions"});
      return;
    }
    lu.compute(matrix.transpose());
    if (lu.info() != Eigen::Success)
      throw NumericalError(Fault{.id = "solve.singular",
                                 .message = "the matrix has no inverse",
                                 .fix = "check the conditions and, of a nonlinear problem, the initial values"});
  }

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    if (cholesky) return cholesky->solve(right);
    return lu.solve(right);
  }
};

DirectSolver::DirectSolver(const LinearSystem& system) {
  for (const VertexId v : ids(system.is_fixed))
    if (system.is_fixed[v] == 0) free_vertices_.push_back(v);
  if (!free_vertices_.empty())
    factors_ = std::make_unique<const Factors>(free_matrix(system, free_vertices_), system.is_symmetric);
}

DirectSolver::DirectSolver(DirectSolver&&) noexcept = default;
DirectSolver::~DirectSolver() = default;

void DirectSolver::solve(const LinearSystem& system, double unit, std::vector<double>& values,
                         LinearReport& report) const {
  std::vector<double> residual(values.size());
  free_residual(system, values, residual);
  report.residuals = {norm(residual) / unit};
  // The second pass refines: it removes most of what rounding left in the first.
  Eigen::VectorXd right(static_cast<Eigen::Index>(free_vertices_.size()));
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t u = 0; u < free_vertices_.size(); ++u)
      right[static_cast<Eigen::Index>(u)] = residual[free_vertices_[u].value()];
    const Eigen::VectorXd correction = factors_->solve(right);
    for (std::size_t u = 0; u < free_vertices_.size(); ++u)
      values[free_vertices_[u].value()] += correction[static_cast<Eigen::Index>(u)];
    free_residual(system, values, residual);
    report.residual = norm(residual) / unit;
    report.residuals.push_back(report.residual);
  }
}

}  // namespace voropack
