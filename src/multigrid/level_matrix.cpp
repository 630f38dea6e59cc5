#include "multigrid/level_matrix.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "voropack/error.h"

namespace voropack {

namespace {

enum class Part : std::uint8_t { kLower, kUpper, kOuter };

/// fn(e, part) for the entries of a row off the diagonal and between free vertices.
template <class Fn>
void for_each_entry(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, std::size_t row, Fn&& fn) {
  if (is_fixed[row] != 0) return;
  const std::size_t begin = row - row % kSmoothingBlock, end = begin + kSmoothingBlock;
  for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e) {
    const std::uint32_t j = matrix.columns[e];
    if (j == row || is_fixed[j] != 0 || matrix.values[e] == 0) continue;
    fn(e, j < begin || j >= end ? Part::kOuter : j < row ? Part::kLower : Part::kUpper);
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
      outer_begin_(matrix.size()),
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
    std::array<std::uint32_t, 3> count{};
    for_each_entry(matrix, is_fixed, row, [&](std::uint64_t, Part part) { ++count[static_cast<std::size_t>(part)]; });
    lower_begin_[row + 1] = count[0];
    rest_begin_[row + 1] = count[1] + count[2];
    outer_begin_[row] = count[1];
  });
}

template <class Real>
void LevelMatrix<Real>::fill_row(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale,
                                 std::size_t row) {
  diagonal_[row] = inverse_diagonal_[row] = inverse_[row] = shift_[row] = 0;
  outer_begin_[row] += rest_begin_[row];
  if (is_fixed[row] != 0) return;
  std::uint32_t to_lower = lower_begin_[row], to_upper = rest_begin_[row], to_outer = outer_begin_[row];
  double between_blocks = 0, diagonal = 0;
  for_each_entry(matrix, is_fixed, row, [&](std::uint64_t e, Part part) {
    const auto value = static_cast<Real>(scale * matrix.values[e]);
    if (part == Part::kLower) {
      lower_columns_[to_lower] = matrix.columns[e];
      lower_values_[to_lower++] = value;
      return;
    }
    std::uint32_t& to = part == Part::kUpper ? to_upper : to_outer;
    rest_columns_[to] = matrix.columns[e];
    rest_values_[to++] = value;
    if (part == Part::kOuter) between_blocks += std::abs(matrix.values[e]);
  });
  for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
    if (matrix.columns[e] == row) diagonal = matrix.values[e];
  // Rounding of a row without absorption does not count as an excess.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const double shift = between_blocks > diagonal * (1 + kRounding) ? (between_blocks - diagonal) / 2 : 0.0;
  diagonal_[row] = static_cast<Real>(scale * diagonal);
  shift_[row] = static_cast<Real>(scale * shift);
  inverse_diagonal_[row] = static_cast<Real>(1 / (scale * diagonal));
  inverse_[row] = static_cast<Real>(1 / (scale * (diagonal + shift)));
}

template <class Real>
void LevelMatrix<Real>::sweep_from_zero(const Real* b, Real* x) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) x[row] = (b[row] - lower(row, x)) * inverse_[row];
  });
}

template <class Real>
void LevelMatrix<Real>::residual_after_sweep(const Real* x, Real* r) const {
  parallel_for(size(), [&](std::size_t row) { r[row] = shift(row) * x[row] - upper_and_outer(row, x); });
}

template <class Real>
void LevelMatrix<Real>::sweep(const Real* b, const Real* x, bool is_backward, Real* x_new) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    const auto right = [&](std::size_t row) { return b[row] + shift(row) * x[row]; };
    if (is_backward)
      for (std::size_t row = end; row-- > begin;)
        x_new[row] = (right(row) - lower(row, x) - upper(row, x_new) - outer(row, x)) * inverse_[row];
    else
      for (std::size_t row = begin; row != end; ++row)
        x_new[row] = (right(row) - lower(row, x_new) - upper_and_outer(row, x)) * inverse_[row];
  });
}

template <class Real>
void LevelMatrix<Real>::symmetric_sweep_from_zero(const Real* b, Real* x1, Real* change, Real* x) const {
  sweep_from_zero(b, x1);
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = end; row-- > begin;) {
      const Real right = (diagonal_[row] + 2 * shift(row)) * x1[row];
      x[row] = (right - outer(row, x1) - upper(row, x)) * inverse_[row];
      change[row] = x1[row] - x[row];
    }
  });
}

template <class Real>
void LevelMatrix<Real>::residual_after_symmetric_sweep(const Real* change, Real* r) const {
  parallel_for(size(),
               [&](std::size_t row) { r[row] = lower(row, change) + outer(row, change) - shift(row) * change[row]; });
}

/// From the forward sweep, b - L x1 = (D + E) x1 + (U + O) x - E x. So the backward one,
/// (D + E + U) x2 = b + E x1 - (L + O) x1, does without L.
template <class Real>
void LevelMatrix<Real>::symmetric_sweep(const Real* b, Real* x1, Real* sums, Real* x) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) {
      sums[row] = upper_and_outer(row, x) - shift(row) * x[row];
      x1[row] = (b[row] - lower(row, x1) - sums[row]) * inverse_[row];
    }
  });
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = end; row-- > begin;) {
      const Real right = (diagonal_[row] + 2 * shift(row)) * x1[row] + sums[row];
      x[row] = (right - outer(row, x1) - upper(row, x)) * inverse_[row];
    }
  });
}

template <class Real>
void LevelMatrix<Real>::residual(const Real* b, const Real* x, Real* r) const {
  parallel_for(size(), [&](std::size_t row) {
    // Fixed rows have no entries: their residual is 0 because b is.
    r[row] = b[row] - diagonal_[row] * x[row] - lower(row, x) - upper_and_outer(row, x);
  });
}

template class LevelMatrix<float>;
template class LevelMatrix<double>;

}  // namespace voropack
