// Circumcenters and circumradii that stay accurate for slivers.
#pragma once

#include <array>

#include "voropack/vec.h"

namespace voropack {

/// The point at equal distance from the corners of a simplex, to within 1e-13 of the length of its edges at corner 0
/// plus one rounding of the coordinates, however flat the simplex: double precision where its error bound allows,
/// else double-double or exact arithmetic. NaN if the simplex is flat.
template <int D>
Vec<D> circumcenter(const std::array<Vec<D>, D + 1>& simplex);

/// The same relative to corner 0, before it is rounded to the coordinates' grid.
template <int D>
Vec<D> circumcenter_offset(const std::array<Vec<D>, D + 1>& simplex);

/// D! times the signed volume of a simplex: to 1e-13 relatively, however flat, and 0 only if it is flat.
template <int D>
double simplex_determinant(const std::array<Vec<D>, D + 1>& simplex);

/// The circumcenter of a triangle in space, in its plane; plain double precision. Accurate while the triangle's
/// angles are not tiny, which a bounded radius-edge ratio grants.
Vec<3> triangle_circumcenter(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c);

}  // namespace voropack
