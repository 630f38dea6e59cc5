#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "mesh/p1_gradients.h"
#include "voropack/quality.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 4096;  // Simplices per task.

template <int D>
ShapeRatios ratios_of(const std::array<Vec<D>, D + 1>& p) {
  const double circumradius = norm(circumcenter_offset<D>(p));
  double shortest_sq = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j) shortest_sq = std::min(shortest_sq, distance_sq(p[i], p[j]));
  // The inradius is D V / (sum of the faces' areas), which is determinant / (sum of the gradients' normals).
  const P1Gradients<D> g = p1_gradients<D>(p);
  double normals = 0;
  for (const Vec<D>& n : g.normal) normals += norm(n);
  ShapeRatios ratios{circumradius / std::sqrt(shortest_sq), circumradius * normals / g.determinant};
  if (std::isnan(ratios.radius_edge)) ratios.radius_edge = std::numeric_limits<double>::infinity();
  if (!(g.determinant > 0)) ratios.radius_ratio = std::numeric_limits<double>::infinity();
  return ratios;
}

}  // namespace

template <int D>
ShapeRatios max_shape_ratios(const Mesh<D>& mesh) {
  const auto larger = [](const ShapeRatios& a, const ShapeRatios& b) {
    return ShapeRatios{std::max(a.radius_edge, b.radius_edge), std::max(a.radius_ratio, b.radius_ratio)};
  };
  return parallel_reduce_ordered(
      mesh.simplex_vertices.size(), kBlock, ShapeRatios{},
      [&](std::size_t begin, std::size_t end) {
        ShapeRatios block;
        for (std::size_t s = begin; s < end; ++s)
          block = larger(block, ratios_of<D>(corner_positions(mesh, SimplexId(s))));
        return block;
      },
      larger);
}

double min_dihedral_deg(const Mesh<3>& mesh, SimplexId s) {
  const auto p = corner_positions(mesh, s);
  const P1Gradients<3> g = p1_gradients<3>(p);
  double least = std::numbers::pi;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet at the edge of the other two corners, and |n_i x n_j| = |edge| determinant.
      const std::size_t k = i > 0 ? 0 : j > 1 ? 1 : 2, l = 6 - i - j - k;
      const double sine = distance(p[k], p[l]) * g.determinant, cosine = -dot(g.normal[i], g.normal[j]);
      least = std::min(least, std::atan2(sine, cosine));
    }
  return least * 180 / std::numbers::pi;
}

template ShapeRatios max_shape_ratios(const Mesh<2>&);
template ShapeRatios max_shape_ratios(const Mesh<3>&);

}  // namespace voropack
