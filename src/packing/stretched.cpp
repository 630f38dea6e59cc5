#include "packing/stretched.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace voropack {

template <int D>
double SharpPairs<D>::angle(PolytopeId p, PolytopeId q) const {
  if (p.dimension >= D || q.dimension >= D) return std::numbers::pi;
  const auto [it, is_new] = known_.try_emplace(std::minmax(p, q), std::numbers::pi);
  if (is_new)
    for (const PolytopeId a : incidence_.holders(p))
      for (const PolytopeId b : incidence_.holders(q))
        if (incidence_.form_sharp_feature(a, b))
          it->second = std::min(it->second, *incidence_.meeting_angle(incidence_.given(a), incidence_.given(b)));
  return it->second;
}

template <int D>
double SharpPairs<D>::ratio_bound(const std::array<PolytopeId, D + 1>& carriers) const {
  double least = std::numbers::pi;
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j) least = std::min(least, angle(carriers[i], carriers[j]));
  return least < kSharpAngle ? std::max(kRadiusEdge, kSharpRadiusEdge / std::sin(0.5 * least)) : kRadiusEdge;
}

template <int D>
bool has_sharp_pair(const Packing<D>& packing, const Incidence<D>& incidence,
                    const std::array<std::uint32_t, D + 1>& spheres) {
  const SharpPairs<D> pairs(incidence);
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j)
      if (pairs.angle(packing.carrier[SphereId(spheres[i])], packing.carrier[SphereId(spheres[j])]) < kSharpAngle)
        return true;
  return false;
}

template <int D>
std::vector<SpacingCap<D>> stretched_simplices(const Packing<D>& packing, const Incidence<D>& incidence) {
  const auto& simplices = packing.triangulation.simplices;
  const auto shape = [&](std::size_t i) {
    std::array<Vec<D>, D + 1> x;
    for (std::size_t k = 0; k <= D; ++k) x[k] = packing.center[SphereId(simplices[i][k])];
    return shape_of<D>(x);
  };
  std::vector<std::uint8_t> is_long(simplices.size(), 0);
  parallel_for(simplices.size(), [&](std::size_t i) { is_long[i] = shape(i).exceeds(kRadiusEdge) ? 1 : 0; });
  const SharpPairs<D> pairs(incidence);
  std::vector<SpacingCap<D>> caps;
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    if (is_long[i] == 0) continue;
    std::array<PolytopeId, D + 1> carriers;
    for (std::size_t k = 0; k <= D; ++k) carriers[k] = packing.carrier[SphereId(simplices[i][k])];
    const Shape<D> here = shape(i);
    if (!here.exceeds(pairs.ratio_bound(carriers))) continue;
    caps.push_back({here.center, std::sqrt(here.radius_sq), 0.5 * std::sqrt(here.shortest_sq)});
  }
  return caps;
}

template bool has_sharp_pair(const Packing<2>&, const Incidence<2>&, const std::array<std::uint32_t, 3>&);
template bool has_sharp_pair(const Packing<3>&, const Incidence<3>&, const std::array<std::uint32_t, 4>&);
template class SharpPairs<2>;
template class SharpPairs<3>;
template std::vector<SpacingCap<2>> stretched_simplices(const Packing<2>&, const Incidence<2>&);
template std::vector<SpacingCap<3>> stretched_simplices(const Packing<3>&, const Incidence<3>&);

}  // namespace voropack
