// Multigrid cycles as a solver of their own.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "solve/vectors.h"
#include "voropack/error.h"
#include "voropack/multigrid.h"

namespace voropack {

namespace {

void check_options(const MultigridSolveOptions& options) {
  const auto fail = [](std::string message, std::string fix) {
    throw OptionError(Fault{.id = "multigrid.bad_option", .message = std::move(message), .fix = std::move(fix)});
  };
  if (!(options.tolerance > 0 && options.tolerance < 1))
    fail(fmt::format("the tolerance of multigrid is {}", options.tolerance), "choose it between 0 and 1");
  if (options.max_cycles < 1) fail(fmt::format("multigrid may make {} cycles", options.max_cycles), "allow at least 1");
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
  check_options(options);
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
  // Rounding ends the descent: a cycle that gains less than a tenth does so near the limit of double precision only.
  constexpr double kStagnation = 0.9, kNearRounding = 1e-10;
  for (double now = 1, before = 2; now > options.tolerance;) {
    if (now < kNearRounding && now > kStagnation * before) break;
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
  report.contraction = final_contraction(report.residuals);
  return solution;
}

}  // namespace voropack
