// An incremental Delaunay triangulation behind a narrow interface: points in, arrays of simplices and neighbors out.
//
// Two kernels implement it: CGAL's (CgalDelaunay, the reference) and our own (BowyerWatson, see its header). Both break
// ties between cospherical points by the same symbolic perturbation (Devillers and Teillaud, SODA 2003), which depends
// on the coordinates alone, so the same set of points gives the same set of simplices in any order of insertion, and no
// simplex is ever flat.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// The vertex at infinity, which closes the hull: a simplex with this vertex is not a simplex but a face of the hull.
inline constexpr std::uint32_t kInfiniteVertex = 0xfffffffeU;
/// "No vertex to start from".
inline constexpr std::uint32_t kNoHint = 0xffffffffU;

/// Simplices live in numbered slots. A slot keeps its simplex until an insertion destroys it; the slot may then be used
/// again.
template <int K>
class CgalDelaunay {
 public:
  using Slot = std::uint32_t;
  using Corners = std::array<std::uint32_t, K + 1>;

  CgalDelaunay();
  ~CgalDelaunay();
  CgalDelaunay(CgalDelaunay&&) noexcept;
  CgalDelaunay& operator=(CgalDelaunay&&) noexcept;

  /// Inserts points, all different from each other and from the earlier ones; point i becomes vertex n_vertices() + i.
  /// The order of insertion is a Hilbert curve's. The first call must bring K + 1 points that do not lie in a
  /// hyperplane. `hints[i]`, if given, is a vertex near points[i].
  void insert(std::span<const Vec<K>> points, std::span<const std::uint32_t> hints = {});

  [[nodiscard]] std::uint32_t n_vertices() const;
  /// Slots are 0 .. n_slots() - 1; some may be empty.
  [[nodiscard]] std::uint32_t n_slots() const;
  /// False for an empty slot and for a simplex with the vertex at infinity.
  [[nodiscard]] bool is_finite(Slot slot) const;
  /// False for an empty slot.
  [[nodiscard]] bool is_alive(Slot slot) const;
  /// Positively oriented corners; for a simplex at infinity one of them is kInfiniteVertex.
  [[nodiscard]] Corners corners(Slot slot) const;
  /// Entry i is the slot that shares the face opposite to corner i.
  [[nodiscard]] Corners neighbors(Slot slot) const;
  /// Some slot that has the vertex as a corner.
  [[nodiscard]] Slot slot_of_vertex(std::uint32_t vertex) const;
  /// The slots that hold simplices made by insertions since the last call (each once, alive, ascending).
  std::vector<Slot> take_created();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voropack
