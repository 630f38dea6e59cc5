#include "solve_output.h"

#include "parameters.h"
#include "voropack/io.h"

namespace voropack::app {

StagedSolution stage(const CaseOutputs& outputs, OutputSet& set) {
  for (const std::filesystem::path& mesh : outputs.meshes) check_extension(mesh, {".vtu"});
  if (outputs.cells) check_extension(*outputs.cells, {".vtu"});
  if (outputs.fluxes) check_extension(*outputs.fluxes, {".csv"});
  StagedSolution staged;
  for (const std::filesystem::path& mesh : outputs.meshes) staged.meshes.push_back(set.stage(mesh));
  if (outputs.cells) staged.cells = set.stage(*outputs.cells);
  if (outputs.fluxes) staged.fluxes = set.stage(*outputs.fluxes);
  return staged;
}

template <int D>
void write_solution(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const CellShapes<D>* shapes,
                    const SolutionArrays<D>& arrays, const StagedSolution& staged) {
  const auto named = [](const auto& u, const auto& error) {
    std::vector<NamedArray> list = {{"u", u}};
    if (!error.empty()) list.push_back({"error", error});
    return list;
  };
  for (const std::filesystem::path& path : staged.meshes)
    write_mesh(mesh, path, {.vertex = named(arrays.u.raw(), arrays.error.raw()), .simplex = {}});
  if (!staged.cells || shapes == nullptr) return;
  const auto on_cells = [&](const IdVector<VertexId, double>& at_vertices) {
    std::vector<double> values;
    if (at_vertices.empty()) return values;
    values.reserve(volumes.cell_vertex.size());
    for (const VertexId v : volumes.cell_vertex) values.push_back(at_vertices[v]);
    return values;
  };
  const std::vector<double> u = on_cells(arrays.u), error = on_cells(arrays.error);
  write_cells(*shapes, volumes, *staged.cells, named(u, error));
}

template void write_solution(const Mesh<2>&, const ControlVolumes<2>&, const CellShapes<2>*, const SolutionArrays<2>&,
                             const StagedSolution&);
template void write_solution(const Mesh<3>&, const ControlVolumes<3>&, const CellShapes<3>*, const SolutionArrays<3>&,
                             const StagedSolution&);

}  // namespace voropack::app
