// Where a point is: which region of a set of walls holds it, whether a box meets a wall, how far the nearest wall is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geom/box_tree.h"
#include "voropack/vec.h"

namespace voropack {

/// (K-1)-simplices in R^K that separate regions. Side 0 is where the normal points: to the left of a -> b in the plane,
/// along (b-a) x (c-a) in space.
template <int K>
struct Walls {
  static constexpr int kOutside = -1;
  std::vector<std::array<Vec<K>, K>> simplices;
  std::vector<std::array<int, 2>> regions;  ///< By wall: region on side 0 and on side 1; kOutside for none.
};

/// A bounding-volume hierarchy over walls. Immutable; safe to use from many threads.
template <int K>
class WallLocator {
 public:
  explicit WallLocator(Walls<K> walls);

  [[nodiscard]] bool empty() const { return walls_.simplices.empty(); }
  /// The region that holds x, by the nearest wall on a ray in a generic direction; another direction is tried when the
  /// ray passes within rounding of a wall's border. x must not lie on a wall.
  [[nodiscard]] int region(const Vec<K>& x) const;
  /// False only if no wall meets the box.
  [[nodiscard]] bool touches(const Box<K>& box) const;
  /// True if some wall is nearer to x than `distance`.
  [[nodiscard]] bool is_near(const Vec<K>& x, double distance) const;

 private:
  enum class Ray : std::uint8_t { kMiss, kHit, kUnclear };

  Ray cast(const Vec<K>& x, const Vec<K>& direction, int& region) const;
  Ray hit(std::uint32_t wall, const Vec<K>& x, const Vec<K>& direction, double& t, int& side) const;

  Walls<K> walls_;
  BoxTree<K> tree_;
};

}  // namespace voropack
