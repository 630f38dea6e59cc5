// One level beyond the boundary: a simplified boundary, and the Delaunay triangulation that conforms to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "coarsening/chained_mesh.h"
#include "coarsening/editable_triangulation.h"

namespace voropack {

/// How bad a triangle is, for a sum over all of them. Angles in degrees.
struct ShapeCost {
  double goal_deg = 25;  ///< A triangle of this quality costs 1,
  double scale_deg = 2;  ///< one that is worse by this costs e times as much.
};

/// The least angle of a triangle in degrees, or what its largest one would be worth if that is less: an isosceles
/// triangle with a base angle of 25 has one of 130 and 20 = kLargeAngleWeight (180 - 130).
double triangle_quality(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);
inline constexpr double kLargeAngleWeight = 0.4;

/// The same for an edge of the simplified boundary, from how far the vertices that it leaves out are from it, relative
/// to its length: a quarter of its length is worth 25 degrees, and twice as much 15 less.
double boundary_quality(double deviation, double length);

/// Some vertices of the finest mesh: boundary vertices, which the simplified boundary passes in the order of their
/// chains, and inner ones.
///
/// Invariants after `settle_boundary` returned no fault and after every `exchange`:
///  1. Every edge of the simplified boundary is in the triangulation, and no vertex is inside of its diametral ball.
///  2. Walking from triangle to triangle, the region changes at boundary edges only, and there as their chain says.
///  3. Every inner vertex lies in the region where it lies in the finest mesh.
class ConformingLevel {
 public:
  using Slot = EditableTriangulation::Slot;
  /// Where the boundary is at odds with itself.
  struct Fault {
    ChainPlace from;                       ///< Where the edge begins that is none,
    std::uint32_t to;                      ///< and where it ends on the same chain.
    std::optional<std::uint32_t> culprit;  ///< A vertex inside of its ball, if that is why.
  };

  explicit ConformingLevel(const ChainedMesh& fine);

  // The boundary, before there are inner vertices.
  void choose(std::uint32_t vertex);  ///< Adds a boundary vertex or an anchor.
  void drop(std::uint32_t vertex);    ///< Takes a boundary vertex away that is no anchor.
  /// The edges that break invariant 1.
  [[nodiscard]] std::vector<Fault> boundary_faults() const;
  /// Finds the regions of all triangles; false if that breaks invariant 2 or 3.
  bool settle_boundary();
  /// Inner vertices that break invariant 3.
  [[nodiscard]] std::vector<std::uint32_t> misplaced_vertices() const;

  // Vertices come and go; the boundary stays in order.
  /// Replaces `out` by `in`; either may be absent. Boundary vertices replace boundary vertices of the same chain. Where
  /// an invariant would break, or accept(change of the cost) is false, nothing happens and the result is false.
  template <class Accept>
  bool exchange(std::optional<std::uint32_t> out, std::optional<std::uint32_t> in, Accept&& accept) {
    apply(out, in);
    const bool is_done = settle() && accept(cost_change_);
    if (!is_done) {
      apply(in, out);
      settle();
    }
    return is_done;
  }
  /// Regions keep their area up to this part of it.
  double max_area_change = 1;
  void set_cost(const ShapeCost& cost);

  [[nodiscard]] bool has(std::uint32_t vertex) const { return triangulation_.has(vertex); }
  [[nodiscard]] std::size_t n_vertices() const { return n_vertices_; }
  [[nodiscard]] std::size_t n_boundary_edges() const { return n_boundary_edges_; }
  [[nodiscard]] const EditableTriangulation& triangulation() const { return triangulation_; }
  /// The region of a triangle, or kOutside.
  [[nodiscard]] int region(Slot slot) const { return region_[slot]; }
  /// Of a triangle in a region.
  [[nodiscard]] double quality(Slot slot) const { return state_[slot].quality; }
  [[nodiscard]] double area_change() const;  ///< The largest one of a region, as a part of its area.

  // Chains. Positions of chosen vertices only.
  [[nodiscard]] std::uint32_t next(ChainPlace place) const { return next_[place.chain][place.position]; }
  [[nodiscard]] std::uint32_t previous(ChainPlace place) const { return previous_[place.chain][place.position]; }
  [[nodiscard]] std::size_t n_chosen(std::size_t chain) const { return n_chosen_[chain]; }
  /// True where an edge begins: everywhere but at the end of an open chain.
  [[nodiscard]] bool begins_edge(ChainPlace place) const {
    const VertexChain& chain = fine_->chains[place.chain];
    return chain.is_closed || place.position + 1 < chain.vertices.size();
  }
  [[nodiscard]] bool may_drop(std::uint32_t vertex) const;
  /// visit(place) for all chosen vertices with an edge to the next one.
  template <class Visit>
  void for_each_edge(Visit&& visit) const {
    for (std::uint32_t c = 0; c < fine_->chains.size(); ++c)
      for (std::uint32_t k = 0; k < fine_->chains[c].vertices.size(); ++k)
        if (has(fine_->chains[c].vertices[k]) && begins_edge({c, k})) visit(ChainPlace{c, k});
  }
  [[nodiscard]] const ChainedMesh& fine() const { return *fine_; }
  [[nodiscard]] double boundary_distance() const;

 private:
  struct SlotState {
    std::uint8_t boundary_sides = 0;  ///< Bit i: side i is on the simplified boundary.
    bool is_fresh = false;            ///< Made since the last `settle`.
    double quality = 0;
    double cost = 0, area = 0;  ///< As counted in the sums.
  };

  [[nodiscard]] double edge_cost(std::uint32_t chain, std::uint32_t from, std::uint32_t to) const;
  void link(std::uint32_t vertex);
  void unlink(std::uint32_t vertex);
  void apply(std::optional<std::uint32_t> out, std::optional<std::uint32_t> in);
  void insert(std::uint32_t vertex);
  void remove(std::uint32_t vertex);
  void take_changes();
  /// Regions and costs of what `apply` made; false if an invariant is broken.
  bool settle();
  bool spread_regions(const std::vector<Slot>& fresh);
  [[nodiscard]] bool is_sound(Slot slot) const;
  void refresh_edge(std::uint32_t a, std::uint32_t b);
  void mark_sides(Slot slot);
  /// The region to the left of the boundary edge from a to b; nothing if that is no boundary edge.
  [[nodiscard]] std::optional<int> boundary_region(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] std::array<std::uint32_t, 2> side(Slot slot, std::size_t i) const {
    const auto& c = triangulation_.triangle(slot).corners;
    return {c[(i + 1) % 3], c[(i + 2) % 3]};
  }
  void measure(Slot slot);
  [[nodiscard]] double cost_of(double quality) const;

  const ChainedMesh* fine_;
  EditableTriangulation triangulation_;
  std::vector<std::vector<std::uint32_t>> next_, previous_;
  std::vector<std::size_t> n_chosen_;
  std::size_t n_vertices_ = 0, n_boundary_edges_ = 0, n_sides_ = 0;
  std::vector<int> region_;
  std::vector<SlotState> state_;
  std::vector<double> area_;
  ShapeCost cost_;
  double cost_change_ = 0, area_change_before_ = 0;
  Slot recent_ = 0;  ///< Near the last change: where the next search begins.
  std::vector<Slot> destroyed_, created_, fresh_, refreshed_;
  std::vector<std::array<std::uint32_t, 2>> changed_edges_;
};

}  // namespace voropack
