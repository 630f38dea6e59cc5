// The polytopes of dimension < D of a domain as metric objects: their distances, and which of them meet.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "geom/box_tree.h"
#include "geom/polytope_distance.h"
#include "voropack/domain.h"

namespace voropack {

/// What a disjoint pair (P, Q) contributes at x: slope * max(d(x,P), d(x,Q)) + gap * d(P,Q).
/// The local feature size has slope 1 and gap 0.
struct PairWeights {
  double slope = 1;
  double gap = 0;
};

/// Polytopes are numbered points first, then segments, then facets. Each is a union of *items*: itself, or the
/// triangles of a facet. Copies what it needs of the domain.
template <int D>
class PolytopeSet {
 public:
  explicit PolytopeSet(const Domain<D>& domain);

  [[nodiscard]] std::size_t n_polytopes() const { return item_begin_.size() - 1; }
  [[nodiscard]] std::size_t n_items() const { return items_.size(); }
  [[nodiscard]] std::uint32_t of_point(PointId p) const { return p.value(); }
  [[nodiscard]] std::uint32_t of_segment(SegmentId s) const { return n_points_ + s.value(); }
  [[nodiscard]] std::uint32_t of_facet(FacetId f) const { return n_points_ + n_segments_ + f.value(); }
  /// The polytope of the (D-1)-dimensional wall number w.
  [[nodiscard]] std::uint32_t of_wall(std::size_t w) const {
    return static_cast<std::uint32_t>(w) + n_points_ + (D == 3 ? n_segments_ : 0);
  }
  [[nodiscard]] bool is_facet(std::uint32_t polytope) const { return polytope >= n_points_ + n_segments_; }
  [[nodiscard]] FacetId facet(std::uint32_t polytope) const { return FacetId(polytope - n_points_ - n_segments_); }

  [[nodiscard]] PolytopeId id_of(std::uint32_t polytope) const {
    if (polytope < n_points_) return PolytopeId(0, polytope);
    if (polytope < n_points_ + n_segments_) return PolytopeId(1, polytope - n_points_);
    return PolytopeId(2, polytope - n_points_ - n_segments_);
  }

  /// Items of polytope p: first_item(p) .. first_item(p + 1) - 1.
  [[nodiscard]] std::uint32_t first_item(std::uint32_t p) const { return item_begin_[p]; }
  [[nodiscard]] std::uint32_t item_owner(std::uint32_t item) const { return item_owner_[item]; }
  [[nodiscard]] const SmallSimplex<D>& item(std::uint32_t item) const { return items_[item]; }
  [[nodiscard]] double item_distance(std::uint32_t item, const Vec<D>& x) const {
    return distance_to_simplex(x, items_[item]);
  }
  /// Over all items.
  [[nodiscard]] const BoxTree<D>& tree() const { return tree_; }

  /// True iff the closures of p and q share no point of the domain. By Definition 3.2 that means that they do not meet.
  [[nodiscard]] bool disjoint(std::uint32_t p, std::uint32_t q) const;
  /// True iff (p, q) is disjoint and no polytope with p (or q) in its closure is disjoint from the other. Only such
  /// pairs matter for a minimum over pairs: the larger polytope is nearer to everything.
  [[nodiscard]] bool is_maximal_pair(std::uint32_t p, std::uint32_t q) const;
  [[nodiscard]] double distance_to(std::uint32_t p, const Vec<D>& x) const;
  /// d(p, q) of a disjoint pair.
  [[nodiscard]] double distance_between(std::uint32_t p, std::uint32_t q) const;
  [[nodiscard]] const Box<D>& box(std::uint32_t p) const { return polytope_box_[p]; }

 private:
  void add_polytope(const SmallSimplex<D>& simplex);
  void build_closures(const Domain<D>& domain);
  void build_cofaces(const Domain<D>& domain);
  void build_trees();

  std::uint32_t n_points_ = 0;
  std::uint32_t n_segments_ = 0;
  std::vector<SmallSimplex<D>> items_;     // [n_items]
  std::vector<std::uint32_t> item_owner_;  // [n_items]
  std::vector<std::uint32_t> item_begin_;  // [n_polytopes + 1]
  std::vector<Box<D>> polytope_box_;       // [n_polytopes]
  BoxTree<D> tree_;

  std::vector<std::uint64_t> closure_begin_;             // [n_polytopes + 1]
  std::vector<std::uint32_t> closure_;                   // Sorted points of each closure.
  std::vector<std::uint64_t> closure_mask_;              // [n_polytopes] one bit for each point, by hash.
  std::vector<std::uint64_t> coface_begin_;              // [n_polytopes + 1]
  std::vector<std::uint32_t> coface_;                    // Polytopes of higher dimension whose closure holds this one.
  std::vector<std::unique_ptr<BoxTree<D>>> facet_tree_;  // [n_polytopes or 0] of the items of large facets.
};

}  // namespace voropack
