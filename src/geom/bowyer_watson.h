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
#include "geom/filtered_predicates.h"
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
  [[nodiscard]] std::uint32_t n_slots() const { return static_cast<std::uint32_t>(simplices_.size()); }
  /// False for an empty slot and for a simplex with the vertex at infinity.
  [[nodiscard]] bool is_finite(Slot slot) const { return simplices_[slot].corner[0] - 1 < kEmpty - 1; }
  /// False for an empty slot.
  [[nodiscard]] bool is_alive(Slot slot) const { return simplices_[slot].corner[0] != kEmpty; }
  /// Positively oriented corners; for a simplex at infinity one of them is kInfiniteVertex.
  [[nodiscard]] Corners corners(Slot slot) const {
    Corners out = simplices_[slot].corner;
    for (std::uint32_t& v : out) v = vertex_[v];
    return out;
  }
  /// Entry i is the slot that shares the face opposite to corner i.
  [[nodiscard]] Corners neighbors(Slot slot) const {
    Corners out = simplices_[slot].neighbor;
    for (std::uint32_t& n : out) n >>= kFaceBits;
    return out;
  }
  /// Some slot that has the vertex as a corner.
  [[nodiscard]] Slot slot_of_vertex(std::uint32_t vertex) const { return vertex_slot_[number_[vertex]]; }
  /// The slots that hold simplices made by insertions since the last call (each once, alive, ascending).
  std::vector<Slot> take_created();

 private:
  // Inside, vertices have numbers of their own, along a Hilbert curve in each batch, so that neighbors are near to each
  // other in memory. Number 0 is the vertex at infinity.
  static constexpr std::uint32_t kInfinite = 0;
  static constexpr std::uint32_t kEmpty = 0xffffffffU;  ///< Corner 0 of an empty slot.

  // A neighbor is (slot << kFaceBits) | (the number of the shared face in that slot).
  static constexpr unsigned kFaceBits = 2;
  static constexpr std::uint32_t kFaceMask = 3;
  static constexpr std::uint32_t kMaxSlots = 1U << 30U;

  // The state of a slot is (round << 2) | (in conflict << 1) | (created since take_created), where the first two tell
  // when the slot was last tested for conflict and the outcome. The last is only kept below first_new_slot_.
  static constexpr std::uint32_t kCreatedBit = 1;
  static constexpr std::uint32_t kConflictBit = 2;
  static constexpr unsigned kRoundShift = 2;

  // While a cavity is filled, vertex_slot_ of its vertices is kLocalBit | (a number from 0 within the cavity).
  static constexpr std::uint32_t kLocalBit = 1U << 31U;

  struct Simplex {
    Corners corner;
    Corners neighbor;
  };

  /// A face of the cavity joined to the new vertex.
  struct NewSimplex {
    Corners corner;                      ///< Positively oriented.
    std::uint32_t apex;                  ///< Which corner is the new vertex.
    std::uint32_t outside;               ///< The neighbor beyond the face.
    Slot slot;                           ///< Where it will be.
    std::array<std::uint32_t, 3> local;  ///< 3D: corners 0 to 2 by their numbers within the cavity.
  };

  /// A face between the cavity and the rest, seen from both sides.
  struct CavityFace {
    std::uint32_t inside;
    std::uint32_t outside;
  };

  void append_points(std::span<const Vec<K>> points, const std::vector<std::uint32_t>& order);
  void check_finite(std::span<const Vec<K>> points) const;
  void reserve_for(std::size_t n_points);
  void make_first_simplex(std::vector<std::uint32_t>& order);
  void insert_vertex(std::uint32_t vertex, Slot start);
  [[nodiscard]] Slot locate(const Vec<K>& p, Slot start) const;
  void check_new(std::uint32_t vertex, Slot slot) const;
  [[nodiscard]] int orientation_with(const Simplex& s, int corner, const Vec<K>& p) const;
  [[nodiscard]] int in_circumball(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] bool in_perturbed_circumball(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] bool in_conflict(const Simplex& s, const Vec<K>& p) const;
  void prefetch_neighbors(Slot slot) const;
  void find_cavity(Vec<K> p, Slot start);
  void list_new_simplices(std::uint32_t vertex);
  void store_new_simplices();
  void link_new_simplices();
  void link_by_table();
  void link_by_sorting();
  Slot new_slot();
  void join(std::uint32_t code_a, std::uint32_t code_b);

  // These three by number, so of size n_vertices + 1.
  std::vector<Vec<K>> points_{1};                       ///< Position.
  std::vector<Slot> vertex_slot_{kEmpty};               ///< A slot with the vertex; kEmpty before its insertion.
  std::vector<std::uint32_t> vertex_{kInfiniteVertex};  ///< The vertex with the number.
  std::vector<std::uint32_t> number_;                   ///< [n_vertices] The number of the vertex.
  std::vector<Simplex> simplices_;                      ///< [n_slots]
  std::vector<std::uint32_t> state_;                    ///< [n_slots]
  std::vector<Slot> free_slots_;                        ///< Empty slots.
  std::uint32_t round_ = 0;                             ///< The number of insertions so far.
  Slot last_slot_ = 0;                                  ///< A slot that the last insertion filled.
  Slot first_new_slot_ = 0;                             ///< n_slots() at the last take_created.
  std::vector<Slot> recreated_;                         ///< Slots below first_new_slot_ that were filled since then.
  Box<K> box_;                                          ///< Of all points.
  FilteredPredicates<K> predicates_;

  // Scratch of one insertion, kept to save allocations. The first two are only longer than needed.
  std::vector<std::uint32_t> conflict_ = std::vector<std::uint32_t>(64);  ///< [n_conflicts_] slot and face of entry.
  std::vector<CavityFace> faces_ = std::vector<CavityFace>(64);           ///< [n_faces_] boundary of the cavity.
  std::size_t n_conflicts_ = 0;
  std::size_t n_faces_ = 0;
  std::vector<NewSimplex> new_;                                     ///< [n_faces_]
  std::vector<std::pair<std::uint32_t, Slot>> local_vertices_;      ///< Vertices of the cavity by local number.
  std::vector<std::uint32_t> edge_table_;                           ///< Local numbers of an edge's ends -> neighbor.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> edge_list_;  ///< The same for cavities too large for a table.
};

}  // namespace voropack
