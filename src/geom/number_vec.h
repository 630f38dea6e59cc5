// Vectors over double, Dd or Expansion, so that a polynomial of the coordinates is written once and evaluated with
// rounding, in double-double, or exactly.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "geom/dd.h"
#include "geom/expansion.h"
#include "voropack/vec.h"

namespace voropack {

template <class S, std::size_t D>
using NumberVec = std::array<S, D>;

/// p - q; exact for Dd and Expansion.
template <class S, int D>
NumberVec<S, D> difference(const Vec<D>& p, const Vec<D>& q) {
  NumberVec<S, D> r;
  for (int k = 0; k < D; ++k) {
    if constexpr (std::is_same_v<S, double>) {
      r[static_cast<std::size_t>(k)] = p[k] - q[k];
    } else {
      r[static_cast<std::size_t>(k)] = S(two_diff(p[k], q[k]));
    }
  }
  return r;
}

/// The same for points that are given as numbers themselves.
template <class S, std::size_t D>
NumberVec<S, D> difference(const NumberVec<S, D>& p, const NumberVec<S, D>& q) {
  NumberVec<S, D> r;
  for (std::size_t k = 0; k < D; ++k) r[k] = p[k] - q[k];
  return r;
}

template <class S>
S dot(const NumberVec<S, 2>& a, const NumberVec<S, 2>& b) {
  return a[0] * b[0] + a[1] * b[1];
}
template <class S>
S dot(const NumberVec<S, 3>& a, const NumberVec<S, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class S>
S cross(const NumberVec<S, 2>& a, const NumberVec<S, 2>& b) {
  return a[0] * b[1] - a[1] * b[0];
}
template <class S>
NumberVec<S, 3> cross(const NumberVec<S, 3>& a, const NumberVec<S, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A power of two that brings the differences of the points from `origin` to about 1, so that polynomials of them
/// neither overflow nor underflow.
template <class Points, int D>
double unit_scale(const Points& points, const Vec<D>& origin) {
  double largest = 0;
  for (const Vec<D>& p : points)
    for (int k = 0; k < D; ++k) largest = std::max(largest, std::abs(p[k] - origin[k]));
  int exponent = 0;
  if (largest > 0 && std::isfinite(largest)) std::frexp(largest, &exponent);
  return std::ldexp(1.0, -exponent);
}

}  // namespace voropack
