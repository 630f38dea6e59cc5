// voropack mesh: packs the domain, triangulates, builds the control volumes, certifies, writes.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <utility>

#include "command.h"
#include "print.h"
#include "voropack/pipeline.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct MeshArguments {
  fs::path domain;
  std::vector<fs::path> outputs;
  std::optional<fs::path> cells;

  std::optional<double> size, spacing;
  std::vector<std::string> region_sizes, marker_sizes;  ///< Each ID=H.
  std::optional<fs::path> size_field;
  std::optional<std::string> size_expression;
  double gradation = MeshingOptions<3>{}.gradation;
  double feature_factor = MeshingOptions<3>{}.feature_factor;

  DomainOptions merge;
  PackingOptions packing;
};

/// The files that a run will write, in their hidden places.
struct StagedOutputs {
  std::vector<fs::path> meshes;
  std::optional<fs::path> cells;
};

/// The .node file with the points of a .poly or .smesh that announces none of its own.
std::optional<fs::path> points_beside(const fs::path& domain) {
  if (domain.extension() != ".poly" && domain.extension() != ".smesh") return std::nullopt;
  std::ifstream file(domain);
  std::string word;
  while (file >> word && word.front() == '#') std::getline(file, word);
  if (word != "0") return std::nullopt;
  return fs::path(domain).replace_extension(".node");
}

template <int D>
typename SizeWishes<D>::Field read_size_field(const fs::path& path, Observer& observer) {
  AnyMesh any = read_mesh(path, observer);
  auto* const mesh = std::get_if<Mesh<D>>(&any);
  const auto fault = [&](const std::string& message, const std::string& fix) {
    return InputError(Fault{.id = "cli.size_field", .message = message, .fix = fix, .file = path.string()});
  };
  if (mesh == nullptr)
    throw fault(fmt::format("this size field is {}D, the domain {}D", 5 - D, D), "give a mesh of the same dimension.");
  std::vector<double> size = mesh->vertex_spacing.raw();
  if (size.empty())
    throw fault("the vertices have no attribute", "give every vertex the wanted edge length as its first attribute.");
  for (std::size_t i = 0; i < size.size(); ++i)
    if (!(std::isfinite(size[i]) && size[i] > 0))
      throw fault(fmt::format("the wanted edge length of vertex {} (counted from 0) is {}", i, size[i]),
                  "give a positive number.");
  return {std::move(*mesh), std::move(size)};
}

template <int D>
MeshingOptions<D> meshing_options(const MeshArguments& arguments, const Session& session) {
  MeshingOptions<D> options;
  options.domain = arguments.merge;
  options.wishes.size = arguments.size;
  options.wishes.spacing = arguments.spacing;
  options.wishes.region_size = sizes_by_id(arguments.region_sizes, "--region-size");
  options.wishes.marker_size = sizes_by_id(arguments.marker_sizes, "--marker-size");
  options.wishes.expression = arguments.size_expression;
  if (arguments.size_field) options.wishes.field = read_size_field<D>(*arguments.size_field, session.observer);
  options.gradation = arguments.gradation;
  options.feature_factor = arguments.feature_factor;
  options.packing = arguments.packing;
  options.packing.seed = session.common.seed;
  options.threads = thread_count(session.common.threads);
  return options;
}

