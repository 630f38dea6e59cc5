// A matrix made ready for any number of loads.
#pragma once

#include <memory>
#include <optional>

#include "solve/direct_solver.h"
#include "voropack/linear_system.h"

namespace voropack {

/// Holds the factors or the preconditioner of one matrix.
class LinearSolver {
 public:
  /// Throws as `solve_linear_system`.
  LinearSolver(const LinearSystem& system, const LinearOptions& options);

  /// Solves a system with the same matrix and fixed vertices. Iterations begin with `guess` at free vertices, or 0.
  [[nodiscard]] LinearSolution solve(const LinearSystem& system, Observer& observer,
                                     const IdVector<VertexId, double>* guess = nullptr) const;

 private:
  LinearOptions options_;
  std::uint64_t n_unknowns_;
  std::optional<DirectSolver> direct_;
  std::shared_ptr<const Preconditioner> preconditioner_;
};

}  // namespace voropack
