// Moves points onto the planes of their sheets, as little as possible.
#pragma once

#include <vector>

#include "domain/sheets.h"

namespace voropack::domain_impl {

/// New positions for points of sheets that are not planar up to `tolerance`.
struct FlatPoints {
  std::vector<Vec<3>> positions;  ///< Of all points; those that need not move are as before.
  std::vector<Index> failed;      ///< Points that would have to move farther than the limit, or meet no common point.
};

/// Solves for positions and planes at once: each point on the planes of all its sheets, with least squares of
/// displacement (Newton's method; each step by conjugate gradients). Planes normal to an axis that hold their points
/// exactly stay. Sheets without any connection to one that is not planar stay as they are.
FlatPoints flatten_sheets(const std::vector<Vec<3>>& points, const std::vector<const Sheet*>& sheets, double tolerance,
                          double limit);

}  // namespace voropack::domain_impl
