// Better shapes on one level by exchanging vertices for others of the finest mesh.
#pragma once

#include <cstdint>
#include <span>

#include "coarsening/planar_packer.h"

namespace voropack {

struct ImprovementWish {
  std::span<const std::uint32_t> kept;  ///< The next coarser level: stays.
  std::size_t min_vertices = 0;         ///< Vertices may be taken away down to this
  std::size_t max_vertices = 0;         ///< or added up to this.
  std::uint64_t seed = 0;
  std::size_t trials = 300;      ///< Per vertex.
  bool is_packing_kept = false;  ///< No vertex comes whose f-sphere overlaps another.
};

/// Exchanges a vertex for one near it, adds or removes one where the sum of the triangles' costs, which the worst ones
/// dominate, falls; by simulated annealing, which accepts some exchanges that raise it as long as it is warm.
/// Returns the number of exchanges.
std::size_t improve_level(const PlanarPacker& packer, const ImprovementWish& wish, PlanarPacking& level,
                          Observer& observer);

/// The worst triangle_quality of a level.
double worst_quality(const ConformingLevel& level);

}  // namespace voropack
