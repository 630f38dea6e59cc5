// Corners: points around which every facet starts with a fan of triangles to centers on one sphere. The protecting ball
// of such a triangle holds a point of the sphere only if that point is in the cap over the triangle's arc, so that a
// corner of any shape is a packing problem of arcs (docs/theory/sharp.md, T5).
#pragma once

#include <vector>

#include "packing/protection.h"
#include "packing/strands.h"
#include "voropack/packing.h"

namespace voropack {

/// The part of a facet around a corner, between two of its segments or all around.
struct FanArc {
  PointId apex;
  FacetId facet;
  Sector sector;
  PackedStrand arc;  ///< Positions are arc lengths from the sector's begin.
};

/// The arcs of all corners, with centers on them. Directions of equal pages of a book are equal.
std::vector<FanArc> pack_corners(const Domain<3>& domain, const Protection<3>& protection, const Spacing<3>& spacing,
                                 std::uint64_t seed);

/// The point of a fan's circle at an arc length from the sector's begin.
Vec<3> point_of_arc(const Domain<3>& domain, const FanArc& fan, double radius, double arc_length);

}  // namespace voropack
