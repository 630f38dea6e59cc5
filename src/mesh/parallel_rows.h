// Rows of variable length, made in parallel: of anything, and of who is beside whom in a set of tuples.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "voropack/index.h"

namespace voropack {

/// Row i is what fill(i, row) appends to `row`. In parallel, in blocks of rows that are consecutive in `order`, or of
/// consecutive rows if it is empty: rows that look at the same things should be made one after the other.
template <class I, class T, class Fill>
Csr<I, T> build_rows(std::size_t n_rows, Fill&& fill, std::span<const std::uint32_t> order = {}) {
  constexpr std::size_t kBlock = 4096;
  const std::size_t n_blocks = (n_rows + kBlock - 1) / kBlock;
  const auto for_blocks = [&](auto&& fn) {
    parallel_for(
        n_blocks,
        [&](std::size_t block) {
          const std::size_t begin = block * kBlock, end = std::min(n_rows, begin + kBlock);
          for (std::size_t i = begin; i < end; ++i) fn(block, order.empty() ? i : order[i]);
        },
        1);
  };
  std::vector<std::vector<T>> parts(n_blocks);
  Csr<I, T> rows;
  rows.offsets.assign(n_rows + 1, 0);  // Of row i, its length at i + 1.
  for_blocks([&](std::size_t block, std::size_t i) {
    const std::size_t before = parts[block].size();
    fill(I(i), parts[block]);
    rows.offsets[i + 1] = parts[block].size() - before;
  });
  for (std::size_t i = 0; i < n_rows; ++i) rows.offsets[i + 1] += rows.offsets[i];
  rows.values.resize(rows.offsets[n_rows]);
  std::vector<std::size_t> next(n_blocks, 0);
  for_blocks([&](std::size_t block, std::size_t i) {
    const std::span<T> row = rows[I(i)];
    const auto from = parts[block].begin() + static_cast<std::ptrdiff_t>(next[block]);
    std::copy(from, from + std::ssize(row), row.begin());
    next[block] += row.size();
    if (next[block] == parts[block].size()) std::vector<T>().swap(parts[block]);
  });
  return rows;
}

/// Sorts distinct numbers. In a short row each one counts those below it, without branches.
template <class V>
void sort_row(std::span<V> row) {
  constexpr std::size_t kLongest = 32, kStep = 4;
  if (row.size() > kLongest) {
    std::sort(row.begin(), row.end());
    return;
  }
  std::array<std::int32_t, kLongest> keys;  // In the order of the unsigned numbers.
  const std::size_t n_steps = (row.size() + kStep - 1) / kStep;
  for (std::size_t i = 0; i < n_steps * kStep; ++i)
    keys[i] = i < row.size() ? static_cast<std::int32_t>(row[i].value() ^ 0x80000000U) : 0x7fffffff;
  for (std::size_t i = 0; i < row.size(); ++i) {
    std::array<std::int32_t, kStep> below{};
    for (std::size_t step = 0; step < n_steps; ++step)
      for (std::size_t k = 0; k < kStep; ++k) below[k] += keys[step * kStep + k] < keys[i] ? 1 : 0;
    row[static_cast<std::size_t>(below[0] + below[1] + below[2] + below[3])] =
        V(static_cast<std::uint32_t>(keys[i]) ^ 0x80000000U);
  }
}

/// Row v lists, in ascending order, the values that share a triangle with v, of triangles that are neighbors where they
/// have an edge in common. corners(t) is an array of values below `n_values`; neighbors(t) has the triangle across from
/// each, or any number from `n_triangles` on; visited are those with exists(t). In parallel; O(n).
template <class V, class Corners, class Neighbors, class Exists>
Csr<V, V> adjacent_in_plane(std::size_t n_values, std::size_t n_triangles, Corners&& corners, Neighbors&& neighbors,
                            Exists&& exists) {
  // An atomic addition takes as long as dozens of other instructions.
  const bool is_alone = is_single_threaded();
  const auto count = [&](std::uint64_t& n) {
    return is_alone ? n++ : std::atomic_ref(n).fetch_add(1, std::memory_order_relaxed);
  };
  // Each edge once: from the triangle before its neighbor, or without one.
  const auto for_each_edge = [&](auto&& fn) {
    parallel_for(n_triangles, [&](std::size_t t) {
      if (!exists(t)) return;
      const auto values = corners(t);
      const auto beyond = neighbors(t);
      for (std::size_t i = 0; i < 3; ++i)
        if (std::size_t{beyond[i]} > t || !exists(beyond[i])) fn(V(values[(i + 1) % 3]), V(values[(i + 2) % 3]));
    });
  };
  // Where row v begins stands at v + 1 until the row is filled, which moves it to the end.
  Csr<V, V> rows;
  rows.offsets.assign(n_values + 2, 0);
  for_each_edge([&](V a, V b) {
    count(rows.offsets[a.value() + 2]);
    count(rows.offsets[b.value() + 2]);
  });
  for (std::size_t v = 2; v < rows.offsets.size(); ++v) rows.offsets[v] += rows.offsets[v - 1];
  rows.values.resize(rows.offsets.back());
  for_each_edge([&](V a, V b) {
    rows.values[count(rows.offsets[a.value() + 1])] = b;
    rows.values[count(rows.offsets[b.value() + 1])] = a;
  });
  rows.offsets.pop_back();
  parallel_for(n_values, [&](std::size_t v) { sort_row(rows[V(v)]); });
  return rows;
}

/// Row v lists, in ascending order, the values that share a tuple with v. tuple(t) is an array of values below
/// `n_values`, for t < n_tuples; visited are those with exists(t). In parallel; O(n) for rows of bounded length.
/// `order` as above.
template <class V, class Tuple, class Exists>
Csr<V, V> adjacent_values(std::size_t n_values, std::size_t n_tuples, Tuple&& tuple, Exists&& exists,
                          std::span<const std::uint32_t> order = {}) {
  // Each value has a chain of tuples, in any order: what is made of them is sorted. Where it is in a tuple, the chain
  // goes on.
  using Values = std::decay_t<decltype(tuple(std::size_t{0}))>;
  constexpr std::size_t kSize = std::tuple_size_v<Values>;
  constexpr std::uint32_t kEnd = 0xffffffffU;
  std::vector<std::uint32_t> first(n_values, kEnd);
  const auto next = std::make_unique_for_overwrite<std::array<std::uint32_t, kSize>[]>(n_tuples);
  // An atomic exchange takes as long as dozens of other instructions.
  const bool is_alone = is_single_threaded();
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
  return build_rows<V, V>(
      n_values,
      [&](V v, std::vector<V>& row) {
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
        sort_row(std::span(row).subspan(static_cast<std::size_t>(begin)));
      },
      order);
}

}  // namespace voropack
