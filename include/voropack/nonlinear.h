// Stage 8: diffusion problems whose conductivity or source depends on the solution, by Newton's method.
#pragma once

#include <vector>

#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

struct NewtonOptions {
  double tolerance = 1e-12;  ///< Residual relative to what flows, as NewtonStep::residual. In (0, 1).
  int max_steps = 50;
  double smallest_damping = 1e-6;  ///< The line search gives up below it. In (0, 1].
  LinearOptions linear;            ///< For the linear system of each step.
};

struct NewtonStep {
  double residual = 0;        ///< Norm of the cells' residuals after the step, relative to that of their flows.
  double damping = 1;         ///< The part of Newton's correction that was taken.
  int linear_iterations = 0;  ///< 0 for a direct solution.
};

struct NewtonReport {
  double first_residual = 0;  ///< Of the initial values.
  std::vector<NewtonStep> steps;
  double residual = 0;  ///< At the end.
};

template <int D>
struct NonlinearSolution {
  DiffusionSolution<D> state;  ///< `matrix` is that of the couplings at the solution, `linear` that of the last step.
  NewtonReport newton;
};

/// Solves -div(kappa(x, u) grad u) + sigma u = f(x, u) with the conditions of `problem` by Newton's method with a line
/// search [Deuflhard2011]: each correction is halved until the norm of the residual falls and all coefficients stay in
/// their range. Far from the solution, steps hold kappa as it is. Problems without a StateFunction take one step.
///
/// kappa is evaluated at the two ends of each edge; its harmonic mean conducts. f is taken at the site, times the
/// volume. The solution is unique where kappa does not depend on u and df/du <= sigma, and where kappa depends on u
/// alone and f not on u; elsewhere there may be several, and the initial values choose.
///
/// Iterations end when the residual is below the tolerance, or when rounding does not let it fall any more. Balances
/// and fluxes are those of `solve`. The same bytes for any number of threads.
/// Throws: as `solve`, and
///         InputError     solve.wrong_length   if there are initial values, but not one for each vertex.
///         InputError     solve.nonlinear_mean if a mean is given: it belongs to linear problems.
///         InputError     solve.nonlinear      if the reaction depends on u (it belongs into the source), or integrals
///                                             of a source that depends on u are given.
///         OptionError    solve.bad_option     if an option is out of its range.
///         NumericalError solve.not_converged  if max_steps do not suffice or no damping helps: says what was reached,
///                                             and where the residual is largest.
template <int D>
NonlinearSolution<D> solve_nonlinear(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                     const DiffusionProblem<D>& problem,
                                     const IdVector<VertexId, double>& initial = {},  ///< [n_vertices], or empty: 0.
                                     const NewtonOptions& options = {}, Observer& observer = silent_observer());

}  // namespace voropack
