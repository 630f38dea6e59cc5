// Cocircular points of a facet. Several triangulations of their polygon are Delaunay in the facet's plane; in space one
// of them appears, the one that the Delaunay kernel's rule for ties selects.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// A convex polygon whose corners are cocircular up to rounding and coplanar exactly.
struct TiedPolygon {
  std::vector<std::uint32_t> points;     ///< Ascending.
  std::vector<std::uint32_t> triangles;  ///< That cover it. Ascending.
};

/// Finds the tied polygons of a plane Delaunay triangulation and gives them the triangles that the Delaunay
/// triangulation in space has whenever no other point is in the polygon's ball: they depend on the polygon alone,
/// because ties are broken by the coordinates of the tied points (geom/delaunay_kernel.h). Polygons that are coplanar
/// only up to rounding are left out: in space they may be the two sides of a flat simplex.
///
/// `in_plane` and `in_space`: positions of the points; `triangles`: positively oriented in the plane, changed in place;
/// `neighbors[t][i]`: the triangle across from corner i of t, or kNoNeighbor.
std::vector<TiedPolygon> settle_tied_polygons(std::span<const Vec<2>> in_plane, std::span<const Vec<3>> in_space,
                                              std::span<const std::array<std::uint32_t, 3>> neighbors,
                                              std::span<std::array<std::uint32_t, 3>> triangles);

/// The triangles that these corners of a polygon, exactly coplanar and cocircular up to rounding, have in space, each
/// with ascending corners; the first three are not collinear.
std::vector<std::array<std::uint32_t, 3>> settle_polygon(std::span<const Vec<3>> corners);

}  // namespace voropack
