// Multigrid for a case: the coarser meshes that it names, or such of its own mesh, made when the first matrix needs
// them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "case.h"
#include "voropack/coarsening.h"
#include "voropack/domain.h"
#include "voropack/mesh.h"
#include "voropack/multigrid.h"
#include "voropack/observer.h"

namespace voropack::app {

/// What became of multigrid.
struct MultigridFigures {
  std::optional<MultigridReport> made;  ///< For the last matrix that got it.
  std::string refused;                  ///< Why a matrix that was to have it did not get it; else empty.
};

/// Makes the preconditioners of the matrices of one mesh. Announces the stages "coarsen" and "multigrid".
template <int D>
class MultigridMaker {
 public:
  /// `domain` is what the mesh was made of, where that is known; else its boundary tells. All have to stay where they
  /// are. Throws: InputError if levels are named and cannot be read, case.contradiction, refine.not_nested.
  MultigridMaker(const Mesh<D>& mesh, const std::optional<Domain<D>>& domain, const Case& given, Observer& observer);

  /// Nothing where another preconditioner is wanted, does better, or has to do.
  std::shared_ptr<const Preconditioner> operator()(const LinearSystem& system);

  [[nodiscard]] const MultigridFigures& figures() const { return figures_; }

 private:
  struct Level {
    SparseMatrix prolongation;
    IdVector<VertexId, VertexId> finest_vertex;
  };
  [[nodiscard]] bool is_wanted(const LinearSystem& system) const;
  void read_levels();
  void make_levels();
  void keep(std::vector<CoarseLevel<D>> levels);

  const Mesh<D>& mesh_;
  const std::optional<Domain<D>>& domain_;
  const Case& given_;
  Observer& observer_;
  std::vector<Level> levels_;
  bool has_levels_ = false;  ///< Or none can be had.
  MultigridFigures figures_;
};

}  // namespace voropack::app
