// Evaluation; the construction is in spacing_tree_builder.cpp.
#include "spacing/spacing_tree.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace voropack {

namespace {

/// Relative slack of bounds that rounding may have made a little too small.
constexpr double kBoundSlack = 1e-12;

}  // namespace

template <int D>
std::array<std::uint32_t, D> SpacingTree<D>::cell_of(const Vec<D>& x) const {
  std::array<std::uint32_t, D> cell;
  for (int k = 0; k < D; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    // Through a signed integer, which processors convert to fast.
    const auto c = static_cast<std::int32_t>((x[k] - box_.lo[k]) * scale_);
    cell[axis] = std::min(static_cast<std::uint32_t>(std::max(c, 0)), last_cell_[axis]);
  }
  return cell;
}

template <int D>
auto SpacingTree<D>::find_leaf(const Vec<D>& x) const -> const Leaf& {
  const auto cell = cell_of(x);
  std::uint32_t node = nodes_[0];
  for (int level = kLevels - 1; (node & kLeafBit) == 0; --level) {
    std::uint32_t child = 0;
    for (std::size_t k = 0; k < D; ++k) child |= (cell[k] >> level & 1U) << k;
    node = nodes_[node + child];
  }
  return leaves_[node & ~kLeafBit];
}

template <int D>
double SpacingTree<D>::near_distance(const Near& near, const Vec<D>& x) const {
  if (near.n_items == 0) return std::abs(dot(x - planes_[near.first][0], planes_[near.first][1]));
  double best = sources_->polytopes.item_distance(near_items_[near.first], x);
  for (std::uint32_t i = 1; i < near.n_items; ++i)
    best = std::min(best, sources_->polytopes.item_distance(near_items_[near.first + i], x));
  return best;
}

template <int D>
double SpacingTree<D>::pairs_minimum(const Leaf& leaf, const Vec<D>& x, double from_center, double best) const {
  const double slope = sources_->weights.slope;
  const double slack = slope * from_center * (1 + kBoundSlack);
  std::array<double, 256> distance;
  std::array<std::uint64_t, 4> known{};
  const auto distance_to = [&](std::uint8_t p) {
    std::uint64_t& word = known[p >> 6U];
    const std::uint64_t bit = std::uint64_t{1} << (p & 63U);
    if ((word & bit) == 0) {
      word |= bit;
      distance[p] = near_distance(nears_[leaf.first_near + p], x);
    }
    return distance[p];
  };
  const Pair* pair = &pairs_[leaf.first_pair];
  for (const Pair* end = pair + leaf.n_pairs; pair != end; ++pair) {
    // Sorted by their value at the center, from which they differ by at most slope * |x - center|.
    if (!(static_cast<double>(pair->at_center) - slack < best)) break;
    const double first = slope * distance_to(pair->p) + pair->offset;
    if (!(first < best)) continue;
    best = std::min(best, std::max(first, slope * distance_to(pair->q) + pair->offset));
  }
  return best;
}

template <int D>
double SpacingTree<D>::atoms_minimum(const Leaf& leaf, const Vec<D>& x, double from_center, double best) const {
  const SizeAtoms<D>& sizes = sources_->sizes;
  const double slack = sizes.slope() * from_center * (1 + kBoundSlack);
  const std::span<const Atom> atoms(&atoms_[leaf.first_atom], leaf.n_atoms);
  const auto matters = [&](const Atom& a) { return static_cast<double>(a.at_center) - slack < best; };
  bool is_found = false, has_local = false;
  for (const Atom& a : atoms) {
    if (!matters(a)) break;
    if (!sizes.is_local(a.index)) {
      best = std::min(best, sizes.at(a.index, x));
    } else if (!is_found) {
      has_local = true;
      const std::optional<double> value = sizes.inside(a.index, x);
      is_found = value.has_value();
      if (is_found) best = std::min(best, *value);
    }
  }
  if (is_found || !has_local) return best;
  // Outside of the field, it goes on as the Lipschitz condition allows.
  for (const Atom& a : atoms) {
    if (!matters(a)) break;
    if (sizes.is_local(a.index) && sizes.bounds(a.index, x).lo < best) best = std::min(best, sizes.at(a.index, x));
  }
  return best;
}

