// A tree of axis-aligned boxes: finds those that may meet something, in O(log n + answers) for spread-out boxes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "geom/box_tree.h"
#include "voropack/vec.h"

namespace voropack {

/// Built once over n boxes, then immutable. Items are named by their index. The order of visits depends on the boxes
/// only.
template <int D>
class AabbTree {
 public:
  AabbTree() = default;
  explicit AabbTree(std::vector<Box<D>> boxes) : boxes_(std::move(boxes)), tree_(boxes_) {}

  [[nodiscard]] std::size_t size() const { return boxes_.size(); }

  /// Calls fn(item) for each item whose box satisfies `meets`, where meets(box) must hold for a box that contains
  /// another for which it holds.
  template <class Meets, class Fn>
  void visit(Meets&& meets, Fn&& fn) const {
    tree_.for_each(meets, [&](std::uint32_t item) {
      if (meets(boxes_[item])) fn(item);
    });
  }

  /// Calls fn(item) for each item whose box overlaps `box`.
  template <class Fn>
  void visit_overlaps(const Box<D>& box, Fn&& fn) const {
    visit([&](const Box<D>& b) { return b.overlaps(box); }, fn);
  }

 private:
  std::vector<Box<D>> boxes_;
  BoxTree<D> tree_;
};

}  // namespace voropack
