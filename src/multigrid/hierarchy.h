// The levels of multigrid and the cycles over them, in single or double precision.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "voropack/multigrid.h"

namespace voropack {

/// What the levels are made from. Nothing of it is kept.
struct HierarchyInput {
  const SparseMatrix* matrix = nullptr;
  std::span<const MultigridLevel> levels;
  std::span<const std::uint8_t> is_fixed;  ///< [n_vertices] 0 as well at a vertex that alone holds its part.
  /// [n_vertices] k + 1 in the k-th part that is free up to a constant, 0 elsewhere; empty if there is none.
  std::span<const std::uint32_t> floating_part;
};

class MultigridHierarchy {
 public:
  virtual ~MultigridHierarchy() = default;
  /// correction = B residual by one cycle from 0, or by full multigrid.
  virtual void apply(std::span<const double> residual, bool is_full, std::span<double> correction) const = 0;
};

/// Fills report.levels.
std::unique_ptr<const MultigridHierarchy> build_hierarchy(const HierarchyInput& input, const MultigridOptions& options,
                                                          MultigridReport& report);

}  // namespace voropack
