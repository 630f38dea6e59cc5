// The vertices of one level: spheres on some of the finest mesh's vertices, in ascending dimension.
#pragma once

#include <vector>

#include "coarsening/fine_mesh.h"
#include "voropack/packing.h"

namespace voropack {

/// A level with more than this part of the vertices of the next finer one is none.
inline constexpr double kLeastGain = 0.95;

template <int D>
struct PackedLevel {
  Packing<D> packing;
  std::vector<VertexId> vertex;        ///< The finest mesh's vertex of each sphere.
  std::vector<SpacingCap<D>> faults;   ///< Where f must shrink, because a protecting ball is not empty.
  IdVector<VertexId, double> spacing;  ///< f at every vertex of the finest mesh.
  double epsilon = 0;                  ///< As CoarseLevel::epsilon.
  double growth = 1;                   ///< f = growth f_0, made Lipschitz.
};

/// Packs the vertices of `fine` with radii `f`. All with `is_kept` join; then as many others as fit.
template <int D>
PackedLevel<D> pack_level(const FineMesh<D>& fine, const IdVector<VertexId, double>& f,
                          const std::vector<std::uint8_t>& is_kept, const Observer& observer);

}  // namespace voropack
