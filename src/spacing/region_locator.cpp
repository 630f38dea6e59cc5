#include "spacing/region_locator.h"

#include "geom/predicates.h"

namespace voropack {

namespace {

/// Orientation of (a, b, q') for q' = q + (e, e^2) with infinitely small e > 0: never 0 unless a == b, and
/// antisymmetric in a and b, so that a point below a shared edge is below exactly one of two triangles that pass there.
int perturbed_orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& q) {
  const int sign = orientation(a, b, q);
  if (sign != 0) return sign;
  if (a[1] != b[1]) return b[1] > a[1] ? -1 : 1;
  if (a[0] != b[0]) return b[0] > a[0] ? 1 : -1;
  return 0;
}

/// True iff the wall item lies above x (in the direction of the last axis).
bool is_above(const SmallSimplex<2>& wall, const Vec<2>& x) {
  const bool swap = wall.corner[1][0] < wall.corner[0][0];
  const Vec<2>& left = wall.corner[swap ? 1 : 0];
  const Vec<2>& right = wall.corner[swap ? 0 : 1];
  if (!(left[0] <= x[0] && x[0] < right[0])) return false;
  return orientation(left, right, x) < 0;
}

bool is_above(const SmallSimplex<3>& wall, const Vec<3>& x) {
  const auto flat = [](const Vec<3>& p) { return Vec<2>{p[0], p[1]}; };
  const Vec<2> a = flat(wall.corner[0]);
  const Vec<2> b = flat(wall.corner[1]);
  const Vec<2> c = flat(wall.corner[2]);
  const Vec<2> q = flat(x);
  const int side = perturbed_orientation(a, b, q);
  if (side == 0 || perturbed_orientation(b, c, q) != side || perturbed_orientation(c, a, q) != side) return false;
  return orientation(wall.corner[0], wall.corner[1], wall.corner[2], x) * side < 0;
}

}  // namespace

template <int D>
RegionLocator<D>::RegionLocator(const Domain<D>& domain, const PolytopeSet<D>& polytopes) : polytopes_(&polytopes) {
  std::vector<Box<D>> boxes;
  for (std::size_t w = 0; w < domain.n_walls(); ++w) {
    const std::uint32_t p = polytopes.of_wall(w);
    for (std::uint32_t i = polytopes.first_item(p); i < polytopes.first_item(p + 1); ++i) {
      items_.push_back(i);
      wall_regions_.push_back(domain.wall_regions[w]);
      boxes.push_back(polytopes.item(i).box());
    }
  }
  tree_ = BoxTree<D>(boxes);
}

template <int D>
bool RegionLocator<D>::in_region(const Vec<D>& x, RegionId region) const {
  // Far up every point is outside of everything.
  bool inside = region.is_none();
  const auto column_meets = [&](const Box<D>& box) {
    for (int k = 0; k < D - 1; ++k)
      if (x[k] < box.lo[k] || x[k] > box.hi[k]) return false;
    return box.hi[D - 1] >= x[D - 1];
  };
  tree_.for_each(column_meets, [&](std::uint32_t k) {
    if (bounds(k, region) && is_above(polytopes_->item(items_[k]), x)) inside = !inside;
  });
  return inside;
}

template <int D>
bool RegionLocator<D>::meets_walls(const Vec<D>& x, double r, RegionId region) const {
  bool found = false;
  tree_.for_each([&](const Box<D>& box) { return !found && box.distance_sq(x) <= r * r; },
                 [&](std::uint32_t k) {
                   if (!found && bounds(k, region)) found = polytopes_->item_distance(items_[k], x) <= r;
                 });
  return found;
}

template <int D>
bool RegionLocator<D>::meets_any_wall(const Vec<D>& x, double r) const {
  bool found = false;
  tree_.for_each([&](const Box<D>& box) { return !found && box.distance_sq(x) <= r * r; },
                 [&](std::uint32_t k) { found = found || polytopes_->item_distance(items_[k], x) <= r; });
  return found;
}

template <int D>
std::vector<std::uint32_t> RegionLocator<D>::wall_items(RegionId region) const {
  std::vector<std::uint32_t> result;
  for (std::uint32_t k = 0; k < items_.size(); ++k)
    if (bounds(k, region)) result.push_back(items_[k]);
  return result;
}

template class RegionLocator<2>;
template class RegionLocator<3>;

}  // namespace voropack
