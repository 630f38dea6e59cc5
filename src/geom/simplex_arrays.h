// The arrays of BowyerWatson: points, simplices and what is known of them, as its insertions see them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "geom/delaunay_kernel.h"
#include "geom/filtered_predicates.h"
#include "voropack/vec.h"

namespace voropack {

/// Vertices have numbers of their own here, along a Hilbert curve in each batch, so that neighbors are near to each
/// other in memory. Number 0 is the vertex at infinity.
template <int K>
struct SimplexArrays {
  using Slot = std::uint32_t;
  using Corners = std::array<std::uint32_t, K + 1>;

  static constexpr std::uint32_t kInfinite = 0;
  static constexpr std::uint32_t kEmpty = 0xffffffffU;  ///< Corner 0 of an empty slot, and no slot.

  // A neighbor is (slot << kFaceBits) | (the number of the shared face in that slot).
  static constexpr unsigned kFaceBits = 2;
  static constexpr std::uint32_t kFaceMask = 3;
  static constexpr std::uint32_t kMaxSlots = 1U << 30U;

  // The state of a slot is (round << 2) | (in conflict << 1) | (created since take_created), where the first two tell
  // when the slot was last tested for conflict and the outcome. The last is only kept below first_new_slot.
  static constexpr std::uint32_t kCreatedBit = 1;
  static constexpr std::uint32_t kConflictBit = 2;
  static constexpr unsigned kRoundShift = 2;

  struct Simplex {
    Corners corner{kEmpty};
    Corners neighbor{};
  };

  /// Makes empty slots up to n.
  void grow(std::size_t n) {
    simplices.resize(n);
    state.resize(n, 0);
  }

  void join(std::uint32_t code_a, std::uint32_t code_b) {
    simplices[code_a >> kFaceBits].neighbor[code_a & kFaceMask] = code_b;
    simplices[code_b >> kFaceBits].neighbor[code_b & kFaceMask] = code_a;
  }

  /// Makes a simplex with the given corners, positively oriented, and the faces of its hull. Returns its slot.
  Slot make_first(const Corners& corner) {
    // Slot 0 is the simplex, slot 1 + i the face of the hull opposite to its corner i.
    grow(K + 2);
    simplices[0].corner = corner;
    for (std::size_t i = 0; i <= K; ++i) {
      // A point beyond face i in place of corner i turns the orientation around; one swap turns it back.
      Corners& face = simplices[1 + i].corner;
      face = corner;
      face[i] = kInfinite;
      if (i == 0)
        std::swap(face[K - 1], face[K]);
      else
        std::swap(face[0], face[i]);
      vertex_slot[corner[i]] = 0;
    }
    vertex_slot[kInfinite] = 1;

    // Together they are the boundary of a simplex of dimension K + 1: each lacks one vertex, and any two are neighbors.
    const auto code = [&](Slot slot, Slot lacked_by) {
      const std::uint32_t lacked = lacked_by == 0 ? kInfinite : corner[lacked_by - 1];
      const Corners& c = simplices[slot].corner;
      return slot << kFaceBits | static_cast<std::uint32_t>(std::find(c.begin(), c.end(), lacked) - c.begin());
    };
    for (Slot a = 0; a < K + 2; ++a)
      for (Slot b = 0; b < a; ++b) join(code(a, b), code(b, a));
    return 0;
  }

  // These three by number, so of size n_vertices + 1.
  std::vector<Vec<K>> points{1};                       ///< Position.
  std::vector<Slot> vertex_slot{kEmpty};               ///< A slot with the vertex, if inserted; else kEmpty.
  std::vector<std::uint32_t> vertex{kInfiniteVertex};  ///< The vertex with the number.

  std::vector<Simplex> simplices;    ///< [n_slots]
  std::vector<std::uint32_t> state;  ///< [n_slots]
  Slot first_new_slot = 0;           ///< n_slots at the last take_created.
  FilteredPredicates<K> predicates;  ///< Their box holds all points.
};

}  // namespace voropack
