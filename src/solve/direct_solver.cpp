#include "solve/direct_solver.h"

#include <Eigen/SparseCholesky>
#include <cstddef>
#include <cstdint>

#include "solve/vectors.h"

namespace voropack {

namespace {

/// The lower triangle of the matrix at free vertices, by columns.
Eigen::SparseMatrix<double> free_matrix(const LinearSystem& system, const std::vector<VertexId>& free_vertices) {
  const SparseMatrix& matrix = system.matrix;
  std::vector<int> unknown(matrix.size(), -1);
  for (std::size_t u = 0; u < free_vertices.size(); ++u) unknown[free_vertices[u].value()] = static_cast<int>(u);
  const auto n = static_cast<Eigen::Index>(free_vertices.size());
  Eigen::SparseMatrix<double> lower(n, n);
  for (std::size_t u = 0; u < free_vertices.size(); ++u) {
    const std::size_t row = free_vertices[u].value();
    lower.startVec(static_cast<Eigen::Index>(u));
    // Row u right of the diagonal is column u below it.
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if (matrix.columns[e] >= row && unknown[matrix.columns[e]] >= 0)
        lower.insertBack(unknown[matrix.columns[e]], static_cast<Eigen::Index>(u)) = matrix.values[e];
  }
  lower.finalize();
  return lower;
}

}  // namespace

void solve_directly(const LinearSystem& system, std::vector<double>& values, LinearReport& report) {
  std::vector<VertexId> free_vertices;
  for (const VertexId v : ids(system.is_fixed))
    if (system.is_fixed[v] == 0) free_vertices.push_back(v);

  std::vector<double> residual(values.size());
  free_residual(system, values, residual);
  const double unit = norm(residual);
  report.residuals = {unit > 0 ? 1.0 : 0.0};
  if (unit == 0) return;

  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factors(free_matrix(system, free_vertices));
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0))
    throw NumericalError(Fault{.id = "solve.singular",
                               .message = "the matrix is not positive definite",
                               .fix = "check the mesh for negative dual faces, and the conditions"});
  // The second pass refines: it removes most of what rounding left in the first.
  Eigen::VectorXd right(static_cast<Eigen::Index>(free_vertices.size()));
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t u = 0; u < free_vertices.size(); ++u)
      right[static_cast<Eigen::Index>(u)] = residual[free_vertices[u].value()];
    const Eigen::VectorXd correction = factors.solve(right);
    for (std::size_t u = 0; u < free_vertices.size(); ++u)
      values[free_vertices[u].value()] += correction[static_cast<Eigen::Index>(u)];
    free_residual(system, values, residual);
    report.residual = norm(residual) / unit;
    report.residuals.push_back(report.residual);
  }
}

}  // namespace voropack
