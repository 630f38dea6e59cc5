// Construction of the spacing's tree, level by level.
//
// A source phi with Lipschitz constant L can be smallest somewhere in a cell with center m and half diagonal h only if
// phi(m) - L h <= min over sources psi of (psi(m) + L' h). Lists are filtered by this from cell to child. Pairs are not
// formed at the root: a cell first keeps the items of polytopes that can take part in such a pair, and forms pairs when
// few polytopes are left.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>

#include "base/parallel.h"
#include "geom/tolerance.h"
#include "spacing/facet_outlines.h"
#include "spacing/spacing_tree.h"

namespace voropack {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Chosen by measuring build time, memory and evaluation time on the domains of bench/micro/spacing.
/// A cell with at most this many polytopes forms pairs, and its children inherit them.
constexpr std::size_t kMaxPolytopes = 160;
/// The same where searching is cheap. Both fit in SpacingTree::Pair::p.
constexpr std::size_t kFewPolytopes = 64;
/// The bound of f at a cell's center rests on at most this many polytopes, the nearest ones. Where the search needs no
/// more, as it does far from a surface of many small facets, searching costs less than long lists.
constexpr std::size_t kMaxMet = 24;
/// Such a cell is not split when f varies by less than this part of its value from the center.
constexpr double kSearchVariation = 0.5;
/// A cell with no more sources than this is not split for their number.
constexpr std::size_t kFewSources = 32;
/// Lists of size atoms longer than this are searched by tree.
constexpr std::size_t kMaxAtoms = 512;
/// A cell with too many sources is split while its side exceeds this multiple of f.
constexpr double kSmallestSide = 1.0;
/// A cell where a constant is smallest in one part and something else in another, or where a field varies, is split
/// down to this multiple of f, so that the part where f is constant becomes known to `constant_on`.
constexpr double kMixedSide = 8.0;
/// No more cells than this, plus a few for each item and two for each size atom.
constexpr std::size_t kBaseCells = 10'000;
constexpr std::size_t kCellsPerItem = 4;
constexpr std::size_t kMostCells = 150'000;

/// Outlines exist in 3D only.
template <int D>
struct NoOutlines {
  NoOutlines(const Domain<D>&, const PolytopeSet<D>&) {}
};

}  // namespace

template <int D>
struct SpacingTree<D>::Builder {
  struct WorkPair {
    std::uint32_t p, q;  // Polytopes.
    double offset;
    double at_center;
  };
  struct WorkAtom {
    std::uint32_t index;
    double at_center;  // A lower bound.
  };
  /// What can matter in a cell: a superset of what can be smallest there.
  struct Lists {
    std::vector<std::uint32_t> items;  // Ascending, so that those of one polytope are consecutive.
    std::vector<WorkPair> pairs;       // Complete if is_paired.
    std::vector<WorkAtom> atoms;
    std::vector<RegionValue> regions;  // Whose walls may pass through the cell.
    double constant = kInfinity;
    bool is_paired = false;
    bool asks_fields = false;
  };
  struct Cell {
    std::uint32_t node = 0;  // Slot in nodes_.
    std::array<std::uint32_t, D> coordinate{};
    std::shared_ptr<const Lists> parent;
    // Found by `examine`:
    std::shared_ptr<Lists> lists;
    Box<D> box;
    double value = 0;  // An upper bound of f at the center.
    double limit = 0;  // An upper bound of f in the cell.
    bool search_is_cheap = false;
    bool is_split = false;
    std::vector<char> is_plane;  // [number of polytopes in `lists->items`]
  };
  using Outlines = std::conditional_t<D == 3, FacetOutlines, NoOutlines<D>>;

