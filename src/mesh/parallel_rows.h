// Rows of variable length, made in parallel: of anything, and of who is beside whom in a set of tuples.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/parallel.h"
#include "voropack/index.h"

namespace voropack {

/// Row i is what fill(i, row) appends to `row`. In parallel, in blocks of consecutive rows.
template <class I, class T, class Fill>
Csr<I, T> build_rows(std::size_t n_rows, Fill&& fill) {
  constexpr std::size_t kBlock = 4096;
  const std::size_t n_blocks = (n_rows + kBlock - 1) / kBlock;
  std::vector<std::vector<T>> parts(n_blocks);
  Csr<I, T> rows;
  rows.offsets.assign(n_rows + 1, 0);  // Of row i, its length at i + 1.
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        std::vector<T>& part = parts[block];
        for (std::size_t i = block * kBlock; i < std::min(n_rows, (block + 1) * kBlock); ++i) {
          const std::size_t before = part.size();
          fill(I(i), part);
          rows.offsets[i + 1] = part.size() - before;
        }
      },
      1);
  for (std::size_t i = 0; i < n_rows; ++i) rows.offsets[i + 1] += rows.offsets[i];
  rows.values.resize(rows.offsets[n_rows]);
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        std::copy(parts[block].begin(), parts[block].end(),
                  rows.values.begin() + static_cast<std::ptrdiff_t>(rows.offsets[block * kBlock]));
        std::vector<T>().swap(parts[block]);
      },
      1);
  return rows;
}

/// Row v lists, in ascending order, the values that share a tuple with v. tuple(t) is an array of values below
/// `n_values`, for t < n_tuples; visited are those with exists(t). In parallel; O(n) for rows of bounded length.
template <class V, class Tuple, class Exists>
Csr<V, V> adjacent_values(std::size_t n_values, std::size_t n_tuples, Tuple&& tuple, Exists&& exists) {
  // Tuples find a place in the rows of their values in any order: what is made of them is sorted.
  std::vector<std::uint32_t> count(n_values + 1, 0);
  parallel_for(n_tuples, [&](std::size_t t) {
    if (!exists(t)) return;
    for (const auto v : tuple(t)) std::atomic_ref(count[V(v).value()]).fetch_add(1, std::memory_order_relaxed);
  });
  std::vector<std::uint64_t> end(n_values + 1);
  for (std::size_t v = 0; v < n_values; ++v) end[v + 1] = end[v] + count[v];
  const auto around = std::make_unique_for_overwrite<std::uint32_t[]>(end[n_values]);
  parallel_for(n_tuples, [&](std::size_t t) {
    if (!exists(t)) return;
    for (const auto v : tuple(t)) {
      const std::uint32_t left = std::atomic_ref(count[V(v).value()]).fetch_sub(1, std::memory_order_relaxed);
      around[end[V(v).value() + std::size_t{1}] - left] = static_cast<std::uint32_t>(t);
    }
  });

  // The last value in whose row each one was put.
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> marks(
      [&] { return std::vector<std::uint32_t>(n_values, 0xffffffffU); });
  return build_rows<V, V>(n_values, [&](V v, std::vector<V>& row) {
    std::vector<std::uint32_t>& mark = marks.local();
    const auto begin = static_cast<std::ptrdiff_t>(row.size());
    mark[v.value()] = v.value();
    for (std::uint64_t k = end[v.value()]; k < end[v.value() + std::size_t{1}]; ++k)
      for (const auto other : tuple(around[k])) {
        const V w(other);
        if (mark[w.value()] == v.value()) continue;
        mark[w.value()] = v.value();
        row.push_back(w);
      }
    std::sort(row.begin() + begin, row.end());
  });
}

}  // namespace voropack
