// A balanced tree of boxes over points or balls: the certificate's only search structure. Robust against any grading,
// because it splits at medians and keeps no cell size.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "voropack/vec.h"

namespace voropack::judge {

/// Squared distance between two boxes, 0 if they meet.
template <int D>
double distance_sq(const Box<D>& a, const Box<D>& b) {
  double s = 0;
  for (int k = 0; k < D; ++k) {
    const double d = std::max({a.lo[k] - b.hi[k], 0.0, b.lo[k] - a.hi[k]});
    s += d * d;
  }
  return s;
}

/// A complete binary tree: node j of level l holds the items at positions [n j / 2^l, n (j+1) / 2^l) of `order`.
///
/// Each item has a box and a weight; each node the union of the boxes and the largest weight.
template <int D>
class BoxTree {
 public:
  BoxTree() = default;

  /// `box_of(i)` for item i in [0, n), `weight_of(i)` >= 0. Expected O(n log n).
  template <class BoxOf, class WeightOf>
  BoxTree(std::size_t n, const BoxOf& box_of, const WeightOf& weight_of) : n_(n) {
    std::vector<Item> items(n);
    parallel_for(n, [&](std::size_t i) { items[i] = {box_of(i).center(), static_cast<std::uint32_t>(i)}; });
    while ((n >> depth_) > kLeafSize) ++depth_;
    for (int level = 0; level < depth_; ++level)
      parallel_for(
          std::size_t{1} << level, [&](std::size_t j) { split(level, j, items); }, 1);
    order_.resize(n);
    parallel_for(n, [&](std::size_t i) { order_[i] = items[i].index; });
    summarize(box_of, weight_of);
  }

  [[nodiscard]] std::size_t size() const { return n_; }
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }
  [[nodiscard]] std::size_t n_leaves() const { return n_ == 0 ? 0 : std::size_t{1} << depth_; }
  [[nodiscard]] std::size_t leaf_begin(std::size_t leaf) const { return (n_ * leaf) >> depth_; }
  [[nodiscard]] const Box<D>& leaf_box(std::size_t leaf) const { return box_[n_leaves() - 1 + leaf]; }
  [[nodiscard]] double leaf_weight(std::size_t leaf) const { return weight_[n_leaves() - 1 + leaf]; }

  /// Depth first: enter(box, weight) says whether a node is of interest, leaf(begin, end) gets positions in `order`.
  /// Leaves before `first` are left out.
  template <class Enter, class Leaf>
  void visit(const Enter& enter, const Leaf& leaf, std::size_t first = 0) const {
    if (n_ == 0) return;
    struct Entry {
      std::size_t node;
      int level;
    };
    std::array<Entry, 64> stack;
    std::size_t top = 0;
    stack[top++] = {0, 0};
    while (top > 0) {
      const auto [node, level] = stack[--top];
      const std::size_t last_leaf = ((node + 2 - (std::size_t{1} << level)) << (depth_ - level)) - 1;
      if (last_leaf < first || !enter(box_[node], weight_[node])) continue;
      if (level == depth_) {
        leaf(leaf_begin(last_leaf), leaf_begin(last_leaf + 1));
      } else {
        stack[top++] = {2 * node + 2, level + 1};
        stack[top++] = {2 * node + 1, level + 1};
      }
    }
  }

 private:
  static constexpr std::size_t kLeafSize = 8;

  struct Item {
    Vec<D> center;
    std::uint32_t index = 0;
  };

  void split(int level, std::size_t j, std::vector<Item>& items) {
    const auto at = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto begin = at((n_ * j) >> level), end = at((n_ * (j + 1)) >> level);
    const auto middle = at((n_ * (2 * j + 1)) >> (level + 1));
    Box<D> box;
    for (auto item = begin; item != end; ++item) box.add(item->center);
    int axis = 0;
    for (int k = 1; k < D; ++k)
      if (box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis]) axis = k;
    std::nth_element(begin, middle, end, [&](const Item& a, const Item& b) { return a.center[axis] < b.center[axis]; });
  }

  template <class BoxOf, class WeightOf>
  void summarize(const BoxOf& box_of, const WeightOf& weight_of) {
    if (n_ == 0) return;
    const std::size_t first_leaf = n_leaves() - 1;
    box_.resize(2 * first_leaf + 1);
    weight_.assign(box_.size(), 0);
    parallel_for(first_leaf + 1, [&](std::size_t leaf) {
      const std::size_t node = first_leaf + leaf;
      for (std::size_t i = leaf_begin(leaf); i < leaf_begin(leaf + 1); ++i) {
        box_[node].add(box_of(order_[i]));
        weight_[node] = std::max(weight_[node], static_cast<double>(weight_of(order_[i])));
      }
    });
    for (std::size_t node = first_leaf; node-- > 0;) {
      box_[node] = box_[2 * node + 1];
      box_[node].add(box_[2 * node + 2]);
      weight_[node] = std::max(weight_[2 * node + 1], weight_[2 * node + 2]);
    }
  }

  std::size_t n_ = 0;
  int depth_ = 0;
  std::vector<std::uint32_t> order_;
  std::vector<Box<D>> box_;  ///< Heap order: children of k are 2k+1 and 2k+2.
  std::vector<double> weight_;
};

}  // namespace voropack::judge
