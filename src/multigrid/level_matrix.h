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

/// A part of a matrix in compressed rows, each filled up with zeros to a multiple of four entries: what a pass over
/// short rows costs is the end of each row, which the processor guesses wrong, and so it guesses it right more often.
template <class Real>
struct PaddedRows {
  static constexpr std::uint32_t kPad = 4;
  RawArray<std::uint32_t> begin;    ///< [n_rows + 1] multiples of kPad.
  RawArray<std::uint32_t> columns;  ///< Those of zeros are columns of the same row.
  RawArray<Real> values;

  /// The sum of a_rj x_j.
  Real product(std::size_t row, const Real* x) const {
    Real sum0 = 0, sum1 = 0;
    const std::uint32_t end = begin[row + 1];
    for (std::uint32_t e = begin[row]; e != end; e += kPad) {
      sum0 += values[e] * x[columns[e]] + values[e + 1] * x[columns[e + 1]];
      sum1 += values[e + 2] * x[columns[e + 2]] + values[e + 3] * x[columns[e + 3]];
    }
    return sum0 + sum1;
  }
};

/// A = D + L + U + O: the diagonal, the entries left and right of it in the same block of rows, and those between
/// blocks, which only some rows have. They lie apart, so that what one pass needs lies together.
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
  [[nodiscard]] std::uint64_t n_entries() const { return n_entries_; }
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
  void fill_outer(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale);
  Real shift(std::size_t row) const { return shift_.empty() ? Real(0) : shift_[row]; }
  /// fn(row, sum of o_ij x_j) for the rows of a block that have entries in O.
  template <class Fn>
  void for_each_outer(std::size_t block_begin, const Real* x, Fn&& fn) const {
    const std::size_t block = block_begin / kSmoothingBlock;
    for (std::uint32_t k = block_outer_begin_[block]; k != block_outer_begin_[block + 1]; ++k)
      fn(outer_row_[k], outer_.product(k, x));
  }
  /// y = -O x in a block.
  void start_with_outer(std::size_t begin, std::size_t end, const Real* x, Real* y) const {
    std::fill(y + begin, y + end, Real(0));
    for_each_outer(begin, x, [&](std::uint32_t row, Real sum) { y[row] = -sum; });
  }

  std::uint64_t n_free_ = 0, n_entries_ = 0;
  PaddedRows<Real> lower_, upper_, outer_;
  RawArray<std::uint32_t> outer_row_;          ///< The row of each row of O, ascending.
  RawArray<std::uint32_t> block_outer_begin_;  ///< [n_blocks + 1]
  RawArray<Real> diagonal_;                    ///< [n] D; 0 at fixed vertices.
  RawArray<Real> inverse_diagonal_;            ///< [n] 1 / D; 0 at fixed vertices.
  RawArray<Real> inverse_;                     ///< [n] 1 / (D + E); 0 at fixed vertices.
  RawArray<Real> shift_;                       ///< [n] E; empty where it is 0 throughout.
};

extern template class LevelMatrix<float>;
extern template class LevelMatrix<double>;

}  // namespace voropack
