// A binary tree of bounding boxes over any items, for nearest-first and least-value searches.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// Items are known by their number and box; each may carry a value from which its function grows (see `minimize`).
template <int D>
class BoxTree {
 public:
  struct Node {
    Box<D> box;
    double value = 0;         ///< The least value of an item below.
    std::uint32_t first = 0;  ///< A leaf's first slot in `order`, or the first of two children.
    std::uint32_t count = 0;  ///< Number of items in a leaf; 0 for an inner node.
  };

  BoxTree() = default;
  /// `values` is empty (all zero) or as long as `boxes`. O(n log n).
  explicit BoxTree(std::span<const Box<D>> boxes, std::span<const double> values = {}) {
    order_.resize(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
    if (boxes.empty()) return;
    nodes_.reserve(boxes.size());
    nodes_.emplace_back();
    build(0, 0, boxes.size(), boxes, values);
  }

  /// Of boxes that come along a space-filling curve, so that neighbors in `order` are neighbors in space, too: halves
  /// of it are as good as those that would have to be found. O(n).
  static BoxTree along_curve(std::vector<std::uint32_t> order, std::span<const Box<D>> boxes) {
    BoxTree tree;
    tree.order_ = std::move(order);
    if (tree.order_.empty()) return tree;
    tree.nodes_.reserve(tree.order_.size());
    tree.nodes_.emplace_back();
    tree.halve(0, 0, tree.order_.size(), boxes);
    return tree;
  }

  /// Other values for the same items. O(n).
  void set_values(std::span<const double> values) {
    // Children come after their parents.
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      Node& node = nodes_[i];
      if (node.count == 0) {
        node.value = std::min(nodes_[node.first].value, nodes_[node.first + 1].value);
        continue;
      }
      node.value = std::numeric_limits<double>::infinity();
      for (const std::uint32_t item : items(node)) node.value = std::min(node.value, values[item]);
    }
  }

