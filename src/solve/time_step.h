// One step in time of a diffusion problem.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "solve/assemble.h"
#include "solve/balance.h"
#include "solve/conservation.h"
#include "solve/linear_solver.h"
#include "voropack/transient.h"

namespace voropack {

/// Solvers of the last two matrices: a step and its halves need no more.
class SolverCache {
 public:
  /// The solver for a matrix and its fixed vertices, made if it is not there. Valid until the next call.
  const LinearSolver& solver_for(const LinearSystem& system, const LinearOptions& options);
  [[nodiscard]] std::uint64_t n_made() const { return n_made_; }

 private:
  struct Entry {
    SparseMatrix matrix;
    IdVector<VertexId, std::uint8_t> is_fixed;
    LinearSolver solver;
  };
  std::array<std::optional<Entry>, 2> entries_;
  std::size_t newest_ = 0;
  std::uint64_t n_made_ = 0;
};

/// The solution at one time.
struct TimeState {
  double time = 0;
  IdVector<VertexId, double> values;
  IdVector<PatchId, std::uint8_t> is_fixed;  ///< [n_patches]
  Flows flows;                               ///< At this time, without storage.
};

template <int D>
struct TimeStep {
  TimeState to;
  TransientStep<D> record;
};

/// Makes single steps; the caller chooses them.
template <int D>
class TimeStepper {
 public:
  /// Throws as `solve_transient`. The volumes have to be checked.
  TimeStepper(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const TransientProblem<D>& problem,
              const NewtonOptions& options, Observer& observer);

  /// The initial values, with those that are fixed at `time`.
  TimeState start(double time);

  /// A step of `length` to `time`, with the part `implicitness` of flows taken at its end: 1 or 1/2. Nothing is made,
  /// and none returned, if other patches are fixed at the end of a step that is not all implicit.
  std::optional<TimeStep<D>> advance(const TimeState& from, double time, double length, double implicitness);

  [[nodiscard]] std::uint64_t n_factorizations() const { return cache_.n_made() + n_newton_; }
  /// Of the first step.
  [[nodiscard]] const std::optional<MatrixCheck>& matrix() const { return matrix_; }
  /// Of the last linear system.
  [[nodiscard]] const LinearReport& linear() const { return linear_; }

 private:
  [[nodiscard]] StepTerms step_terms(const TimeState& from, double length, double implicitness) const;
  CellTerms solve_linear(const DiffusionProblem<D>& problem, const StepTerms& step, IdVector<VertexId, double>& values,
                         TransientStep<D>& record);
  CellTerms solve_newton(const DiffusionProblem<D>& problem, const StepTerms& step, IdVector<VertexId, double>& values,
                         TransientStep<D>& record);
  void check_matrix(const LinearSystem& system);

  const ControlVolumes<D>& volumes_;
  const BoundaryAreas<D>& boundary_;
  const TransientProblem<D>& problem_;
  const NewtonOptions& options_;
  Observer& observer_;
  CellIndex index_;
  RegionGroups groups_;
  IdVector<CellId, double> capacity_;  ///< Times volume.
  SolverCache cache_;
  std::uint64_t n_newton_ = 0;
  std::optional<MatrixCheck> matrix_;
  LinearReport linear_;
};

}  // namespace voropack
