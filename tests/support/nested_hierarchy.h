// Hierarchies for tests of multigrid, made the plain way: grids whose every other point is kept, and greedy subsets of
// the vertices of a mesh.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "voropack/diffusion.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/multigrid.h"

namespace voropack::test {

struct NestedLevel {
  SparseMatrix prolongation;            ///< To the level before.
  std::vector<VertexId> finest_vertex;  ///< [n_vertices]
  std::optional<SparseMatrix> matrix;   ///< Of the coarse control volumes.
};

/// A problem on the finest level, and coarser levels.
struct NestedHierarchy {
  LinearSystem system;
  std::vector<NestedLevel> levels;

  /// What Multigrid takes: with the matrices of the coarse control volumes, or without.
  [[nodiscard]] std::vector<MultigridLevel> views(bool with_matrices) const;
};

/// What to solve on the unit square or cube: source 1, and the conductivity `right` for x > 1/2, 1 elsewhere.
struct BoxProblem {
  double right = 1;
  double reaction = 0;
  bool is_dirichlet = true;  ///< u = 0 on the whole boundary; else nothing enters, and vertex 0 is held at 0.
};

/// Grids of n, n / 2, ... boxes per side, down to 2, each cut into D! simplices; piecewise linear interpolation.
template <int D>
NestedHierarchy grid_hierarchy(std::size_t n, const BoxProblem& problem);

/// Subsets of the vertices of a mesh of the unit square or cube that keep a distance of growth^k times the mean
/// distance of neighbors; their Delaunay triangulations; barycentric interpolation. One region.
template <int D>
NestedHierarchy greedy_hierarchy(const Mesh<D>& mesh, double growth, const BoxProblem& problem);

}  // namespace voropack::test
