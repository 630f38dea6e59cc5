// The one quantity of the dual that sees slivers: the length of the dual edge of a face, certified.
#pragma once

#include <array>

#include "geom/dd.h"
#include "voropack/vec.h"

namespace voropack {

/// What a face passes to the areas of its edges.
///
/// `value` is q_f = l*_f / |n_f|, where l*_f is the signed length of the dual edge of face f and |n_f| is twice the
/// area of f (its length in 2D). Then A_ij = h_ij/4 sum_f dot_k(f) q_f in 3D, where dot_k = |n_f| cot k is the dot
/// product of the two edges of f at k, and A_ij = h_ij q_f in 2D.
///
/// The sign of `value` is exact. Its error is at most kFaceWeightError / L, where L is the longer of the edges of the
/// face at its first corner, and at most kFaceWeightError in 2D. NaN if an apex lies on the plane of the face or on the
/// wrong side of it.
struct FaceWeight {
  double value = 0;
  bool beyond_double = false;  ///< Double precision did not certify it.
};

/// The areas are promised to 1e-12 h^2. An interior edge has about five faces, each with |dot_k| / (4 L) <= h/2 at
/// worst and about h/7 on average, so 4e-13 keeps the promise where the certified bounds are attained, and double
/// precision certifies most faces (docs/theory/dual.md).
inline constexpr double kFaceWeightError = 4e-13;

/// q of a face between two simplices. (face..., above) is positively oriented, (face..., below) negatively.
template <int D>
FaceWeight interior_weight(const std::array<Vec<D>, D>& face, const Vec<D>& above, const Vec<D>& below);

/// q of the part of the dual edge from the face to the circumcenter of the simplex (face..., above).
template <int D>
FaceWeight boundary_weight(const std::array<Vec<D>, D>& face, const Vec<D>& above);

/// The same to about 30 digits, relatively, whatever the simplices.
template <int D>
Dd exact_interior_weight(const std::array<Vec<D>, D>& face, const Vec<D>& above, const Vec<D>& below);
template <int D>
Dd exact_boundary_weight(const std::array<Vec<D>, D>& face, const Vec<D>& above);

}  // namespace voropack
