// The Lipschitz envelope of an affine function on a simplex, in closed form.
#pragma once

#include <array>

#include "voropack/vec.h"

namespace voropack {

/// The least of value(y) + slope * |x - y| over the points y of a simplex, where `value` is affine with the given
/// values at the corners.
///
/// Over the inside of a face with gradient g (within the face) the minimum is a stationary point iff |g| < slope: with
/// p the projection of x to the face's affine hull and e = |x - p|, it lies at p - g e / sqrt(slope^2 - |g|^2) and is
/// value(p) + e sqrt(slope^2 - |g|^2). Otherwise the minimum is on the face's boundary. So it is the least over all
/// faces whose stationary point lies in them, and the corners.
template <int D>
double affine_envelope(const std::array<Vec<D>, D + 1>& corners, const std::array<double, D + 1>& values, double slope,
                       const Vec<D>& x);

/// The same over a simplex of one dimension less.
template <int D>
double affine_envelope_of_face(const std::array<Vec<D>, D>& corners, const std::array<double, D>& values, double slope,
                               const Vec<D>& x);

}  // namespace voropack
