#include "spacing/pair_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace voropack {

namespace {

/// A node or item that waits to be looked at, nearest first; ties by number, so that the order is the same everywhere.
struct Waiting {
  double distance;
  std::uint32_t number;
  bool is_item;
  friend bool operator<(const Waiting& a, const Waiting& b) {
    if (a.distance != b.distance) return a.distance > b.distance;
    if (a.is_item != b.is_item) return a.is_item;
    return a.number > b.number;
  }
};

/// Gives the items in the order of their distance from x, as long as they can contribute less than a limit that may
/// shrink.
template <int D>
class NearestFirst {
 public:
  NearestFirst(const PolytopeSet<D>& polytopes, const PairTable<D>* table, double slope, const Vec<D>& x)
      : polytopes_(polytopes),
        table_(table),
        tree_(table != nullptr ? table->tree() : polytopes.tree()),
        slope_(slope),
        x_(x) {
    if (tree_.empty()) return;
    heap_.reserve(64);
    push({std::sqrt(tree_.nodes()[0].box.distance_sq(x)), 0, false});
  }

  /// False when there is none whose contribution, at least slope times its distance, can be less than `limit`.
  bool next(double limit, std::uint32_t& item, double& distance) {
    while (!heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end());
      const Waiting top = heap_.back();
      heap_.pop_back();
      if (!(slope_ * top.distance < limit)) return false;
      if (top.is_item) {
        item = top.number;
        distance = top.distance;
        return true;
      }
      open(tree_.nodes()[top.number], limit);
    }
    return false;
  }

 private:
  void open(const typename BoxTree<D>::Node& node, double limit) {
    if (node.count == 0) {
      for (std::uint32_t c = node.first; c < node.first + 2; ++c) {
        const double d = std::sqrt(tree_.nodes()[c].box.distance_sq(x_));
        if (slope_ * d < limit) push({d, c, false});
      }
      return;
    }
    for (std::uint32_t i : tree_.items(node)) {
      const std::uint32_t item = table_ != nullptr ? table_->items()[i] : i;
      const double d = polytopes_.item_distance(item, x_);
      const double gap = table_ != nullptr ? table_->least_gap(polytopes_.item_owner(item)) : 0.0;
      if (slope_ * d + gap < limit) push({d, item, true});
    }
  }
  void push(const Waiting& waiting) {
    heap_.push_back(waiting);
    std::push_heap(heap_.begin(), heap_.end());
  }

  const PolytopeSet<D>& polytopes_;
  const PairTable<D>* table_;
  const BoxTree<D>& tree_;
  double slope_;
  const Vec<D>& x_;
  std::vector<Waiting> heap_;
};

}  // namespace

template <int D>
PairSearch search_pairs(const PolytopeSet<D>& polytopes, const PairTable<D>* table, PairWeights weights,
                        const Vec<D>& x, double bound, std::size_t max_met) {
  double best = bound;
  std::vector<std::uint32_t> met;  // Nearest first.
  met.reserve(64);
  const auto is_met = [&](std::uint32_t p) { return std::find(met.begin(), met.end(), p) != met.end(); };
  NearestFirst<D> nearest(polytopes, table, weights.slope, x);
  std::uint32_t item = 0;
  double distance = 0;
  while (nearest.next(best, item, distance)) {
    const double reach = weights.slope * distance;
    const std::uint32_t p = polytopes.item_owner(item);
    if (is_met(p)) continue;
    if (table != nullptr) {
      for (const auto& partner : (*table)[p]) {
        if (!(reach + partner.gap < best)) break;
        if (is_met(partner.polytope)) best = reach + partner.gap;
      }
    } else {
      for (std::uint32_t q : met) {
        if (weights.gap == 0) {
          if (polytopes.disjoint(p, q)) return {reach, met.size()};  // Nearest first: no later pair is smaller.
          continue;
        }
        const double least_gap = weights.gap * box_distance(polytopes.box(p), polytopes.box(q));
        if (reach + least_gap < best && polytopes.is_maximal_pair(p, q))
          best = std::min(best, reach + weights.gap * polytopes.distance_between(p, q));
      }
    }
    met.push_back(p);
    if (met.size() >= max_met && best < bound) break;
  }
  return {best, met.size()};
}

template <int D>
std::vector<PairAt> pairs_below(const PolytopeSet<D>& polytopes, const PairTable<D>* table, PairWeights weights,
                                const Vec<D>& x, double limit, std::size_t max_met) {
  std::vector<PairAt> result;
  std::vector<std::uint32_t> met;  // Nearest first.
  const auto is_met = [&](std::uint32_t p) { return std::find(met.begin(), met.end(), p) != met.end(); };
  NearestFirst<D> nearest(polytopes, table, weights.slope, x);
  std::uint32_t item = 0;
  double distance = 0;
  while (met.size() < max_met && nearest.next(limit, item, distance)) {
    const double reach = weights.slope * distance;
    const std::uint32_t p = polytopes.item_owner(item);
    if (is_met(p)) continue;
    if (table != nullptr) {
      for (const auto& partner : (*table)[p]) {
        if (!(reach + partner.gap < limit)) break;
        if (is_met(partner.polytope))
          result.push_back({reach + partner.gap, partner.gap / weights.gap, p, partner.polytope});
      }
    } else {
      for (const std::uint32_t q : met) {
        if (reach + weights.gap * box_distance(polytopes.box(p), polytopes.box(q)) >= limit) continue;
        if (!polytopes.is_maximal_pair(p, q)) continue;
        const double gap = polytopes.distance_between(p, q);
        if (reach + weights.gap * gap < limit) result.push_back({reach + weights.gap * gap, gap, p, q});
      }
    }
    met.push_back(p);
  }
  return result;
}

template std::vector<PairAt> pairs_below<2>(const PolytopeSet<2>&, const PairTable<2>*, PairWeights, const Vec<2>&,
                                            double, std::size_t);
template std::vector<PairAt> pairs_below<3>(const PolytopeSet<3>&, const PairTable<3>*, PairWeights, const Vec<3>&,
                                            double, std::size_t);
template PairSearch search_pairs<2>(const PolytopeSet<2>&, const PairTable<2>*, PairWeights, const Vec<2>&, double,
                                    std::size_t);
template PairSearch search_pairs<3>(const PolytopeSet<3>&, const PairTable<3>*, PairWeights, const Vec<3>&, double,
                                    std::size_t);

}  // namespace voropack
