// The connected components of space between walls.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geom/aabb_tree.h"
#include "voropack/vec.h"

namespace voropack::domain_impl {

/// Walls as simplices: segments in 2D, positively oriented triangles in 3D. Side 0 of a segment is to its left, of a
/// triangle where its corners turn counterclockwise.
template <int D>
struct Walls {
  std::vector<Vec<D>> points;
  std::vector<std::array<std::uint32_t, D>> simplices;
  std::vector<std::uint32_t> simplex_wall;
  std::size_t n_walls = 0;
};

/// One wall at a ridge: a point (2D) or a segment (3D) at which walls end. A wall on both sides of a ridge has two.
struct Fin {
  std::uint32_t ridge = 0, wall = 0;
  /// The side that a counterclockwise turn about the ridge enters first. 3D: about the direction of the segment.
  std::uint8_t ccw_side = 0;
  /// A point in the wall's plane off the ridge's line; in 3D `opposite` tells that the wall is on the line's other
  /// side.
  std::uint32_t apex = 0;
  bool opposite = false;
};

/// Fins grouped by ridge and sorted counterclockwise around it. `ridges` are the ends of segments in 3D; a point twice
/// in 2D.
template <int D>
void sort_fins(const std::vector<Vec<D>>& points, const std::vector<std::array<std::uint32_t, 2>>& ridges,
               std::vector<Fin>& fins);

/// What lies between the walls. Volume `kOutside` is the unbounded one.
template <int D>
class Volumes {
 public:
  static constexpr std::uint32_t kOutside = 0xffffffffU;

  /// `fins` as sort_fins leaves them. The walls must not cross. O(n log n) plus one ray for each shell.
  Volumes(const Walls<D>& walls, const std::vector<Fin>& fins);

  [[nodiscard]] std::size_t size() const { return measure_.size(); }
  /// The volume on a side of a wall.
  [[nodiscard]] std::uint32_t at(std::size_t wall, int side) const {
    return side_volume_[2 * wall + static_cast<std::size_t>(side)];
  }
  [[nodiscard]] double measure(std::uint32_t volume) const { return static_cast<double>(measure_[volume]); }
  /// The volume that holds x; none if x is on a wall.
  [[nodiscard]] std::optional<std::uint32_t> locate(const Vec<D>& x) const;

 private:
  struct Crossing {
    double at = 0;  ///< 0 at the start, 1 at the end of the ray.
    std::uint32_t wall = 0;
    int far_side = 0;
  };

  /// Sides that are joined around ridges: a closed surface that faces one volume.
  struct Shell {
    long double measure = 0;  ///< Signed: positive if the shell is the outer boundary of a volume.
    std::uint32_t largest = kOutside;
    double largest_size = 0;
  };

  std::vector<std::uint32_t> join_at_ridges(const std::vector<Fin>& fins) const;
  std::vector<Shell> measure_shells(const std::vector<std::uint32_t>& side_shell, std::size_t n_shells) const;
  /// All crossings of a generic line through a simplex, from outside to outside.
  std::vector<Crossing> line_through(std::uint32_t simplex, std::uint64_t salt) const;
  void join_nested(const std::vector<std::uint32_t>& side_shell, std::size_t n_shells);
  /// All crossings of the segment pq, sorted; nothing if it touches an edge or starts on a wall.
  std::optional<std::vector<Crossing>> crossings(const Vec<D>& p, const Vec<D>& q) const;
  [[nodiscard]] Vec<D> direction(std::uint64_t salt, std::uint64_t attempt) const;

  Walls<D> walls_;
  Box<D> box_;
  AabbTree<D> tree_;
  std::vector<std::uint32_t> side_volume_;  ///< [2 * n_walls]
  std::vector<long double> measure_;
};

}  // namespace voropack::domain_impl
