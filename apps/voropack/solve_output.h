// The files that the command solve writes.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "case.h"
#include "output_set.h"
#include "voropack/dual.h"
#include "voropack/mesh.h"

namespace voropack::app {

/// The files of a run, in their hidden places.
struct StagedSolution {
  std::vector<std::filesystem::path> meshes;
  std::optional<std::filesystem::path> cells, fluxes;
};

/// Throws OptionError io.unknown_format, and as OutputSet::stage.
StagedSolution stage(const CaseOutputs& outputs, OutputSet& set);

/// The solution at the vertices, on the mesh and on the control volumes, as array `u`; with an exact solution also
/// `error`. Empty arrays are left out.
template <int D>
struct SolutionArrays {
  IdVector<VertexId, double> u, error;
};

template <int D>
void write_solution(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const CellShapes<D>* shapes,
                    const SolutionArrays<D>& arrays, const StagedSolution& staged);

}  // namespace voropack::app
