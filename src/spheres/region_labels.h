// Which region each simplex of a triangulation lies in: the components that remain when the protected
// faces are taken away.
#pragma once

#include <cstdint>
#include <vector>

#include "geom/kernel.h"
#include "spheres/packing_problem.h"

namespace voropack {

template <int K>
struct RegionLabels {
  std::vector<int> region;                   ///< By slot of the kernel; Walls<K>::kOutside outside and for empty slots.
  std::vector<std::uint32_t> missing_faces;  ///< Indices of faces that the triangulation does not contain.
  std::vector<std::uint32_t> leaking_faces;  ///< Indices of faces that have the wrong region on a side.
};

/// Labels the simplices of `kernel`, whose vertices 0 .. are the problem's fixed spheres. Without faces every finite
/// simplex is in region 0, as PackingProblem says. O(n).
template <int K>
RegionLabels<K> label_regions(const DelaunayKernel<K>& kernel, const std::vector<ProtectedFace<K>>& faces);

/// The simplices whose region is not negative, numbered anew in the order of their slots.
template <int K>
Triangulation<K> export_triangulation(const DelaunayKernel<K>& kernel, const std::vector<int>& region);

}  // namespace voropack
