// An incomplete factorization of matrices that are not symmetric.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// L U with the pattern of the matrix, in the same blocks as IncompleteCholesky.
class IncompleteLu final : public Preconditioner {
 public:
  explicit IncompleteLu(const LinearSystem& system);
  void apply(std::span<const double> residual, std::span<double> correction) const override;
  [[nodiscard]] std::string name() const override { return "incomplete LU"; }

 private:
  void factor_block(std::size_t begin, std::size_t end);

  std::vector<std::uint64_t> offsets_;  ///< [n + 1] rows of L without its unit diagonal and of U without its diagonal.
  std::vector<std::uint64_t> upper_;    ///< [n] where the part of U begins in each row.
  std::vector<std::uint32_t> columns_;
  std::vector<double> values_;
  std::vector<double> inverse_pivot_;  ///< [n] 1 / U_ii; 0 at fixed vertices.
};

}  // namespace voropack
