// The Delaunay kernel that the mesher uses. Both implement the same interface and give the same simplices.
#pragma once

#include "geom/bowyer_watson.h"

namespace voropack {

template <int K>
using DelaunayKernel = BowyerWatson<K>;

}  // namespace voropack
