// A sparse uniform grid of lists: cells are grouped into dense blocks, and the blocks are found by a hash. A search
// over neighboring cells touches few blocks, so it costs about as much as in a dense array.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/random.h"
#include "voropack/vec.h"

namespace voropack {

template <int K>
class BlockGrid {
 public:
  static constexpr std::uint32_t kEnd = 0xffffffffU;
  using Index = std::array<std::int32_t, K>;

  /// Cells of the given side, counted from `origin`, which should be near the points so that 32-bit indices suffice.
  BlockGrid(const Vec<K>& origin, double side) : origin_(origin), side_(side), inverse_(1 / side) { rehash(64); }

  [[nodiscard]] double side() const { return side_; }
  [[nodiscard]] Index index(const Vec<K>& x) const {
    Index i;
    for (int k = 0; k < K; ++k) i[static_cast<std::size_t>(k)] = floor_of((x[k] - origin_[k]) * inverse_);
    return i;
  }

  /// The first item of the list of a cell, to be changed by the caller, who keeps the links.
  std::uint32_t& head(const Index& cell) {
    const Index block = block_of(cell);
    if (last_.block == kEnd || !equal(last_.key, block)) last_ = {block, find_or_add(block)};
    return heads_[std::size_t{last_.block} * kCellsPerBlock + offset_in_block(cell)];
  }

  /// Calls visit(head) for every non-empty cell that meets the box; stops when visit returns true, and returns whether
  /// it did.
  template <class Visit>
  bool visit(const Box<K>& box, Visit&& visit) const {
    const Index lo = index(box.lo), hi = index(box.hi);
    const Index block_lo = block_of(lo), block_hi = block_of(hi);
    return visit_blocks(lo, hi, block_lo, block_hi, block_lo, 0, visit);
  }

  /// The first item of the list of the cell that holds x, or kEnd.
  [[nodiscard]] std::uint32_t find(const Vec<K>& x) const {
    const Index cell = index(x);
    const std::size_t slot = find_slot(block_of(cell));
    if (slots_[slot].block == kEnd) return kEnd;
    return heads_[std::size_t{slots_[slot].block} * kCellsPerBlock + offset_in_block(cell)];
  }

 private:
  static constexpr int kBits = K == 3 ? 3 : (K == 2 ? 4 : 6);  ///< log2 of the cells along a block's side.
  static constexpr std::size_t kCellsPerBlock = std::size_t{1} << (kBits * K);
  struct Slot {
    Index key{};
    std::uint32_t block = kEnd;
  };

  /// Without the call of the library's floor that plain x86-64 would need.
  static std::int32_t floor_of(double t) {
    const auto i = static_cast<std::int32_t>(t);
    return i - (t < i ? 1 : 0);
  }
  static bool equal(const Index& a, const Index& b) {
    bool same = true;
    for (std::size_t k = 0; k < K; ++k) same = same && a[k] == b[k];
    return same;
  }
  std::uint32_t find_or_add(const Index& block) {
    std::size_t slot = find_slot(block);
    if (slots_[slot].block == kEnd) {
      if (2 * (n_blocks_ + 1) > slots_.size()) {
        rehash(2 * slots_.size());
        slot = find_slot(block);
      }
      slots_[slot] = {block, static_cast<std::uint32_t>(n_blocks_++)};
      heads_.resize(n_blocks_ * kCellsPerBlock, kEnd);
    }
    return slots_[slot].block;
  }
  static Index block_of(const Index& cell) {
    Index b;
    for (std::size_t k = 0; k < K; ++k) b[k] = cell[k] >> kBits;
    return b;
  }
  static std::size_t offset_in_block(const Index& cell) {
    std::size_t offset = 0;
    for (std::size_t k = 0; k < K; ++k)
      offset = (offset << kBits) | (static_cast<std::size_t>(cell[k]) & ((1U << kBits) - 1));
    return offset;
  }
  [[nodiscard]] std::size_t find_slot(const Index& block) const {
    std::uint64_t h = 0;
    for (std::size_t k = 0; k < K; ++k) h = h * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(block[k]);
    std::size_t slot = mix64(h) & (slots_.size() - 1);
    while (slots_[slot].block != kEnd && !equal(slots_[slot].key, block)) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }
  void rehash(std::size_t n) {
    std::vector<Slot> old(n);
    old.swap(slots_);
    for (const Slot& s : old)
      if (s.block != kEnd) slots_[find_slot(s.key)] = s;
  }

  template <class Visit>
  bool visit_blocks(const Index& lo, const Index& hi, const Index& block_lo, const Index& block_hi, Index block,
                    std::size_t axis, Visit& visit) const {
    if (axis < K) {
      for (std::int32_t b = block_lo[axis]; b <= block_hi[axis]; ++b) {
        block[axis] = b;
        if (visit_blocks(lo, hi, block_lo, block_hi, block, axis + 1, visit)) return true;
      }
      return false;
    }
    const std::size_t slot = find_slot(block);
    if (slots_[slot].block == kEnd) return false;
    const std::uint32_t* heads = heads_.data() + std::size_t{slots_[slot].block} * kCellsPerBlock;
    Index from, to;
    for (std::size_t k = 0; k < K; ++k) {
      const std::int32_t first = block[k] << kBits;
      from[k] = std::max(lo[k] - first, 0);
      to[k] = std::min(hi[k] - first, (1 << kBits) - 1);
    }
    return visit_cells(heads, from, to, 0, 0, visit);
  }
  template <class Visit>
  bool visit_cells(const std::uint32_t* heads, const Index& from, const Index& to, std::size_t offset, std::size_t axis,
                   Visit& visit) const {
    for (std::int32_t i = from[axis]; i <= to[axis]; ++i) {
      const std::size_t o = (offset << kBits) | static_cast<std::size_t>(i);
      if (axis + 1 < K) {
        if (visit_cells(heads, from, to, o, axis + 1, visit)) return true;
      } else if (heads[o] != kEnd && visit(heads[o])) {
        return true;
      }
    }
    return false;
  }

  Vec<K> origin_;
  double side_, inverse_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> heads_;
  std::size_t n_blocks_ = 0;
  Slot last_;  ///< The block that head() was last asked for: items mostly come in spatial order.
};

}  // namespace voropack
