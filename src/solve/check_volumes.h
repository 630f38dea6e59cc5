// Control volumes and boundary areas may come from another program: whether they fit together.
#pragma once

#include "voropack/boundary_areas.h"
#include "voropack/mesh.h"

namespace voropack {

/// Throws InputError solve.bad_volumes.
template <int D>
void check_volumes(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary);

}  // namespace voropack
