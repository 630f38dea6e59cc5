// The matrix of the control volume method from evaluated terms.
#pragma once

#include "solve/coefficients.h"
#include "voropack/diffusion.h"

namespace voropack {

/// What a time step adds to the equations of the vertices.
struct StepTerms {
  IdVector<VertexId, double> storage;  ///< [n_vertices] capacity |V| over the time that the implicit part stands for.
  IdVector<VertexId, double> load;     ///< [n_vertices]
};

template <int D>
LinearSystem assemble_terms(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                            const StepTerms* step = nullptr);

/// Turns the system of `terms` into its derivative by the solution, at `values`: the matrix, and its row sums as far as
/// they come from what is absorbed. What `system.absorption` holds besides is kept.
template <int D>
void differentiate_terms(const ControlVolumes<D>& volumes, const CellTerms& terms,
                         const IdVector<VertexId, double>& values, LinearSystem& system);

}  // namespace voropack
