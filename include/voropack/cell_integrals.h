// Integrals of functions over control volumes, from the cells' shapes.
#pragma once

#include <functional>
#include <span>

#include "voropack/dual.h"
#include "voropack/index.h"
#include "voropack/mesh.h"
#include "voropack/vec.h"

namespace voropack {

/// The integral over each cell of a function of position and region: exact for polynomials of degree 3.
///
/// Each cell is cut into the simplices that its site spans with the triangles (3D) or edges (2D) of its boundary, and
/// each of these is integrated with 8 points (3D; 7 in 2D) of positive weight; points that simplices of a face have in
/// common are evaluated once. `function` is called from many threads.
/// Cost: O(n): some 250 evaluations per cell in 3D, 25 in 2D. The same result for any number of threads.
template <int D>
IdVector<CellId, double> integrate_over_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
                                              const std::function<double(const Vec<D>& x, int region)>& function);

/// The same, for a function that is faster for many points at once: all those of a cell. values[k] belongs to x[k].
template <int D>
IdVector<CellId, double> integrate_over_cells(
    const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
    const std::function<void(std::span<const Vec<D>> x, int region, std::span<double> values)>& function);

}  // namespace voropack
