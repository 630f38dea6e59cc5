// Blocks of consecutive vertices that incomplete factorizations keep apart.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/parallel.h"

namespace voropack {

/// Vertices per block of an incomplete factorization. Larger blocks need fewer iterations, smaller ones keep more
/// threads busy.
inline constexpr std::size_t kBlockSize = 16384;

constexpr std::size_t block_of(std::size_t row) { return row / kBlockSize; }

/// Runs fn(begin, end) on every block, in parallel.
template <class Fn>
void for_each_block(std::size_t n, Fn&& fn) {
  const std::size_t n_blocks = (n + kBlockSize - 1) / kBlockSize;
  parallel_for(
      n_blocks, [&](std::size_t b) { fn(b * kBlockSize, std::min(n, (b + 1) * kBlockSize)); }, 1);
}

}  // namespace voropack
