// voropack stats: counts and quality of a mesh file.
#include <memory>

#include "command.h"
#include "print.h"
#include "voropack/quality.h"

namespace voropack::app {

namespace {

struct StatsArguments {
  std::filesystem::path mesh;
  bool redelaunay = false;
};

template <int D>
ExitCode measure_mesh(const Mesh<D>& mesh, const StatsArguments& arguments, StageTimes times, Session& session) {
  Report report;
  report.command = "stats";
  report.options["redelaunay"] = arguments.redelaunay;
  report.input = describe_file(arguments.mesh, D);
  const ControlVolumes<D> volumes = timed(times, "dual", [&] { return build_control_volumes(mesh, session.observer); });
  report.quality = timed(times, "quality", [&] { return measure_quality(mesh, volumes, session.observer); });
  report.input.regions = report.quality->regions.size();
  report.times = times;
  const QualityReport& quality = *report.quality;
  session.finish(report, count_table(quality) + '\n' + quality_table(quality) + histograms(quality));
  return ExitCode::kDone;
}

ExitCode run_stats(const StatsArguments& arguments, Session& session) {
  session.outputs.protect(arguments.mesh);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(
      times, "read", [&] { return read_mesh_or_triangulate(arguments.mesh, arguments.redelaunay, session.observer); });
  return std::visit([&](const auto& any) { return measure_mesh(any, arguments, times, session); }, mesh);
}

}  // namespace

Command add_stats_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("stats", "Counts and quality of a mesh, with histograms");
  const auto arguments = std::make_shared<StatsArguments>();
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele) or .vtu")->required();
  add_redelaunay_option(*app, arguments->redelaunay);
  add_common_options(*app, common);
  app->footer(
      "Angles are in degrees, lengths and volumes in the units of the mesh.\n"
      "Example: voropack stats part.vtu --report part.json");
  return {app, [arguments](Session& session) { return run_stats(*arguments, session); }};
}

}  // namespace voropack::app
