// Packs everything of dimension < D: points, segments and, in space, facets; and checks that their protecting balls are
// empty.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geom/predicates.h"
#include "packing/protection.h"
#include "packing/segments.h"
#include "spheres/packing_problem.h"
#include "spheres/sphere_set.h"
#include "voropack/domain.h"
#include "voropack/packing.h"

namespace voropack {

/// Spheres on points, segments and facets, the simplices they form, and the protecting balls of these.
template <int D>
struct BoundaryPacking {
  Packing<D> packing;                 ///< Without the interior.
  std::vector<Ball<D>> balls;         ///< Of the subsegments, then of the subfacets.
  std::vector<SpacingCap<D>> faults;  ///< Where f must shrink, because a ball is not empty or two spheres overlap.
  bool protects_more = false;         ///< Something new is protected. If this is false and no fault: all is well.
  std::vector<SpacingCap<D>> tied;    ///< Where a center has less than f, because another page or segment has less.
};

/// Packs under what `protection` protects by now, and adds to it what fails. `segments` has packed the segments of the
/// round before, if there was one; since then f has got the caps `lowered`.
template <int D>
BoundaryPacking<D> pack_boundary(const Spacing<D>& spacing, std::span<const SpacingCap<D>> lowered,
                                 Protection<D>& protection, SegmentPacker<D>& segments, const PackingOptions& options,
                                 const Observer& observer);

/// True if x is strictly inside the protecting ball of that number, as BoundaryPacking lists them. Exact.
template <int D>
bool is_inside_ball(const Packing<D>& packing, std::uint32_t ball, const Vec<D>& x) {
  const auto corner = [&](SphereId s) { return packing.center[s]; };
  if constexpr (D == 3)
    if (ball >= packing.subsegments.size()) {
      const auto& [a, b, c] = packing.subfacets[ball - packing.subsegments.size()].spheres;
      return in_diametral_ball(corner(a), corner(b), corner(c), x) > 0;
    }
  const auto& [a, b] = packing.subsegments[ball].spheres;
  return in_diametral_ball(corner(a), corner(b), x) > 0;
}

/// How much f shrinks where a protecting ball is not empty.
inline constexpr double kRepairFactor = 0.7;

/// A cap on f around a place where something is wrong with p and q; they are the same if only one is known.
template <int D>
SpacingCap<D> repair_cap(const Vec<D>& center, double radius, const Spacing<D>& spacing, PolytopeId p, PolytopeId q) {
  return {center, 2 * radius, kRepairFactor * spacing(center), std::array{p, q}};
}

}  // namespace voropack
