// A partition of 0 .. n - 1 that grows coarser: union-find. Several threads may join sets at a time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace voropack {

/// Numbers 0 .. n - 1, each in a set of its own at first. A set is a tree in which parents are smaller than their
/// children; joining hangs the larger root below the smaller one. So the root of a set is its smallest member, in
/// whatever order and by whatever threads it was joined. [Anderson and Woll, Wait-free parallel algorithms for the
/// union-find problem, STOC 1991; the order of roots replaces their ranks.]
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }

  /// The smallest member of i's set, if no other thread joins meanwhile; else of a part of it. O(log n) amortized.
  std::uint32_t find(std::uint32_t i) {
    std::uint32_t parent = load(i);
    while (parent != i) {
      const std::uint32_t next = load(parent);
      // Any ancestor will do as parent: it does not matter who of several threads writes last.
      if (next != parent) std::atomic_ref(parent_[i]).store(next, std::memory_order_relaxed);
      i = parent;
      parent = next;
    }
    return i;
  }

  void join(std::uint32_t a, std::uint32_t b) {
    if (load(a) == load(b)) return;  // Mostly, once sets are large.
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t expected = a;
      if (std::atomic_ref(parent_[a]).compare_exchange_weak(expected, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::uint32_t load(std::uint32_t i) { return std::atomic_ref(parent_[i]).load(std::memory_order_relaxed); }

  std::vector<std::uint32_t> parent_;
};

}  // namespace voropack
