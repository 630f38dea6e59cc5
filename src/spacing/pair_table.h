// The disjoint pairs of polytopes that can matter anywhere, with their distances.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "spacing/polytope_set.h"

namespace voropack {

/// A pair (P, Q) contributes phi_PQ = s max(d(x,P), d(x,Q)) + g d(P,Q). Let (P, Q') be another disjoint pair and H the
/// largest distance of a point of P from Q'. From d(x,Q') <= d(x,P) + H follows phi_PQ' <= s (d(x,P) + H) + g d(P,Q'),
/// so that phi_PQ' <= phi_PQ everywhere if d(P,Q) >= (s/g) H + d(P,Q'). The least right-hand side over Q' is the
/// *cutoff* of P. Pairs farther apart than one of their cutoffs are left out, and so are pairs that are not maximal.
/// What is left is of the order of n where polytopes are about as large as the gaps between them.
template <int D>
class PairTable {
 public:
  struct Partner {
    std::uint32_t polytope;
    double gap;  ///< d(P, Q) times PairWeights::gap.
  };

  PairTable() = default;
  /// weights.gap must be positive. In parallel; the same for any number of threads.
  PairTable(const PolytopeSet<D>& polytopes, PairWeights weights);

  /// False for a table that was not built.
  [[nodiscard]] bool is_built() const { return !begin_.empty(); }
  /// The partners of p, by increasing gap.
  [[nodiscard]] std::span<const Partner> operator[](std::uint32_t p) const {
    return {partners_.data() + begin_[p], partners_.data() + begin_[p + 1]};
  }
  /// The least gap of p with a partner, or infinity if it has none.
  [[nodiscard]] double least_gap(std::uint32_t p) const {
    return begin_[p] < begin_[p + 1] ? partners_[begin_[p]].gap : std::numeric_limits<double>::infinity();
  }
  /// The items of the polytopes that have partners, ascending. Most points and segments have none.
  [[nodiscard]] const std::vector<std::uint32_t>& items() const { return items_; }
  /// Over the entries of items().
  [[nodiscard]] const BoxTree<D>& tree() const { return tree_; }
  [[nodiscard]] std::size_t n_pairs() const { return partners_.size() / 2; }

 private:
  std::vector<std::uint64_t> begin_;  // [n_polytopes + 1]
  std::vector<Partner> partners_;     // Every pair twice.
  std::vector<std::uint32_t> items_;
  BoxTree<D> tree_;
};

}  // namespace voropack
