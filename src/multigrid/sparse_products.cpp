// Transposes and triple products of sparse matrices, row by row.
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "voropack/multigrid.h"

namespace voropack {

namespace {

constexpr std::size_t kRowsPerTask = 2048;

/// One row of a product in the making [Gustavson1978]: the place of each column in the row, and the sums so far.
class RowSum {
 public:
  explicit RowSum(std::size_t n_columns) : place_(n_columns, kNone) {}

  void add(std::uint32_t column, double value) {
    std::uint32_t& place = place_[column];
    if (place == kNone) {
      place = static_cast<std::uint32_t>(entries_.size());
      entries_.emplace_back(column, value);
    } else {
      entries_[place].second += value;
    }
  }

  /// Appends the row to a matrix, and begins a new one.
  void move_to(SparseMatrix& matrix) {
    for (const auto& [column, value] : entries_) place_[column] = kNone;
    std::sort(entries_.begin(), entries_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [column, value] : entries_) {
      matrix.columns.push_back(column);
      matrix.values.push_back(value);
    }
    matrix.offsets.push_back(matrix.columns.size());
    entries_.clear();
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place_;
  std::vector<std::pair<std::uint32_t, double>> entries_;
};

/// The matrix whose rows `fill(row, sum)` adds up. Each task makes a piece of it; then the pieces are put together.
template <class Fill>
SparseMatrix build_rows(std::size_t n_rows, std::size_t n_columns, Fill&& fill) {
  const std::size_t n_tasks = (n_rows + kRowsPerTask - 1) / kRowsPerTask;
  std::vector<SparseMatrix> pieces(n_tasks);
  tbb::enumerable_thread_specific<RowSum> sums([&] { return RowSum(n_columns); });
  parallel_for(
      n_tasks,
      [&](std::size_t task) {
        RowSum& sum = sums.local();
        const std::size_t end = std::min(n_rows, (task + 1) * kRowsPerTask);
        for (std::size_t row = task * kRowsPerTask; row != end; ++row) {
          fill(row, sum);
          sum.move_to(pieces[task]);
        }
      },
      1);
  std::vector<std::uint64_t> first(n_tasks + 1);
  for (std::size_t t = 0; t < n_tasks; ++t) first[t + 1] = first[t] + pieces[t].columns.size();
  SparseMatrix matrix;
  matrix.offsets.resize(n_rows + 1);
  matrix.columns.resize(first[n_tasks]);
  matrix.values.resize(first[n_tasks]);
  parallel_for(
      n_tasks,
      [&](std::size_t t) {
        const SparseMatrix& piece = pieces[t];
        std::copy(piece.columns.begin(), piece.columns.end(), matrix.columns.begin() + static_cast<long>(first[t]));
        std::copy(piece.values.begin(), piece.values.end(), matrix.values.begin() + static_cast<long>(first[t]));
        for (std::size_t row = 0; row < piece.size(); ++row)
          matrix.offsets[t * kRowsPerTask + row + 1] = first[t] + piece.offsets[row + 1];
      },
      1);
  return matrix;
}

}  // namespace

SparseMatrix transpose(const SparseMatrix& matrix, std::size_t n_columns) {
  struct Entry {
    std::uint32_t row;
    double value;
  };
  const std::size_t n_entries = matrix.columns.size();
  // Entries find a place in their column in any order, and are sorted by row there.
  const auto next = std::make_unique<std::atomic<std::uint64_t>[]>(n_columns);
  parallel_for(n_entries, [&](std::size_t e) { next[matrix.columns[e]].fetch_add(1, std::memory_order_relaxed); });
  SparseMatrix result;
  result.offsets.resize(n_columns + 1);
  for (std::size_t c = 0; c < n_columns; ++c) {
    result.offsets[c + 1] = result.offsets[c] + next[c].load(std::memory_order_relaxed);
    next[c].store(result.offsets[c], std::memory_order_relaxed);
  }
  const auto entries = std::make_unique_for_overwrite<Entry[]>(n_entries);
  parallel_for(matrix.size(), [&](std::size_t row) {
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      entries[next[matrix.columns[e]].fetch_add(1, std::memory_order_relaxed)] = {static_cast<std::uint32_t>(row),
                                                                                  matrix.values[e]};
  });
  result.columns.resize(n_entries);
  result.values.resize(n_entries);
  parallel_for(n_columns, [&](std::size_t c) {
    const std::uint64_t begin = result.offsets[c], end = result.offsets[c + 1];
    std::sort(entries.get() + begin, entries.get() + end, [](const Entry& a, const Entry& b) { return a.row < b.row; });
    for (std::uint64_t e = begin; e != end; ++e) {
      result.columns[e] = entries[e].row;
      result.values[e] = entries[e].value;
    }
  });
  return result;
}

SparseMatrix galerkin_product(const SparseMatrix& matrix, const SparseMatrix& prolongation,
                              std::span<const std::uint8_t> is_fixed, std::span<const std::uint8_t> is_coarse_fixed) {
  const std::size_t n_coarse = is_coarse_fixed.size();
  const SparseMatrix right = build_rows(matrix.size(), n_coarse, [&](std::size_t i, RowSum& sum) {
    if (is_fixed[i] != 0) return;
    for (std::uint64_t e = matrix.offsets[i]; e != matrix.offsets[i + 1]; ++e) {
      const std::uint32_t j = matrix.columns[e];
      if (is_fixed[j] != 0) continue;
      for (std::uint64_t f = prolongation.offsets[j]; f != prolongation.offsets[j + 1]; ++f)
        if (is_coarse_fixed[prolongation.columns[f]] == 0)
          sum.add(prolongation.columns[f], matrix.values[e] * prolongation.values[f]);
    }
  });
  const SparseMatrix left = transpose(prolongation, n_coarse);
  return build_rows(n_coarse, n_coarse, [&](std::size_t c, RowSum& sum) {
    sum.add(static_cast<std::uint32_t>(c), 0.0);
    if (is_coarse_fixed[c] != 0) return;
    for (std::uint64_t e = left.offsets[c]; e != left.offsets[c + 1]; ++e)
      for (std::uint64_t f = right.offsets[left.columns[e]]; f != right.offsets[left.columns[e] + 1]; ++f)
        sum.add(right.columns[f], left.values[e] * right.values[f]);
  });
}

}  // namespace voropack
