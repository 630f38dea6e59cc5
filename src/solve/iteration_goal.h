// When an iteration ends.
#pragma once

namespace voropack {

struct IterationGoal {
  double tolerance = 0;  ///< Relative to `unit`.
  double unit = 0;       ///< The residual norm of the solution 0, > 0.
  int max_iterations = 0;
};

}  // namespace voropack
