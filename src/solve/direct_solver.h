// Sparse factorizations by Eigen.
#pragma once

#include <memory>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// The matrix at free vertices, factorized: LDL^T, or LU where it is not symmetric.
class DirectSolver {
 public:
  /// Throws NumericalError solve.singular.
  explicit DirectSolver(const LinearSystem& system);
  DirectSolver(DirectSolver&&) noexcept;
  ~DirectSolver();

  /// Replaces `values` by the solution of a system with the same matrix and fixed vertices. Residuals are relative to
  /// `unit`.
  void solve(const LinearSystem& system, double unit, std::vector<double>& values, LinearReport& report) const;

 private:
  struct Factors;
  std::vector<VertexId> free_vertices_;
  std::unique_ptr<const Factors> factors_;
};

}  // namespace voropack
