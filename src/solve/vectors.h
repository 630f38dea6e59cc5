// Operations on vectors and matrices that several solvers need. Sums are the same for any number of threads.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "voropack/linear_system.h"

namespace voropack {

inline constexpr std::size_t kVectorBlock = 8192;  ///< Entries that are summed one after the other.

inline double dot(std::span<const double> a, std::span<const double> b) {
  return parallel_reduce_ordered(
      a.size(), kVectorBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i != end; ++i) sum += a[i] * b[i];
        return sum;
      },
      [](double x, double y) { return x + y; });
}

inline double norm(std::span<const double> a) { return std::sqrt(dot(a, a)); }

/// The diagonal of a matrix that lists all of it.
inline std::vector<double> diagonal_of(const SparseMatrix& matrix) {
  std::vector<double> diagonal(matrix.size());
  parallel_for(matrix.size(), [&](std::size_t row) {
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if (matrix.columns[e] == row) diagonal[row] = matrix.values[e];
  });
  return diagonal;
}

/// residual = load - matrix values at free vertices, 0 at fixed ones.
inline void free_residual(const LinearSystem& system, std::span<const double> values, std::span<double> residual) {
  multiply(system.matrix, values, residual);
  parallel_for(residual.size(), [&](std::size_t i) {
    const VertexId v(i);
    residual[i] = system.is_fixed[v] != 0 ? 0.0 : system.load[v] - residual[i];
  });
}

}  // namespace voropack