  Builder(const Domain<D>& domain, const SpacingSources<D>& spacing_sources, SpacingTree& target)
      : sources(spacing_sources), polytopes(spacing_sources.polytopes), tree(target), outlines(domain, polytopes) {
    for (int k = 0; k < D; ++k) root_side = std::max(root_side, tree.box_.hi[k] - tree.box_.lo[k]);
    tolerance = absolute_tolerance(tree.box_, kCellTolerance);
    tree.scale_ = (1U << kLevels) / root_side;
    for (int k = 0; k < D; ++k) {
      const double cells = std::ceil((tree.box_.hi[k] - tree.box_.lo[k] - tolerance) * tree.scale_);
      tree.last_cell_[static_cast<std::size_t>(k)] =
          static_cast<std::uint32_t>(std::clamp(cells, 1.0, static_cast<double>(1U << kLevels))) - 1;
    }
  }

  /// The part of a cell in the domain's box; nothing if they do not overlap.
  [[nodiscard]] std::optional<Box<D>> clipped(const std::array<std::uint32_t, D>& coordinate, int level) const {
    const double side = std::ldexp(root_side, -level);
    Box<D> box;
    for (int k = 0; k < D; ++k) {
      const std::uint32_t c = coordinate[static_cast<std::size_t>(k)];
      if (c > tree.last_cell_[static_cast<std::size_t>(k)] >> (kLevels - level)) return std::nullopt;
      box.lo[k] = tree.box_.lo[k] + c * side;
      box.hi[k] = std::min(tree.box_.lo[k] + (c + 1) * side, tree.box_.hi[k]);
    }
    return box;
  }

  void build(Observer& observer) {
    auto all = std::make_shared<Lists>();
    if (sources.table.is_built()) {
      all->items = sources.table.items();
    } else {
      all->items.resize(polytopes.n_items());
      std::iota(all->items.begin(), all->items.end(), 0U);
    }
    all->atoms.resize(sources.sizes.size());
    for (std::uint32_t i = 0; i < all->atoms.size(); ++i) all->atoms[i].index = i;
    all->regions = sources.sizes.regions();
    all->constant = sources.constant;
    all->asks_fields = !sources.sizes.fields().empty();
    std::size_t n_sizes = all->atoms.size();
    for (const FillingField<D>& field : sources.sizes.fields()) n_sizes += field.size();
    const std::size_t max_cells = std::min(kMostCells, kBaseCells + kCellsPerItem * all->items.size() + 2 * n_sizes);

    tree.nodes_.assign(1, kLeafBit);
    std::vector<Cell> level(1);
    level[0].parent = std::move(all);
    for (int depth = 0; !level.empty(); ++depth) {
      observer.check_cancelled();
      parallel_for(
          level.size(), [&](std::size_t i) { examine(level[i], depth); }, 1);
      std::size_t n_cells = tree.nodes_.size();
      for (Cell& cell : level) {
        cell.is_split = cell.is_split && n_cells + (1U << D) <= max_cells;
        if (cell.is_split) n_cells += 1U << D;
      }
      if constexpr (D == 3)
        parallel_for(
            level.size(), [&](std::size_t i) { find_planes(level[i]); }, 1);
      std::vector<Cell> next;
      for (Cell& cell : level) {
        if (cell.is_split)
          add_children(cell, depth, next);
        else
          add_leaf(cell);
        cell = Cell{};  // Frees its lists.
      }
      level = std::move(next);
    }
  }

  void add_children(const Cell& cell, int depth, std::vector<Cell>& next) {
    const auto first = static_cast<std::uint32_t>(tree.nodes_.size());
    tree.nodes_[cell.node] = first;
    tree.nodes_.resize(tree.nodes_.size() + (1U << D), kLeafBit);  // Those outside the box are never reached.
    for (std::uint32_t child = 0; child < (1U << D); ++child) {
      Cell c;
      c.node = first + child;
      for (std::size_t k = 0; k < D; ++k) c.coordinate[k] = 2 * cell.coordinate[k] + (child >> k & 1U);
      if (!clipped(c.coordinate, depth + 1)) continue;
      c.parent = cell.lists;
      next.push_back(std::move(c));
    }
  }

