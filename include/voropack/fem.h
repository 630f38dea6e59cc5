// Stage 7: Mesh<D> and a diffusion problem -> its solution by P1 finite elements. For comparison with the control
// volume method, which does not need well-shaped simplices (docs/theory/figure3.md).
#pragma once

#include "voropack/diffusion.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// int kappa grad(lambda_i) . grad(lambda_j) for the hat functions lambda, with the mean of kappa over each simplex by
/// quadrature. Symmetric to the bit; rows sum to zero up to rounding.
///
/// On a Delaunay mesh of the plane with kappa constant by region it is the matrix of the control volume method
/// [MacNeal1953]; in space it is not.
///
/// Cost: O(n), in parallel. The same result for any number of threads.
/// Throws: InputError mesh.degenerate_simplex  if a simplex is flat or negatively oriented.
///         InputError solve.unknown_region     if kappa is given by region and misses one.
///         InputError solve.bad_conductivity   if kappa is not positive and finite on some simplex.
template <int D>
SparseMatrix stiffness_matrix(const Mesh<D>& mesh, const Coefficient<D>& conductivity = 1.0);

/// int sigma lambda_i lambda_j by quadrature of degree 5: exact for a constant sigma.
template <int D>
SparseMatrix mass_matrix(const Mesh<D>& mesh, const Coefficient<D>& reaction = 1.0);

/// int f lambda_i by quadrature of degree 5. A coefficient per vertex is its P1 function.
template <int D>
IdVector<VertexId, double> load_vector(const Mesh<D>& mesh, const Coefficient<D>& source);

/// The system of P1 finite elements for the problem that the control volume method solves, with conditions on the hull
/// faces of `mesh.boundary_vertices`. Markers that no hull face has are looked for inside the domain, as
/// `build_boundary_areas` does; conditions there act on its patches. A vertex without simplices has the fixed value 0.
///
/// Throws: as above, and
///         InputError solve.unknown_marker  if nothing has the marker of a condition; names the nearest.
///         InputError solve.cell_integrals  if integrals of the source over cells are given.
///         InputError solve.nonlinear       if a coefficient depends on the solution.
template <int D>
LinearSystem assemble_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem);

/// The diagonal as preconditioner: the matrix is in general no M-matrix, and incomplete Cholesky breaks down on
/// slivers.
inline LinearOptions fem_linear_options() {
  LinearOptions options;
  options.preconditioner = PreconditionerKind::kDiagonal;
  return options;
}

/// Assembles and solves, and adds up what flows where.
///
/// Flows are those of the hat functions, which take the place of cells: what enters through a Dirichlet condition is
/// the residual at its vertices, shared by the integrals of hat functions where conditions meet. So they are
/// consistent and conservative [Hughes2000].
/// `mean` holds for the integral of the P1 solution. Throws: as `assemble_fem` and `solve_linear_system`, and
/// solve.no_condition, solve.mean_not_free, solve.incompatible as `solve`.
template <int D>
DiffusionSolution<D> solve_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem,
                               const LinearOptions& options = fem_linear_options(),
                               Observer& observer = silent_observer());

}  // namespace voropack
