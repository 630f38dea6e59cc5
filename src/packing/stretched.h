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
/// The same of a simplex in a sharp feature, times the sine of half the angle there.
inline constexpr double kSharpRadiusEdge = 8;

/// The circumball and the shortest edge of a simplex.
template <int D>
struct Shape {
  Vec<D> center;
  double radius_sq = 0, shortest_sq = 0;
  Vec<D> edge_middle;  ///< Of the shortest edge.

  [[nodiscard]] bool exceeds(double ratio) const { return radius_sq > ratio * ratio * shortest_sq; }
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

/// The sharp features that centers on given polytopes have to do with. Keeps what it has found: not to be used by
/// several threads at once.
template <int D>
class SharpPairs {
 public:
  explicit SharpPairs(const Incidence<D>& incidence) : incidence_(incidence) {}
  /// The least angle below kSharpAngle between two polytopes, neither in the other, one of which holds p and the other
  /// one q; pi if there is none.
  [[nodiscard]] double angle(PolytopeId p, PolytopeId q) const;
  /// How large R / l of a simplex may be whose corners are on these polytopes.
  [[nodiscard]] double ratio_bound(const std::array<PolytopeId, D + 1>& carriers) const;

 private:
  const Incidence<D>& incidence_;
  mutable std::map<std::pair<PolytopeId, PolytopeId>, double> known_;
};

/// Whether two of the spheres lie on polytopes, taken closed, that form a sharp feature.
template <int D>
bool has_sharp_pair(const Packing<D>& packing, const Incidence<D>& incidence,
                    const std::array<std::uint32_t, D + 1>& spheres);

/// For each simplex of the packing's triangulation whose R / l is beyond its bound: a cap under which no ball there is
/// empty and as large beside its shortest edge. O(n).
template <int D>
std::vector<SpacingCap<D>> stretched_simplices(const Packing<D>& packing, const Incidence<D>& incidence);

}  // namespace voropack
