// The matrix of one level of multigrid, stored for smoothing: at free vertices only, in blocks of consecutive rows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "multigrid/raw_array.h"
#include "voropack/linear_system.h"

namespace voropack {

/// Rows that Gauss-Seidel takes one after the other. Larger blocks smooth better, smaller ones keep more threads busy;
/// the values of one block stay in the nearest cache.
inline constexpr std::size_t kSmoothingBlock = 4096;

/// Runs fn(begin, end) on every block, in parallel.
template <class Fn>
void for_each_smoothing_block(std::size_t n, Fn&& fn) {
  parallel_for((n + kSmoothingBlock - 1) / kSmoothingBlock,
               [&](std::size_t b) { fn(b * kSmoothingBlock, std::min(n, (b + 1) * kSmoothingBlock)); }, 1);
}

/// A = D + L + R: the diagonal, the entries left of it in the same block of rows, and the rest, apart, so that what
/// one pass needs lies together.
///
/// Gauss-Seidel in blocks is x += M^-1 (b - A x) with M = D + E + L, or its transpose. It converges in the norm of A
/// if M + M^T - A = D + 2 E - (entries between blocks) is positive definite. By Gershgorin it is semidefinite with
/// E_ii = max(0, (sum of |a_ij| between blocks - a_ii) / 2), which is 0 for every M-matrix, and definite unless a row
/// has no entry within its block. The l1 smoothers of [Baker2011] need the bound for matrices that are no M-matrices.
template <class Real>
class LevelMatrix {
 public:
  /// Takes scale * matrix. Throws NumericalError multigrid.singular, LimitError multigrid.too_large.
  LevelMatrix(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale);

  [[nodiscard]] std::size_t size() const { return inverse_.size(); }
  [[nodiscard]] std::uint64_t n_entries() const { return lower_columns_.size() + rest_columns_.size() + n_free_; }
  [[nodiscard]] std::uint64_t n_free() const { return n_free_; }
  /// 1 / D, 0 at fixed vertices.
  [[nodiscard]] std::span<const Real> inverse_diagonal() const { return inverse_diagonal_; }

  /// x = (D + E + L)^-1 b: a forward sweep from 0.
  void smooth_from_zero(const Real* b, Real* x) const;
  /// r = b - A x after smooth_from_zero: (E - R) x.
  void residual_after_first_sweep(const Real* x, Real* r) const;
  /// x_new = x + (D + E + L)^-1 (b - A x), or with its transpose if backward.
  void smooth(const Real* b, const Real* x, Real* x_new, bool is_backward) const;
  /// r = b - A x.
  void residual(const Real* b, const Real* x, Real* r) const;

 private:
  void count_entries(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed);
  void fill_row(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale, std::size_t row);
  /// Sum of a_ij x_j right of the diagonal or between blocks; entries of the block see `inside`, others `outside`.
  Real rest_product(std::size_t row, std::size_t begin, std::size_t end, const Real* inside, const Real* outside) const;
  Real lower_product(std::size_t row, const Real* x) const;

  std::uint64_t n_free_ = 0;
  RawArray<std::uint32_t> lower_begin_, rest_begin_;      ///< [n + 1]
  RawArray<std::uint32_t> lower_columns_, rest_columns_;  ///< Ascending in each row.
  RawArray<Real> lower_values_, rest_values_;
  RawArray<Real> diagonal_;          ///< [n] D; 0 at fixed vertices.
  RawArray<Real> inverse_diagonal_;  ///< [n] 1 / D; 0 at fixed vertices.
  RawArray<Real> inverse_;           ///< [n] 1 / (D + E); 0 at fixed vertices.
  RawArray<Real> shift_;             ///< [n] E; empty where it is 0 throughout.
};

extern template class LevelMatrix<float>;
extern template class LevelMatrix<double>;

}  // namespace voropack
