// The Delaunay kernel that the mesher uses. Both implement the same interface and give the same simplices.
#pragma once

#include "geom/delaunay_kernel.h"

namespace voropack {

template <int K>
using DelaunayKernel = CgalDelaunay<K>;

}  // namespace voropack