  /// Filters the parent's lists for the cell and decides whether it is to be split.
  void examine(Cell& cell, int depth) const {
    cell.box = *clipped(cell.coordinate, depth);
    const Vec<D> m = cell.box.center();
    const double h = 0.5 * cell.box.diagonal() + tolerance;
    const Lists& parent = *cell.parent;
    auto lists = std::make_shared<Lists>();
    lists->constant = parent.constant;
    lists->is_paired = parent.is_paired;
    cell.value = parent.constant;

    double size_limit = kInfinity;
    if (parent.asks_fields) size_limit = look_at_fields(cell.box, *lists);
    cell.value = std::min({cell.value, lists->constant, size_limit});
    size_limit = std::min(size_limit, filter_sizes(parent, m, h, *lists, cell.value));
    std::vector<double> distances;
    for (std::uint32_t i : parent.items) distances.push_back(polytopes.item_distance(i, m));
    const OwnerDistances owners = owner_distances(parent.items, distances);
    cell.limit = std::min(size_limit, pair_limit(parent, m, h, owners, cell));
    filter_polytopes(parent, h, cell.limit, distances, owners, *lists);
    if (cell.limit < size_limit) {
      const double b = sources.sizes.slope();
      std::erase_if(lists->atoms, [&](const WorkAtom& a) { return a.at_center - b * h > cell.limit; });
    }
    cell.lists = std::move(lists);
    cell.parent.reset();
    const std::size_t few = cell.search_is_cheap ? kFewPolytopes : kMaxPolytopes;
    if (!cell.lists->is_paired && count_polytopes(*cell.lists) <= few) form_pairs(cell, m, h);
    cell.is_split = depth < kLevels && wants_split(cell, h);
  }

  /// Bounds the parent's atoms and region values at m and keeps those that can be smallest in the cell. Returns an
  /// upper bound of f in the cell.
  double filter_sizes(const Lists& parent, const Vec<D>& m, double h, Lists& lists, double& value) const {
    const SizeAtoms<D>& sizes = sources.sizes;
    const double b = sizes.slope();
    const auto meets = [&](const WorkAtom& a) {
      return sizes.is_local(a.index) && sizes.atom_box(a.index).distance_sq(m) <= h * h;
    };
    // Where a cell meets local atoms, those that it does not meet say nothing about it.
    const bool meets_local = std::any_of(parent.atoms.begin(), parent.atoms.end(), meets);
    double least = kInfinity;
    for (const WorkAtom& a : parent.atoms) {
      if (meets_local && sizes.is_local(a.index) && !meets(a)) continue;
      const Interval at_center = sizes.bounds(a.index, m);
      least = std::min(least, at_center.hi);
      lists.atoms.push_back({a.index, at_center.lo});
    }
    double limit = std::min(lists.constant, least + b * h);
    for (const RegionValue& r : parent.regions) {
      if (!(r.value < limit)) break;
      if (sources.locator.meets_walls(m, h, r.region)) {
        lists.regions.push_back(r);
      } else if (sources.locator.in_region(m, r.region)) {
        lists.constant = std::min(lists.constant, r.value);
        limit = std::min(limit, r.value);
      }
    }
    std::erase_if(lists.regions, [&](const RegionValue& r) { return r.value > limit; });
    std::erase_if(lists.atoms, [&](const WorkAtom& a) {
      return a.at_center - b * h > limit || a.at_center - b * h >= lists.constant;
    });
    value = std::min({value, lists.constant, least});
    return limit;
  }

  /// What the fields that fill the domain are in the cell. Of its part outside of the domain nobody asks. Returns an
  /// upper bound of f.
  double look_at_fields(const Box<D>& box, Lists& lists) const {
    double limit = kInfinity;
    for (const FillingField<D>& field : sources.sizes.fields()) {
      const Interval values = field.range(box);
      limit = std::min(limit, values.hi);
      if (values.lo == values.hi)
        lists.constant = std::min(lists.constant, values.lo);
      else
        lists.asks_fields = lists.asks_fields || values.lo < lists.constant;
    }
    return limit;
  }

  using OwnerDistances = std::vector<std::pair<std::uint32_t, double>>;

