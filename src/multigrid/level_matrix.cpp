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

/// The number of entries of a row with its zeros.
std::uint32_t padded(std::uint32_t count) {
  constexpr std::uint32_t kPad = PaddedRows<float>::kPad;
  return (count + kPad - 1) / kPad * kPad;
}

/// Makes place for the rows whose lengths are in begin[1], begin[2], ...
template <class Real>
void allocate(PaddedRows<Real>& rows) {
  std::uint64_t sum = 0;
  rows.begin[0] = 0;
  for (std::size_t i = 1; i < rows.begin.size(); ++i) {
    sum += rows.begin[i];
    rows.begin[i] = static_cast<std::uint32_t>(sum);
  }
  if (sum > std::numeric_limits<std::uint32_t>::max())
    throw LimitError(Fault{.id = "multigrid.too_large",
                           .message = fmt::format("a level has {} entries, more than 2^32", sum),
                           .fix = "use another preconditioner, or a coarser mesh"});
  rows.columns = RawArray<std::uint32_t>(sum);
  rows.values = RawArray<Real>(sum);
}

/// Where the next entry of a row goes.
template <class Real>
class RowWriter {
 public:
  RowWriter(PaddedRows<Real>& rows, std::size_t row) : rows_(rows), at_(rows.begin[row]), end_(rows.begin[row + 1]) {}
  void add(std::uint32_t column, Real value) {
    rows_.columns[at_] = column;
    rows_.values[at_++] = value;
  }
  void fill_up() {
    while (at_ != end_) add(rows_.columns[at_ - 1], Real(0));
  }

 private:
  PaddedRows<Real>& rows_;
  std::uint32_t at_, end_;
};

}  // namespace

template <class Real>
LevelMatrix<Real>::LevelMatrix(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale)
    : diagonal_(matrix.size()), inverse_diagonal_(matrix.size()), inverse_(matrix.size()), shift_(matrix.size()) {
  count_entries(matrix, is_fixed);
  allocate(lower_);
  allocate(upper_);
  allocate(outer_);
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
  fill_outer(matrix, is_fixed, scale);
  n_free_ = n_free;
  if (n_shifted == 0) shift_ = RawArray<Real>();
}

template <class Real>
void LevelMatrix<Real>::count_entries(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed) {
  const std::size_t n_blocks = (size() + kSmoothingBlock - 1) / kSmoothingBlock;
  lower_.begin = RawArray<std::uint32_t>(size() + 1);
  upper_.begin = RawArray<std::uint32_t>(size() + 1);
  block_outer_begin_ = RawArray<std::uint32_t>(n_blocks + 1);
  RawArray<std::uint32_t> n_outer(size());
  std::atomic<std::uint64_t> n_entries = 0;
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    std::uint64_t n_here = 0;
    std::uint32_t n_rows = 0;
    for (std::size_t row = begin; row != end; ++row) {
      std::array<std::uint32_t, 3> count{};
      for_each_entry(matrix, is_fixed, row, [&](std::uint64_t, Part part) { ++count[static_cast<std::size_t>(part)]; });
      lower_.begin[row + 1] = padded(count[0]);
      upper_.begin[row + 1] = padded(count[1]);
      n_outer[row] = padded(count[2]);
      n_rows += count[2] > 0 ? 1 : 0;
      n_here += count[0] + count[1] + count[2] + (is_fixed[row] == 0 ? 1 : 0);
    }
    block_outer_begin_[begin / kSmoothingBlock + 1] = n_rows;
    n_entries += n_here;
  });
  n_entries_ = n_entries;
  block_outer_begin_[0] = 0;
  for (std::size_t b = 0; b < n_blocks; ++b) block_outer_begin_[b + 1] += block_outer_begin_[b];
  outer_row_ = RawArray<std::uint32_t>(block_outer_begin_[n_blocks]);
  outer_.begin = RawArray<std::uint32_t>(outer_row_.size() + 1);
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    std::uint32_t to = block_outer_begin_[begin / kSmoothingBlock];
    for (std::size_t row = begin; row != end; ++row) {
      if (n_outer[row] == 0) continue;
      outer_row_[to] = static_cast<std::uint32_t>(row);
      outer_.begin[++to] = n_outer[row];
    }
  });
}

