// A triangle in parts, each next to one of its corners.
#pragma once

#include <array>
#include <cstddef>

#include "geom/circumcenter.h"
#include "voropack/vec.h"

namespace voropack {

/// What is nearest to a corner of a triangle is a kite with a right triangle for each of the corner's two edges:
/// corner, midpoint of the edge, circumcenter.
struct KiteHalf {
  std::size_t corner;             ///< 0 .. 2.
  std::array<Vec<3>, 3> corners;  ///< In the order above.
  double area;                    ///< |edge|^2 / 8 times the cotangent of the opposite angle, signed as that is.
};

/// All six, corner by corner: their areas add up to that of the triangle, which may not be flat.
inline std::array<KiteHalf, 6> kite_halves(const std::array<Vec<3>, 3>& x) {
  const double twice_area = norm(cross(x[1] - x[0], x[2] - x[0]));
  const Vec<3> center = triangle_circumcenter(x[0], x[1], x[2]);
  const auto half = [&](std::size_t a, std::size_t b) {
    const std::size_t c = 3 - a - b;
    const double area = distance_sq(x[a], x[b]) / 8 * dot(x[a] - x[c], x[b] - x[c]) / twice_area;
    return KiteHalf{a, {x[a], 0.5 * (x[a] + x[b]), center}, area};
  };
  return {half(0, 1), half(0, 2), half(1, 2), half(1, 0), half(2, 0), half(2, 1)};
}

}  // namespace voropack
