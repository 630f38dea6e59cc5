// Values of a function that is expensive and asked for at the same places again and again.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/random.h"
#include "voropack/vec.h"

namespace voropack {

/// Remembers positive values by the exact position, up to some million; then new ones replace old ones. Safe to use
/// from many threads.
template <int D>
class ValueMemory {
 public:
  /// The remembered value at x, or else compute(), which is remembered.
  template <class Compute>
  double get(const Vec<D>& x, Compute&& compute) {
    const std::uint64_t key = hash_of(x), hash = key / kShards;
    Shard& shard = shards_[key % kShards];
    {
      const std::lock_guard lock(shard.mutex);
      if (!shard.slots.empty())
        if (const Slot& slot = shard.find(x, hash); slot.value > 0 && slot.x == x) return slot.value;
    }
    const double value = compute();
    const std::lock_guard lock(shard.mutex);
    shard.put({x, value}, hash);
    return value;
  }

 private:
  static constexpr std::size_t kShards = 64, kFirstSlots = 64, kMostSlots = 1U << 15U, kProbes = 4;
  struct Slot {
    Vec<D> x;
    double value = 0;  ///< 0 if nothing is here.
  };
  struct alignas(64) Shard {
    std::mutex mutex;
    std::vector<Slot> slots;
    std::size_t n_used = 0;

    /// The slot of x, or where it would go.
    Slot& find(const Vec<D>& x, std::uint64_t hash) {
      const std::size_t mask = slots.size() - 1;
      for (std::size_t i = 0; i < kProbes; ++i)
        if (Slot& slot = slots[(hash + i) & mask]; slot.value == 0 || slot.x == x) return slot;
      return slots[hash & mask];
    }
    void put(const Slot& entry, std::uint64_t hash) {
      if (slots.size() < kMostSlots && 2 * n_used >= slots.size()) grow();
      Slot& slot = find(entry.x, hash);
      if (slot.value == 0) ++n_used;
      slot = entry;
    }
    void grow() {
      std::vector<Slot> old(slots.empty() ? kFirstSlots : 2 * slots.size());
      old.swap(slots);
      n_used = 0;
      for (const Slot& slot : old)
        if (slot.value > 0) {
          Slot& place = find(slot.x, ValueMemory::hash_of(slot.x) / kShards);
          if (place.value == 0) ++n_used;
          place = slot;
        }
    }
  };
  static std::uint64_t hash_of(const Vec<D>& x) {
    std::uint64_t hash = 0;
    for (int k = 0; k < D; ++k) hash = mix64(hash ^ std::bit_cast<std::uint64_t>(x[k]));
    return hash;
  }

  std::array<Shard, kShards> shards_;
};

}  // namespace voropack
