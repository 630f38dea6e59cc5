// Sparse systems over the vertices of a mesh, and their solution. Knows no geometry.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "voropack/index.h"
#include "voropack/observer.h"

namespace voropack {

/// A square sparse matrix in compressed rows. Row r has the entries offsets[r] .. offsets[r + 1] - 1.
struct SparseMatrix {
  std::vector<std::uint64_t> offsets = {0};  ///< [n + 1]
  std::vector<std::uint32_t> columns;        ///< [n_entries] ascending in each row; the diagonal is always listed.
  std::vector<double> values;                ///< [n_entries]

  [[nodiscard]] std::size_t size() const { return offsets.size() - 1; }
  friend bool operator==(const SparseMatrix&, const SparseMatrix&) = default;
};

/// y = A x, in parallel; the same bytes for any number of threads.
void multiply(const SparseMatrix& matrix, std::span<const double> x, std::span<double> y);

/// matrix u = load at the vertices that are free, u = fixed_value at the others.
///
/// The rows of fixed vertices are there as well: (matrix u - load)[i] is what has to enter at i so that u keeps the
/// fixed value, which is how fluxes come out conservative.
struct LinearSystem {
  SparseMatrix matrix;                        ///< [n_vertices] of symmetric pattern.
  IdVector<VertexId, double> load;            ///< [n_vertices]
  IdVector<VertexId, double> absorption;      ///< [n_vertices] the sum of the row, computed without cancellation:
                                              ///< positive where reaction or a Robin condition acts.
  IdVector<VertexId, std::uint8_t> is_fixed;  ///< [n_vertices] 1 where the value is given.
  IdVector<VertexId, double> fixed_value;     ///< [n_vertices] 0 where it is not.
  bool is_symmetric = true;                   ///< Of values. Where false, methods for unsymmetric matrices are used.
};

/// Whether the matrix is an M-matrix, so that the discrete maximum principle holds: no off-diagonal entry is positive,
/// no row sum is negative, and every vertex is connected with one that is fixed or where something is absorbed.
struct MatrixCheck {
  bool is_m_matrix = false;
  std::uint64_t n_positive_couplings = 0;  ///< Pairs i < j with a positive entry.
  std::uint64_t n_negative_row_sums = 0;   ///< By more than rounding.
  std::uint64_t n_floating = 0;            ///< Connected parts where the solution is free up to a constant.
  double largest_positive = 0;             ///< Largest a_ij > 0, i != j, relative to sqrt(a_ii a_jj).
};
MatrixCheck check_m_matrix(const LinearSystem& system);

/// An approximate inverse of the matrix; for conjugate gradients symmetric and positive definite.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  /// correction = M^-1 residual. Both have an entry for every vertex; those of fixed vertices are 0 and stay so.
  virtual void apply(std::span<const double> residual, std::span<double> correction) const = 0;
  [[nodiscard]] virtual std::string name() const = 0;
};

/// Makes the preconditioner of a system. Where it returns nothing, that of LinearOptions::preconditioner is used.
using PreconditionerMaker = std::function<std::shared_ptr<const Preconditioner>(const LinearSystem&)>;

enum class LinearMethod : std::uint8_t {
  kAutomatic,  ///< Direct up to LinearOptions::max_direct free vertices, else iterative.
  kDirect,     ///< Sparse LDL^T (LU where not symmetric) with minimum degree ordering, and one step of refinement.
  kConjugateGradients,  ///< Preconditioned; BiCGSTAB [Vorst1992] where not symmetric.
};

enum class PreconditionerKind : std::uint8_t {
  kDiagonal,
  /// Incomplete Cholesky (LU where not symmetric) without fill in blocks of consecutive vertices. It exists for every
  /// M-matrix [Meijerink1977]; for others, pivots that are not positive are replaced by the diagonal.
  kIncompleteCholesky,
};

struct LinearOptions {
  LinearMethod method = LinearMethod::kAutomatic;
  PreconditionerKind preconditioner = PreconditionerKind::kIncompleteCholesky;
  PreconditionerMaker own_preconditioner;  ///< Asked first, if there is one, where iterations need a preconditioner.
  double tolerance = 1e-12;  ///< Residual norm relative to that of the solution 0 at free vertices. In (0, 1).
  int max_iterations = 20'000;
  std::size_t max_direct = 5'000;  ///< Beyond, fill makes it slower: in space 0.2 s for 4000 unknowns, 3 s for 13,000.
};

/// How the solution was found.
struct LinearReport {
  std::string method;            ///< "direct", "conjugate gradients" or "BiCGSTAB".
  std::string preconditioner;    ///< Empty for a direct solution.
  std::uint64_t n_unknowns = 0;  ///< Free vertices.
  std::uint64_t n_entries = 0;   ///< Of the matrix, with those of fixed vertices.
  int n_iterations = 0;
  std::vector<double> residuals;  ///< Relative residual norms: 1 at the start, then after each iteration.
  double residual = 0;            ///< The true one at the end, relative; 0 if the start solves the system.
  double contraction = 0;         ///< Of the residual per cycle in the end, where multigrid is the solver; else 0.
};

struct LinearSolution {
  IdVector<VertexId, double> values;  ///< [n_vertices], fixed ones included.
  LinearReport report;
};

/// Solves the system. The same bytes for any number of threads.
///
/// Iterations end when the residual has fallen below the tolerance, or when rounding does not let it fall any more:
/// `residual` says what was reached.
/// Throws: OptionError    solve.bad_option     if an option is out of its range.
///         NumericalError solve.not_converged  if max_iterations do not suffice.
///         NumericalError solve.singular       if the matrix is not positive definite at the free vertices; where it
///                                             is not symmetric, if it has no inverse.
///         NumericalError solve.overflow       if numbers go beyond the range of double precision.
///         Cancelled      if the observer asks to stop.
LinearSolution solve_linear_system(const LinearSystem& system, const LinearOptions& options = {},
                                   Observer& observer = silent_observer());

}  // namespace voropack
