// Solving a case on its mesh: stationary or in time, linear or not, by control volumes or finite elements.
#pragma once

#include <functional>
#include <optional>

#include "case.h"
#include "case_problem.h"
#include "solve_report.h"
#include "voropack/boundary_areas.h"
#include "voropack/dual.h"

namespace voropack::app {

/// A case on its mesh.
template <int D>
struct Setting {
  const Case& given;
  CompiledCase<D> compiled;
  Mesh<D> mesh{};
  std::optional<Domain<D>> domain{};  ///< That the mesh was made of, where that is known.
  ControlVolumes<D> volumes{};
  BoundaryAreas<D> boundary{};
  bool writes_cells = false;
  std::optional<CellShapes<D>> shapes{};  ///< Where cells are written or integrated over.
};

/// u at the vertices; with an exact solution also u - exact, else empty.
template <int D>
struct SolutionArrays {
  IdVector<VertexId, double> u, error;
};

template <int D>
struct Solved {
  SolveFigures figures;
  SolutionArrays<D> arrays;  ///< In time: at the end.
};

/// Binds the case to the mesh, and builds the shapes of cells that are written or integrated over.
template <int D>
void prepare(Setting<D>& setting, Observer& observer);

/// Called for each state of a case in time that is to be written, but not for the last.
template <int D>
using StateCallback = std::function<void(double time, const SolutionArrays<D>&)>;

/// What solve_case solves where nothing depends on time.
template <int D>
DiffusionProblem<D> stationary_problem(const Setting<D>& setting);

/// Solves and measures. Whether the source is integrated over cells is decided by `shapes` being there.
template <int D>
Solved<D> solve_case(const Setting<D>& setting, const StateCallback<D>& on_state, Observer& observer);

}  // namespace voropack::app
