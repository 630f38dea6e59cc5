// By how much the solution itself misses the equations of its cells, where coefficients are taken at sites: what is
// integrated there by one value.
#pragma once

#include "voropack/adaptivity.h"

namespace voropack {

/// What the terms need to know of a solution.
template <int D>
struct SolvedProblem {
  const Mesh<D>& mesh;
  const ControlVolumes<D>& volumes;
  const DiffusionProblem<D>& problem;
  const VertexValues& values;
  const RecoveredDerivatives<D>& derivatives;
};

/// [n_cells] the integral of sigma u - s over each cell, less volume times the value at its site; and what enters
/// through patches with a Robin condition by the value at the site, less the integral of that. The solution is the
/// polynomial of second degree at the site. Conditions inside of the domain are left out; of coefficients that are
/// given by vertex, nothing is known in between. The same result for any number of threads.
template <int D>
IdVector<CellId, double> find_consistency_errors(const SolvedProblem<D>& solved);

/// Adds to the defect of each dual face what conductivity that varies in a region makes of it,
///
///     mean over the face of (kappa / k - 1) n . grad u,
///
/// where k is the harmonic mean of its values at the two sites.
template <int D>
void add_conductivity_defects(const SolvedProblem<D>& solved, EdgeValues& defect);

}  // namespace voropack
