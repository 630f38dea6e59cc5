#include "multigrid/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/parallel.h"
#include "multigrid/chebyshev.h"
#include "multigrid/coarsest.h"
#include "multigrid/level_matrix.h"
#include "multigrid/raw_array.h"
#include "multigrid/transfer.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// Sweeps forward and backward on a coarsest level that is too large for a direct solution.
constexpr int kCoarsestSweeps = 20;

template <class Real>
struct Level {
  LevelMatrix<Real> matrix;
  std::optional<ChebyshevSmoother<Real>> chebyshev;
  std::optional<TransferMatrix<Real>> prolongation, restriction;  ///< From and to the next coarser level.
};

/// The vectors of one level during a cycle.
template <class Real>
struct LevelVectors {
  explicit LevelVectors(std::size_t n) : load(n), values(n), scratch(n), extra(n) {}
  RawArray<Real> load, values, scratch, extra;
};

template <class Real>
class HierarchyOf final : public MultigridHierarchy {
 public:
  HierarchyOf(const HierarchyInput& input, const MultigridOptions& options, MultigridReport& report);
  void apply(std::span<const double> residual, bool is_full, std::span<double> correction) const override;

 private:
  using Vectors = std::vector<LevelVectors<Real>>;

  void add_level(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, bool is_galerkin,
                 MultigridReport& report);
  void add_coarsest_solver(const SparseMatrix& matrix, std::vector<std::uint8_t> is_fixed,
                           std::span<const VertexId> finest_vertex, std::span<const std::uint32_t> floating_part);
  void solve_coarsest(LevelVectors<Real>& v) const;
  void smooth(const Level<Real>& level, bool is_zero, bool is_backward, LevelVectors<Real>& v) const;
  void residual(const Level<Real>& level, bool was_zero, LevelVectors<Real>& v) const;
  void cycle(std::size_t k, bool is_zero, Vectors& vectors) const;
  void full_cycle(Vectors& vectors) const;
  std::unique_ptr<Vectors> take_vectors() const;

  MultigridOptions options_;
  double scale_ = 1;  ///< Matrices are stored multiplied by it, so that they fit into the range of floats.
  std::vector<Level<Real>> levels_;
  std::optional<CoarsestSolver> coarsest_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Vectors>> unused_;  ///< Vectors of cycles that have ended.
};

/// A power of two at or above 1 / x, so that scaling does not round.
double inverse_power_of_two(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  return std::ldexp(1.0, -exponent);
}

double largest_magnitude(std::span<const double> x) {
  return parallel_reduce_ordered(
      x.size(), kVectorBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (std::size_t i = begin; i != end; ++i) largest = std::max(largest, std::abs(x[i]));
        return largest;
      },
      [](double a, double b) { return std::max(a, b); });
}

std::vector<std::uint8_t> fixed_of(std::span<const VertexId> finest_vertex, std::span<const std::uint8_t> is_fixed) {
  std::vector<std::uint8_t> coarse(finest_vertex.size());
  for (std::size_t c = 0; c < coarse.size(); ++c) coarse[c] = is_fixed[finest_vertex[c].value()];
  return coarse;
}

template <class Real>
HierarchyOf<Real>::HierarchyOf(const HierarchyInput& input, const MultigridOptions& options, MultigridReport& report)
    : options_(options) {
  const double largest = largest_magnitude(input.matrix->values);
  if (largest > 0) scale_ = inverse_power_of_two(largest);
  std::vector<std::uint8_t> is_fixed(input.is_fixed.begin(), input.is_fixed.end());
  std::span<const VertexId> finest_vertex;
  const SparseMatrix* matrix = input.matrix;
  std::optional<SparseMatrix> galerkin;
  add_level(*matrix, is_fixed, false, report);
  for (const MultigridLevel& level : input.levels) {
    if (report.levels.back().n_unknowns <= options.enough) break;
    std::vector<std::uint8_t> is_coarse_fixed = fixed_of(level.finest_vertex, input.is_fixed);
    levels_.back().prolongation.emplace(*level.prolongation, is_fixed, is_coarse_fixed);
    levels_.back().restriction.emplace(transpose(*level.prolongation, level.finest_vertex.size()), is_coarse_fixed,
                                       is_fixed);
    if (level.matrix != nullptr) {
      matrix = level.matrix;
    } else {
      galerkin = galerkin_product(*matrix, *level.prolongation, is_fixed, is_coarse_fixed);
      matrix = &*galerkin;
    }
    is_fixed = std::move(is_coarse_fixed);
    finest_vertex = level.finest_vertex;
    add_level(*matrix, is_fixed, level.matrix == nullptr, report);
  }
  report.is_coarsest_direct = report.levels.back().n_unknowns <= options.max_direct;
  if (report.is_coarsest_direct) add_coarsest_solver(*matrix, std::move(is_fixed), finest_vertex, input.floating_part);
}

