// Multigrid cycles as a solver of their own.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/iteration_limits.h"
#include "solve/vectors.h"
#include "voropack/error.h"
#include "voropack/multigrid.h"

namespace voropack {

namespace {

/// What rounding leaves of the residual load - A x, in norm: a few units in the last place of the terms of each row.
double rounding_of_residual(const LinearSystem& system, const std::vector<double>& values) {
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  const SparseMatrix& matrix = system.matrix;
  std::vector<double> magnitude(values.size());
  parallel_for(values.size(), [&](std::size_t i) {
    if (system.is_fixed[VertexId(i)] != 0) return;
    double sum = std::abs(system.load[VertexId(i)]);
    for (std::uint64_t e = matrix.offsets[i]; e != matrix.offsets[i + 1]; ++e)
      sum += std::abs(matrix.values[e] * values[matrix.columns[e]]);
    magnitude[i] = kRounding * sum;
  });
  return norm(magnitude);
}

/// The geometric mean of the factors of the last half of the cycles: the first ones remove what is easy.
double final_contraction(const std::vector<double>& residuals) {
  const std::size_t last = residuals.size() - 1, first = last / 2;
  if (last == first || !(residuals[first] > 0)) return 0;
  return std::pow(residuals[last] / residuals[first], 1 / static_cast<double>(last - first));
}

}  // namespace

LinearSolution solve_by_multigrid(const LinearSystem& system, const Multigrid& multigrid,
                                  const MultigridSolveOptions& options, Observer& observer) {
  check_iteration_limits("multigrid.bad_option", "multigrid", options.tolerance, options.max_cycles, "cycles");
  observer.begin_stage("solve");
  LinearSolution solution{.values = system.fixed_value, .report = {}};
  LinearReport& report = solution.report;
  report.method = "multigrid";
  report.n_unknowns = static_cast<std::uint64_t>(std::count(system.is_fixed.begin(), system.is_fixed.end(), 0));
  report.n_entries = system.matrix.values.size();
  std::vector<double>& values = solution.values.raw();
  std::vector<double> residual(values.size()), correction(values.size());
  free_residual(system, values, residual);
  const double unit = norm(residual);
  report.residuals = {unit > 0 ? 1.0 : 0.0};
  if (unit == 0) return solution;
  constexpr double kStagnation = 0.9;
  for (double now = 1, before = 2; now > options.tolerance;) {
    if (now > kStagnation * before && now * unit <= rounding_of_residual(system, values)) break;
    observer.check_cancelled();
    if (report.n_iterations == options.max_cycles || !(now < 1e10))
      throw NumericalError(Fault{.id = "multigrid.not_converged",
                                 .message = fmt::format("multigrid reached a relative residual of {:.3g} in {} cycles",
                                                        now, report.n_iterations),
                                 .fix = "use it as preconditioner of conjugate gradients"});
    if (report.n_iterations == 0 && options.starts_with_full)
      multigrid.apply_full(residual, correction);
    else
      multigrid.apply(residual, correction);
    parallel_for(values.size(), [&](std::size_t i) { values[i] += correction[i]; });
    free_residual(system, values, residual);
    before = now;
    now = norm(residual) / unit;
    report.residuals.push_back(now);
    ++report.n_iterations;
  }
  report.residual = report.residuals.back();
  std::vector<double> falling = report.residuals;
  while (falling.size() > 2 && falling.back() > kStagnation * falling[falling.size() - 2]) falling.pop_back();
  report.contraction = final_contraction(falling);
  return solution;
}

}  // namespace voropack
