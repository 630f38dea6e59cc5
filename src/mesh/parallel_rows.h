// Rows of variable length, made in parallel: of anything, and of who is beside whom in a set of tuples.
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
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
  // Each value has a chain of tuples, in any order: what is made of them is sorted. Where it is in a tuple, the chain
  // goes on.
  using Values = std::decay_t<decltype(tuple(std::size_t{0}))>;
  constexpr std::size_t kSize = std::tuple_size_v<Values>;
  constexpr std::uint32_t kEnd = 0xffffffffU;
  std::vector<std::uint32_t> first(n_values, kEnd);
  const auto next = std::make_unique_for_overwrite<std::array<std::uint32_t, kSize>[]>(n_tuples);
  // An atomic exchange takes as long as dozens of other instructions.
  const bool is_alone = tbb::this_task_arena::max_concurrency() == 1;
  parallel_for(n_tuples, [&](std::size_t number) {
    if (!exists(number)) return;
    const auto t = static_cast<std::uint32_t>(number);
    const Values& values = tuple(number);
    for (std::size_t i = 0; i < kSize; ++i) {
      std::uint32_t& head = first[V(values[i]).value()];
      next[t][i] = is_alone ? std::exchange(head, t) : std::atomic_ref(head).exchange(t, std::memory_order_relaxed);
    }
  });

  // The last value in whose row each one was put.
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> marks(
      [&] { return std::vector<std::uint32_t>(n_values, 0xffffffffU); });
  return build_rows<V, V>(n_values, [&](V v, std::vector<V>& row) {
    std::vector<std::uint32_t>& mark = marks.local();
    const auto begin = static_cast<std::ptrdiff_t>(row.size());
    for (std::uint32_t t = first[v.value()]; t != kEnd;) {
      const Values& values = tuple(t);
      std::uint32_t after = kEnd;
      for (std::size_t i = 0; i < kSize; ++i) {
        const V w(values[i]);
        if (w == v)
          after = next[t][i];
        else if (std::exchange(mark[w.value()], v.value()) != v.value())
          row.push_back(w);
      }
      t = after;
    }
    std::sort(row.begin() + begin, row.end());
  });
}

}  // namespace voropack
