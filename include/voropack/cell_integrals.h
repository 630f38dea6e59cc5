// Integrals of functions over control volumes, from the cells' shapes.
#pragma once

#include <functional>

#include "voropack/dual.h"
#include "voropack/index.h"
#include "voropack/mesh.h"
#include "voropack/vec.h"

namespace voropack {

/// The integral over each cell of a function of position and region: exact for polynomials of degree 3.
///
/// Each cell is cut into the simplices that its site spans with the triangles (3D) or edges (2D) of its boundary, and
/// each of these is integrated with 8 points (3D; 7 in 2D) of positive weight. `function` is called from many threads.
/// Cost: O(n): some 600 evaluations per cell in 3D, 40 in 2D. The same result for any number of threads.
template <int D>
IdVector<CellId, double> integrate_over_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
                                              const std::function<double(const Vec<D>& x, int region)>& function);

}  // namespace voropack
