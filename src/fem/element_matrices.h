// What single simplices contribute, tested with their hat functions.
#pragma once

#include <array>

#include "voropack/diffusion.h"
#include "voropack/mesh.h"

namespace voropack {

template <int D>
using ElementTerms = std::array<double, D + 1>;

/// int kappa grad u . grad(lambda_i): adds up to 0 but for rounding in proportion to the terms.
template <int D>
ElementTerms<D> element_diffusion(const Mesh<D>& mesh, const Coefficient<D>& conductivity, SimplexId s,
                                  const IdVector<VertexId, double>& u);

/// int sigma u lambda_i
template <int D>
ElementTerms<D> element_absorption(const Mesh<D>& mesh, const Coefficient<D>& reaction, SimplexId s,
                                   const IdVector<VertexId, double>& u);

/// int f lambda_i
template <int D>
ElementTerms<D> element_load(const Mesh<D>& mesh, const Coefficient<D>& source, SimplexId s);

}  // namespace voropack
