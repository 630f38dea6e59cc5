// Newton's method for the equations of control volumes, stationary or of one time step.
#pragma once

#include "solve/assemble.h"
#include "solve/cell_index.h"
#include "solve/coefficients.h"
#include "solve/conservation.h"
#include "voropack/nonlinear.h"

namespace voropack {

template <int D>
struct NonlinearEquations {
  const ControlVolumes<D>& volumes;
  const BoundaryAreas<D>& boundary;
  const CellIndex& index;
  const RegionGroups& groups;
  const DiffusionProblem<D>& problem;
  const StepTerms* step = nullptr;
};

/// The equations at the solution.
struct NewtonResult {
  CellTerms terms;
  LinearSystem system;  ///< With the couplings of the solution, not their derivatives.
  LinearReport linear;  ///< Of the last step.
  NewtonReport newton;
};

/// Sets fixed values, and improves the others. Throws as `solve_nonlinear`.
template <int D>
NewtonResult run_newton(const NonlinearEquations<D>& equations, const NewtonOptions& options, Observer& observer,
                        IdVector<VertexId, double>& values);

}  // namespace voropack
