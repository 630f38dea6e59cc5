// The gradients of the hat functions of a simplex.
#pragma once

#include <array>

#include "geom/circumcenter.h"
#include "voropack/mesh.h"

namespace voropack {

template <int D>
std::array<Vec<D>, D + 1> corner_positions(const Mesh<D>& mesh, SimplexId s) {
  std::array<Vec<D>, D + 1> p;
  for (std::size_t i = 0; i <= D; ++i) p[i] = mesh.points[mesh.simplex_vertices[s][i]];
  return p;
}

/// Hat function i of a simplex has the gradient normal[i] / determinant. Both are accurate however flat the simplex.
template <int D>
struct P1Gradients {
  std::array<Vec<D>, D + 1> normal;  ///< Into the simplex, (D-1)! times the area of the face opposite to corner i.
  double determinant;                ///< D! times the volume.
};

template <int D>
P1Gradients<D> p1_gradients(const std::array<Vec<D>, D + 1>& p) {
  P1Gradients<D> g;
  if constexpr (D == 2) {
    const Vec<2> u = p[1] - p[0], v = p[2] - p[0];
    g.normal[1] = {v[1], -v[0]};
    g.normal[2] = {-u[1], u[0]};
  } else {
    const Vec<3> u = p[1] - p[0], v = p[2] - p[0], w = p[3] - p[0];
    g.normal[1] = cross(v, w);
    g.normal[2] = cross(w, u);
    g.normal[3] = cross(u, v);
  }
  // The hat functions sum to one, so their gradients sum to zero.
  g.normal[0] = Vec<D>{};
  for (std::size_t i = 1; i <= D; ++i) g.normal[0] -= g.normal[i];
  g.determinant = simplex_determinant<D>(p);
  return g;
}

/// D!: a simplex's determinant over its volume.
template <int D>
inline constexpr double kFactorial = D == 2 ? 2 : 6;

}  // namespace voropack
