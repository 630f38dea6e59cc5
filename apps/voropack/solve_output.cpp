#include "solve_output.h"

#include <fmt/format.h>

#include <span>

#include "parameters.h"
#include "voropack/io.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

/// heat.pvd -> heat_0000.vtu, heat_0001.vtu, ...
fs::path frame(const fs::path& series, std::size_t number) {
  return series.parent_path() / fmt::format("{}_{:04}.vtu", series.stem().string(), number);
}

std::string pvd_text(const fs::path& series, std::span<const double> times) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (std::size_t i = 0; i < times.size(); ++i)
    text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", times[i],
                        frame(series, i).filename().string());
  return text + "  </Collection>\n</VTKFile>\n";
}

std::vector<NamedArray> named(std::span<const double> u, std::span<const double> error) {
  std::vector<NamedArray> arrays = {{"u", u}};
  if (!error.empty()) arrays.push_back({"error", error});
  return arrays;
}

}  // namespace

StagedSolution stage(const CaseOutputs& outputs, bool is_series, OutputSet& set) {
  StagedSolution staged;
  staged.is_series = is_series;
  const auto add = [&](fs::path name, const char* extension) {
    check_extension(name, {extension});
    if (is_series && name.extension() == ".vtu") name.replace_extension(".pvd");
    staged.names.push_back(name);
    return set.stage(name);
  };
  for (const fs::path& mesh : outputs.meshes) staged.meshes.push_back(add(mesh, ".vtu"));
  if (outputs.cells) staged.cells = add(*outputs.cells, ".vtu");
  if (outputs.fluxes) staged.fluxes = add(*outputs.fluxes, ".csv");
  return staged;
}

template <int D>
fs::path SolutionWriter<D>::place(const fs::path& staged) const {
  return staged_.is_series ? frame(staged, times_.size() - 1) : staged;
}

template <int D>
void SolutionWriter<D>::add(double time, const SolutionArrays<D>& arrays) {
  times_.push_back(time);
  const MeshArrays mesh_arrays{.vertex = named(arrays.u.raw(), arrays.error.raw()), .simplex = {}};
  for (const fs::path& mesh : staged_.meshes) write_mesh(setting_.mesh, place(mesh), mesh_arrays);
  if (!staged_.cells) return;
  const auto on_cells = [&](const IdVector<VertexId, double>& at_vertices) {
    std::vector<double> values;
    if (at_vertices.empty()) return values;
    values.reserve(setting_.volumes.cell_vertex.size());
    for (const VertexId v : setting_.volumes.cell_vertex) values.push_back(at_vertices[v]);
    return values;
  };
  const std::vector<double> u = on_cells(arrays.u), error = on_cells(arrays.error);
  write_cells(*setting_.shapes, setting_.volumes, place(*staged_.cells), named(u, error));
}

template <int D>
void SolutionWriter<D>::finish() const {
  if (!staged_.is_series) return;
  for (const fs::path& mesh : staged_.meshes) write_text(pvd_text(mesh, times_), mesh);
  if (staged_.cells) write_text(pvd_text(*staged_.cells, times_), *staged_.cells);
}

template class SolutionWriter<2>;
template class SolutionWriter<3>;

}  // namespace voropack::app
