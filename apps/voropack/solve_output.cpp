#include "solve_output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
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

/// The numbers of the states that belong to the series that is there.
std::vector<std::size_t> earlier_frames(const fs::path& series) {
  std::vector<std::size_t> numbers;
  std::error_code error;
  if (!fs::exists(series, error)) return numbers;
  const fs::path folder = series.has_parent_path() ? series.parent_path() : fs::path(".");
  const std::string prefix = series.stem().string() + '_';
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file(error) || !name.starts_with(prefix)) continue;
    std::size_t number = 0;
    std::from_chars(name.data() + prefix.size(), name.data() + name.size(), number);
    if (frame(series, number).filename() == name) numbers.push_back(number);
  }
  return numbers;
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

std::string StagedSolution::stale_line(std::size_t n_states) const {
  const std::vector<std::size_t> stale(earlier.lower_bound(n_states), earlier.end());
  if (stale.empty()) return {};
  return fmt::format("removed           state {} of an earlier series there\n", fmt::join(stale, ", "));
}

StagedSolution stage(const CaseOutputs& outputs, bool is_series, OutputSet& set) {
  StagedSolution staged;
  staged.is_series = is_series;
  const auto add = [&](fs::path name, const char* extension) {
    check_extension(name, {extension});
    if (is_series && name.extension() == ".vtu") name.replace_extension(".pvd");
    staged.names.push_back(name);
    if (is_series && name.extension() == ".pvd")
      for (const std::size_t number : earlier_frames(name)) {
        set.replace(frame(name, number));
        staged.earlier.insert(number);
      }
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
