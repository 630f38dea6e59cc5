// R/r of Theorem 2.4 for every cell.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/unset_array.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// What the cells need to know about simplices.
template <int D>
struct SimplexFigures {
  explicit SimplexFigures(std::size_t n_simplices) : circumcenter(n_simplices), walls(n_simplices) {}

  UnsetArray<SimplexId, std::array<double, D>> circumcenter;  ///< [n_simplices]
  UnsetArray<SimplexId, std::uint8_t> walls;  ///< [n_simplices] bit i: the region ends opposite to corner i.
};

/// [n_cells] R/r of each cell, in the order of ControlVolumes::cell_vertex. R is the radius of the smallest ball around
/// the cell, r that of the largest ball in it (docs/theory/quality.md); a cell whose boundary is not convex at its
/// site gets a ball in a convex part of it, so that its R/r is an upper bound. Infinite for a cell without interior.
/// `vertex_simplices` lists the simplices around each vertex.
template <int D>
std::vector<double> cell_aspects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                                 const Csr<VertexId, SimplexId>& vertex_simplices, const SimplexFigures<D>& figures,
                                 Observer& observer);

}  // namespace voropack
