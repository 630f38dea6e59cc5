#include "solve/preconditioners.h"

#include <cstddef>

#include "base/parallel.h"
#include "solve/blocks.h"
#include "solve/vectors.h"

namespace voropack {

DiagonalPreconditioner::DiagonalPreconditioner(const LinearSystem& system) : inverse_(diagonal_of(system.matrix)) {
  parallel_for(inverse_.size(), [&](std::size_t i) {
    inverse_[i] = system.is_fixed[VertexId(i)] != 0 || !(inverse_[i] > 0) ? 0.0 : 1 / inverse_[i];
  });
}

void DiagonalPreconditioner::apply(std::span<const double> residual, std::span<double> correction) const {
  parallel_for(inverse_.size(), [&](std::size_t i) { correction[i] = inverse_[i] * residual[i]; });
}

IncompleteCholesky::IncompleteCholesky(const LinearSystem& system)
    : offsets_(system.matrix.size() + 1), inverse_pivot_(system.matrix.size()) {
  const SparseMatrix& matrix = system.matrix;
  const std::size_t n = matrix.size();
  // Entries of row i in the block, left of the diagonal, between free vertices.
  const auto for_each_kept = [&](std::size_t row, auto&& fn) {
    if (system.is_fixed[VertexId(row)] != 0) return;
    const std::size_t first = row - row % kBlockSize;
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1] && matrix.columns[e] < row; ++e)
      if (matrix.columns[e] >= first && system.is_fixed[VertexId(matrix.columns[e])] == 0) fn(e);
  };
  parallel_for(n, [&](std::size_t row) { for_each_kept(row, [&](std::uint64_t) { ++offsets_[row + 1]; }); });
  for (std::size_t row = 0; row < n; ++row) offsets_[row + 1] += offsets_[row];
  columns_.resize(offsets_[n]);
  values_.resize(offsets_[n]);
  parallel_for(n, [&](std::size_t row) {
    std::uint64_t to = offsets_[row];
    for_each_kept(row, [&](std::uint64_t e) {
      columns_[to] = matrix.columns[e];
      values_[to++] = matrix.values[e];
    });
  });
  for_each_block(n, [&](std::size_t begin, std::size_t end) { factor_block(system, begin, end); });
}

/// Row by row: (L D)_ij = a_ij - sum over common k < j of (L D)_ik L_jk, then D_i = a_ii - sum (L D)_ij L_ij.
void IncompleteCholesky::factor_block(const LinearSystem& system, std::size_t begin, std::size_t end) {
  const std::vector<double>& pivots = inverse_pivot_;
  std::vector<double> row_of(end - begin);  // (L D)_ik by column, 0 off the pattern.
  for (std::size_t i = begin; i != end; ++i) {
    if (system.is_fixed[VertexId(i)] != 0) continue;
    const SparseMatrix& matrix = system.matrix;
    double diagonal = 0;
    for (std::uint64_t e = matrix.offsets[i]; e != matrix.offsets[i + 1]; ++e)
      if (matrix.columns[e] == i) diagonal = matrix.values[e];
    double pivot = diagonal;
    for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e) {
      const std::uint32_t j = columns_[e];
      double value = values_[e];
      for (std::uint64_t k = offsets_[j]; k != offsets_[j + 1]; ++k) value -= row_of[columns_[k] - begin] * values_[k];
      row_of[j - begin] = value;
      values_[e] = value * pivots[j];
      pivot -= value * values_[e];
    }
    for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e) row_of[columns_[e] - begin] = 0;
    if (!(pivot > 0)) pivot = diagonal;
    inverse_pivot_[i] = pivot > 0 ? 1 / pivot : 0.0;
  }
}

void IncompleteCholesky::apply(std::span<const double> residual, std::span<double> correction) const {
  for_each_block(inverse_pivot_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      double value = residual[i];
      for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e) value -= values_[e] * correction[columns_[e]];
      correction[i] = value;
    }
    for (std::size_t i = begin; i != end; ++i) correction[i] *= inverse_pivot_[i];
    for (std::size_t i = end; i-- > begin;)
      for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e)
        correction[columns_[e]] -= values_[e] * correction[i];
  });
}

}  // namespace voropack
