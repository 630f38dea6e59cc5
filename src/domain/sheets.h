// Sheets: input facets that lie in one plane within the merge tolerance.
#pragma once

#include <vector>

#include "domain/complex.h"

namespace voropack::domain_impl {

/// How far facets may be off the plane that they share. Both include what coordinates so large can resolve.
struct MergeLimits {
  double distance = 0;  ///< Of a point from the plane.
  double sine = 0;      ///< Of the angle between a facet's plane and the common one.
};

/// Facets with points in common, directly or through others of them, and their common plane.
struct Sheet {
  std::vector<Index> facets;  ///< Of the complex, sorted.
  std::vector<Index> points;  ///< All that the facets name, sorted.
  PlaneFrame frame;           ///< The plane of least squares of the points.
  double deviation = 0;       ///< The largest distance of a point from it.
  bool is_exact = false;      ///< The points agree exactly in one coordinate, and the plane is normal to that axis.
};

/// Partitions the facets into sheets, each grown from the largest facet that is left. Every point of a facet is within
/// limits.distance of the plane of its sheet, and the facet's own plane within the angle of it unless the facet is so
/// thin that its own plane says nothing. A facet that is alone in its sheet may be farther from being planar. Thus no
/// chain of small steps leaves a plane. With `merge` false every facet is alone. Near O(n log n).
std::vector<Sheet> find_sheets(const Complex<3>& complex, const MergeLimits& limits, bool merge);

/// Finds the points of a sheet and fits its plane to them.
void fit_sheet(const Complex<3>& complex, Sheet& sheet);

/// Fits the plane of a sheet, which has one already, to other positions of its points.
void fit_points(const std::vector<Vec<3>>& positions, Sheet& sheet);

}  // namespace voropack::domain_impl
