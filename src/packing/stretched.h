// Simplices whose circumradius is large beside their shortest edge although no sharp feature explains it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packing/incidence.h"
#include "voropack/packing.h"

namespace voropack {

/// Circumradius divided by shortest edge that packings keep away from sharp features. Theory bounds it for small b only
/// (docs/theory/certificate.md, radius_edge).
inline constexpr double kRadiusEdge = 2.5;

/// Whether two of the spheres lie on polytopes, taken closed, that form a sharp feature.
template <int D>
bool has_sharp_pair(const Packing<D>& packing, const Incidence<D>& incidence,
                    const std::array<std::uint32_t, D + 1>& spheres);

/// For each simplex of the packing's triangulation that exceeds kRadiusEdge, and no two of whose corners lie on two
/// polytopes of one sharp feature: a cap under which no ball there is empty and as large beside that edge. O(n).
template <int D>
std::vector<SpacingCap<D>> stretched_simplices(const Packing<D>& packing, const Incidence<D>& incidence);

}  // namespace voropack
