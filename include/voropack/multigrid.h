// Multigrid over a given hierarchy, as a solver and as a preconditioner of symmetric systems. Knows no geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "voropack/index.h"
#include "voropack/linear_system.h"
#include "voropack/observer.h"

namespace voropack {

/// One coarser level, seen in arrays that belong to the caller.
struct MultigridLevel {
  /// Rows are the vertices of the next finer level, columns those of this one: x_finer = P x. Of piecewise linear
  /// functions, a row holds barycentric coordinates. No diagonal has to be listed.
  const SparseMatrix* prolongation = nullptr;
  /// [n_vertices] the vertex of the finest level at the same place, which says whether it is fixed and to which
  /// connected part it belongs.
  std::span<const VertexId> finest_vertex;
  /// The control volume matrix of this level's mesh. Without it the Galerkin operator P^T A P is used.
  const SparseMatrix* matrix = nullptr;
};

enum class MultigridCycle : std::uint8_t {
  kV,  ///< Visits the next coarser level once.
  kW,  ///< Twice.
};

/// Gauss-Seidel goes in blocks of consecutive vertices, which see each other's old values: the same result for any
/// number of threads. It converges for every symmetric positive definite matrix, see docs/theory/multigrid.md.
enum class MultigridSmoother : std::uint8_t {
  kSymmetricGaussSeidel,  ///< A step is a forward and a backward sweep.
  kGaussSeidel,           ///< A step is a forward sweep before the coarse correction, a backward sweep after it.
  /// A Chebyshev polynomial in the matrix scaled by its diagonal, which damps the upper part of its spectrum.
  kChebyshev,
};

struct MultigridOptions {
  MultigridCycle cycle = MultigridCycle::kV;
  MultigridSmoother smoother = MultigridSmoother::kSymmetricGaussSeidel;
  int n_smoothing = 1;              ///< Steps before and after the coarse correction, >= 1: as many, for symmetry.
  int chebyshev_degree = 2;         ///< Products with the matrix in one step of kChebyshev. In [1, 10].
  double chebyshev_range = 4;       ///< It damps eigenvalues in [largest / range, largest]. Above 1.
  std::size_t enough = 1'000;       ///< The first level with at most so many unknowns is solved directly.
  std::size_t max_direct = 10'000;  ///< The coarsest level is solved directly up to this size. Beyond, it is smoothed
                                    ///< many times: MultigridReport::is_coarsest_direct says so.
  bool is_single_precision = true;  ///< Levels in float. Iterations around it are in double, so that accuracy is not
                                    ///< concerned; the time of a cycle is that of its memory traffic.
};

struct MultigridLevelReport {
  std::uint64_t n_unknowns = 0;  ///< Free vertices.
  std::uint64_t n_entries = 0;   ///< Of the matrix at free vertices.
  bool is_galerkin = false;
};

struct MultigridReport {
  std::vector<MultigridLevelReport> levels;  ///< Finest first.
  double operator_complexity = 0;            ///< Entries of all levels over those of the finest.
  double grid_complexity = 0;                ///< Unknowns of all levels over those of the finest.
  bool is_coarsest_direct = true;
  std::size_t n_floating = 0;  ///< Connected parts where the solution is free up to a constant, or held at one vertex.
};

class MultigridHierarchy;
class SingularParts;

/// A hierarchy of matrices with cycles over it. Immutable; `apply` may be called by several threads at once.
///
/// Fixed vertices get no correction on any level. Where nothing but one fixed vertex holds a connected part, as
/// `solve` leaves it for Neumann conditions, the part is treated as what it is, a singular problem, and the result
/// is shifted so that it vanishes at that vertex: the convergence is that of the singular problem.
///
/// Results have the same bytes for any number of threads.
class Multigrid final : public Preconditioner {
 public:
  /// `levels` go from fine to coarse; none of it is kept. Cost: O(n), some twenty products of the matrix and a vector
  /// where coarse matrices are given, some hundred for Galerkin operators.
  ///
  /// Throws: OptionError    multigrid.bad_option  if an option is out of its range.
  ///         InputError     multigrid.bad_level   if arrays do not fit together; says which level.
  ///         InputError     multigrid.unsymmetric if the system says that its matrix is not symmetric.
  ///         NumericalError multigrid.singular    if a matrix has a diagonal entry that is not positive at a free
  ///                                              vertex, or the coarsest one is not positive definite.
  ///         LimitError     multigrid.too_large   if a level has 2^32 entries or more.
  Multigrid(const LinearSystem& system, std::span<const MultigridLevel> levels, const MultigridOptions& options = {});
  ~Multigrid() override;
  Multigrid(const Multigrid&) = delete;
  Multigrid& operator=(const Multigrid&) = delete;

  /// One cycle from the correction 0: symmetric and positive definite.
  void apply(std::span<const double> residual, std::span<double> correction) const override;
  /// Full multigrid: solves on the coarsest level, then goes up with one cycle on each. Not symmetric: a start, not a
  /// preconditioner.
  void apply_full(std::span<const double> residual, std::span<double> correction) const;
  [[nodiscard]] std::string name() const override { return "multigrid"; }
  [[nodiscard]] const MultigridReport& report() const { return report_; }

 private:
  void apply_cycle(std::span<const double> residual, bool is_full, std::span<double> correction) const;

  std::unique_ptr<const SingularParts> singular_parts_;
  std::unique_ptr<const MultigridHierarchy> hierarchy_;
  MultigridReport report_;
};

/// The same as a value that LinearOptions::own_preconditioner can return.
std::shared_ptr<const Multigrid> make_multigrid(const LinearSystem& system, std::span<const MultigridLevel> levels,
                                                const MultigridOptions& options = {});

struct MultigridSolveOptions {
  double tolerance = 1e-8;  ///< Residual norm relative to that of the solution 0 at free vertices. In (0, 1).
  int max_cycles = 100;
  bool starts_with_full = true;  ///< The first cycle is full multigrid.
};

/// Solves by cycles alone. LinearReport::n_iterations counts cycles; `contraction` is set.
///
/// Cycles end when the residual has fallen below the tolerance, or when rounding does not let it fall any more.
/// Throws: OptionError    multigrid.bad_option    if an option is out of its range.
///         NumericalError multigrid.not_converged if max_cycles do not suffice.
///         Cancelled      if the observer asks to stop.
LinearSolution solve_by_multigrid(const LinearSystem& system, const Multigrid& multigrid,
                                  const MultigridSolveOptions& options = {}, Observer& observer = silent_observer());

/// P^T, with ascending columns, of a matrix with n_columns columns. In parallel; the same bytes for any number of
/// threads.
SparseMatrix transpose(const SparseMatrix& matrix, std::size_t n_columns);

/// P^T A P, where rows of P with is_fixed and columns of P with is_coarse_fixed count as 0. Its diagonal is listed. In
/// parallel; the same bytes for any number of threads.
SparseMatrix galerkin_product(const SparseMatrix& matrix, const SparseMatrix& prolongation,
                              std::span<const std::uint8_t> is_fixed, std::span<const std::uint8_t> is_coarse_fixed);

}  // namespace voropack
