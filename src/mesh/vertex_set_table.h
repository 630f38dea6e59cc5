// Faces and edges as sorted sets of vertices, and a table that finds them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/random.h"
#include "voropack/index.h"

namespace voropack {

/// Sorts the vertices; true if the permutation was odd.
template <std::size_t K>
bool sort_vertices(std::array<VertexId, K>& v) {
  bool odd = false;
  const auto order = [&](std::size_t a, std::size_t b) {
    if (v[b] < v[a]) {
      std::swap(v[a], v[b]);
      odd = !odd;
    }
  };
  order(0, 1);
  if constexpr (K == 3) {
    order(1, 2);
    order(0, 1);
  }
  return odd;
}

/// Finds the index of a set of K vertices in a list, whatever the order in which its vertices are given. O(1) expected.
template <std::size_t K>
class VertexSetTable {
 public:
  using Key = std::array<VertexId, K>;
  static constexpr std::uint32_t kAbsent = ~std::uint32_t{0};

  explicit VertexSetTable(std::size_t capacity) {
    std::size_t n_slots = 16;
    while (n_slots < 2 * capacity) n_slots *= 2;
    slots_.assign(n_slots, Slot{});
  }

  /// Inserts under `index`; if the set is there already, returns its index and changes nothing, else kAbsent.
  std::uint32_t insert(Key key, std::uint32_t index) {
    sort_vertices(key);
    Slot& slot = slots_[find_slot(key)];
    if (slot.index != kAbsent) return slot.index;
    slot = {key, index};
    return kAbsent;
  }

  [[nodiscard]] std::uint32_t find(Key key) const {
    sort_vertices(key);
    return slots_[find_slot(key)].index;
  }

 private:
  struct Slot {
    Key key{};
    std::uint32_t index = kAbsent;
  };

  [[nodiscard]] std::size_t find_slot(const Key& key) const {
    std::uint64_t hash = 0;
    for (const VertexId v : key) hash = mix64(hash ^ v.value()) + 0x9e3779b97f4a7c15ULL;
    std::size_t i = hash & (slots_.size() - 1);
    while (slots_[i].index != kAbsent && slots_[i].key != key) i = (i + 1) & (slots_.size() - 1);
    return i;
  }

  std::vector<Slot> slots_;
};

}  // namespace voropack
