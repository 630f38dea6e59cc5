// voropack convert: from any mesh format that is read to any that is written.
#include <fmt/format.h>

#include <memory>

#include "command.h"

namespace voropack::app {

namespace {

struct ConvertArguments {
  std::filesystem::path from, to;
  bool redelaunay = false;
};

ExitCode run_convert(const ConvertArguments& arguments, Session& session) {
  check_extension(arguments.to, kMeshExtensions);
  const std::filesystem::path staged = session.outputs.stage(arguments.to);
  session.outputs.protect(arguments.from);
  Report report;
  report.command = "convert";
  report.options["output"] = arguments.to.string();
  report.options["redelaunay"] = arguments.redelaunay;
  session.observer.begin_stage("read");
  const AnyMesh mesh = timed(report.times, "read", [&] {
    return read_mesh_or_triangulate(arguments.from, arguments.redelaunay, session.observer);
  });
  return std::visit(
      [&](const auto& any) {
        report.input = describe_file(arguments.from, dimension_of(any));
        session.observer.begin_stage("write");
        timed(report.times, "write", [&] { write_mesh(any, staged); });
        session.finish(report, fmt::format("{}: {} vertices, {} simplices\n", arguments.to.string(),
                                           grouped(any.points.size()), grouped(any.simplex_vertices.size())));
        return ExitCode::kDone;
      },
      mesh);
}

}  // namespace

Command add_convert_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("convert", "Convert a mesh to another format");
  const auto arguments = std::make_shared<ConvertArguments>();
  app->add_option("IN", arguments->from, "Mesh to read: .node (with .ele) or .vtu")->required();
  app->add_option("OUT", arguments->to, "Mesh to write: .node (with .ele, .face, .edge) or .vtu")->required();
  add_redelaunay_option(*app, arguments->redelaunay);
  add_common_options(*app, common);
  app->footer("Example: voropack convert part.node part.vtu");
  return {app, [arguments](Session& session) { return run_convert(*arguments, session); }};
}

}  // namespace voropack::app
