// Barycentric coordinates in a simplex.
#pragma once

#include <array>

#include "voropack/vec.h"

namespace voropack {

/// Points are inside of a simplex down to this barycentric coordinate: no gaps between neighbors.
inline constexpr double kInsideSlack = 1e-9;

/// Gradients of the hat functions of corners 1 .. D: the rows of the inverse of the matrix of the edges from corner 0.
/// Not finite where the simplex is flat.
inline std::array<Vec<2>, 2> hat_gradients(const std::array<Vec<2>, 3>& x) {
  const Vec<2> e = x[1] - x[0], f = x[2] - x[0];
  const double det = cross(e, f);
  return {Vec<2>{f[1], -f[0]} / det, Vec<2>{-e[1], e[0]} / det};
}
inline std::array<Vec<3>, 3> hat_gradients(const std::array<Vec<3>, 4>& x) {
  const Vec<3> e = x[1] - x[0], f = x[2] - x[0], g = x[3] - x[0];
  const double det = dot(e, cross(f, g));
  return {cross(f, g) / det, cross(g, e) / det, cross(e, f) / det};
}

}  // namespace voropack
