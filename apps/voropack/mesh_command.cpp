// voropack mesh: packs the domain, triangulates, builds the control volumes, certifies, writes.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "command.h"
#include "meshing.h"
#include "print.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct MeshArguments {
  fs::path domain;
  std::vector<fs::path> outputs;
  std::optional<fs::path> cells;
  MeshingWishes wishes;
};

/// The files that a run will write, in their hidden places.
struct StagedOutputs {
  std::vector<fs::path> meshes;
  std::optional<fs::path> cells;
};

template <int D>
Json options_json(const MeshArguments& arguments, const MeshingOptions<D>& options) {
  Json json;
  json["output"] = Json::array();
  for (const fs::path& output : arguments.outputs) json["output"].push_back(output.string());
  if (arguments.cells) json["cells"] = arguments.cells->string();
  json.update(meshing_json(arguments.wishes, options));
  return json;
}

/// Nothing where the wished sizes alone decide about most of the mesh.
template <int D>
std::string features_text(const MeshingResult<D>& result) {
  constexpr double kWorthTelling = 0.2;
  double sum = 0;
  for (const CostlyFeature<D>& feature : result.costliest_features) sum += feature.vertices;
  if (sum < kWorthTelling * static_cast<double>(result.mesh.points.size())) return {};
  std::string text = "Costliest features:\n";
  for (const CostlyFeature<D>& feature : result.costliest_features)
    text += "  " + describe(feature, result.domain) + '\n';
  return text + '\n';
}

template <int D>
std::string summary(const MeshArguments& arguments, const MeshingResult<D>& result) {
  std::string text = domain_line(arguments.domain, result.domain) + '\n';
  text += count_table(result.quality) + '\n' + quality_table(result.quality) + '\n';
  if (!result.repairs.empty())
    text += fmt::format("The spacing was reduced in {} places to keep protecting balls empty.\n\n",
                        grouped(result.repairs.size()));
  text += features_text(result);
  text += certificate_table(result.certificate);
  for (const fs::path& output : arguments.outputs) text += "mesh:  " + output.string() + '\n';
  if (arguments.cells) text += "cells: " + arguments.cells->string() + '\n';
  return text;
}

template <int D>
ExitCode mesh_domain(const DomainInput<D>& input, const MeshArguments& arguments, const StagedOutputs& staged,
                     StageTimes read_times, Session& session) {
  const MeshingOptions<D> options =
      timed(read_times, "read", [&] { return meshing_options<D>(arguments.wishes, session); });
  const MeshingResult<D> result = make_mesh<D>(input, options, session.observer);

  Report report;
  report.command = "mesh";
  report.options = options_json(arguments, options);
  report.input = describe_domain(arguments.domain, result.domain);
  describe_meshing(result, report);
  report.times = result.times;
  report.times["read"] = read_times["read"];

  session.observer.begin_stage("write");
  timed(report.times, "write", [&] {
    for (const fs::path& path : staged.meshes) {
      session.observer.check_cancelled();
      write_mesh(result.mesh, path);
    }
    session.observer.check_cancelled();
    if (staged.cells) write_cells(build_cell_shapes(result.mesh, result.volumes), result.volumes, *staged.cells);
  });
  session.finish(report, summary(arguments, result));
  return result.certificate.ok ? ExitCode::kDone : ExitCode::kCheckFailed;
}

ExitCode run_mesh(const MeshArguments& arguments, Session& session) {
  for (const fs::path& output : arguments.outputs) check_extension(output, kMeshExtensions);
  if (arguments.cells) check_extension(*arguments.cells, {".vtu"});
  StagedOutputs staged;
  for (const fs::path& output : arguments.outputs) staged.meshes.push_back(session.outputs.stage(output));
  if (arguments.cells) staged.cells = session.outputs.stage(*arguments.cells);
  for (const fs::path& file : domain_files(arguments.domain)) session.outputs.protect(file);
  for (const fs::path& file : arguments.wishes.files()) session.outputs.protect(file);

  session.observer.begin_stage("read");
  StageTimes times;
  const AnyDomainInput input = timed(times, "read", [&] { return read_domain(arguments.domain, session.observer); });
  return std::visit([&](const auto& any) { return mesh_domain(any, arguments, staged, times, session); }, input);
}

}  // namespace

Command add_mesh_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("mesh", "Mesh a domain and certify the mesh");
  const auto arguments = std::make_shared<MeshArguments>();
  app->add_option("DOMAIN", arguments->domain, "Domain: .poly, .smesh, .node, .off, .stl, .obj or .ply")->required();
  add_output_option(*app, arguments->outputs,
                    "Mesh to write: .node (with .ele, .face, .edge) or .vtu; may be given again")
      ->type_name("MESH");
  app->add_option("--cells", arguments->cells, "Write the control volumes as polyhedra or polygons")
      ->type_name("FILE.vtu");
  add_size_options(*app, arguments->wishes);
  add_merge_options(*app, arguments->wishes.merge);
  add_packing_options(*app, arguments->wishes.packing);
  add_common_options(*app, common);
  app->footer(
      "Lengths are in the units of the domain.\n"
      "Example: voropack mesh part.poly -o part.vtu -o part.node --size 0.1 --region-size 2=0.05 --report part.json");
  return {app, [arguments](Session& session) { return run_mesh(*arguments, session); }};
}

}  // namespace voropack::app