template <class Real>
void HierarchyOf<Real>::add_level(const SparseMatrix& matrix, std::span<const std::uint8_t> is_fixed, bool is_galerkin,
                                  MultigridReport& report) {
  levels_.push_back({.matrix = LevelMatrix<Real>(matrix, is_fixed, scale_),
                     .chebyshev = std::nullopt,
                     .prolongation = std::nullopt,
                     .restriction = std::nullopt});
  Level<Real>& level = levels_.back();
  if (options_.smoother == MultigridSmoother::kChebyshev)
    level.chebyshev.emplace(level.matrix, options_.chebyshev_degree, options_.chebyshev_range);
  report.levels.push_back(
      {.n_unknowns = level.matrix.n_free(), .n_entries = level.matrix.n_entries(), .is_galerkin = is_galerkin});
}

/// A part that is free up to a constant is held at its first vertex: loads that add up to 0 let that be any value.
template <class Real>
void HierarchyOf<Real>::add_coarsest_solver(const SparseMatrix& matrix, std::vector<std::uint8_t> is_fixed,
                                            std::span<const VertexId> finest_vertex,
                                            std::span<const std::uint32_t> floating_part) {
  if (!floating_part.empty()) {
    std::vector<bool> is_held(floating_part.size() + 1, false);
    for (std::size_t c = 0; c < is_fixed.size(); ++c) {
      const std::uint32_t part = floating_part[finest_vertex.empty() ? c : finest_vertex[c].value()];
      if (part == 0 || is_held[part] || is_fixed[c] != 0) continue;
      is_held[part] = true;
      is_fixed[c] = 1;
    }
  }
  coarsest_.emplace(matrix, is_fixed, scale_);
}

template <class Real>
void HierarchyOf<Real>::solve_coarsest(LevelVectors<Real>& v) const {
  if (coarsest_) return coarsest_->solve(v.load, v.values);
  const LevelMatrix<Real>& matrix = levels_.back().matrix;
  matrix.symmetric_sweep_from_zero(v.load.data(), v.scratch.data(), v.extra.data(), v.values.data());
  for (int sweep = 1; sweep < kCoarsestSweeps; ++sweep)
    matrix.symmetric_sweep(v.load.data(), v.scratch.data(), v.extra.data(), v.values.data());
}

template <class Real>
void HierarchyOf<Real>::smooth(const Level<Real>& level, bool is_zero, bool is_backward, LevelVectors<Real>& v) const {
  Real *load = v.load.data(), *values = v.values.data(), *scratch = v.scratch.data(), *extra = v.extra.data();
  switch (options_.smoother) {
    case MultigridSmoother::kChebyshev:
      return level.chebyshev->smooth(level.matrix, load, is_zero, values, scratch, extra);
    case MultigridSmoother::kSymmetricGaussSeidel:
      if (is_zero) return level.matrix.symmetric_sweep_from_zero(load, scratch, extra, values);
      return level.matrix.symmetric_sweep(load, scratch, extra, values);
    case MultigridSmoother::kGaussSeidel:
      if (is_zero) return level.matrix.sweep_from_zero(load, values);
      level.matrix.sweep(load, values, is_backward, scratch);
      return std::swap(v.values, v.scratch);
  }
}

