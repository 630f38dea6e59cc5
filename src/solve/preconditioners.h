// Preconditioners that need nothing but the matrix.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// Divides by the diagonal.
class DiagonalPreconditioner final : public Preconditioner {
 public:
  explicit DiagonalPreconditioner(const LinearSystem& system);
  void apply(std::span<const double> residual, std::span<double> correction) const override;
  [[nodiscard]] std::string name() const override { return "diagonal"; }

 private:
  std::vector<double> inverse_;  ///< 0 at fixed vertices.
};

/// L D L^T with the pattern of the matrix, in blocks of consecutive vertices that do not see each other: so threads
/// share the work, and the result depends on the blocks only. Vertices in the order of a space-filling curve make
/// blocks compact.
class IncompleteCholesky final : public Preconditioner {
 public:
  explicit IncompleteCholesky(const LinearSystem& system);
  void apply(std::span<const double> residual, std::span<double> correction) const override;
  [[nodiscard]] std::string name() const override { return "incomplete Cholesky"; }

 private:
  void factor_block(const LinearSystem& system, std::size_t begin, std::size_t end);

  std::vector<std::uint64_t> offsets_;  ///< [n + 1] rows of L without its unit diagonal, in one block each.
  std::vector<std::uint32_t> columns_;
  std::vector<double> values_;
  std::vector<double> inverse_pivot_;  ///< [n] 1 / D; 0 at fixed vertices.
};

}  // namespace voropack
