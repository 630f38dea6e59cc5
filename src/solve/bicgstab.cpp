#include "solve/bicgstab.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "base/parallel.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// The vectors of the iteration [Vorst1992]. All are 0 at fixed vertices.
class Iteration {
 public:
  Iteration(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
            Observer& observer, LinearReport& report)
      : system_(system), preconditioner_(preconditioner), goal_(goal), observer_(observer), report_(report) {
    for (auto* const v : {&residual_, &shadow_, &direction_, &image_, &correction_, &second_image_})
      v->resize(system.matrix.size());
  }

  /// Sets the residual to that of `values` and returns its norm.
  double start(const std::vector<double>& values) {
    free_residual(system_, values, residual_);
    return norm(residual_);
  }

  /// Iterates from the residual of `start` until the one that the recurrence knows is small enough.
  void run(std::vector<double>& values) {
    double product = 0;
    for (double norm_now = norm(residual_); norm_now > goal_.tolerance * goal_.unit;) {
      observer_.check_cancelled();
      if (report_.n_iterations == goal_.max_iterations)
        throw_not_converged("BiCGSTAB", preconditioner_, norm_now / goal_.unit, report_.n_iterations);
      product = renew_direction(product, norm_now);
      step(product, values);
      norm_now = norm(residual_);
      if (!std::isfinite(norm_now)) throw_broken_down();
      report_.residuals.push_back(norm_now / goal_.unit);
      ++report_.n_iterations;
    }
  }

 private:
  /// Returns the product of residual and shadow. Where that has lost all digits, the recurrence begins anew.
  double renew_direction(double before, double norm_now) {
    const double product = dot(shadow_, residual_);
    if (before == 0 || !(std::abs(product) > std::numeric_limits<double>::epsilon() * norm(shadow_) * norm_now)) {
      shadow_ = residual_;
      direction_ = residual_;
      return norm_now * norm_now;
    }
    const double beta = (product / before) * (alpha_ / omega_);
    parallel_for(direction_.size(),
                 [&](std::size_t i) { direction_[i] = residual_[i] + beta * (direction_[i] - omega_ * image_[i]); });
    return product;
  }

  /// Along the direction, and then along the residual that is left.
  void step(double product, std::vector<double>& values) {
    preconditioner_.apply(direction_, correction_);
    multiply_free(correction_, image_);
    alpha_ = product / dot(shadow_, image_);
    parallel_for(values.size(), [&](std::size_t i) {
      values[i] += alpha_ * correction_[i];
      residual_[i] -= alpha_ * image_[i];
    });
    preconditioner_.apply(residual_, correction_);
    multiply_free(correction_, second_image_);
    const double square = dot(second_image_, second_image_);
    omega_ = square > 0 ? dot(second_image_, residual_) / square : 0.0;
    parallel_for(values.size(), [&](std::size_t i) {
      values[i] += omega_ * correction_[i];
      residual_[i] -= omega_ * second_image_[i];
    });
  }

  void multiply_free(const std::vector<double>& x, std::vector<double>& y) const {
    multiply(system_.matrix, x, y);
    parallel_for(y.size(), [&](std::size_t i) {
      if (system_.is_fixed[VertexId(i)] != 0) y[i] = 0;
    });
  }

  [[noreturn]] static void throw_broken_down() {
    throw NumericalError(Fault{.id = "solve.singular",
                               .message = "BiCGSTAB broke down: the matrix is singular or far from an M-matrix",
                               .fix = "check the conditions, or use the direct solver"});
  }

  const LinearSystem& system_;
  const Preconditioner& preconditioner_;
  const IterationGoal& goal_;
  Observer& observer_;
  LinearReport& report_;
  double alpha_ = 1, omega_ = 1;
  std::vector<double> residual_, shadow_, direction_, image_, correction_, second_image_;
};

}  // namespace

void bicgstab(const LinearSystem& system, const Preconditioner& preconditioner, const IterationGoal& goal,
              Observer& observer, std::vector<double>& values, LinearReport& report) {
  Iteration iteration(system, preconditioner, goal, observer, report);
  iterate_to(goal, iteration, values, report);
}

}  // namespace voropack
