// Our own incremental Delaunay triangulation: the algorithm of Bowyer and Watson (both 1981) with exact predicates.
//
// It gives the same set of simplices as CgalDelaunay, degenerate input included, and has the same interface; see
// delaunay_kernel.h. The data structure and the ways to save time are those of geogram's delaunay_3d (Levy) and of
// HXT (Marot, Pellerin, Remacle, One machine, one minute, three billion tetrahedra, 2018).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geom/delaunay_kernel.h"
#include "geom/simplex_arrays.h"
#include "geom/vertex_inserter.h"
#include "voropack/vec.h"

namespace voropack {

/// Invariants between calls:
///  1. The live simplices, those with the vertex at infinity included, form a triangulated K-sphere; `neighbor` is
///     mutual.
///  2. Finite simplices are positively oriented. A simplex at infinity has its infinite vertex at corner 0 and would be
///     positively oriented if that vertex were a point beyond the hull's face.
///  3. No vertex is inside the perturbed circumball of a finite simplex.
template <int K>
class BowyerWatson {
 public:
  using Slot = std::uint32_t;
  using Corners = std::array<std::uint32_t, K + 1>;

  /// Inserts points, all different from each other and from the earlier ones; point i becomes vertex n_vertices() + i.
  /// The first call must bring K + 1 points that do not lie in a hyperplane. `hints[i]`, if given, is a vertex near
  /// points[i]; the same calls give the same slots.
  ///
  /// Cost: expected O(n) for points spread evenly, 0.3 kB per vertex in 3D.
  /// Throws: InputError delaunay.degenerate if the first points lie in a hyperplane; nothing is inserted.
  ///         InputError delaunay.not_finite if a coordinate is infinite or not a number; nothing is inserted.
  ///         InputError delaunay.duplicate_points for identical points; only some points are inserted then, and the
  ///         triangulation can only be destroyed.
  ///         LimitError delaunay.too_many_simplices beyond 2^30 slots; likewise.
  void insert(std::span<const Vec<K>> points, std::span<const std::uint32_t> hints = {});

  [[nodiscard]] std::uint32_t n_vertices() const { return static_cast<std::uint32_t>(number_.size()); }
  /// Slots are 0 .. n_slots() - 1; some may be empty.
  [[nodiscard]] std::uint32_t n_slots() const { return static_cast<std::uint32_t>(arrays_.simplices.size()); }
  /// False for an empty slot and for a simplex with the vertex at infinity.
  [[nodiscard]] bool is_finite(Slot slot) const { return arrays_.simplices[slot].corner[0] - 1 < Arrays::kEmpty - 1; }
  /// False for an empty slot.
  [[nodiscard]] bool is_alive(Slot slot) const { return arrays_.simplices[slot].corner[0] != Arrays::kEmpty; }
  /// Positively oriented corners; for a simplex at infinity one of them is kInfiniteVertex.
  [[nodiscard]] Corners corners(Slot slot) const {
    Corners out = arrays_.simplices[slot].corner;
    for (std::uint32_t& v : out) v = arrays_.vertex[v];
    return out;
  }
  /// Entry i is the slot that shares the face opposite to corner i.
  [[nodiscard]] Corners neighbors(Slot slot) const {
    Corners out = arrays_.simplices[slot].neighbor;
    for (std::uint32_t& n : out) n >>= Arrays::kFaceBits;
    return out;
  }
  /// Some slot that has the vertex as a corner.
  [[nodiscard]] Slot slot_of_vertex(std::uint32_t vertex) const { return arrays_.vertex_slot[number_[vertex]]; }
  /// The slots that hold simplices made by insertions since the last call (each once, alive, ascending).
  std::vector<Slot> take_created();
  /// How many vertices were inserted several at a time.
  [[nodiscard]] std::size_t n_inserted_in_parallel() const { return n_parallel_; }

 private:
  using Arrays = SimplexArrays<K>;

  void append_points(std::span<const Vec<K>> points, const std::vector<std::uint32_t>& order);
  void check_finite(std::span<const Vec<K>> points) const;
  void reserve_for(std::size_t n_points);
  void make_first_simplex(std::vector<std::uint32_t>& order);
  void insert_rounds(std::span<const std::uint32_t> schedule);

  Arrays arrays_;
  InsertionState<K> insertion_;        ///< Of the insertions one after the other.
  std::vector<std::uint32_t> number_;  ///< [n_vertices] The number of the vertex in the arrays.
  Box<K> box_;                         ///< Of all points.
  std::size_t n_parallel_ = 0;
};

}  // namespace voropack
