#include "multigrid/level_matrix.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "voropack/error.h"

namespace voropack {

namespace {

/// fn(e, is_lower) for the entries of a row off the diagonal and between free vertices.
template <class Fn>
void for_each_entry(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, std::size_t row, Fn&& fn) {
  if (is_fixed[row] != 0) return;
  const std::size_t block = row - row % kSmoothingBlock;
  for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e) {
    const std::uint32_t j = matrix.columns[e];
    if (j != row && is_fixed[j] == 0 && matrix.values[e] != 0) fn(e, j >= block && j < row);
  }
}

/// offsets[0] = 0, and each entry becomes the sum up to it.
std::uint32_t accumulate(RawArray<std::uint32_t>& offsets) {
  std::uint64_t sum = 0;
  offsets[0] = 0;
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    sum += offsets[i];
    offsets[i] = static_cast<std::uint32_t>(sum);
  }
  if (sum > std::numeric_limits<std::uint32_t>::max())
    throw LimitError(Fault{.id = "multigrid.too_large",
                           .message = fmt::format("a level has {} entries, more than 2^32", sum),
                           .fix = "use another preconditioner, or a coarser mesh"});
  return static_cast<std::uint32_t>(sum);
}

}  // namespace

template <class Real>
LevelMatrix<Real>::LevelMatrix(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale)
    : lower_begin_(matrix.size() + 1),
      rest_begin_(matrix.size() + 1),
      diagonal_(matrix.size()),
      inverse_diagonal_(matrix.size()),
      inverse_(matrix.size()),
      shift_(matrix.size()) {
  count_entries(matrix, is_fixed);
  const std::uint32_t n_lower = accumulate(lower_begin_), n_rest = accumulate(rest_begin_);
  lower_columns_ = RawArray<std::uint32_t>(n_lower);
  lower_values_ = RawArray<Real>(n_lower);
  rest_columns_ = RawArray<std::uint32_t>(n_rest);
  rest_values_ = RawArray<Real>(n_rest);
  std::atomic<std::uint64_t> n_free = 0, n_shifted = 0, n_bad = 0;
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    std::uint64_t n_free_here = 0, n_shifted_here = 0, n_bad_here = 0;
    for (std::size_t row = begin; row != end; ++row) {
      fill_row(matrix, is_fixed, scale, row);
      if (is_fixed[row] != 0) continue;
      ++n_free_here;
      if (shift_[row] > 0) ++n_shifted_here;
      if (!(diagonal_[row] > 0 && std::isfinite(inverse_diagonal_[row]))) ++n_bad_here;
    }
    n_free += n_free_here;
    n_shifted += n_shifted_here;
    n_bad += n_bad_here;
  });
  if (n_bad > 0)
    throw NumericalError(
        Fault{.id = "multigrid.singular",
              .message = fmt::format("{} diagonal entries of {} are not positive", n_bad.load(), n_free.load()),
              .fix = "check the mesh for negative dual faces, and the conditions"});
  n_free_ = n_free;
  if (n_shifted == 0) shift_ = RawArray<Real>();
}

template <class Real>
void LevelMatrix<Real>::count_entries(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed) {
  parallel_for(size(), [&](std::size_t row) {
    std::uint32_t n_lower = 0, n_rest = 0;
    for_each_entry(matrix, is_fixed, row, [&](std::uint64_t, bool is_lower) { ++(is_lower ? n_lower : n_rest); });
    lower_begin_[row + 1] = n_lower;
    rest_begin_[row + 1] = n_rest;
  });
}

template <class Real>
void LevelMatrix<Real>::fill_row(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale,
                                 std::size_t row) {
  diagonal_[row] = inverse_diagonal_[row] = inverse_[row] = shift_[row] = 0;
  if (is_fixed[row] != 0) return;
  const std::size_t begin = row - row % kSmoothingBlock, end = begin + kSmoothingBlock;
  std::uint32_t to_lower = lower_begin_[row], to_rest = rest_begin_[row];
  double between_blocks = 0, diagonal = 0;
  for_each_entry(matrix, is_fixed, row, [&](std::uint64_t e, bool is_lower) {
    const std::uint32_t j = matrix.columns[e];
    if (j < begin || j >= end) between_blocks += std::abs(matrix.values[e]);
    std::uint32_t& to = is_lower ? to_lower : to_rest;
    (is_lower ? lower_columns_ : rest_columns_)[to] = j;
    (is_lower ? lower_values_ : rest_values_)[to] = static_cast<Real>(scale * matrix.values[e]);
    ++to;
  });
  for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
    if (matrix.columns[e] == row) diagonal = matrix.values[e];
  // Rounding of a row without absorption does not count as an excess.
  const double shift = between_blocks > diagonal * (1 + 64 * std::numeric_limits<double>::epsilon())
                           ? (between_blocks - diagonal) / 2
                           : 0.0;
  diagonal_[row] = static_cast<Real>(scale * diagonal);
  shift_[row] = static_cast<Real>(scale * shift);
  inverse_diagonal_[row] = static_cast<Real>(1 / (scale * diagonal));
  inverse_[row] = static_cast<Real>(1 / (scale * (diagonal + shift)));
}

template <class Real>
Real LevelMatrix<Real>::lower_product(std::size_t row, const Real* x) const {
  Real sum = 0;
  for (std::uint32_t e = lower_begin_[row]; e != lower_begin_[row + 1]; ++e)
    sum += lower_values_[e] * x[lower_columns_[e]];
  return sum;
}

template <class Real>
Real LevelMatrix<Real>::rest_product(std::size_t row, std::size_t begin, std::size_t end, const Real* inside,
                                     const Real* outside) const {
  Real sum = 0;
  for (std::uint32_t e = rest_begin_[row]; e != rest_begin_[row + 1]; ++e) {
    const std::uint32_t j = rest_columns_[e];
    sum += rest_values_[e] * (j - begin < end - begin ? inside : outside)[j];
  }
  return sum;
}

template <class Real>
void LevelMatrix<Real>::smooth_from_zero(const Real* b, Real* x) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) x[row] = (b[row] - lower_product(row, x)) * inverse_[row];
  });
}

template <class Real>
void LevelMatrix<Real>::residual_after_first_sweep(const Real* x, Real* r) const {
  parallel_for(size(), [&](std::size_t row) {
    const Real kept = shift_.empty() ? Real(0) : shift_[row] * x[row];
    r[row] = kept - rest_product(row, 0, 0, x, x);
  });
}

template <class Real>
void LevelMatrix<Real>::smooth(const Real* b, const Real* x, Real* x_new, bool is_backward) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    std::copy(x + begin, x + end, x_new + begin);
    const auto relax = [&](std::size_t row) {
      const Real kept = shift_.empty() ? Real(0) : shift_[row] * x[row];
      x_new[row] =
          (b[row] + kept - lower_product(row, x_new) - rest_product(row, begin, end, x_new, x)) * inverse_[row];
    };
    if (is_backward)
      for (std::size_t row = end; row-- > begin;) relax(row);
    else
      for (std::size_t row = begin; row != end; ++row) relax(row);
  });
}

template <class Real>
void LevelMatrix<Real>::residual(const Real* b, const Real* x, Real* r) const {
  parallel_for(size(), [&](std::size_t row) {
    // Fixed rows have no entries: their residual is 0 because b is.
    r[row] = b[row] - diagonal_[row] * x[row] - lower_product(row, x) - rest_product(row, 0, 0, x, x);
  });
}

template class LevelMatrix<float>;
template class LevelMatrix<double>;

}  // namespace voropack
