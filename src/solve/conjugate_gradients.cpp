#include "solve/conjugate_gradients.h"

#include <cstddef>

#include "base/parallel.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// The vectors of the iteration and what stays the same in it.
class Iteration {
 public:
  Iteration(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
            Observer& observer, LinearReport& report)
      : system_(system),
        preconditioner_(preconditioner),
        goal_(goal),
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

  /// Iterates from the residual of `start` until the one that the recurrence knows is small enough.
  void run(std::vector<double>& values) {
    double norm_now = norm(residual_), previous = 0;
    for (bool is_first = true; norm_now > goal_.tolerance * goal_.unit; is_first = false) {
      observer_.check_cancelled();
      if (report_.n_iterations == goal_.max_iterations)
        throw_not_converged("conjugate gradients", preconditioner_, norm_now / goal_.unit, report_.n_iterations);
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
      report_.residuals.push_back(norm_now / goal_.unit);
      ++report_.n_iterations;
    }
  }

 private:
  [[noreturn]] static void throw_singular() {
    throw NumericalError(Fault{.id = "solve.singular",
                               .message = "the matrix is not positive definite",
                               .fix = "check the mesh for negative dual faces, and the conditions"});
  }

  const LinearSystem& system_;
  const Preconditioner& preconditioner_;
  const IterationGoal& goal_;
  Observer& observer_;
  LinearReport& report_;
  // All are 0 at fixed vertices but for image_, so that products with it see free vertices only.
  std::vector<double> residual_, correction_, direction_, image_;
};

}  // namespace

void conjugate_gradients(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
                         Observer& observer, std::vector<double>& values, LinearReport& report) {
  Iteration iteration(system, preconditioner, goal, observer, report);
  iterate_to(goal, iteration, values, report);
}

}  // namespace voropack