  /// The distance to each polytope that has an item in the list, by ascending number.
  OwnerDistances owner_distances(const std::vector<std::uint32_t>& items, const std::vector<double>& distances) const {
    OwnerDistances result;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::uint32_t owner = polytopes.item_owner(items[i]);
      if (result.empty() || result.back().first != owner) result.emplace_back(owner, distances[i]);
      result.back().second = std::min(result.back().second, distances[i]);
    }
    return result;
  }
  static double lookup(const OwnerDistances& owners, std::uint32_t p) {
    const auto entry = std::lower_bound(owners.begin(), owners.end(), std::pair(p, -kInfinity));
    return entry != owners.end() && entry->first == p ? entry->second : kInfinity;
  }

  /// An upper bound of f in the cell from the pairs. Improves cell.value.
  double pair_limit(const Lists& parent, const Vec<D>& m, double h, const OwnerDistances& owners, Cell& cell) const {
    const double slope = sources.weights.slope;
    double least = kInfinity;
    if (parent.is_paired) {
      for (const WorkPair& pair : parent.pairs) least = std::min(least, value_of(pair, owners));
    } else {
      const auto search = sources.pairs(m, cell.value, kMaxMet);
      cell.search_is_cheap = search.n_met < kMaxMet;
      if (search.value < cell.value) least = search.value;
    }
    cell.value = std::min(cell.value, least);
    return least + slope * h;
  }

  double value_of(const WorkPair& pair, const OwnerDistances& owners) const {
    return sources.weights.slope * std::max(lookup(owners, pair.p), lookup(owners, pair.q)) + pair.offset;
  }

  void filter_polytopes(const Lists& parent, double h, double limit, const std::vector<double>& distances,
                        const OwnerDistances& owners, Lists& lists) const {
    const double slope = sources.weights.slope;
    for (WorkPair pair : parent.pairs) {
      pair.at_center = value_of(pair, owners);
      if (matters(pair.at_center - slope * h, limit, lists.constant)) lists.pairs.push_back(pair);
    }
    std::vector<double> kept;
    for (std::size_t i = 0; i < parent.items.size(); ++i) {
      const double gap =
          sources.table.is_built() ? sources.table.least_gap(polytopes.item_owner(parent.items[i])) : 0.0;
      if (!matters(slope * (distances[i] - h) + gap, limit, lists.constant)) continue;
      lists.items.push_back(parent.items[i]);
      kept.push_back(distances[i]);
    }
    drop_far_items(h, kept, lists);
    if (lists.is_paired) drop_unpaired_items(lists);
  }

  /// A source with this lower bound in a cell where f is at most `limit`, and at most `constant`.
  static bool matters(double lower, double limit, double constant) { return lower <= limit && lower < constant; }

  /// Of each polytope, keeps the items that can be nearest somewhere in the cell.
  void drop_far_items(double h, const std::vector<double>& distances, Lists& lists) const {
    const auto owners = owner_distances(lists.items, distances);
    std::size_t n = 0;
    for (std::size_t i = 0; i < lists.items.size(); ++i)
      if (distances[i] <= lookup(owners, polytopes.item_owner(lists.items[i])) + 2 * h)
        lists.items[n++] = lists.items[i];
    lists.items.resize(n);
  }

  /// Drops the items of polytopes that are in no pair.
  void drop_unpaired_items(Lists& lists) const {
    std::vector<std::uint32_t> used;
    for (const WorkPair& pair : lists.pairs) used.insert(used.end(), {pair.p, pair.q});
    std::sort(used.begin(), used.end());
    std::erase_if(lists.items, [&](std::uint32_t i) {
      return !std::binary_search(used.begin(), used.end(), polytopes.item_owner(i));
    });
  }

  /// Keeps the pairs of what is in the cell that can be smallest there.
  void form_pairs(Cell& cell, const Vec<D>& m, double h) const {
    Lists& lists = *cell.lists;
    std::vector<double> distances;
    for (std::uint32_t i : lists.items) distances.push_back(polytopes.item_distance(i, m));
    const auto owners = owner_distances(lists.items, distances);
    const double slope = sources.weights.slope;
    const double slack = slope * h;
    const auto add = [&](std::uint32_t p, std::uint32_t q, double reach, double offset) {
      const double at_center = reach + offset;
      if (!matters(at_center - slack, cell.limit, lists.constant)) return;
      cell.value = std::min(cell.value, at_center);
      cell.limit = std::min(cell.limit, at_center + slack);
      lists.pairs.push_back({p, q, offset, at_center});
    };
    if (sources.table.is_built()) {
      for (const auto& [p, d_p] : owners) {
        for (const auto& partner : sources.table[p]) {
          if (!matters(slope * d_p + partner.gap - slack, cell.limit, lists.constant)) break;
          if (partner.polytope > p) continue;  // Each pair once.
          const double d_q = lookup(owners, partner.polytope);
          if (d_q < kInfinity) add(p, partner.polytope, slope * std::max(d_p, d_q), partner.gap);
        }
      }
    } else {
      for_each_disjoint_pair(owners, cell.limit + slack, add);
    }
    std::erase_if(lists.pairs,
                  [&](const WorkPair& a) { return !matters(a.at_center - slack, cell.limit, lists.constant); });
    lists.is_paired = true;
    drop_unpaired_items(lists);
  }

  /// add(p, q, reach, offset) for all pairs that can be at most `limit` at the point to which the distances refer.
  template <class Add>
  void for_each_disjoint_pair(const OwnerDistances& owners, double limit, Add&& add) const {
    const PairWeights w = sources.weights;
    for (std::size_t i = 0; i < owners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto [p, d_p] = owners[i];
        const auto [q, d_q] = owners[j];
        const double reach = w.slope * std::max(d_p, d_q);
        if (reach > limit || reach + w.gap * box_distance(polytopes.box(p), polytopes.box(q)) > limit) continue;
        if (polytopes.is_maximal_pair(p, q))
          add(p, q, reach, w.gap > 0 ? w.gap * polytopes.distance_between(p, q) : 0.0);
      }
    }
  }

  [[nodiscard]] std::size_t count_polytopes(const Lists& lists) const {
    std::size_t n = 0;
    for_each_polytope(lists.items, [&](std::uint32_t, std::span<const std::uint32_t>) { ++n; });
    return n;
  }

  [[nodiscard]] bool wants_split(const Cell& cell, double h) const {
    const Lists& lists = *cell.lists;
    double side = 0;
    for (int k = 0; k < D; ++k) side = std::max(side, cell.box.hi[k] - cell.box.lo[k]);
    if (lists.items.empty() && lists.atoms.empty() && lists.regions.empty() && !lists.asks_fields) return false;
    const bool is_mixed = lists.constant <= cell.limit || lists.asks_fields;
    if (is_mixed && side > kMixedSide * cell.value) return true;
    if (!(side > kSmallestSide * cell.value)) return false;
    if (!lists.is_paired) return !cell.search_is_cheap || sources.weights.slope * h > kSearchVariation * cell.value;
    return lists.items.size() + lists.atoms.size() + lists.regions.size() > kFewSources;
  }

  /// Marks the facets whose plane decides.
  void find_planes(Cell& cell) const {
    if (cell.is_split || !cell.lists->is_paired) return;
    if constexpr (D == 3) {
      for_each_polytope(cell.lists->items, [&](std::uint32_t p, std::span<const std::uint32_t>) {
        const bool plane = polytopes.is_facet(p) && outlines.projects_inside(cell.box, polytopes.facet(p));
        cell.is_plane.push_back(plane ? 1 : 0);
      });
    }
  }

  /// visit(polytope, its items in the list) for each polytope that has some.
  template <class Visit>
  void for_each_polytope(const std::vector<std::uint32_t>& items, Visit&& visit) const {
    for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
      const std::uint32_t p = polytopes.item_owner(items[begin]);
      while (end < items.size() && polytopes.item_owner(items[end]) == p) ++end;
      visit(p, std::span<const std::uint32_t>(items).subspan(begin, end - begin));
    }
  }

  static float rounded_down(double x) { return std::nextafter(static_cast<float>(x), -1.0F); }

  void add_leaf(const Cell& cell) {
    const Lists& lists = *cell.lists;
    Leaf leaf;
    leaf.center = cell.box.center();
    leaf.value = cell.value;
    leaf.constant = lists.constant;
    leaf.asks_fields = lists.asks_fields;
    leaf.first_pair = tree.pairs_.size();
    leaf.first_near = tree.nears_.size();
    leaf.first_atom = tree.atoms_.size();
    leaf.first_region = tree.regions_.size();
    if (lists.is_paired)
      add_pairs(cell, leaf);
    else
      leaf.search_pairs = true;
    if (lists.atoms.size() > kMaxAtoms) {
      leaf.search_atoms = true;
    } else {
      for (const WorkAtom& a : lists.atoms) tree.atoms_.push_back({a.index, rounded_down(a.at_center)});
      std::sort(tree.atoms_.begin() + static_cast<std::ptrdiff_t>(leaf.first_atom), tree.atoms_.end(),
                [](const Atom& a, const Atom& b) {
                  return a.at_center < b.at_center || (a.at_center == b.at_center && a.index < b.index);
                });
      leaf.n_atoms = static_cast<std::uint32_t>(lists.atoms.size());
    }
    tree.regions_.insert(tree.regions_.end(), lists.regions.begin(), lists.regions.end());
    leaf.n_regions = static_cast<std::uint32_t>(lists.regions.size());
    tree.nodes_[cell.node] = kLeafBit | static_cast<std::uint32_t>(tree.leaves_.size());
    tree.leaves_.push_back(leaf);
  }

  void add_pairs(const Cell& cell, Leaf& leaf) {
    const Lists& lists = *cell.lists;
    std::vector<std::uint32_t> owners;  // In the order of their entries in nears_.
    for_each_polytope(lists.items, [&](std::uint32_t p, std::span<const std::uint32_t> items) {
      bool is_plane = false;
      if constexpr (D == 3) is_plane = cell.is_plane[owners.size()] != 0;
      owners.push_back(p);
      if (is_plane) {
        if constexpr (D == 3) tree.nears_.push_back({polytopes.facet(p).value(), 0});
      } else {
        tree.nears_.push_back(
            {static_cast<std::uint32_t>(tree.near_items_.size()), static_cast<std::uint32_t>(items.size())});
        tree.near_items_.insert(tree.near_items_.end(), items.begin(), items.end());
      }
    });
    const auto slot = [&](std::uint32_t p) {
      return static_cast<std::uint8_t>(std::lower_bound(owners.begin(), owners.end(), p) - owners.begin());
    };
    for (const WorkPair& pair : lists.pairs)
      tree.pairs_.push_back({pair.offset, rounded_down(pair.at_center), slot(pair.p), slot(pair.q)});
    std::stable_sort(tree.pairs_.begin() + static_cast<std::ptrdiff_t>(leaf.first_pair), tree.pairs_.end(),
                     [](const Pair& a, const Pair& b) { return a.at_center < b.at_center; });
    leaf.n_pairs = static_cast<std::uint32_t>(lists.pairs.size());
  }

  const SpacingSources<D>& sources;
  const PolytopeSet<D>& polytopes;
  SpacingTree& tree;
  Outlines outlines;
  double root_side = 0;
  double tolerance = 0;
};

template <int D>
SpacingTree<D>::SpacingTree(const Domain<D>& domain, const SpacingSources<D>& sources, Observer& observer)
    : sources_(&sources), box_(domain.box) {
  if constexpr (D == 3)
    for (const PlaneFrame& frame : domain.facet_frame) planes_.push_back({frame.origin, frame.normal});
  Builder(domain, sources, *this).build(observer);
}

template SpacingTree<2>::SpacingTree(const Domain<2>&, const SpacingSources<2>&, Observer&);
template SpacingTree<3>::SpacingTree(const Domain<3>&, const SpacingSources<3>&, Observer&);

}  // namespace voropack
