// The two balls of Theorem 2.4: around a cell, and inside of it.
#pragma once

#include "quality/row_pairs.h"
#include "voropack/vec.h"

namespace voropack {

template <int D>
struct Ball {
  Vec<D> center;
  double radius = 0;
};

/// Coordinates of points.
template <int D>
using PointRows = RowPairs<D>;

/// Half-spaces {x : normal.x <= offset}: |normal| = 1, then the offset.
template <int D>
using HalfSpaceRows = RowPairs<D + 1>;

/// The smallest ball that contains all points, to a relative 1e-9. Expected O(n). `points` is not empty.
template <int D>
Ball<D> smallest_enclosing_ball(const PointRows<D>& points);

/// The largest ball in the intersection of half-spaces that all contain the origin, to 1e-9 of `size`, a bound of the
/// intersection's extent. A ball in the intersection in any case; radius <= 0 if it has no interior.
template <int D>
Ball<D> largest_inscribed_ball(const HalfSpaceRows<D>& half_spaces, double size);

}  // namespace voropack
