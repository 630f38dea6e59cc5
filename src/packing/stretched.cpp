#include "packing/stretched.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"

namespace voropack {

namespace {

template <int D>
struct Shape {
  Vec<D> center;
  double radius_sq = 0, shortest_sq = 0;

  [[nodiscard]] bool is_stretched() const { return radius_sq > kRadiusEdge * kRadiusEdge * shortest_sq; }
};

template <int D>
Shape<D> shape_of(const Packing<D>& packing, const std::array<std::uint32_t, D + 1>& corners) {
  std::array<Vec<D>, D + 1> x;
  for (std::size_t i = 0; i <= D; ++i) x[i] = packing.center[SphereId(corners[i])];
  double shortest_sq = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j) shortest_sq = std::min(shortest_sq, distance_sq(x[i], x[j]));
  const Vec<D> center = fast_circumcenter(x);
  return {center, distance_sq(center, x[0]), shortest_sq};
}

}  // namespace

template <int D>
bool has_sharp_pair(const Packing<D>& packing, const Incidence<D>& incidence,
                    const std::array<std::uint32_t, D + 1>& spheres) {
  std::array<std::vector<PolytopeId>, D + 1> holders;
  for (std::size_t i = 0; i <= D; ++i) holders[i] = incidence.holders(packing.carrier[SphereId(spheres[i])]);
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j)
      for (const PolytopeId p : holders[i])
        for (const PolytopeId q : holders[j])
          if (incidence.form_sharp_feature(p, q)) return true;
  return false;
}

template <int D>
std::vector<SpacingCap<D>> stretched_simplices(const Packing<D>& packing, const Incidence<D>& incidence) {
  const auto& simplices = packing.triangulation.simplices;
  std::vector<std::uint8_t> is_long(simplices.size(), 0);
  parallel_for(simplices.size(),
               [&](std::size_t i) { is_long[i] = shape_of(packing, simplices[i]).is_stretched() ? 1 : 0; });
  std::vector<SpacingCap<D>> caps;
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    if (is_long[i] == 0 || has_sharp_pair<D>(packing, incidence, simplices[i])) continue;
    const Shape<D> shape = shape_of(packing, simplices[i]);
    caps.push_back({shape.center, std::sqrt(shape.radius_sq), 0.5 * std::sqrt(shape.shortest_sq)});
  }
  return caps;
}

template bool has_sharp_pair(const Packing<2>&, const Incidence<2>&, const std::array<std::uint32_t, 3>&);
template bool has_sharp_pair(const Packing<3>&, const Incidence<3>&, const std::array<std::uint32_t, 4>&);
template std::vector<SpacingCap<2>> stretched_simplices(const Packing<2>&, const Incidence<2>&);
template std::vector<SpacingCap<3>> stretched_simplices(const Packing<3>&, const Incidence<3>&);

}  // namespace voropack
