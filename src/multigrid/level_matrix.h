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

/// A = D + L + U + O: the diagonal, the entries left and right of it in the same block of rows, and those between
/// blocks. L lies apart from U and O, so that what one pass needs lies together.
///
/// Gauss-Seidel in blocks is x += M^-1 (b - A x) with M = D + E + L (forward), or its transpose (backward). It
/// converges in the norm of A if M + M^T - A = D + 2 E - O is positive definite. By Gershgorin it is semidefinite with
/// E_ii = max(0, (sum of |o_ij| - a_ii) / 2), which is 0 for every M-matrix, and definite unless all that a row has
/// lies between blocks. The l1 smoothers of [Baker2011] take E_ii from sum of |o_ij| in every row.
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
  void sweep_from_zero(const Real* b, Real* x) const;
  /// r = b - A x after sweep_from_zero, which is (E - U - O) x.
  void residual_after_sweep(const Real* x, Real* r) const;
  /// x_new = x + (D + E + L)^-1 (b - A x), or with its transpose if backward.
  void sweep(const Real* b, const Real* x, bool is_backward, Real* x_new) const;

  /// A forward and a backward sweep from 0, by one pass over the matrix: with x1 after the first sweep,
  /// (D + E + U) x = (D + 2 E - O) x1. Sets x1, x and change = x1 - x.
  void symmetric_sweep_from_zero(const Real* b, Real* x1, Real* change, Real* x) const;
  /// r = b - A x after symmetric_sweep_from_zero, which is (L + O - E) (x1 - x).
  void residual_after_symmetric_sweep(const Real* change, Real* r) const;
  /// A forward and a backward sweep by one and a half passes. Sets x1 and sums = (U + O) x of the old x.
  void symmetric_sweep(const Real* b, Real* x1, Real* sums, Real* x) const;

  /// r = b - A x.
  void residual(const Real* b, const Real* x, Real* r) const;

 private:
  void count_entries(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed);
  void fill_row(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale, std::size_t row);
  Real lower(std::size_t row, const Real* x) const {
    Real sum = 0;
    for (std::uint32_t e = lower_begin_[row]; e != lower_begin_[row + 1]; ++e)
      sum += lower_values_[e] * x[lower_columns_[e]];
    return sum;
  }
  Real rest(std::uint32_t begin, std::uint32_t end, const Real* x) const {
    Real sum = 0;
    for (std::uint32_t e = begin; e != end; ++e) sum += rest_values_[e] * x[rest_columns_[e]];
    return sum;
  }
  Real upper(std::size_t row, const Real* x) const { return rest(rest_begin_[row], outer_begin_[row], x); }
  Real outer(std::size_t row, const Real* x) const { return rest(outer_begin_[row], rest_begin_[row + 1], x); }
  Real upper_and_outer(std::size_t row, const Real* x) const { return rest(rest_begin_[row], rest_begin_[row + 1], x); }
  Real shift(std::size_t row) const { return shift_.empty() ? Real(0) : shift_[row]; }

  std::uint64_t n_free_ = 0;
  RawArray<std::uint32_t> lower_begin_;  ///< [n + 1] rows of L.
  RawArray<std::uint32_t> rest_begin_;   ///< [n + 1] rows of U and O.
  RawArray<std::uint32_t> outer_begin_;  ///< [n] where O begins in them.
  RawArray<std::uint32_t> lower_columns_, rest_columns_;
  RawArray<Real> lower_values_, rest_values_;
  RawArray<Real> diagonal_;          ///< [n] D; 0 at fixed vertices.
  RawArray<Real> inverse_diagonal_;  ///< [n] 1 / D; 0 at fixed vertices.
  RawArray<Real> inverse_;           ///< [n] 1 / (D + E); 0 at fixed vertices.
  RawArray<Real> shift_;             ///< [n] E; empty where it is 0 throughout.
};

extern template class LevelMatrix<float>;
extern template class LevelMatrix<double>;

}  // namespace voropack
