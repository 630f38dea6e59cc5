// Solution on the coarsest level.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "voropack/linear_system.h"

namespace voropack {

/// Factors of a matrix at its free vertices, in double precision.
class CoarsestSolver {
 public:
  /// Takes scale * matrix. Throws NumericalError multigrid.singular.
  CoarsestSolver(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale);
  ~CoarsestSolver();

  /// x = A^-1 b, and 0 at fixed vertices.
  void solve(std::span<const float> b, std::span<float> x) const;
  void solve(std::span<const double> b, std::span<double> x) const;

 private:
  struct Factors;
  template <class Real>
  void solve_any(std::span<const Real> b, std::span<Real> x) const;
  std::unique_ptr<const Factors> factors_;
};

}  // namespace voropack