/// The residual of the level in its scratch. What the first sweeps leave is known in part.
template <class Real>
void HierarchyOf<Real>::residual(const Level<Real>& level, bool was_zero, LevelVectors<Real>& v) const {
  if (was_zero && options_.n_smoothing == 1 && options_.smoother == MultigridSmoother::kGaussSeidel)
    level.matrix.residual_after_sweep(v.values.data(), v.scratch.data());
  else if (was_zero && options_.n_smoothing == 1 && options_.smoother == MultigridSmoother::kSymmetricGaussSeidel)
    level.matrix.residual_after_symmetric_sweep(v.extra.data(), v.scratch.data());
  else
    level.matrix.residual(v.load.data(), v.values.data(), v.scratch.data());
}

/// Improves the values of level k for its load; overwrites those of the coarser levels.
template <class Real>
void HierarchyOf<Real>::cycle(std::size_t k, bool is_zero, Vectors& vectors) const {
  LevelVectors<Real>& fine = vectors[k];
  if (k + 1 == levels_.size()) return solve_coarsest(fine);
  const Level<Real>& level = levels_[k];
  for (int step = 0; step < options_.n_smoothing; ++step) smooth(level, is_zero && step == 0, false, fine);
  residual(level, is_zero, fine);
  LevelVectors<Real>& coarse = vectors[k + 1];
  level.restriction->multiply(fine.scratch.data(), false, coarse.load.data());
  // The second visit of a direct solution would change nothing.
  const bool is_last = k + 2 == levels_.size();
  const int n_visits = options_.cycle == MultigridCycle::kW && !is_last ? 2 : 1;
  for (int visit = 0; visit < n_visits; ++visit) cycle(k + 1, visit == 0, vectors);
  level.prolongation->multiply(coarse.values.data(), true, fine.values.data());
  for (int step = 0; step < options_.n_smoothing; ++step) smooth(level, false, true, fine);
}

template <class Real>
void HierarchyOf<Real>::full_cycle(Vectors& vectors) const {
  for (std::size_t k = 0; k + 1 < levels_.size(); ++k)
    levels_[k].restriction->multiply(vectors[k].load.data(), false, vectors[k + 1].load.data());
  solve_coarsest(vectors.back());
  for (std::size_t k = levels_.size() - 1; k-- > 0;) {
    levels_[k].prolongation->multiply(vectors[k + 1].values.data(), false, vectors[k].values.data());
    cycle(k, false, vectors);
  }
}

template <class Real>
auto HierarchyOf<Real>::take_vectors() const -> std::unique_ptr<Vectors> {
  {
    const std::lock_guard lock(mutex_);
    if (!unused_.empty()) {
      auto vectors = std::move(unused_.back());
      unused_.pop_back();
      return vectors;
    }
  }
  auto vectors = std::make_unique<Vectors>();
  for (const Level<Real>& level : levels_) vectors->emplace_back(level.matrix.size());
  return vectors;
}

template <class Real>
void HierarchyOf<Real>::apply(std::span<const double> residual, bool is_full, std::span<double> correction) const {
  const double largest = largest_magnitude(residual);
  if (!(largest > 0)) {
    std::fill(correction.begin(), correction.end(), 0.0);
    return;
  }
  const double unit = inverse_power_of_two(largest);
  auto vectors = take_vectors();
  LevelVectors<Real>& finest = vectors->front();
  parallel_for(residual.size(), [&](std::size_t i) { finest.load[i] = static_cast<Real>(residual[i] * unit); });
  if (is_full)
    full_cycle(*vectors);
  else
    cycle(0, true, *vectors);
  const double back = scale_ / unit;
  parallel_for(residual.size(), [&](std::size_t i) { correction[i] = static_cast<double>(finest.values[i]) * back; });
  const std::lock_guard lock(mutex_);
  unused_.push_back(std::move(vectors));
}

}  // namespace

std::unique_ptr<const MultigridHierarchy> build_hierarchy(const HierarchyInput& input, const MultigridOptions& options,
                                                          MultigridReport& report) {
  if (options.is_single_precision) return std::make_unique<HierarchyOf<float>>(input, options, report);
  return std::make_unique<HierarchyOf<double>>(input, options, report);
}

}  // namespace voropack
