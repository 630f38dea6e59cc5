// Parallel loops. Results must not depend on how the range is cut: each index writes its own slot, or partial results
// are combined in a fixed order.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <vector>

namespace voropack {

/// Runs fn() with at most n_threads threads for every parallel loop inside; 0 means all of the machine.
template <class Fn>
void run_with_threads(int n_threads, Fn&& fn) {
  tbb::task_arena arena(n_threads > 0 ? n_threads : tbb::task_arena::automatic);
  arena.execute(std::forward<Fn>(fn));
}

/// fn(i) for i in [0, n), in parallel.
template <class Fn>
void parallel_for(std::size_t n, Fn&& fn, std::size_t grain = 1024) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    for (std::size_t i = r.begin(); i != r.end(); ++i) fn(i);
  });
}

/// Cuts [0, n) into blocks of `block` indices, calls fn(begin, end) -> T on each in parallel, and folds the results in
/// order: acc = combine(acc, T). The same result for any number of threads.
template <class T, class Fn, class Combine>
T parallel_reduce_ordered(std::size_t n, std::size_t block, T init, Fn&& fn, Combine&& combine) {
  const std::size_t n_blocks = (n + block - 1) / block;
  std::vector<T> partial(n_blocks, init);
  tbb::parallel_for(std::size_t{0}, n_blocks, [&](std::size_t b) {
    const std::size_t begin = b * block;
    partial[b] = fn(begin, begin + block < n ? begin + block : n);
  });
  T acc = init;
  for (const T& p : partial) acc = combine(acc, p);
  return acc;
}

}  // namespace voropack
