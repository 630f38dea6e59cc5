// The value of a coefficient at a point of a simplex.
#pragma once

#include <array>
#include <string_view>

#include "voropack/diffusion.h"
#include "voropack/mesh.h"

namespace voropack {

/// Throws InputError solve.unknown_region, solve.wrong_length, or solve.nonlinear.
template <int D>
void check_coefficient(const Coefficient<D>& coefficient, const Mesh<D>& mesh, std::string_view name);

/// Of a coefficient that is checked; `barycentric` are the coordinates of `x` in simplex s.
template <int D>
double value_at(const Coefficient<D>& coefficient, const Mesh<D>& mesh, SimplexId s,
                const std::array<double, D + 1>& barycentric, const Vec<D>& x);

}  // namespace voropack
