// The two balls of Theorem 2.4: around a cell, and inside of it.
#pragma once

#include <span>

#include "voropack/vec.h"

namespace voropack {

template <int D>
struct Ball {
  Vec<D> center;
  double radius = 0;
};

/// The smallest ball that contains all points, to a relative 1e-9. Expected O(n). `points` is not empty.
template <int D>
Ball<D> smallest_enclosing_ball(std::span<const Vec<D>> points);

/// {x : normal.x <= offset}, |normal| = 1.
template <int D>
struct HalfSpace {
  Vec<D> normal;
  double offset = 0;
};

/// The largest ball in the intersection of half-spaces that all contain the origin, to 1e-9 of `size`, a bound of the
/// intersection's extent. A ball in the intersection in any case; radius <= 0 if it has no interior.
template <int D>
Ball<D> largest_inscribed_ball(std::span<const HalfSpace<D>> half_spaces, double size);

}  // namespace voropack
