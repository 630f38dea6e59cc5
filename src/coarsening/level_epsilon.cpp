#include "coarsening/level_epsilon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geom/circumcenter.h"
#include "packing/stretched.h"

namespace voropack {

namespace {

constexpr double kEpsilonSlack = 1e-9;  // Whoever measures again rounds otherwise.
/// The least one of a packing that is not maximal at every circumcenter, whatever E that takes.
constexpr double kLeastEpsilon = 1e-6;

}  // namespace

template <int D>
double measured_epsilon(const Mesh<D>& mesh) {
  double slope = 0;
  for (const auto& c : mesh.simplex_vertices)
    for (std::size_t i = 0; i < D; ++i)
      for (std::size_t j = i + 1; j <= D; ++j)
        slope = std::max(slope, std::abs(mesh.vertex_spacing[c[i]] - mesh.vertex_spacing[c[j]]) /
                                    distance(mesh.points[c[i]], mesh.points[c[j]]));
  double epsilon = 0;
  for (const auto& c : mesh.simplex_vertices) {
    std::array<Vec<D>, D + 1> x;
    for (std::size_t i = 0; i <= D; ++i) x[i] = mesh.points[c[i]];
    const double radius = distance(fast_circumcenter(x), x[0]);
    double f = std::numeric_limits<double>::infinity(), largest = 0, shortest = f;
    for (std::size_t i = 0; i <= D; ++i) {
      f = std::min(f, mesh.vertex_spacing[c[i]] + slope * radius);
      largest = std::max(largest, mesh.vertex_spacing[c[i]]);
      for (std::size_t j = 0; j < i; ++j) shortest = std::min(shortest, distance(x[i], x[j]));
    }
    if (radius > f + largest || radius > kRadiusEdge * shortest) epsilon = std::max(epsilon, kLeastEpsilon);
    epsilon = std::max(epsilon, (radius * (1 - slope) / f - 2) / (1 + slope));
  }
  return epsilon > 0 ? epsilon * (1 + kEpsilonSlack) : 0;
}

template double measured_epsilon(const Mesh<2>&);
template double measured_epsilon(const Mesh<3>&);

}  // namespace voropack
