// Whether geometry can be done with the vertices of a mesh at all.
#pragma once

#include "voropack/mesh.h"

namespace voropack {

/// Throws: InputError mesh.empty      if there are no simplices,
///                    mesh.too_large  for coordinates beyond kMaxCoordinate,
///                    mesh.too_small  if all vertices lie within kMinDiameter.
template <int D>
void check_extent(const Mesh<D>& mesh);

}  // namespace voropack
