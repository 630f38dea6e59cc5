// Connected parts of a system that are singular problems, with or without one vertex held.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// The connected parts where nothing is absorbed and at most one vertex is fixed. On such a part the rows of the
/// matrix, that of the fixed vertex included, add up to 0, and the values are free up to a constant but for that
/// vertex.
///
/// Let S subtract from a function its value at the fixed vertex. The system with that vertex held is S^-1-similar to
/// the singular one: with B the multigrid of the singular problem, S B S^T is a preconditioner that converges as fast.
/// S^T gives the fixed vertex minus the sum of the others' residuals, which makes the load compatible. Without a fixed
/// vertex, S subtracts the mean.
class SingularParts {
 public:
  explicit SingularParts(const LinearSystem& system);

  [[nodiscard]] bool empty() const { return held_.empty(); }
  [[nodiscard]] std::size_t size() const { return held_.size(); }
  /// [n_vertices] k + 1 in part k, 0 elsewhere; empty if there is no part.
  [[nodiscard]] std::span<const std::uint32_t> part() const { return part_; }
  /// is_fixed of the system without the vertices that alone hold a part.
  [[nodiscard]] std::vector<std::uint8_t> without_held(const LinearSystem& system) const;

  /// result = S^T residual.
  void make_compatible(std::span<const double> residual, std::span<double> result) const;
  /// values = S values.
  void shift(std::span<double> values) const;

 private:
  /// The sums of the values over the parts.
  [[nodiscard]] std::vector<double> sums(std::span<const double> values) const;
  void subtract(const std::vector<double>& amounts, std::span<double> values) const;

  std::vector<std::uint32_t> part_;
  std::vector<std::optional<std::uint32_t>> held_;  ///< [n_parts] the fixed vertex.
  std::vector<double> n_vertices_;                  ///< [n_parts]
};

}  // namespace voropack
