#include "multigrid/coarsest.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "voropack/error.h"

namespace voropack {

struct CoarsestSolver::Factors {
  std::vector<std::uint32_t> free_rows;  ///< [n_free] the row of each unknown.
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> ldlt;
};

CoarsestSolver::CoarsestSolver(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale) {
  auto factors = std::make_unique<Factors>();
  std::vector<int> unknown(matrix.size(), -1);
  for (std::uint32_t row = 0; row < matrix.size(); ++row)
    if (is_fixed[row] == 0) {
      unknown[row] = static_cast<int>(factors->free_rows.size());
      factors->free_rows.push_back(row);
    }
  const auto n = static_cast<Eigen::Index>(factors->free_rows.size());
  Eigen::SparseMatrix<double> lower(n, n);
  for (Eigen::Index u = 0; u < n; ++u) {
    const std::uint32_t row = factors->free_rows[static_cast<std::size_t>(u)];
    lower.startVec(u);
    // The row right of the diagonal is the column below it.
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if (matrix.columns[e] >= row && unknown[matrix.columns[e]] >= 0)
        lower.insertBack(unknown[matrix.columns[e]], u) = scale * matrix.values[e];
  }
  lower.finalize();
  if (n > 0) {
    factors->ldlt.compute(lower);
    if (factors->ldlt.info() != Eigen::Success || !(factors->ldlt.vectorD().minCoeff() > 0))
      throw NumericalError(Fault{.id = "multigrid.singular",
                                 .message = "the matrix of the coarsest level is not positive definite",
                                 .fix = "check the mesh for negative dual faces, and the conditions"});
  }
  factors_ = std::move(factors);
}

CoarsestSolver::~CoarsestSolver() = default;

template <class Real>
void CoarsestSolver::solve_any(std::span<const Real> b, std::span<Real> x) const {
  std::fill(x.begin(), x.end(), Real(0));
  const std::vector<std::uint32_t>& rows = factors_->free_rows;
  if (rows.empty()) return;
  Eigen::VectorXd right(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t u = 0; u < rows.size(); ++u) right[static_cast<Eigen::Index>(u)] = static_cast<double>(b[rows[u]]);
  const Eigen::VectorXd solution = factors_->ldlt.solve(right);
  for (std::size_t u = 0; u < rows.size(); ++u) x[rows[u]] = static_cast<Real>(solution[static_cast<Eigen::Index>(u)]);
}

void CoarsestSolver::solve(std::span<const float> b, std::span<float> x) const { solve_any(b, x); }
void CoarsestSolver::solve(std::span<const double> b, std::span<double> x) const { solve_any(b, x); }

}  // namespace voropack
