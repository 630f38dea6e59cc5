#include "solve/conjugate_gradients.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "base/parallel.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// The vectors of the iteration and what stays the same in it.
class Iteration {
 public:
  Iteration(const LinearSystem& system, const Preconditioner& preconditioner, Observer& observer, LinearReport& report)
      : system_(system),
        preconditioner_(preconditioner),
        observer_(observer),
        report_(report),
        residual_(system.matrix.size()),
        correction_(system.matrix.size()),
        direction_(system.matrix.size()),
        image_(system.matrix.size()) {}

  /// Sets the residual to that of `values` and returns its norm.
  double start(const std::vector<double>& values) {
    free_residual(system_, values, residual_);
    return norm(residual_);
  }

  /// Iterates from the residual of `start` until the one that the recurrence knows is at most `goal`.
  void run(double goal, double unit, int max_iterations, std::vector<double>& values) {
    double norm_now = norm(residual_), previous = 0;
    for (bool is_first = true; norm_now > goal; is_first = false) {
      observer_.check_cancelled();
      if (report_.n_iterations == max_iterations) throw_not_converged(norm_now / unit);
      preconditioner_.apply(residual_, correction_);
      const double product = dot(residual_, correction_);
      const double beta = is_first ? 0 : product / previous;
      parallel_for(direction_.size(), [&](std::size_t i) { direction_[i] = correction_[i] + beta * direction_[i]; });
      multiply(system_.matrix, direction_, image_);
      const double curvature = dot(direction_, image_);
      if (!(curvature > 0) || !(product > 0)) throw_singular();
      const double alpha = product / curvature;
      parallel_for(values.size(), [&](std::size_t i) {
        if (system_.is_fixed[VertexId(i)] != 0) return;
        values[i] += alpha * direction_[i];
        residual_[i] -= alpha * image_[i];
      });
      previous = product;
      norm_now = norm(residual_);
      report_.residuals.push_back(norm_now / unit);
      ++report_.n_iterations;
    }
  }

 private:
  [[noreturn]] void throw_not_converged(double residual) const {
    throw NumericalError(Fault{
        .id = "solve.not_converged",
        .message = fmt::format("conjugate gradients with {} preconditioner reached a relative residual of {:.3g} in {} "
                               "iterations",
                               preconditioner_.name(), residual, report_.n_iterations),
        .fix = "raise the number of iterations or the tolerance, or use the direct solver"});
  }
  [[noreturn]] static void throw_singular() {
    throw NumericalError(Fault{.id = "solve.singular",
                               .message = "the matrix is not positive definite",
                               .fix = "check the mesh for negative dual faces, and the conditions"});
  }

  const LinearSystem& system_;
  const Preconditioner& preconditioner_;
  Observer& observer_;
  LinearReport& report_;
  // All are 0 at fixed vertices but for image_, so that products with it see free vertices only.
  std::vector<double> residual_, correction_, direction_, image_;
};

}  // namespace

void conjugate_gradients(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
                         Observer& observer, std::vector<double>& values, LinearReport& report) {
  Iteration iteration(system, preconditioner, observer, report);
  double reached = iteration.start(values);
  report.residuals = {reached / goal.unit};
  report.residual = reached / goal.unit;
  // The residual of the recurrence drifts away from the true one by rounding. Where that matters, the iteration begins
  // anew from the true one, as long as this gains something.
  for (double before = 2 * reached; reached > goal.tolerance * goal.unit && reached <= 0.5 * before;) {
    iteration.run(goal.tolerance * goal.unit, goal.unit, goal.max_iterations, values);
    before = reached;
    reached = iteration.start(values);
    report.residual = reached / goal.unit;
  }
}

}  // namespace voropack
