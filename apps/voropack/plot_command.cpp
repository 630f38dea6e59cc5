// voropack plot: a picture of a 2D mesh with its control volumes.
#include <fmt/format.h>

#include <memory>

#include "command.h"

namespace voropack::app {

namespace {

struct PlotArguments {
  std::filesystem::path mesh;
  std::vector<std::filesystem::path> outputs;
  std::optional<std::string> array;
};

void draw_array(const Mesh<2>& mesh, const PlotArguments& arguments, const std::vector<std::filesystem::path>& staged,
                Observer& observer) {
  const std::vector<double> values = read_point_array(arguments.mesh, *arguments.array, observer);
  if (values.size() != mesh.points.size())
    throw InputError(Fault{.id = "cli.wrong_length",
                           .message = fmt::format("the array \"{}\" has {} numbers for {} vertices", *arguments.array,
                                                  values.size(), mesh.points.size()),
                           .fix = "name an array with one number for each vertex.",
                           .file = arguments.mesh.string()});
  for (const std::filesystem::path& path : staged) write_svg(mesh, {*arguments.array, values}, path);
}

void draw_cells(const Mesh<2>& mesh, const std::vector<std::filesystem::path>& staged, Report& report,
                Observer& observer) {
  const ControlVolumes<2> volumes = timed(report.times, "dual", [&] { return build_control_volumes(mesh, observer); });
  observer.begin_stage("write");
  timed(report.times, "write", [&] {
    const CellShapes<2> shapes = build_cell_shapes(mesh, volumes);
    for (const std::filesystem::path& path : staged) write_svg(mesh, shapes, volumes, path);
  });
}

ExitCode run_plot(const PlotArguments& arguments, Session& session) {
  std::vector<std::filesystem::path> staged;
  for (const std::filesystem::path& output : arguments.outputs) check_extension(output, {".svg"});
  for (const std::filesystem::path& output : arguments.outputs) staged.push_back(session.outputs.stage(output));
  session.outputs.protect(arguments.mesh);

  Report report;
  report.command = "plot";
  session.observer.begin_stage("read");
  const AnyMesh any = timed(report.times, "read", [&] { return read_mesh(arguments.mesh, session.observer); });
  const auto* const mesh = std::get_if<Mesh<2>>(&any);
  if (mesh == nullptr)
    throw InputError(Fault{.id = "cli.dimension",
                           .message = "only 2D meshes can be plotted, this one is 3D",
                           .fix = "convert it to .vtu and open that in ParaView.",
                           .file = arguments.mesh.string()});
  report.input = describe_file(arguments.mesh, 2);
  if (arguments.array) {
    report.options["array"] = *arguments.array;
    timed(report.times, "write", [&] { draw_array(*mesh, arguments, staged, session.observer); });
  } else {
    draw_cells(*mesh, staged, report, session.observer);
  }
  std::string text;
  for (const std::filesystem::path& output : arguments.outputs) {
    report.options["output"].push_back(output.string());
    text += fmt::format("picture: {}\n", output.string());
  }
  session.finish(report, text);
  return ExitCode::kDone;
}

}  // namespace

Command add_plot_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("plot", "Draw a 2D mesh and its control volumes, or a solution");
  const auto arguments = std::make_shared<PlotArguments>();
  app->add_option("MESH", arguments->mesh, "2D mesh: .node (with .ele) or .vtu")->required();
  add_output_option(*app, arguments->outputs, "Picture to write")->type_name("PICTURE.svg");
  app->add_option("--array", arguments->array,
                  "Draw contours of this array of point data (.vtu) instead of control volumes, such as u")
      ->type_name("NAME");
  add_common_options(*app, common);
  app->footer(
      "Example: voropack plot part.vtu -o part.svg\n"
      "Example: voropack plot heat.vtu --array u -o heat.svg");
  return {app, [arguments](Session& session) { return run_plot(*arguments, session); }};
}

}  // namespace voropack::app