template <class Real>
void LevelMatrix<Real>::fill_row(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale,
                                 std::size_t row) {
  diagonal_[row] = inverse_diagonal_[row] = inverse_[row] = shift_[row] = 0;
  if (is_fixed[row] != 0) return;
  RowWriter<Real> lower(lower_, row), upper(upper_, row);
  double between_blocks = 0, diagonal = 0;
  for_each_entry(matrix, is_fixed, row, [&](std::uint64_t e, Part part) {
    if (part == Part::kOuter)
      between_blocks += std::abs(matrix.values[e]);
    else
      (part == Part::kLower ? lower : upper).add(matrix.columns[e], static_cast<Real>(scale * matrix.values[e]));
  });
  lower.fill_up();
  upper.fill_up();
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
void LevelMatrix<Real>::fill_outer(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, double scale) {
  parallel_for(outer_row_.size(), [&](std::size_t k) {
    RowWriter<Real> outer(outer_, k);
    for_each_entry(matrix, is_fixed, outer_row_[k], [&](std::uint64_t e, Part part) {
      if (part == Part::kOuter) outer.add(matrix.columns[e], static_cast<Real>(scale * matrix.values[e]));
    });
    outer.fill_up();
  });
}

template <class Real>
void LevelMatrix<Real>::sweep_from_zero(const Real* b, Real* x) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) x[row] = (b[row] - lower_.product(row, x)) * inverse_[row];
  });
}

template <class Real>
void LevelMatrix<Real>::residual_after_sweep(const Real* x, Real* r) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) r[row] = shift(row) * x[row] - upper_.product(row, x);
    for_each_outer(begin, x, [&](std::uint32_t row, Real sum) { r[row] -= sum; });
  });
}

template <class Real>
void LevelMatrix<Real>::sweep(const Real* b, const Real* x, bool is_backward, Real* x_new) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    start_with_outer(begin, end, x, x_new);
    const auto relax = [&](std::size_t row, const Real* left, const Real* right) {
      const Real known = b[row] + shift(row) * x[row] + x_new[row];
      x_new[row] = (known - lower_.product(row, left) - upper_.product(row, right)) * inverse_[row];
    };
    if (is_backward)
      for (std::size_t row = end; row-- > begin;) relax(row, x, x_new);
    else
      for (std::size_t row = begin; row != end; ++row) relax(row, x_new, x);
  });
}

template <class Real>
void LevelMatrix<Real>::symmetric_sweep_from_zero(const Real* b, Real* x1, Real* change, Real* x) const {
  sweep_from_zero(b, x1);
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    start_with_outer(begin, end, x1, x);
    for (std::size_t row = end; row-- > begin;) {
      const Real known = (diagonal_[row] + 2 * shift(row)) * x1[row] + x[row];
      x[row] = (known - upper_.product(row, x)) * inverse_[row];
      change[row] = x1[row] - x[row];
    }
  });
}

template <class Real>
void LevelMatrix<Real>::residual_after_symmetric_sweep(const Real* change, Real* r) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row) r[row] = lower_.product(row, change) - shift(row) * change[row];
    for_each_outer(begin, change, [&](std::uint32_t row, Real sum) { r[row] += sum; });
  });
}

/// From the forward sweep, b - L x1 = (D + E) x1 + (U + O) x - E x. So the backward one,
/// (D + E + U) x2 = b + E x1 - (L + O) x1, does without L.
template <class Real>
void LevelMatrix<Real>::symmetric_sweep(const Real* b, Real* x1, Real* sums, Real* x) const {
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    start_with_outer(begin, end, x, sums);
    for (std::size_t row = begin; row != end; ++row) {
      sums[row] = upper_.product(row, x) - sums[row] - shift(row) * x[row];
      x1[row] = (b[row] - lower_.product(row, x1) - sums[row]) * inverse_[row];
    }
  });
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    start_with_outer(begin, end, x1, x);
    for (std::size_t row = end; row-- > begin;) {
      const Real known = (diagonal_[row] + 2 * shift(row)) * x1[row] + sums[row] + x[row];
      x[row] = (known - upper_.product(row, x)) * inverse_[row];
    }
  });
}

template <class Real>
void LevelMatrix<Real>::residual(const Real* b, const Real* x, Real* r) const {
  // Fixed rows have no entries: their residual is 0 because b is.
  for_each_smoothing_block(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row != end; ++row)
      r[row] = b[row] - diagonal_[row] * x[row] - lower_.product(row, x) - upper_.product(row, x);
    for_each_outer(begin, x, [&](std::uint32_t row, Real sum) { r[row] -= sum; });
  });
}

template class LevelMatrix<float>;
template class LevelMatrix<double>;

}  // namespace voropack
