// Parallel loops. Results must not depend on how the range is cut: each index writes its own slot, or partial results
// are combined in a fixed order.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/loop_edges.h"

namespace voropack {

/// Runs fn() with at most n_threads threads for every parallel loop inside; 0 means all of the machine. More than the
/// process may use (its processors, unless the program has set a tbb::global_control) would only make TBB complain on
/// standard error.
template <class Fn>
void run_with_threads(int n_threads, Fn&& fn) {
  const auto allowed =
      static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  tbb::task_arena arena(n_threads > 0 ? std::min(n_threads, allowed) : tbb::task_arena::automatic);
  LoopEdges edges;
  arena.execute([&] {
    [[maybe_unused]] const LoopEdges::Part part(edges);
    std::forward<Fn>(fn)();
  });
  edges.join();
}

/// Whether no other thread takes part in loops that are begun here. Then they can do without what keeps threads apart.
inline bool is_single_threaded() { return tbb::this_task_arena::max_concurrency() == 1; }

/// fn(i) for i in [0, n), in parallel.
template <class Fn>
void parallel_for(std::size_t n, Fn&& fn, std::size_t grain = 1024) {
  LoopEdges edges;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    [[maybe_unused]] const LoopEdges::Part part(edges);
    for (std::size_t i = r.begin(); i != r.end(); ++i) fn(i);
  });
  edges.join();
}

/// Calls both, in parallel. A thread that is done with one helps with the loops of the other.
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  parallel_for(
      2, [&](std::size_t task) { task == 0 ? first() : second(); }, 1);
}

/// Sorts by <. Equal elements must be alike.
template <class Iterator>
void parallel_sort(Iterator first, Iterator last) {
  if constexpr (kThreadSanitizer)
    std::sort(first, last);  // What TBB does inside is not ours to test.
  else
    tbb::parallel_sort(first, last);
}

/// Cuts [0, n) into blocks of `block` indices, calls fn(begin, end) -> T on each in parallel, and folds the results in
/// order: acc = combine(acc, T). The same result for any number of threads.
template <class T, class Fn, class Combine>
T parallel_reduce_ordered(std::size_t n, std::size_t block, T init, Fn&& fn, Combine&& combine) {
  const std::size_t n_blocks = (n + block - 1) / block;
  std::vector<T> partial(n_blocks, init);
  parallel_for(
      n_blocks,
      [&](std::size_t b) {
        const std::size_t begin = b * block;
        partial[b] = fn(begin, begin + block < n ? begin + block : n);
      },
      1);
  T acc = init;
  for (const T& p : partial) acc = combine(acc, p);
  return acc;
}

}  // namespace voropack
