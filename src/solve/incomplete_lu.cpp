#include "solve/incomplete_lu.h"

#include <algorithm>
#include <cstddef>

#include "base/parallel.h"
#include "solve/blocks.h"
#include "solve/vectors.h"

namespace voropack {

IncompleteLu::IncompleteLu(const LinearSystem& system)
    : offsets_(system.matrix.size() + 1), upper_(system.matrix.size()), inverse_pivot_(diagonal_of(system.matrix)) {
  const SparseMatrix& matrix = system.matrix;
  const std::size_t n = matrix.size();
  // Entries of a row in its block beside the diagonal, between free vertices.
  const auto for_each_kept = [&](std::size_t row, auto&& fn) {
    if (system.is_fixed[VertexId(row)] != 0) return;
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if (matrix.columns[e] != row && block_of(matrix.columns[e]) == block_of(row) &&
          system.is_fixed[VertexId(matrix.columns[e])] == 0)
        fn(e);
  };
  parallel_for(n, [&](std::size_t row) { for_each_kept(row, [&](std::uint64_t) { ++offsets_[row + 1]; }); });
  for (std::size_t row = 0; row < n; ++row) offsets_[row + 1] += offsets_[row];
  columns_.resize(offsets_[n]);
  values_.resize(offsets_[n]);
  parallel_for(n, [&](std::size_t row) {
    if (system.is_fixed[VertexId(row)] != 0) inverse_pivot_[row] = 0;
    std::uint64_t to = offsets_[row];
    for_each_kept(row, [&](std::uint64_t e) {
      columns_[to] = matrix.columns[e];
      values_[to++] = matrix.values[e];
    });
    const auto begin = columns_.begin() + static_cast<std::ptrdiff_t>(offsets_[row]);
    const auto end = columns_.begin() + static_cast<std::ptrdiff_t>(offsets_[row + 1]);
    upper_[row] = static_cast<std::uint64_t>(std::lower_bound(begin, end, row) - columns_.begin());
  });
  for_each_block(n, [&](std::size_t begin, std::size_t end) { factor_block(begin, end); });
}

/// Row i minus l_ik times row k of U, for each k < i in the row's pattern; what falls off the pattern is dropped.
void IncompleteLu::factor_block(std::size_t begin, std::size_t end) {
  constexpr std::uint64_t kAbsent = ~std::uint64_t{0};
  std::vector<std::uint64_t> entry_of(end - begin, kAbsent);  // Of the row, by column.
  for (std::size_t i = begin; i != end; ++i) {
    const double diagonal = inverse_pivot_[i];
    double pivot = diagonal;
    for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e) entry_of[columns_[e] - begin] = e;
    for (std::uint64_t e = offsets_[i]; e != upper_[i]; ++e) {
      const std::uint32_t k = columns_[e];
      values_[e] *= inverse_pivot_[k];
      for (std::uint64_t u = upper_[k]; u != offsets_[k + std::size_t{1}]; ++u) {
        const std::uint32_t j = columns_[u];
        if (j == i)
          pivot -= values_[e] * values_[u];
        else if (entry_of[j - begin] != kAbsent)
          values_[entry_of[j - begin]] -= values_[e] * values_[u];
      }
    }
    for (std::uint64_t e = offsets_[i]; e != offsets_[i + 1]; ++e) entry_of[columns_[e] - begin] = kAbsent;
    if (!(pivot > 0)) pivot = diagonal;
    inverse_pivot_[i] = pivot != 0 ? 1 / pivot : 0.0;
  }
}

void IncompleteLu::apply(std::span<const double> residual, std::span<double> correction) const {
  for_each_block(inverse_pivot_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      double value = residual[i];
      for (std::uint64_t e = offsets_[i]; e != upper_[i]; ++e) value -= values_[e] * correction[columns_[e]];
      correction[i] = value;
    }
    for (std::size_t i = end; i-- > begin;) {
      double value = correction[i];
      for (std::uint64_t e = upper_[i]; e != offsets_[i + 1]; ++e) value -= values_[e] * correction[columns_[e]];
      correction[i] = value * inverse_pivot_[i];
    }
  });
}

}  // namespace voropack
