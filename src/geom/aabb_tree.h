// A tree of axis-aligned boxes: finds those that may meet something, in O(log n + answers) for spread-out boxes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// Built once over n boxes, then immutable. Items are named by their index. The order of visits depends on the boxes
/// only.
template <int D>
class AabbTree {
 public:
  AabbTree() = default;
  explicit AabbTree(std::vector<Box<D>> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  }

  [[nodiscard]] std::size_t size() const { return boxes_.size(); }

  /// Calls fn(item) for each item whose box satisfies `meets`, where meets(box) must hold for a box that contains
  /// another for which it holds.
  template <class Meets, class Fn>
  void visit(Meets&& meets, Fn&& fn) const {
    if (nodes_.empty()) return;
    std::vector<std::uint32_t> stack = {0};
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!meets(node.box)) continue;
      if (node.right == 0) {
        for (std::uint32_t i = node.begin; i < node.end; ++i)
          if (meets(boxes_[order_[i]])) fn(order_[i]);
        continue;
      }
      stack.push_back(node.right);
      stack.push_back(static_cast<std::uint32_t>(&node - nodes_.data()) + 1);
    }
  }

  /// Calls fn(item) for each item whose box overlaps `box`.
  template <class Fn>
  void visit_overlaps(const Box<D>& box, Fn&& fn) const {
    visit([&](const Box<D>& b) { return b.overlaps(box); }, fn);
  }

 private:
  static constexpr std::uint32_t kLeafSize = 4;

  /// Children: the next node in the array, and `right`. A leaf has right == 0 and holds order_[begin, end).
  struct Node {
    Box<D> box;
    std::uint32_t begin = 0, end = 0, right = 0;
  };

  void build(std::uint32_t begin, std::uint32_t end) {
    const auto self = nodes_.size();
    nodes_.push_back({});
    Box<D> box, centers;
    for (std::uint32_t i = begin; i < end; ++i) {
      box.add(boxes_[order_[i]]);
      centers.add(boxes_[order_[i]].center());
    }
    nodes_[self].box = box;
    nodes_[self].begin = begin;
    nodes_[self].end = end;
    if (end - begin <= kLeafSize) return;
    int axis = 0;
    for (int k = 1; k < D; ++k)
      if (centers.hi[k] - centers.lo[k] > centers.hi[axis] - centers.lo[axis]) axis = k;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       return std::pair(boxes_[a].center()[axis], a) < std::pair(boxes_[b].center()[axis], b);
                     });
    build(begin, middle);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
  }

  std::vector<Box<D>> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace voropack
