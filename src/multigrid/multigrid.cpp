#include "voropack/multigrid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "multigrid/hierarchy.h"
#include "multigrid/singular_parts.h"
#include "voropack/error.h"

namespace voropack {

namespace {

void check_options(const MultigridOptions& options) {
  const auto fail = [](std::string message, std::string fix) {
    throw OptionError(Fault{.id = "multigrid.bad_option", .message = std::move(message), .fix = std::move(fix)});
  };
  if (options.n_smoothing < 1)
    fail(fmt::format("multigrid is to smooth {} times", options.n_smoothing), "smooth at least once");
  if (options.chebyshev_degree < 1 || options.chebyshev_degree > 10)
    fail(fmt::format("the Chebyshev polynomial has degree {}", options.chebyshev_degree), "choose it from 1 to 10");
  if (!(options.chebyshev_range > 1 && std::isfinite(options.chebyshev_range)))
    fail(fmt::format("the range of the Chebyshev polynomial is {}", options.chebyshev_range), "choose it above 1");
}

/// Whether rows and columns are as many as they should be, and in range.
bool fits(const SparseMatrix& matrix, std::size_t n_rows, std::size_t n_columns) {
  return matrix.size() == n_rows && matrix.offsets.back() == matrix.columns.size() &&
         matrix.columns.size() == matrix.values.size() &&
         std::all_of(matrix.columns.begin(), matrix.columns.end(), [&](std::uint32_t c) { return c < n_columns; });
}

void check_levels(const LinearSystem& system, std::span<const MultigridLevel> levels) {
  const auto fail = [](std::size_t level, std::string_view what) {
    throw InputError(Fault{.id = "multigrid.bad_level",
                           .message = fmt::format("level {} of the hierarchy: {}", level, what),
                           .fix = "give arrays that belong to the same hierarchy"});
  };
  const std::size_t n_finest = system.matrix.size();
  if (system.is_fixed.size() != n_finest || system.absorption.size() != n_finest ||
      !fits(system.matrix, n_finest, n_finest))
    fail(0, "the arrays of the system do not fit together");
  if (!system.is_symmetric)
    throw InputError(Fault{.id = "multigrid.unsymmetric",
                           .message = "multigrid smooths and corrects symmetric matrices only",
                           .fix = "use incomplete factors as preconditioner"});
  std::size_t n_finer = n_finest;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const MultigridLevel& level = levels[k];
    const std::size_t n = level.finest_vertex.size();
    if (level.prolongation == nullptr) fail(k + 1, "it has no prolongation");
    if (!fits(*level.prolongation, n_finer, n))
      fail(k + 1, fmt::format("the prolongation is not one from {} to {} vertices", n, n_finer));
    if (level.matrix != nullptr && !fits(*level.matrix, n, n))
      fail(k + 1, fmt::format("the matrix is not one of {} vertices", n));
    for (const VertexId v : level.finest_vertex)
      if (v.value() >= n_finest)
        fail(k + 1, fmt::format("the finest level has no vertex {} (counted from 0)", v.value()));
    n_finer = n;
  }
}

}  // namespace

Multigrid::Multigrid(const LinearSystem& system, std::span<const MultigridLevel> levels,
                     const MultigridOptions& options) {
  check_options(options);
  check_levels(system, levels);
  singular_parts_ = std::make_unique<const SingularParts>(system);
  const std::vector<std::uint8_t> is_fixed = singular_parts_->without_held(system);
  hierarchy_ = build_hierarchy(
      {.matrix = &system.matrix, .levels = levels, .is_fixed = is_fixed, .floating_part = singular_parts_->part()},
      options, report_);
  report_.n_floating = singular_parts_->size();
  double n_entries = 0, n_unknowns = 0;
  for (const MultigridLevelReport& level : report_.levels) {
    n_entries += static_cast<double>(level.n_entries);
    n_unknowns += static_cast<double>(level.n_unknowns);
  }
  const MultigridLevelReport& finest = report_.levels.front();
  report_.operator_complexity = n_entries / std::max(1.0, static_cast<double>(finest.n_entries));
  report_.grid_complexity = n_unknowns / std::max(1.0, static_cast<double>(finest.n_unknowns));
}

Multigrid::~Multigrid() = default;

void Multigrid::apply(std::span<const double> residual, std::span<double> correction) const {
  apply_cycle(residual, false, correction);
}

void Multigrid::apply_full(std::span<const double> residual, std::span<double> correction) const {
  apply_cycle(residual, true, correction);
}

void Multigrid::apply_cycle(std::span<const double> residual, bool is_full, std::span<double> correction) const {
  if (singular_parts_->empty()) return hierarchy_->apply(residual, is_full, correction);
  std::vector<double> compatible(residual.size());
  singular_parts_->make_compatible(residual, compatible);
  hierarchy_->apply(compatible, is_full, correction);
  singular_parts_->shift(correction);
}

std::shared_ptr<const Multigrid> make_multigrid(const LinearSystem& system, std::span<const MultigridLevel> levels,
                                                const MultigridOptions& options) {
  return std::make_shared<const Multigrid>(system, levels, options);
}

}  // namespace voropack