template <int D>
double SpacingTree<D>::operator()(const Vec<D>& x) const {
  const Leaf& leaf = find_leaf(x);
  double best = leaf.constant;
  if (leaf.is_constant()) return best;
  const double from_center = distance(x, leaf.center);
  if (leaf.asks_fields) best = sources_->sizes.fields_minimum(x, best);
  if (leaf.n_atoms > 0) best = atoms_minimum(leaf, x, from_center, best);
  for (std::uint32_t i = 0; i < leaf.n_regions; ++i) {
    const RegionValue& r = regions_[leaf.first_region + i];
    if (r.value < best && sources_->locator.in_region(x, r.region)) best = r.value;
  }
  if (leaf.n_pairs > 0) best = pairs_minimum(leaf, x, from_center, best);
  if (!leaf.search_pairs && !leaf.search_atoms) return best;
  // The value at the center bounds the search from the beginning.
  best = std::min(best, (leaf.value + sources_->sizes.slope() * from_center) * (1 + kBoundSlack));
  if (leaf.search_atoms) best = sources_->sizes.minimum(x, best);
  if (leaf.search_pairs) best = sources_->pairs(x, best).value;
  return best;
}

template <int D>
std::optional<double> SpacingTree<D>::constant_on(const Box<D>& box) const {
  if (!box_.contains(box.lo) || !box_.contains(box.hi)) return std::nullopt;
  const auto lo = cell_of(box.lo);
  const auto hi = cell_of(box.hi);
  struct Entry {
    std::uint32_t node;
    int level;
    std::array<std::uint32_t, D> cell;  // In cells of this level.
  };
  std::array<Entry, kLevels*((1U << D) - 1) + 1> stack;
  std::size_t size = 0;
  stack[size++] = {nodes_[0], 0, {}};
  // Where nothing but fields decides, they are asked for the box as a whole.
  std::optional<std::optional<double>> known;
  const auto of_fields = [&] {
    if (!known) known = sources_->sizes.fields_constant(box);
    return *known;
  };
  std::optional<double> constant;
  while (size > 0) {
    const Entry entry = stack[--size];
    if ((entry.node & kLeafBit) != 0) {
      const Leaf& leaf = leaves_[entry.node & ~kLeafBit];
      const std::optional<double> here = leaf.is_constant()    ? std::optional(leaf.constant)
                                         : leaf.has_no_lists() ? of_fields()
                                                               : std::nullopt;
      if (!here || (constant && *constant != *here)) return std::nullopt;
      constant = here;
      continue;
    }
    const int shift = kLevels - entry.level - 1;
    for (std::uint32_t child = 0; child < (1U << D); ++child) {
      Entry next{nodes_[entry.node + child], entry.level + 1, {}};
      bool overlaps = true;
      for (std::size_t k = 0; k < D; ++k) {
        next.cell[k] = 2 * entry.cell[k] + (child >> k & 1U);
        overlaps = overlaps && next.cell[k] >= lo[k] >> shift && next.cell[k] <= hi[k] >> shift;
      }
      if (overlaps) stack[size++] = next;
    }
  }
  return constant;
}

template <int D>
auto SpacingTree<D>::statistics() const -> Statistics {
  Statistics s;
  s.n_leaves = leaves_.size();
  for (const Leaf& leaf : leaves_) {
    s.n_constant += leaf.is_constant() ? 1 : 0;
    s.n_searching += leaf.search_pairs || leaf.search_atoms ? 1 : 0;
  }
  s.n_pairs = pairs_.size();
  s.n_near = nears_.size();
  s.n_atoms = atoms_.size();
  s.n_bytes = nodes_.size() * sizeof(nodes_[0]) + leaves_.size() * sizeof(Leaf) + pairs_.size() * sizeof(Pair) +
              nears_.size() * sizeof(Near) + near_items_.size() * 4 + atoms_.size() * sizeof(Atom);
  return s;
}

template class SpacingTree<2>;
template class SpacingTree<3>;

}  // namespace voropack
