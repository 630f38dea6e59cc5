// Distances from points to simplices of dimension at most two, and between such simplices that do not meet.
#pragma once

#include <array>
#include <span>

#include "voropack/vec.h"

namespace voropack {

/// The distance from x to the segment ab.
template <int D>
double distance_to_segment(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b);

/// The distance from x to the triangle abc (in the plane: 0 inside).
template <int D>
double distance_to_triangle(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b, const Vec<D>& c);

/// The distance between the segments ab and cd; 0 (up to rounding) if they cross.
template <int D>
double segment_distance(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d);

/// A point, segment or triangle by its one to three corners.
template <int D>
struct SmallSimplex {
  std::array<Vec<D>, 3> corner;
  int dimension = 0;

  [[nodiscard]] Box<D> box() const {
    Box<D> result;
    for (int i = 0; i <= dimension; ++i) result.add(corner[static_cast<std::size_t>(i)]);
    return result;
  }
};

template <int D>
double distance_to_simplex(const Vec<D>& x, const SmallSimplex<D>& s);

/// The distance between two simplices that do not meet: the least over the corners of one against the other and over
/// pairs of edges.
template <int D>
double distance_between_disjoint(const SmallSimplex<D>& s, const SmallSimplex<D>& t);

/// The distance between two boxes, 0 if they overlap.
template <int D>
double box_distance(const Box<D>& a, const Box<D>& b) {
  double sum = 0;
  for (int k = 0; k < D; ++k) {
    const double gap = std::max({a.lo[k] - b.hi[k], 0.0, b.lo[k] - a.hi[k]});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

}  // namespace voropack
