// A quadtree or octree that knows, in each leaf, which sources can attain the minimum f.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "spacing/spacing_sources.h"
#include "voropack/observer.h"

namespace voropack {

/// Evaluates f inside the domain's box. Every source that is smallest at some point of a leaf is listed in it, so the
/// minimum over the list is f itself; leaves whose lists would be too long search instead.
template <int D>
class SpacingTree {
 public:
  /// `sources` must outlive the tree. Built level by level, in parallel; the same for any number of threads.
  SpacingTree(const Domain<D>& domain, const SpacingSources<D>& sources, Observer& observer);

  [[nodiscard]] const Box<D>& box() const { return box_; }
  /// f(x), for x in box().
  [[nodiscard]] double operator()(const Vec<D>& x) const;
  [[nodiscard]] std::optional<double> constant_on(const Box<D>& box) const;

  /// For reports and tuning.
  struct Statistics {
    std::size_t n_leaves = 0, n_constant = 0, n_searching = 0, n_pairs = 0, n_near = 0, n_atoms = 0, depth = 0;
    std::size_t n_bytes = 0;
  };
  [[nodiscard]] Statistics statistics() const;

 private:
  struct Builder;
  friend struct Builder;

  static constexpr int kLevels = 20;                                  // Cells have side box / 2^kLevels at least.
  static constexpr std::uint32_t kLeafBit = std::uint32_t{1} << 31U;  // In nodes_: the rest is a leaf's number.

  /// A polytope in a leaf, as far as it can matter there.
  struct Near {
    std::uint32_t first;    // Slot in near_items_, or the facet if is_plane.
    std::uint32_t n_items;  // 0: the distance is that from the facet's plane.
  };
  /// Contributes slope * max(d(x, p), d(x, q)) + offset, for the leaf's p-th and q-th polytope.
  struct Pair {
    double offset;
    float at_center;  // The contribution at the leaf's center, rounded down.
    std::uint8_t p, q;
  };
  struct Atom {
    std::uint32_t index;
    float at_center;
  };
  struct Leaf {
    Vec<D> center;
    double value = 0;     // An upper bound of f at the center.
    double constant = 0;  // A source that is constant throughout the leaf.
    std::uint64_t first_pair = 0, first_near = 0, first_atom = 0, first_region = 0;
    std::uint32_t n_pairs = 0, n_atoms = 0, n_regions = 0;
    bool search_pairs = false, search_atoms = false, asks_fields = false;
    [[nodiscard]] bool is_constant() const { return has_no_lists() && !asks_fields; }
    [[nodiscard]] bool has_no_lists() const {
      return n_pairs == 0 && n_atoms == 0 && n_regions == 0 && !search_pairs && !search_atoms;
    }
  };

  [[nodiscard]] const Leaf& find_leaf(const Vec<D>& x) const;
  [[nodiscard]] std::array<std::uint32_t, D> cell_of(const Vec<D>& x) const;
  [[nodiscard]] double pairs_minimum(const Leaf& leaf, const Vec<D>& x, double from_center, double best) const;
  [[nodiscard]] double atoms_minimum(const Leaf& leaf, const Vec<D>& x, double from_center, double best) const;
  [[nodiscard]] double near_distance(const Near& near, const Vec<D>& x) const;

  const SpacingSources<D>* sources_;
  Box<D> box_;
  double scale_ = 0;                          // Smallest cells per length.
  std::array<std::uint32_t, D> last_cell_{};  // The largest cell coordinate along each axis.
  std::vector<std::uint32_t> nodes_;          // The first of 2^D children, or a leaf with kLeafBit.
  std::vector<Leaf> leaves_;
  std::vector<Pair> pairs_;
  std::vector<Near> nears_;
  std::vector<std::uint32_t> near_items_;
  std::vector<Atom> atoms_;
  std::vector<RegionValue> regions_;
  std::vector<std::array<Vec<D>, 2>> planes_;  // [n_facets] origin and normal.
};

}  // namespace voropack
