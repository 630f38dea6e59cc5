#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "solve/floating_parts.h"
#include "solve/vectors.h"
#include "voropack/linear_system.h"

namespace voropack {

namespace {

/// Signs of some rows of the matrix.
MatrixCheck check_rows(const LinearSystem& system, const std::vector<double>& diagonal, std::size_t begin,
                       std::size_t end) {
  const SparseMatrix& matrix = system.matrix;
  MatrixCheck check;
  for (std::size_t row = begin; row != end; ++row) {
    double sum = 0, magnitude = 0;
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e) {
      const double value = matrix.values[e];
      sum += value;
      magnitude += std::abs(value);
      const std::size_t column = matrix.columns[e];
      if (column <= row || !(value > 0)) continue;
      ++check.n_positive_couplings;
      const double scale = std::sqrt(std::abs(diagonal[row] * diagonal[column]));
      check.largest_positive = std::max(check.largest_positive, scale > 0 ? value / scale : 1.0);
    }
    // The diagonal is itself a rounded sum of the entries, and summed up again here.
    const auto n_terms = static_cast<double>(matrix.offsets[row + 1] - matrix.offsets[row]);
    if (!(sum >= -2 * n_terms * std::numeric_limits<double>::epsilon() * magnitude)) ++check.n_negative_row_sums;
  }
  return check;
}

MatrixCheck combine(MatrixCheck a, const MatrixCheck& b) {
  a.n_positive_couplings += b.n_positive_couplings;
  a.n_negative_row_sums += b.n_negative_row_sums;
  a.largest_positive = std::max(a.largest_positive, b.largest_positive);
  return a;
}

}  // namespace

void multiply(const SparseMatrix& matrix, std::span<const double> x, std::span<double> y) {
  parallel_for(matrix.size(), [&](std::size_t row) {
    double sum = 0;
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      sum += matrix.values[e] * x[matrix.columns[e]];
    y[row] = sum;
  });
}

MatrixCheck check_m_matrix(const LinearSystem& system) {
  const std::vector<double> diagonal = diagonal_of(system.matrix);
  MatrixCheck check = parallel_reduce_ordered(
      system.matrix.size(), kVectorBlock, MatrixCheck{},
      [&](std::size_t begin, std::size_t end) { return check_rows(system, diagonal, begin, end); }, combine);
  check.n_floating = floating_roots(system).size();
  check.is_m_matrix = check.n_positive_couplings == 0 && check.n_negative_row_sums == 0 && check.n_floating == 0;
  return check;
}

}  // namespace voropack
