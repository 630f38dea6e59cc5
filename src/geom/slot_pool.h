// Empty slots of a triangulation, to be taken one by one or handed out in shares.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace voropack {

class SlotPool {
 public:
  using Slot = std::uint32_t;

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Adds the slots begin .. end - 1.
  void give(Slot begin, Slot end) {
    if (begin == end) return;
    ranges_.push_back({begin, end});
    size_ += end - begin;
  }

  /// Adds all slots of another pool.
  void give(const SlotPool& other) {
    ranges_.insert(ranges_.end(), other.ranges_.begin(), other.ranges_.end());
    size_ += other.size_;
  }

  /// The first slot of the range given last; there must be one.
  Slot take() {
    Range& last = ranges_.back();
    const Slot slot = last.begin++;
    if (last.begin == last.end) ranges_.pop_back();
    --size_;
    return slot;
  }

  /// Moves n slots, or all if there are fewer, to a pool of their own.
  SlotPool split_off(std::size_t n) {
    SlotPool share;
    while (share.size() < n && size_ > 0) {
      Range& last = ranges_.back();
      const auto count = static_cast<Slot>(std::min<std::size_t>(n - share.size(), last.end - last.begin));
      share.give(last.begin, last.begin + count);
      last.begin += count;
      if (last.begin == last.end) ranges_.pop_back();
      size_ -= count;
    }
    return share;
  }

 private:
  struct Range {
    Slot begin, end;
  };
  std::vector<Range> ranges_;  ///< None is empty.
  std::size_t size_ = 0;
};

}  // namespace voropack
