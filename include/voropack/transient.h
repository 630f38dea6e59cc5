// Stage 8: diffusion problems that depend on time, by backward Euler or Crank-Nicolson steps.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/mesh.h"
#include "voropack/nonlinear.h"
#include "voropack/observer.h"

namespace voropack {

/// capacity du/dt - div(kappa grad u) + sigma u = f, where everything but the capacity may depend on time, and kappa
/// and f on u.
template <int D>
struct TransientProblem {
  /// The problem at a time: its coefficients and conditions. Asked at each step, and at the beginning.
  std::function<DiffusionProblem<D>(double time)> at;
  Coefficient<D> capacity = 1.0;  ///< > 0, of position and region.
  /// u at the beginning; at Dirichlet conditions, their values replace it. Where a vertex lies in several regions, the
  /// mean of their values weighted by what they can store.
  Coefficient<D> initial = 0.0;
};

enum class TimeScheme : std::uint8_t {
  kBackwardEuler,  ///< First order. Keeps the maximum principle for steps of any length.
  /// Second order. Initial values that do not fit the conditions ring; startup steps damp that.
  kCrankNicolson,
};

struct TimeOptions {
  double begin = 0;
  double end = 1;      ///< > begin
  double step = 0.01;  ///< Without tolerance: shortened so that a whole number fits. With one: the first trial.
  TimeScheme scheme = TimeScheme::kCrankNicolson;
  /// Each of the first steps of kCrankNicolson is made as two backward Euler steps of half its length [Rannacher1984],
  /// whose matrix is the same. So are those after a change of the vertices that are fixed.
  int n_startup = 2;
  /// Adaptive steps, if given: each is made at once and in two halves; the halves are kept if they differ by no more
  /// than this anywhere, in units of u, after division by 2^order - 1. Steps are doubled and halved.
  std::optional<double> tolerance;
  double smallest_step = 0;  ///< Adaptive steps below it are a NumericalError; 0: 1e-12 of the whole time.
  std::uint64_t max_steps = 1'000'000;
  NewtonOptions newton;  ///< Its `linear` is used for linear problems as well.
};

/// A step that is accepted. Flows are means over the step, so that the balance closes in each. The initial state is a
/// step of length 0 without flows.
template <int D>
struct TransientStep {
  double time = 0;                      ///< At its end.
  double length = 0;                    ///< Of the step.
  IdVector<VertexId, double> values;    ///< [n_vertices] u at its end.
  std::vector<MarkerFlux> fluxes;       ///< One for each marker of the boundary, ascending.
  std::vector<RegionBalance> balances;  ///< One for each region, ascending.
  int linear_iterations = 0;            ///< Of all linear systems of the step; 0 for direct solutions.
  std::vector<NewtonStep> newton;       ///< Empty for linear problems.
};

struct TransientReport {
  std::uint64_t n_steps = 0;           ///< Accepted, as the callback sees them; the initial state is none.
  std::uint64_t n_rejected = 0;        ///< Trials of two halves whose error was too large.
  std::uint64_t n_factorizations = 0;  ///< Matrices that were factorized or preconditioned.
  std::uint64_t linear_iterations = 0;
  double shortest_step = 0;
  double longest_step = 0;
};

template <int D>
struct TransientSolution {
  IdVector<VertexId, double> values;  ///< [n_vertices] u at the end.
  MatrixCheck matrix;                 ///< Of the first step: storage included, so that nothing floats.
  LinearReport linear;                ///< Of the last linear system.
  TransientReport report;
};

/// Called with the initial state and after each accepted step, in order, from the calling thread. The balances hold
/// what is stored.
template <int D>
using StepCallback = std::function<void(const TransientStep<D>&)>;

/// Follows the problem from `begin` to `end`. Storage is lumped, as control volumes have it: capacity |V_i| du_i/dt.
///
/// A system is factorized or preconditioned anew only where its matrix differs from the last ones.
/// Throws: as `solve_nonlinear`; an exception of the callback goes through; and
///         InputError     solve.bad_capacity   if the capacity is not positive and finite.
///         InputError     solve.bad_initial    if initial values are not finite.
///         OptionError    solve.bad_option     if an option is out of its range.
///         NumericalError solve.step_too_small if errors stay too large; says when.
///         LimitError     solve.too_many_steps if max_steps do not reach the end.
template <int D>
TransientSolution<D> solve_transient(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                     const TransientProblem<D>& problem, const TimeOptions& options = {},
                                     const StepCallback<D>& on_step = {}, Observer& observer = silent_observer());

}  // namespace voropack
