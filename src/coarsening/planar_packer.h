// Packs one level beyond the boundary with vertices of the finest mesh: boundary chains first, then what lies between.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "coarsening/conforming_level.h"
#include "geom/box_tree.h"
#include "voropack/coarsening.h"
#include "voropack/observer.h"

namespace voropack {

/// What is wanted of one level.
struct PackingWish {
  double growth = 2;                    ///< f = growth f_0, made Lipschitz
  double lipschitz = 0.1;               ///< with this constant.
  std::span<const std::uint32_t> kept;  ///< The next coarser level: stays, packed or not.
  std::span<const double> bound;        ///< Its spacing: f is not larger. Empty on the coarsest level.
  std::uint64_t seed = 0;               ///< Another one, another packing.
  CoarseningOrder order = CoarseningOrder::kFront;
  double max_area_change = 1;
  std::span<const std::uint32_t> rungs;  ///< Vertices beside tips of wedges on coarser levels.
};

struct PlanarPacking {
  ConformingLevel level;
  std::vector<double> spacing;  ///< [fine vertices] f: by it vertices keep others away.
  /// [fine vertices] radii of f-spheres: f, but beside the tip of a wedge, where vertices face each other across the
  /// outside, at most half of their distance.
  std::vector<double> radius;
  std::vector<std::uint32_t> rungs;  ///< Those vertices.
  double growth = 1, lipschitz = 0;
};

class PlanarPacker {
 public:
  PlanarPacker(const Mesh<2>& mesh, const ChainedMesh& fine, InitialSpacing initial, Observer& observer);

  /// A maximal set of vertices whose f-spheres do not overlap, except for those of `kept` among each other. The tip of
  /// a wedge stays, between pairs of vertices at equal distances from it. Where the boundary does not conform, a vertex
  /// is left out, or f halved, whichever keeps it near the original.
  [[nodiscard]] PlanarPacking pack(const PackingWish& wish) const;
  /// The largest overlap of the f-sphere of a vertex with those of the level but `other`: 1 - distance / sum of the
  /// radii.
  [[nodiscard]] double overlap(const PlanarPacking& packed, std::uint32_t vertex,
                               std::optional<std::uint32_t> other = std::nullopt) const;
  /// visit(vertex) for the vertices within a distance of x.
  template <class Visit>
  void for_each_near(const Vec<2>& x, double radius, Visit&& visit) const {
    const double radius_sq = radius * radius;
    tree_.for_each([&](const Box<2>& box) { return box.distance_sq(x) <= radius_sq; },
                   [&](std::uint32_t v) {
                     if (distance_sq(fine_->points[v], x) <= radius_sq) visit(v);
                   });
  }
  [[nodiscard]] const ChainedMesh& fine() const { return *fine_; }

 private:
  struct State;
  void find_anchor_gaps();
  [[nodiscard]] std::vector<double> spacing(const PackingWish& wish, const std::vector<double>& reduction) const;
  /// False if f was reduced somewhere and the boundary has to be packed anew.
  bool pack_boundary(const PackingWish& wish, State& state) const;
  [[nodiscard]] std::vector<double> radii(const State& state) const;
  void choose_tips(const PackingWish& wish, State& state) const;
  void choose_tip(const ChainPlace& tip, const PackingWish& wish, State& state) const;
  bool mend_boundary(const PackingWish& wish, State& state) const;
  bool mend(const ConformingLevel::Fault& fault, bool is_last_resort, State& state) const;
  /// Drops boundary vertices near vertices of the coarser level that ended up on the wrong side.
  bool free_misplaced(State& state) const;
  bool reduce_edge(const ChainPlace& from, const PackingWish& wish, State& state) const;
  bool reduce_area_change(const PackingWish& wish, State& state) const;
  bool reduce(std::uint32_t vertex, const PackingWish& wish, State& state) const;
  void pack_interior(const PackingWish& wish, State& state) const;
  void block_around(std::uint32_t vertex, double lipschitz, State& state) const;
  [[nodiscard]] std::vector<std::uint32_t> boundary_order(const PackingWish& wish) const;

  const ChainedMesh* fine_;
  Observer* observer_;
  BoxTree<2> tree_;
  std::vector<double> initial_;     ///< f_0.
  std::vector<double> anchor_gap_;  ///< At anchors, half the distance to the nearest other one: all of them are packed.
  std::vector<double> nearest_;     ///< Half the distance to the nearest neighbor: with it all vertices are packed.
};

}  // namespace voropack
