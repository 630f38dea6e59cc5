// The balls that have to be empty at an edge where a surface bends, so that the mesh on each side conforms to it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "coarsening/surface_complex.h"
#include "spheres/sphere_set.h"

namespace voropack {

struct EdgeBalls {
  std::array<Ball<3>, 3> balls;
  std::size_t n = 0;
};

/// For two triangles abp and abq of a surface with empty equatorial balls: balls that hold no vertex but these, and
/// circumcenters over them are in their regions, and the dual face of ab has no negative area.
///
/// None where the triangles are coplanar; else the diametral ball of ab. If the angle at p or q is obtuse, and there is
/// a region on the side towards which the surface bends: also balls through the corners of each triangle with a
/// center that is lifted into that region. `has_region`: on the side of (b-a) x (p-a), and on the other one.
/// Nothing if no balls would do. docs/theory/beyond_boundary.md has the proof.
std::optional<EdgeBalls> edge_balls(const Vec<3>& a, const Vec<3>& b, const Vec<3>& p, const Vec<3>& q,
                                    const std::array<bool, 2>& has_region);

inline std::uint32_t third_corner(const SurfaceTriangle& t, std::uint32_t a, std::uint32_t b) {
  return t.corners[0] ^ t.corners[1] ^ t.corners[2] ^ a ^ b;
}

/// `has_region` of edge_balls for the edge ab of t.
std::array<bool, 2> regions_beside(const SurfaceTriangle& t, std::uint32_t a, std::uint32_t b);

}  // namespace voropack
