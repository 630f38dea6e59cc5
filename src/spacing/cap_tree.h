// The least of many caps at a point: a quadtree (octree) that keeps in each cell the caps that can be least there.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "voropack/spacing.h"
#include "voropack/vec.h"

namespace voropack {

/// Cells are split where points are asked for. Safe to use from many threads; the answers
/// are exact, and do not depend on what was split.
template <int D>
class CapTree {
 public:
  /// Over `box`; nothing else may be asked for.
  CapTree(const Box<D>& box, std::span<const SpacingCap<D>> caps, double slope) : slope_(slope), root_(box) {
    root_.caps.reserve(caps.size());
    for (const SpacingCap<D>& cap : caps) root_.caps.push_back({cap.center, cap.radius, cap.value});
    root_.is_fine = caps.size() <= kFew;
  }

  [[nodiscard]] const Box<D>& box() const { return root_.box; }

  /// min(base, all caps) at x. `base_at` is a function with the same slope whose value at x is `base`.
  template <class BaseAt>
  [[nodiscard]] double minimum(const Vec<D>& x, double base, BaseAt&& base_at) const {
    const Cell* cell = &root_;
    for (int depth = 0; !cell->is_fine && depth < kMostDepth; ++depth) {
      const std::size_t k = child_of(*cell, x);
      const Cell* child = cell->children[k].load(std::memory_order_acquire);
      cell = child != nullptr ? child : add_child(*cell, k, base_at);
    }
    for (const Ball& cap : cell->caps) {
      const double within = (cap.radius + (base - cap.value) / slope_) * (1 + kRounding);
      if (cap.value < base && distance_sq(x, cap.center) <= within * within)
        base = std::min(base, cap.value + slope_ * std::max(0.0, distance(x, cap.center) - cap.radius));
    }
    return base;
  }

 private:
  static constexpr std::size_t kFew = 12;  ///< Caps that are looked at one after the other.
  static constexpr int kMostDepth = 20;
  /// Where f cannot change by more than this part in a cell, the caps in it differ by less, and no split tells which
  /// is least.
  static constexpr double kFlat = 0.25;
  struct Ball {
    Vec<D> center;
    double radius, value;
  };
  struct Cell {
    explicit Cell(const Box<D>& the_box) : box(the_box) {}
    ~Cell() {
      for (const auto& child : children) delete child.load(std::memory_order_relaxed);
    }
    Cell(const Cell&) = delete;
    Cell& operator=(const Cell&) = delete;
    Box<D> box;
    std::vector<Ball> caps;
    bool is_fine = false;  ///< To split it would leave few caps less to look at.
    mutable std::array<std::atomic<const Cell*>, 1U << static_cast<unsigned>(D)> children{};
  };

  static std::size_t child_of(const Cell& cell, const Vec<D>& x) {
    const Vec<D> middle = cell.box.center();
    std::size_t child = 0;
    for (std::size_t k = 0; k < D; ++k)
      if (x.coord[k] >= middle.coord[k]) child |= std::size_t{1} << k;
    return child;
  }

  template <class BaseAt>
  const Cell* add_child(const Cell& cell, std::size_t which, BaseAt&& base_at) const {
    auto child = std::make_unique<Cell>(cell.box);
    const Vec<D> middle = cell.box.center();
    for (std::size_t k = 0; k < D; ++k)
      ((which >> k & 1U) != 0 ? child->box.lo : child->box.hi).coord[k] = middle.coord[k];
    const Vec<D> center = child->box.center();
    const double reach = 0.5 * child->box.diagonal();
    // No cap matters that is nowhere in the child less than what another one, or the base, is everywhere in it. A cap
    // is at most `most` as far as radius + (most - value) / slope from its center; few need the root of the distance.
    double most = base_at(center) + slope_ * reach;
    for (const Ball& cap : cell.caps) {
      const double within = cap.radius - reach + (most - cap.value) / slope_;
      if (!(within > 0 && distance_sq(center, cap.center) < within * within)) continue;
      const double away = distance(center, cap.center) + reach - cap.radius;
      most = std::min(most, cap.value + slope_ * std::max(0.0, away));
    }
    most *= 1 + kRounding;
    for (const Ball& cap : cell.caps) {
      const double within = (cap.radius + (most - cap.value) / slope_) * (1 + kRounding);
      if (cap.value <= most && child->box.distance_sq(cap.center) <= within * within) child->caps.push_back(cap);
    }
    child->is_fine = child->caps.size() <= kFew || 2 * slope_ * reach <= kFlat * most;
    const Cell* expected = nullptr;
    if (cell.children[which].compare_exchange_strong(expected, child.get(), std::memory_order_acq_rel))
      return child.release();
    return expected;  // Another thread was faster.
  }

  static constexpr double kRounding = 1e-12;

  double slope_;
  Cell root_;
};

}  // namespace voropack
