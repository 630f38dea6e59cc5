// Which points lie in a region: parity of the walls above a point, by exact predicates.
#pragma once

#include <cstdint>
#include <vector>

#include "geom/box_tree.h"
#include "spacing/polytope_set.h"
#include "voropack/domain.h"

namespace voropack {

/// Points on a wall count as on one of its sides, consistently. Refers to `polytopes`, which must outlive it.
template <int D>
class RegionLocator {
 public:
  RegionLocator(const Domain<D>& domain, const PolytopeSet<D>& polytopes);

  [[nodiscard]] bool in_region(const Vec<D>& x, RegionId region) const;
  [[nodiscard]] bool in_domain(const Vec<D>& x) const { return in_region(x, RegionId::none()) == false; }
  /// The distance from x to the walls with `region` on exactly one side is less than r; `none()` stands for the
  /// outside.
  [[nodiscard]] bool meets_walls(const Vec<D>& x, double r, RegionId region) const;
  /// The same for all walls.
  [[nodiscard]] bool meets_any_wall(const Vec<D>& x, double r) const;
  /// The items of the walls with `region` on exactly one side.
  [[nodiscard]] std::vector<std::uint32_t> wall_items(RegionId region) const;

 private:
  [[nodiscard]] bool bounds(std::uint32_t k, RegionId region) const {
    return (wall_regions_[k][0] == region) != (wall_regions_[k][1] == region);
  }

  const PolytopeSet<D>* polytopes_;
  std::vector<std::uint32_t> items_;                   // [n_wall_items] item of `polytopes`.
  std::vector<std::array<RegionId, 2>> wall_regions_;  // [n_wall_items]
  BoxTree<D> tree_;                                    // Over wall items.
};

}  // namespace voropack
