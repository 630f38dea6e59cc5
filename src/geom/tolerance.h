// Every geometric tolerance of the library. Each is relative to a length that its comment names.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "voropack/vec.h"

namespace voropack {

/// A point this near to a segment or facet, relative to the domain's diameter, lies on it. Large enough for coordinates
/// that were rounded a few times in double precision, small enough that no feature of a model that can be meshed with
/// 32-bit ids is as thin.
inline constexpr double kOnTolerance = 1e-9;

/// Facets this near to parallel (radians) whose points lie within kOnTolerance of one plane are coplanar.
inline constexpr double kCoplanarAngle = 1e-6;

/// Facets whose points are this near to one plane, relative to the domain's diameter, are meant to be coplanar: text
/// with six significant digits leaves points up to 5e-6 off their plane. docs/theory/domain.md has the measurements.
inline constexpr double kMergeDistance = 1e-5;

/// Coordinates that are rounded more coarsely than that, since they are far from the origin, are believed to mean so up
/// to this, relative to the domain's diameter. Beyond, the user has to say so.
inline constexpr double kMaxDefaultMergeDistance = 1e-3;

/// A new point must stay this far outside of a protecting ball of radius R, as power relative to R^2, so that no tie
/// decides whether the protected simplex is Delaunay.
inline constexpr double kBallMargin = 1e-9;

/// Two spheres may overlap by this much, relative to the sum of their radii: rounding of positions on lattices and
/// segments.
inline constexpr double kPackingSlack = 1e-12;

/// The certificate's counterpart of kPackingSlack: looser, so that the maker's rounding does not fail it.
inline constexpr double kPackingCheckSlack = 1e-10;

/// A facet whose points are this near to its plane, relative to the domain's diameter, is flat up to rounding:
/// distances to it may be measured from the plane without disturbing the Lipschitz condition of the spacing.
inline constexpr double kFlatTolerance = 1e-14;

/// Cells of the spacing's tree are taken this much larger, relative to the tree's root, when it is decided which
/// sources matter in them, so that a point that rounding puts into the neighboring cell finds its sources there.
inline constexpr double kCellTolerance = 1e-10;

/// Coordinates beyond this are refused: their fourth powers would leave the range of doubles.
inline constexpr double kMaxCoordinate = 1e60;

/// Domains smaller than this are refused, for the same reason at the other end.
inline constexpr double kMinDiameter = 1e-60;

/// A domain that the rounding of its coordinates blurs by more than this, relative to its diameter, is refused: it lies
/// so far from the origin that spheres could not be placed.
inline constexpr double kMaxBlur = 1e-3;

/// Angles this much (degrees) below a limit still satisfy it: rounding of coordinates turns an exact 60 into slightly
/// less.
inline constexpr double kAngleSlackDeg = 1e-7;

/// Two walls that a ray crosses this near to each other, relative to the domain's diameter, leave their order open:
/// another ray is tried.
inline constexpr double kRayGap = 1e-12;

/// `relative` times the size of `box`, plus 16 ulp of its largest coordinate: what input far from the origin can
/// resolve.
template <int D>
double absolute_tolerance(const Box<D>& box, double relative) {
  double largest = 0;
  for (int k = 0; k < D; ++k) largest = std::max({largest, std::abs(box.lo[k]), std::abs(box.hi[k])});
  return relative * box.diagonal() + 16 * std::numeric_limits<double>::epsilon() * largest;
}

}  // namespace voropack
