// The matrix of the control volume method from evaluated terms.
#pragma once

#include "solve/coefficients.h"
#include "voropack/diffusion.h"

namespace voropack {

template <int D>
LinearSystem assemble_terms(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms);

}  // namespace voropack
