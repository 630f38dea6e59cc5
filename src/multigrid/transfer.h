// Interpolation to the next finer level and restriction by its transpose, stored for the cycles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "multigrid/raw_array.h"
#include "voropack/linear_system.h"

namespace voropack {

/// A rectangular matrix in compressed rows, in the precision of the cycles.
template <class Real>
class TransferMatrix {
 public:
  /// Leaves out rows and columns that are fixed.
  TransferMatrix(const SparseMatrix& matrix, std::span<const std::uint8_t> is_row_fixed,
                 std::span<const std::uint8_t> is_column_fixed)
      : begin_(matrix.size() + 1) {
    const auto for_each_kept = [&](std::size_t row, auto&& fn) {
      if (is_row_fixed[row] != 0) return;
      for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
        if (is_column_fixed[matrix.columns[e]] == 0 && matrix.values[e] != 0) fn(e);
    };
    begin_[0] = 0;
    parallel_for(matrix.size(), [&](std::size_t row) {
      std::uint32_t count = 0;
      for_each_kept(row, [&](std::uint64_t) { ++count; });
      begin_[row + 1] = count;
    });
    for (std::size_t row = 0; row < matrix.size(); ++row) begin_[row + 1] += begin_[row];
    columns_ = RawArray<std::uint32_t>(begin_[matrix.size()]);
    values_ = RawArray<Real>(begin_[matrix.size()]);
    parallel_for(matrix.size(), [&](std::size_t row) {
      std::uint32_t to = begin_[row];
      for_each_kept(row, [&](std::uint64_t e) {
        columns_[to] = matrix.columns[e];
        values_[to++] = static_cast<Real>(matrix.values[e]);
      });
    });
  }

  /// y = T x, or y += T x.
  void multiply(const Real* x, bool adds, Real* y) const {
    parallel_for(begin_.size() - 1, [&](std::size_t row) {
      Real sum = adds ? y[row] : Real(0);
      for (std::uint32_t e = begin_[row]; e != begin_[row + 1]; ++e) sum += values_[e] * x[columns_[e]];
      y[row] = sum;
    });
  }

 private:
  RawArray<std::uint32_t> begin_;  ///< [n_rows + 1]
  RawArray<std::uint32_t> columns_;
  RawArray<Real> values_;
};

}  // namespace voropack
