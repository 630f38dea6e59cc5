// Simplices whose circumradius is large beside their shortest edge although no sharp feature explains it.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "geom/circumcenter.h"
#include "packing/incidence.h"
#include "voropack/packing.h"

namespace voropack {

/// Circumradius divided by shortest edge that packings keep away from sharp features. Theory bounds it for small b only
/// (docs/theory/certificate.md, radius_edge).
inline constexpr double kRadiusEdge = 2.5;

/// The circumball and the shortest edge of a simplex.
template <int D>
struct Shape {
  Vec<D> center;
  double radius_sq = 0, shortest_sq = 0;
  Vec<D> edge_middle;  ///< Of the shortest edge.

  [[nodiscard]] bool is_stretched() const { return radius_sq > kRadiusEdge * kRadiusEdge * shortest_sq; }
};

template <int D>
Shape<D> shape_of(const std::array<Vec<D>, D + 1>& x) {
  const Vec<D> center = fast_circumcenter(x);
  Shape<D> shape{center, distance_sq(center, x[0]), std::numeric_limits<double>::infinity(), {}};
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j)
      if (const double d = distance_sq(x[i], x[j]); d < shape.shortest_sq)
        shape.shortest_sq = d, shape.edge_middle = 0.5 * (x[i] + x[j]);
  return shape;
}

/// Answers whether centers lie on polytopes, taken closed, that form a sharp feature. Keeps what it has found: not to
/// be used by several threads at once.
template <int D>
class SharpPairs {
 public:
  explicit SharpPairs(const Incidence<D>& incidence) : incidence_(incidence) {}
  /// Of centers on these polytopes.
  [[nodiscard]] bool is_sharp(PolytopeId p, PolytopeId q) const;
  /// Of any two of these spheres.
  [[nodiscard]] bool any_sharp(const Packing<D>& packing, const std::array<std::uint32_t, D + 1>& spheres) const;

 private:
  const Incidence<D>& incidence_;
  mutable std::map<std::pair<PolytopeId, PolytopeId>, bool> known_;
};

/// The same, from any thread.
template <int D>
bool has_sharp_pair(const Packing<D>& packing, const Incidence<D>& incidence,
                    const std::array<std::uint32_t, D + 1>& spheres) {
  return SharpPairs<D>(incidence).any_sharp(packing, spheres);
}

/// For each simplex of the packing's triangulation that exceeds kRadiusEdge, and no two of whose corners lie on two
/// polytopes of one sharp feature: a cap under which no ball there is empty and as large beside that edge. O(n).
template <int D>
std::vector<SpacingCap<D>> stretched_simplices(const Packing<D>& packing, const Incidence<D>& incidence);

}  // namespace voropack
