// Moves points onto the planes of their sheets, as little as possible.
#pragma once

#include <vector>

#include "domain/sheets.h"

namespace voropack::domain_impl {

/// Planes this far off, relative to the tolerance, show that points have noise: what touches a facet may then be more
/// than the tolerance off, though the facets are not.
inline constexpr double kVisibleNoise = 0.1;

/// New positions for points of sheets that are not planar.
struct FlatPoints {
  std::vector<Vec<3>> positions;  ///< Of all points; those that need not move are as before.
  /// Points that would have to move farther than the limit, or meet no common point.
  std::vector<Index> failed;
};

/// Flattens the sheets that are off by kVisibleNoise times `tolerance`; they then are planar within half of it.
/// Solves for positions and planes at once: each point on the planes of all its sheets, with least squares of
/// displacement (Newton's method; each step by conjugate gradients). Planes normal to an axis that hold their points
/// exactly stay. Of the points that fail, those are told that do so by the part `told` of what the worst one does:
/// others may fail because of them. Sheets without any connection to one that is not planar stay as they are.
FlatPoints flatten_sheets(const std::vector<Vec<3>>& points, const std::vector<const Sheet*>& sheets, double tolerance,
                          double limit, double told);

}  // namespace voropack::domain_impl
