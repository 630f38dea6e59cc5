// What the sphere-packing engine works on: the interior of one polytope of dimension K, given what is packed on its
// boundary already.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "geom/circumcenter.h"
#include "geom/tolerance.h"
#include "geom/wall_locator.h"
#include "spheres/sphere_set.h"
#include "voropack/observer.h"
#include "voropack/packing.h"
#include "voropack/vec.h"

namespace voropack {

/// The spacing function in the coordinates of the problem.
template <int K>
struct LocalSpacing {
  std::function<double(const Vec<K>&)> at;
  std::function<std::optional<double>(const Box<K>&)> constant_on;  ///< See Spacing::constant_on.
  double lipschitz = 0;
};

/// A (K-1)-simplex of fixed spheres that the triangulation must contain, with the regions on its two sides (as in
/// Walls).
template <int K>
struct ProtectedFace {
  std::array<std::uint32_t, K> corners;  ///< Indices into PackingProblem::fixed.
  std::array<int, 2> regions;
};

/// A part of R^K.
template <int K>
class Area {
 public:
  virtual ~Area() = default;
  [[nodiscard]] virtual bool holds(const Vec<K>& x) const = 0;
  /// False only if no point of the box is in the area.
  [[nodiscard]] virtual bool touches(const Box<K>& box) const = 0;
  /// True only if the whole box is in the area.
  [[nodiscard]] virtual bool covers(const Box<K>& box) const = 0;
};

/// The protected simplices that bound regions: subsegments in the plane, subfacets in space.
template <int D>
const auto& wall_simplices(const Packing<D>& packing) {
  if constexpr (D == 2)
    return packing.subsegments;
  else
    return packing.subfacets;
}

/// What Walls say of the regions on both sides of a wall of a domain.
inline std::array<int, 2> regions_of_wall(const std::array<RegionId, 2>& sides) {
  std::array<int, 2> result;
  for (std::size_t i = 0; i < 2; ++i)
    result[i] = sides[i].is_none() ? Walls<2>::kOutside : static_cast<int>(sides[i].value());
  return result;
}

/// The protected simplices that bound the regions of `domain`, with the indices of their regions.
template <int D>
std::vector<ProtectedFace<D>> protected_faces(const Domain<D>& domain, const Packing<D>& packing) {
  std::vector<ProtectedFace<D>> faces;
  for (const auto& simplex : wall_simplices(packing)) {
    ProtectedFace<D> face{{}, regions_of_wall(domain.wall_regions[simplex.carrier.index])};
    for (std::size_t i = 0; i < D; ++i) face.corners[i] = simplex.spheres[i].value();
    faces.push_back(face);
  }
  return faces;
}

/// The protecting balls of a packing: of its subsegments, then of its subfacets.
template <int D>
BallSet<D> protecting_balls(const Domain<D>& domain, const Packing<D>& packing) {
  BallSet<D> balls(domain.box.center());
  for (const auto& e : packing.subsegments) {
    const Vec<D> a = packing.center[e.spheres[0]], b = packing.center[e.spheres[1]];
    balls.add({0.5 * (a + b), 0.5 * distance(a, b)});
  }
  if constexpr (D == 3)
    for (const auto& t : packing.subfacets) {
      const Vec<3> a = packing.center[t.spheres[0]];
      const Vec<3> c = triangle_circumcenter(a, packing.center[t.spheres[1]], packing.center[t.spheres[2]]);
      balls.add({c, distance(c, a)});
    }
  return balls;
}

/// The ball so much larger that a center outside of it and of its margin is outside of the ball itself, too, once the
/// coordinates of both are rounded as they are in `box`. The same ball unless it is tiny or far from the origin.
template <int K, int D>
Ball<K> grown_by_blur(const Ball<K>& ball, const Box<D>& box) {
  const double blur = absolute_tolerance(box, 0);
  return {ball.center, ball.radius + std::max(0.0, 2 * blur - 0.5 * kBallMargin * ball.radius)};
}

template <int K>
struct PackingProblem {
  Box<K> bounds;                          ///< Holds every region.
  std::vector<Ball<K>> fixed;             ///< Spheres that are there already: on lower polytopes of this one.
  std::vector<Ball<K>> foreign;           ///< Spheres on other polytopes: they conflict, but are no vertices here.
  std::vector<Ball<K>> balls;             ///< Protecting balls: no new center may enter.
  std::vector<ProtectedFace<K>> faces;    ///< The boundary of the regions.
  const WallLocator<K>* walls = nullptr;  ///< Where a point is; nullptr: all of `bounds` is region 0.
  const WallLocator<K>* far = nullptr;    ///< The far rule: centers keep 2 f from these walls (Definition 3.3).
  const Area<K>* reserved = nullptr;      ///< Where no new center may be, although the regions reach there.
  LocalSpacing<K> spacing;
  PackingForm form = PackingForm::kVoronoi;
  Interior interior = Interior::kLattice;
  double epsilon = 0.25;
  /// A value of f for which there is a lattice that is as coarse as can be. Absent: the largest one that is found.
  std::optional<double> plateau;
  bool lattice_first = false;  ///< The forms that are random by definition start with a lattice, too.
  /// New centers move by up to this much, relative to f, at random: no four of them on a circle by symmetry.
  double jitter = 0;
  std::uint64_t seed = 1;

  /// The region that holds x; negative outside and where it is reserved. On a segment (K = 1) everything is region 0.
  [[nodiscard]] int region_of(const Vec<K>& x) const {
    if constexpr (K > 1) {
      if (is_reserved(x)) return Walls<K>::kOutside;
      if (walls != nullptr) return walls->region(x);
      if (!bounds.contains(x)) return Walls<K>::kOutside;
    }
    return 0;
  }
  /// False only if region_of is the same all over the box.
  [[nodiscard]] bool meets_wall(const Box<K>& box) const {
    if constexpr (K > 1) {
      if (reserved != nullptr && reserved->touches(box)) return !reserved->covers(box);
      if (walls != nullptr) return walls->touches(box);
      return box.overlaps(bounds) && !(bounds.contains(box.lo) && bounds.contains(box.hi));
    }
    return false;
  }
  /// True if the far rule holds here and x is nearer to a wall than `distance`.
  [[nodiscard]] bool breaks_far_rule(const Vec<K>& x, double distance) const {
    if constexpr (K > 1) return far != nullptr && distance > 0 && far->is_near(x, distance);
    return false;
  }
  [[nodiscard]] bool is_reserved(const Vec<K>& x) const { return reserved != nullptr && reserved->holds(x); }
  /// True if `x` with radius f may join `set`: it keeps to the three rules of algorithm PACKING. Does not test where x
  /// is.
  [[nodiscard]] bool admits(const SphereSet<K>& set, const BallSet<K>& forbidden, const Vec<K>& x, double f) const {
    return !set.conflicts(x, f) && !forbidden.forbids(x) && !is_reserved(x) && !breaks_far_rule(x, 2 * f);
  }
};

}  // namespace voropack
