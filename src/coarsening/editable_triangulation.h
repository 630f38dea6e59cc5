// A Delaunay triangulation in the plane whose vertices come and go.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// The Delaunay triangulation of some of `points` and of the four corners of a box around all of them, ten times as
/// large. The corners stand for infinity: they never reach into the ball of an edge between two points, so that inside
/// a boundary whose diametral balls are empty the triangulation is that of the points alone.
///
/// Triangles live in numbered slots, which are used again. Every change lists the slots that it emptied and filled.
class EditableTriangulation {
 public:
  using Slot = std::uint32_t;
  static constexpr Slot kNoSlot = 0xffffffffU;
  struct Triangle {
    std::array<std::uint32_t, 3> corners;  ///< Counterclockwise.
    std::array<Slot, 3> neighbors;         ///< Entry i is opposite to corner i; kNoSlot at the box.
  };

  /// Starts with no point. `points` must outlive this.
  explicit EditableTriangulation(std::span<const Vec<2>> points);

  [[nodiscard]] bool has(std::uint32_t vertex) const { return slot_of_[vertex] != kNoSlot; }
  [[nodiscard]] bool is_box(std::uint32_t vertex) const { return vertex >= points_.size(); }
  [[nodiscard]] const Vec<2>& point(std::uint32_t vertex) const {
    return is_box(vertex) ? box_[vertex - points_.size()] : points_[vertex];
  }
  [[nodiscard]] std::uint32_t n_slots() const { return static_cast<std::uint32_t>(triangles_.size()); }
  [[nodiscard]] bool is_alive(Slot slot) const { return triangles_[slot].corners[0] != kEmpty; }
  [[nodiscard]] const Triangle& triangle(Slot slot) const { return triangles_[slot]; }
  /// Some triangle with this corner.
  [[nodiscard]] Slot slot_of(std::uint32_t vertex) const { return slot_of_[vertex]; }
  /// The slot to the left of the edge from a to b, or kNoSlot if there is no such edge. Both are in the triangulation.
  [[nodiscard]] Slot left_of(std::uint32_t a, std::uint32_t b) const;

  /// visit(slot, i) for the triangles around a vertex, counterclockwise; i is the vertex's place among the corners.
  template <class Visit>
  void around(std::uint32_t vertex, Visit&& visit) const {
    const Slot first = slot_of_[vertex];
    Slot slot = first;
    do {
      const std::size_t i = place_of(slot, vertex);
      const Slot next = triangles_[slot].neighbors[(i + 1) % 3];
      visit(slot, i);
      slot = next;
    } while (slot != first && slot != kNoSlot);
  }

  /// The triangle that holds x, by a walk from `from`.
  [[nodiscard]] Slot locate(const Vec<2>& x, Slot from) const;
  /// The triangles whose open circumcircle holds x, which lies in triangle `start`: those that inserting x destroys.
  void find_cavity(const Vec<2>& x, Slot start, std::vector<Slot>& cavity) const;

  /// Adds points_[vertex], which no vertex coincides with. `near` is any slot to start the search from.
  void insert(std::uint32_t vertex, Slot near, std::vector<Slot>& destroyed, std::vector<Slot>& created);
  /// Takes a vertex away, whose neighbors are triangulated anew.
  void remove(std::uint32_t vertex, std::vector<Slot>& destroyed, std::vector<Slot>& created);

 private:
  static constexpr std::uint32_t kEmpty = 0xffffffffU;
  struct Rim {
    std::uint32_t from, to;  ///< An edge of a hole, counterclockwise around it.
    Slot outside;
  };

  [[nodiscard]] std::size_t place_of(Slot slot, std::uint32_t vertex) const {
    const auto& c = triangles_[slot].corners;
    return c[0] == vertex ? 0 : c[1] == vertex ? 1 : 2;
  }
  Slot make(const std::array<std::uint32_t, 3>& corners, std::vector<Slot>& created);
  void empty_slot(Slot slot, std::vector<Slot>& destroyed);
  /// Makes `slot` (side i) and what lies beyond edge (from, to) neighbors.
  void glue(Slot slot, std::size_t i, Slot other, std::uint32_t from, std::uint32_t to);
  [[nodiscard]] bool is_ear(const std::vector<Rim>& rim, std::size_t i) const;

  std::span<const Vec<2>> points_;
  std::array<Vec<2>, 4> box_;
  std::vector<Triangle> triangles_;
  std::vector<Slot> free_;
  std::vector<Slot> slot_of_;  ///< [points and box]
  mutable std::vector<std::uint32_t> mark_;
  mutable std::uint32_t stamp_ = 0;
  std::vector<Slot> cavity_;
  std::vector<Rim> rim_;
};

}  // namespace voropack