  [[nodiscard]] bool empty() const { return nodes_.empty(); }
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] std::span<const std::uint32_t> items(const Node& node) const {
    return {&order_[node.first], node.count};
  }

  /// visit(item) for every item below nodes whose box passes `enter`.
  template <class Enter, class Visit>
  void for_each(Enter&& enter, Visit&& visit) const {
    for_each_below([&](const Node& node) { return enter(node.box); }, visit);
  }

  /// The same where entering depends on the node's value, too.
  template <class Enter, class Visit>
  void for_each_below(Enter&& enter, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kMaxDepth];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (!enter(node)) continue;
      if (node.count > 0) {
        for (std::uint32_t item : items(node)) visit(item);
      } else {
        stack[size++] = node.first + 1;
        stack[size++] = node.first;
      }
    }
  }

  /// True if accept(item) is, for an item below nodes whose box passes `enter`; none is looked at after that.
  template <class Enter, class Accept>
  bool find(Enter&& enter, Accept&& accept) const {
    if (nodes_.empty() || !enter(nodes_[0].box)) return false;
    std::uint32_t stack[kMaxDepth];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (node.count > 0) {
        for (std::uint32_t item : items(node))
          if (accept(item)) return true;
        continue;
      }
      for (const std::uint32_t child : {node.first + 1, node.first})
        if (enter(nodes_[child].box)) stack[size++] = child;
    }
    return false;
  }

  /// The least of `bound` and value_at(item) over all items, where value_at(item) is at least the item's value plus
  /// `slope` times the distance from x to its box.
  template <class ValueAt>
  double minimize(const Vec<D>& x, double slope, double bound, ValueAt&& value_at) const {
    if (nodes_.empty()) return bound;
    struct Entry {
      double lower;
      std::uint32_t node;
    };
    Entry stack[kMaxDepth];
    int size = 0;
    const auto lower = [&](std::uint32_t n) {
      return nodes_[n].value + slope * std::sqrt(nodes_[n].box.distance_sq(x));
    };
    const auto from_center = [&](std::uint32_t n) { return distance_sq(x, nodes_[n].box.center()); };
    stack[size++] = {lower(0), 0};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (!(entry.lower < bound)) continue;
      const Node& node = nodes_[entry.node];
      if (node.count > 0) {
        for (std::uint32_t item : items(node)) bound = std::min(bound, value_at(item));
        continue;
      }
      Entry a{lower(node.first), node.first};
      Entry b{lower(node.first + 1), node.first + 1};
      // The more promising child first; where x lies in both, the one whose middle is nearer.
      if (b.lower < a.lower || (b.lower == a.lower && from_center(b.node) < from_center(a.node))) std::swap(a, b);
      stack[size++] = b;
      stack[size++] = a;
    }
    return bound;
  }

 private:
  static constexpr std::size_t kLeafSize = 4;
  static constexpr int kMaxDepth = 128;  // At most 32 halvings and as many separations of large items, one entry each.

  void build(std::uint32_t at, std::size_t begin, std::size_t end, std::span<const Box<D>> boxes,
             std::span<const double> values) {
    Box<D> box;
    Box<D> centers;
    double value = std::numeric_limits<double>::infinity();
    for (std::size_t i = begin; i < end; ++i) {
      box.add(boxes[order_[i]]);
      centers.add(boxes[order_[i]].center());
      value = std::min(value, values.empty() ? 0.0 : values[order_[i]]);
    }
    nodes_[at].box = box;
    nodes_[at].value = value;
    if (end - begin <= kLeafSize) {
      nodes_[at].first = static_cast<std::uint32_t>(begin);
      nodes_[at].count = static_cast<std::uint32_t>(end - begin);
      return;
    }
    const std::size_t middle = split(begin, end, box, centers, boxes);
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[at].first = child;
    nodes_[at].count = 0;
    nodes_.emplace_back();
    nodes_.emplace_back();
    build(child, begin, middle, boxes, values);
    build(child + 1, middle, end, boxes, values);
  }

  void halve(std::uint32_t at, std::size_t begin, std::size_t end, std::span<const Box<D>> boxes) {
    Box<D> box;
    if (end - begin <= kLeafSize) {
      for (std::size_t i = begin; i < end; ++i) box.add(boxes[order_[i]]);
      nodes_[at] = {box, 0, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end - begin)};
      return;
    }
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    nodes_.emplace_back();
    halve(child, begin, (begin + end) / 2, boxes);
    halve(child + 1, (begin + end) / 2, end, boxes);
    box.add(nodes_[child].box);
    box.add(nodes_[child + 1].box);
    nodes_[at] = {box, 0, child, 0};
  }

  /// Orders [begin, end) and returns where its second half begins.
  std::size_t split(std::size_t begin, std::size_t end, const Box<D>& box, const Box<D>& centers,
                    std::span<const Box<D>> boxes) {
    const auto at_index = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    // Large items apart, or they would make the boxes of small ones large.
    const double large = 0.5 * box.diagonal();
    const auto is_large = [&](std::uint32_t i) { return boxes[i].diagonal() > large; };
    const auto small = std::stable_partition(at_index(begin), at_index(end), is_large);
    if (small != at_index(begin) && small != at_index(end)) return static_cast<std::size_t>(small - order_.begin());
    int axis = 0;
    for (int k = 1; k < D; ++k)
      if (centers.hi[k] - centers.lo[k] > centers.hi[axis] - centers.lo[axis]) axis = k;
    const std::size_t middle = (begin + end) / 2;
    std::nth_element(at_index(begin), at_index(middle), at_index(end), [&](std::uint32_t i, std::uint32_t j) {
      // Ties, which regular input has many of, are broken by the other axes, or boxes would overlap.
      for (int k = 0; k < D; ++k) {
        const int along = (axis + k) % D;
        const double ci = boxes[i].lo[along] + boxes[i].hi[along];
        const double cj = boxes[j].lo[along] + boxes[j].hi[along];
        if (ci != cj) return ci < cj;
      }
      return i < j;
    });
    return middle;
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace voropack
