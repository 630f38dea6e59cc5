// The points that cells are made of, each once, with those that coincide merged.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voropack/mesh.h"

namespace voropack {

/// Numbers of the corner points of all cells: sites on the walls, midpoints of the walls' edges, circumcenters of wall
/// faces and of simplices. A *wall* is a face where a region ends; its two sides share the points.
///
/// Points that coincide (cospherical simplices, a circumcenter on a wall, right angles of a wall) have one number, so
/// that polyhedra stay closed when edges of length zero are left out.
template <int D>
class ShapePoints {
 public:
  explicit ShapePoints(const Mesh<D>& mesh);

  [[nodiscard]] std::uint32_t site(VertexId v) const { return merged(v.value()); }
  [[nodiscard]] std::uint32_t simplex(SimplexId s) const { return merged(first_simplex_ + s.value()); }
  /// The circumcenter of the wall opposite to corner i of s; in 2D its midpoint.
  [[nodiscard]] std::uint32_t wall(SimplexId s, int i) const { return merged(wall_number(s, i)); }
  /// 3D: the midpoint of an edge of a wall.
  [[nodiscard]] std::uint32_t midpoint(VertexId a, VertexId b) const { return merged(midpoint_number(a, b)); }

  /// 3D: false if the two walls at the edge continue each other in one plane, so that it is no corner of any cell.
  [[nodiscard]] bool is_crease(VertexId a, VertexId b) const { return is_crease_[wall_edge_index(a, b)] != 0; }

  /// The walls, each from one side: that of the region with the lower id.
  struct Wall {
    SimplexId simplex;
    int corner = 0;
  };
  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }

  /// Position of every number; only numbers returned above are meant to be used.
  [[nodiscard]] const std::vector<Vec<D>>& positions() const { return positions_; }

 private:
  void list_walls(const Mesh<D>& mesh);
  void place(const Mesh<D>& mesh);
  void merge_coinciding(const Mesh<D>& mesh);
  void merge(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] std::uint32_t root(std::uint32_t p) const;
  [[nodiscard]] std::uint32_t merged(std::size_t p) const { return root(static_cast<std::uint32_t>(p)); }
  [[nodiscard]] std::uint32_t wall_number(SimplexId s, int i) const;
  [[nodiscard]] std::uint32_t midpoint_number(VertexId a, VertexId b) const;
  [[nodiscard]] std::size_t wall_edge_index(VertexId a, VertexId b) const;
  void find_creases(const Mesh<D>& mesh);

  struct Side {
    std::uint64_t key;  ///< simplex * (D + 1) + corner
    std::uint32_t wall;
  };
  std::vector<Wall> walls_;
  std::vector<Side> sides_;                          ///< Sorted by key.
  std::vector<std::array<VertexId, 2>> wall_edges_;  ///< Sorted. Empty in 2D.
  std::vector<std::uint8_t> is_crease_;              ///< [wall_edges_.size()]
  std::vector<Vec<D>> positions_;
  std::vector<std::uint32_t> parent_;  ///< Union-find; the root has the lowest number of its set.
  std::size_t first_midpoint_ = 0, first_wall_ = 0, first_simplex_ = 0;
};

}  // namespace voropack