template <int D>
Json options_json(const MeshArguments& arguments, const MeshingOptions<D>& options) {
  Json json;
  json["output"] = Json::array();
  for (const fs::path& output : arguments.outputs) json["output"].push_back(output.string());
  if (arguments.cells) json["cells"] = arguments.cells->string();
  if (options.wishes.size) json["size"] = *options.wishes.size;
  if (options.wishes.spacing) json["spacing"] = *options.wishes.spacing;
  for (const auto& [id, size] : options.wishes.region_size) json["region_size"][std::to_string(id)] = size;
  for (const auto& [id, size] : options.wishes.marker_size) json["marker_size"][std::to_string(id)] = size;
  if (arguments.size_field) json["size_field"] = arguments.size_field->string();
  if (options.wishes.expression) json["size_expr"] = *options.wishes.expression;
  if (options.domain.merge_distance) json["merge_distance"] = *options.domain.merge_distance;
  json["merge_angle"] = options.domain.merge_angle_deg;
  json["gradation"] = options.gradation;
  json["feature_factor"] = options.feature_factor;
  json["packing"] = name_of(kFormNames, options.packing.form);
  if (options.packing.form == PackingForm::kVoronoi)
    json["interior"] = name_of(kInteriorNames, options.packing.interior);
  else
    json["epsilon"] = options.packing.epsilon;
  json["max_vertices"] = options.packing.max_vertices;
  json["seed"] = options.packing.seed;
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
  const Domain<D>& domain = result.domain;
  std::string text = fmt::format("{}: {}D, {} points, {} segments", arguments.domain.string(), D,
                                 grouped(domain.points.size()), grouped(domain.segments.size()));
  if (D == 3) text += fmt::format(", {} facets", grouped(domain.facet_frame.size()));
  text += fmt::format(", {} regions\n\n", grouped(domain.region_id.size()));
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
  const MeshingOptions<D> options = timed(read_times, "read", [&] { return meshing_options<D>(arguments, session); });
  const MeshingResult<D> result = make_mesh<D>(input, options, session.observer);

  Report report;
  report.command = "mesh";
  report.options = options_json(arguments, options);
  report.input = describe_domain(arguments.domain, result.domain);
  report.quality = result.quality;
  report.certificate = result.certificate;
  report.packing = PackingFigures{.repairs = result.repairs.size(), .repair_rounds = result.repair_rounds};
  if (result.spacing_integral > 0)
    report.packing->size_ratio = static_cast<double>(result.mesh.points.size()) / result.spacing_integral;
  report.costliest_features = features_json(result.costliest_features, result.domain);
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
  sizes_by_id(arguments.region_sizes, "--region-size");
  sizes_by_id(arguments.marker_sizes, "--marker-size");
  StagedOutputs staged;
  for (const fs::path& output : arguments.outputs) staged.meshes.push_back(session.outputs.stage(output));
  if (arguments.cells) staged.cells = session.outputs.stage(*arguments.cells);
  session.outputs.protect(arguments.domain);
  if (const std::optional<fs::path> points = points_beside(arguments.domain)) session.outputs.protect(*points);
  if (arguments.size_field) session.outputs.protect(*arguments.size_field);

  session.observer.begin_stage("read");
  StageTimes times;
  const AnyDomainInput input = timed(times, "read", [&] { return read_domain(arguments.domain, session.observer); });
  return std::visit([&](const auto& any) { return mesh_domain(any, arguments, staged, times, session); }, input);
}

void add_size_options(CLI::App& command, MeshArguments& arguments) {
  command.add_option("--size", arguments.size, "Wanted mean edge length; without it the geometry alone decides")
      ->check(positive_number())
      ->type_name("H");
  command.add_option("--spacing", arguments.spacing, "Upper bound on the spacing function f itself (a radius)")
      ->check(positive_number())
      ->type_name("F");
  command.add_option("--region-size", arguments.region_sizes, "Wanted edge length in one region; may be given again")
      ->check(size_of_id())
      ->allow_extra_args(false)
      ->type_name("ID=H");
  command
      .add_option("--marker-size", arguments.marker_sizes,
                  "Wanted edge length at facets, segments, points of one marker; may be given again")
      ->check(size_of_id())
      ->allow_extra_args(false)
      ->type_name("ID=H");
  command
      .add_option("--size-field", arguments.size_field,
                  "Mesh (.node, .vtu) whose first vertex attribute is the wanted edge length")
      ->type_name("FILE");
  command.add_option("--size-expr", arguments.size_expression, "Wanted edge length as a formula in x, y and z")
      ->type_name("\"0.05+0.1*x\"");
  add_gradation_option(command, arguments.gradation);
  command.add_option("--feature-factor", arguments.feature_factor, "Spacing over local feature size, at most 1")
      ->check(positive_number(1))
      ->type_name("A")
      ->capture_default_str();
}

void add_packing_options(CLI::App& command, MeshArguments& arguments) {
  add_form_options(command, arguments.packing.form, arguments.packing.epsilon);
  std::vector<std::string> names;
  for (const auto& [name, value] : kInteriorNames) names.push_back(name);
  command
      .add_option_function<std::string>(
          "--interior",
          [&interior = arguments.packing.interior](const std::string& name) { interior = kInteriorNames.at(name); },
          "With --packing voronoi: what fills the interior, lattice or random")
      ->check(one_of(names))
      ->type_name("KIND")
      ->default_str(name_of(kInteriorNames, arguments.packing.interior));
  command
      .add_option("--max-vertices", arguments.packing.max_vertices,
                  "Stop before the work if more vertices than this are expected")
      ->check(whole_number(1))
      ->type_name("N")
      ->capture_default_str();
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
  add_size_options(*app, *arguments);
  add_merge_options(*app, arguments->merge);
  add_packing_options(*app, *arguments);
  add_common_options(*app, common);
  app->footer(
      "Lengths are in the units of the domain.\n"
      "Example: voropack mesh part.poly -o part.vtu -o part.node --size 0.1 --region-size 2=0.05 --report part.json");
  return {app, [arguments](Session& session) { return run_mesh(*arguments, session); }};
}

}  // namespace voropack::app
