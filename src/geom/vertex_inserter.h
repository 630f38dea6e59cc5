// One insertion into a Delaunay triangulation: find the simplices in conflict with the new vertex, replace them by the
// cone over their border [Bowyer 1981, Watson 1981].
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "geom/simplex_arrays.h"
#include "geom/slot_pool.h"
#include "voropack/vec.h"

namespace voropack {

/// What a sequence of insertions keeps from one to the next.
template <int K>
struct InsertionState {
  using Slot = std::uint32_t;
  using Corners = std::array<std::uint32_t, K + 1>;

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

  std::uint32_t round = 0;                    ///< Attempts so far; those of parallel sequences are disjoint.
  Slot last_slot = SimplexArrays<K>::kEmpty;  ///< A slot that the last insertion filled.
  SlotPool free_slots;                        ///< Empty slots.
  std::vector<Slot> recreated;                ///< Slots below first_new_slot that were filled since take_created.
  std::uint32_t infinite_entry = 0;           ///< Instead of vertex_slot of the infinite vertex.

  // Scratch of one insertion, kept to save allocations. The first two are only longer than needed.
  std::vector<std::uint32_t> conflict = std::vector<std::uint32_t>(64);  ///< [n_conflicts] slot and face of entry.
  std::vector<CavityFace> faces = std::vector<CavityFace>(64);           ///< [n_faces] boundary of the cavity.
  std::size_t n_conflicts = 0;
  std::size_t n_faces = 0;
  std::vector<NewSimplex> created;                                 ///< [n_faces]
  std::vector<std::pair<std::uint32_t, Slot>> local_vertices;      ///< Vertices of the cavity by local number.
  std::vector<std::uint32_t> edge_table;                           ///< Local numbers of an edge's ends -> neighbor.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> edge_list;  ///< The same for cavities too large for a table.
};

/// The territory of an insertion that is alone: it may change every simplex.
struct WholeTriangulation {};

/// The territory of one of several insertions at a time: the simplices whose finite corners are all in one part.
struct PartOfTriangulation {
  const std::uint8_t* part;  ///< By number: the part of the vertex.
  std::uint8_t own;
};

/// Inserts vertices one after the other. In a PartOfTriangulation it reads and writes nothing that an inserter for
/// another part writes; parallel_insertion.h says why.
template <int K, class Territory>
class VertexInserter {
 public:
  using Arrays = SimplexArrays<K>;
  using Slot = typename Arrays::Slot;
  using Corners = typename Arrays::Corners;

  VertexInserter(Arrays& arrays, InsertionState<K>& state, Territory territory = {})
      : a_(arrays), s_(state), territory_(territory) {}

  /// Inserts the vertex with a number by a walk from `start`, a slot that has a corner in the territory.
  ///
  /// In a part of the triangulation, returns false and changes nothing if the walk or the cavity leaves the territory,
  /// if there are too few free slots, or if the point is there already. In the whole, returns true or throws the errors
  /// of BowyerWatson::insert.
  bool insert(std::uint32_t vertex, Slot start);

 private:
  static constexpr bool kWhole = std::is_same_v<Territory, WholeTriangulation>;
  static constexpr unsigned kFaceBits = Arrays::kFaceBits;
  static constexpr std::uint32_t kInfinite = Arrays::kInfinite;
  static constexpr std::uint32_t kEmpty = Arrays::kEmpty;
  // While a cavity is filled, vertex_slot of its vertices is kLocalBit | (a number from 0 within the cavity).
  static constexpr std::uint32_t kLocalBit = 1U << 31U;
  using Simplex = typename Arrays::Simplex;
  using NewSimplex = typename InsertionState<K>::NewSimplex;

  [[nodiscard]] bool owns(const Simplex& s) const;
  [[nodiscard]] int orientation_with(const Simplex& s, int corner, const Vec<K>& p) const;
  [[nodiscard]] int in_circumball(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] bool in_perturbed_circumball(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] bool in_conflict(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] bool in_conflict_beyond(const Simplex& s, const Vec<K>& p) const;
  [[nodiscard]] Slot locate(const Vec<K>& p, Slot start) const;
  [[nodiscard]] std::uint32_t find_equal(std::uint32_t vertex, Slot slot) const;
  [[noreturn]] void throw_duplicate(std::uint32_t a, std::uint32_t b) const;
  void prefetch_neighbors(Slot slot) const;
  bool find_cavity(Vec<K> p, Slot start);
  Slot new_slot();
  void list_new_simplices(std::uint32_t vertex);
  void store_new_simplices();
  void link_triangles() requires(K == 2);
  void link_tetrahedra() requires(K == 3);
  void link_by_table() requires(K == 3);
  void link_by_sorting() requires(K == 3);
  std::uint32_t& slot_entry(std::uint32_t vertex);

  Arrays& a_;
  InsertionState<K>& s_;
  Territory territory_;
};

}  // namespace voropack
