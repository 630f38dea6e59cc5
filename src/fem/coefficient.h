// The value of a coefficient at a point of a simplex.
#pragma once

#include <array>

#include "voropack/diffusion.h"
#include "voropack/mesh.h"

namespace voropack {

/// `barycentric` are the coordinates of `x` in simplex s. Throws InputError solve.unknown_region, solve.wrong_length.
template <int D>
double value_at(const Coefficient<D>& coefficient, const Mesh<D>& mesh, SimplexId s,
                const std::array<double, D + 1>& barycentric, const Vec<D>& x);

}  // namespace voropack
