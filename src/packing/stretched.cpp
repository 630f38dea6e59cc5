#include "packing/stretched.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace voropack {

template <int D>
bool SharpPairs<D>::is_sharp(PolytopeId p, PolytopeId q) const {
  if (p.dimension >= D || q.dimension >= D) return false;
  const auto [it, is_new] = known_.try_emplace(std::minmax(p, q), false);
  if (is_new)
    for (const PolytopeId a : incidence_.holders(p))
      for (const PolytopeId b : incidence_.holders(q)) it->second = it->second || incidence_.form_sharp_feature(a, b);
  return it->second;
}

template <int D>
bool SharpPairs<D>::any_sharp(const Packing<D>& packing, const std::array<std::uint32_t, D + 1>& spheres) const {
  for (std::size_t i = 0; i < D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j)
      if (is_sharp(packing.carrier[SphereId(spheres[i])], packing.carrier[SphereId(spheres[j])])) return true;
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
  parallel_for(simplices.size(), [&](std::size_t i) { is_long[i] = shape(i).is_stretched() ? 1 : 0; });
  const SharpPairs<D> pairs(incidence);
  std::vector<SpacingCap<D>> caps;
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    if (is_long[i] == 0 || pairs.any_sharp(packing, simplices[i])) continue;
    const Shape<D> here = shape(i);
    caps.push_back({here.center, std::sqrt(here.radius_sq), 0.5 * std::sqrt(here.shortest_sq)});
  }
  return caps;
}

template class SharpPairs<2>;
template class SharpPairs<3>;
template std::vector<SpacingCap<2>> stretched_simplices(const Packing<2>&, const Incidence<2>&);
template std::vector<SpacingCap<3>> stretched_simplices(const Packing<3>&, const Incidence<3>&);

}  // namespace voropack
