// What flows where in a solution by finite elements.
#pragma once

#include "fem/conditions.h"
#include "solve/balance.h"
#include "voropack/diffusion.h"
#include "voropack/mesh.h"

namespace voropack {

/// Hat functions as if they were cells: each has a part in every region where it is not 0, whose volume is its
/// integral. Vertices without simplices have none. There are no faces.
template <int D>
ControlVolumes<D> hat_cells(const Mesh<D>& mesh);

/// The balances of hat functions, added up by marker and region. What enters at a fixed vertex is the residual there,
/// so that flows are conservative: they add up to 0 as exactly as the solution solves its system.
/// `sink` is what was taken away from the source, per volume.
template <int D>
FlowSums add_up_fem_flows(const Mesh<D>& mesh, const ControlVolumes<D>& hats, const DiffusionProblem<D>& problem,
                          const Conditions<D>& conditions, const IdVector<VertexId, double>& sink,
                          const IdVector<VertexId, double>& values);

}  // namespace voropack
