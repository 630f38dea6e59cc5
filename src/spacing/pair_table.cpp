#include "spacing/pair_table.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace voropack {

namespace {

/// Pairs are left out only if they are farther apart than the cutoff by more than rounding, so that no two pairs are
/// each left out because of the other.
constexpr double kCutoffSlack = 1 + 1e-9;

/// The cutoff of p, from items instead of whole polytopes and from corners instead of all points of p: both make it
/// larger, never smaller.
template <int D>
double cutoff(const PolytopeSet<D>& polytopes, std::uint32_t p, double ratio) {
  std::vector<Vec<D>> corners;
  for (std::uint32_t i = polytopes.first_item(p); i < polytopes.first_item(p + 1); ++i) {
    const SmallSimplex<D>& item = polytopes.item(i);
    corners.insert(corners.end(), item.corner.begin(), item.corner.begin() + item.dimension + 1);
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  Vec<D> center;
  for (const Vec<D>& x : corners) center += x;
  center *= 1.0 / static_cast<double>(corners.size());
  // The largest distance of a corner from an item is at least that of the center, because it is a convex function.
  const double infinity = std::numeric_limits<double>::infinity();
  double least = infinity;
  polytopes.tree().minimize(center, ratio, infinity, [&](std::uint32_t item) {
    if (!(ratio * polytopes.item_distance(item, center) < least)) return infinity;
    if (!polytopes.disjoint(p, polytopes.item_owner(item))) return infinity;
    double nearest = infinity;
    double farthest = 0;
    for (const Vec<D>& x : corners) {
      const double d = polytopes.item_distance(item, x);
      nearest = std::min(nearest, d);
      farthest = std::max(farthest, d);
      if (ratio * farthest >= least) return infinity;
    }
    least = std::min(least, ratio * farthest + nearest);
    return least;
  });
  return least * kCutoffSlack;
}

}  // namespace

template <int D>
PairTable<D>::PairTable(const PolytopeSet<D>& polytopes, PairWeights weights) {
  const std::size_t n = polytopes.n_polytopes();
  std::vector<double> reach(n);
  const double ratio = weights.slope / weights.gap;
  const auto id = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
  parallel_for(
      n, [&](std::size_t p) { reach[p] = cutoff(polytopes, id(p), ratio); }, 64);

  // Each pair is found from the polytope with the smaller cutoff.
  std::vector<std::vector<Partner>> rows(n);
  const auto find_partners = [&](std::size_t i) {
    const std::uint32_t p = id(i);
    std::vector<std::uint32_t> near;
    const auto is_near = [&](const Box<D>& box) { return box_distance(box, polytopes.box(p)) <= reach[p]; };
    polytopes.tree().for_each(is_near, [&](std::uint32_t item) {
      const std::uint32_t q = polytopes.item_owner(item);
      if (std::pair(reach[p], p) < std::pair(reach[q], q) && is_near(polytopes.box(q))) near.push_back(q);
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (std::uint32_t q : near) {
      if (!polytopes.is_maximal_pair(p, q)) continue;
      const double gap = polytopes.distance_between(p, q);
      if (gap <= reach[p]) rows[p].push_back({q, weights.gap * gap});
    }
  };
  parallel_for(n, find_partners, 16);

  begin_.assign(n + 1, 0);
  for (std::uint32_t p = 0; p < n; ++p) {
    begin_[p + 1] += rows[p].size();
    for (const Partner& partner : rows[p]) ++begin_[partner.polytope + 1];
  }
  for (std::size_t p = 0; p < n; ++p) begin_[p + 1] += begin_[p];
  partners_.resize(begin_.back());
  std::vector<std::uint64_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t p = 0; p < n; ++p) {
    for (const Partner& partner : rows[p]) {
      partners_[next[p]++] = partner;
      partners_[next[partner.polytope]++] = {p, partner.gap};
    }
  }
  for (std::size_t p = 0; p < n; ++p)
    std::sort(partners_.begin() + static_cast<std::ptrdiff_t>(begin_[p]),
              partners_.begin() + static_cast<std::ptrdiff_t>(begin_[p + 1]), [](const Partner& a, const Partner& b) {
                return std::pair(a.gap, a.polytope) < std::pair(b.gap, b.polytope);
              });

  std::vector<Box<D>> boxes;
  for (std::uint32_t i = 0; i < polytopes.n_items(); ++i) {
    if ((*this)[polytopes.item_owner(i)].empty()) continue;
    items_.push_back(i);
    boxes.push_back(polytopes.item(i).box());
  }
  tree_ = BoxTree<D>(boxes);
}

template class PairTable<2>;
template class PairTable<3>;

}  // namespace voropack
