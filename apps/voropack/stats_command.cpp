// voropack stats: counts and quality of a mesh file.
#include <memory>

#include "command.h"
#include "print.h"
#include "voropack/quality.h"

namespace voropack::app {

namespace {

template <int D>
ExitCode measure_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, StageTimes times, Session& session) {
  Report report;
  report.command = "stats";
  report.input = describe_file(path, D);
  const ControlVolumes<D> volumes = timed(times, "dual", [&] { return build_control_volumes(mesh, session.observer); });
  report.quality = timed(times, "quality", [&] { return measure_quality(mesh, volumes, session.observer); });
  report.input.regions = report.quality->regions.size();
  report.times = times;
  const QualityReport& quality = *report.quality;
  session.finish(report, count_table(quality) + '\n' + quality_table(quality) + histograms(quality));
  return ExitCode::kDone;
}

ExitCode run_stats(const std::filesystem::path& path, Session& session) {
  session.outputs.protect(path);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(times, "read", [&] { return read_mesh(path, session.observer); });
  return std::visit([&](const auto& any) { return measure_mesh(any, path, times, session); }, mesh);
}

}  // namespace

Command add_stats_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("stats", "Counts and quality of a mesh, with histograms");
  const auto path = std::make_shared<std::filesystem::path>();
  app->add_option("MESH", *path, "Mesh: .node (with .ele) or .vtu")->required();
  add_common_options(*app, common);
  app->footer(
      "Angles are in degrees, lengths and volumes in the units of the mesh.\n"
      "Example: voropack stats part.vtu --report part.json");
  return {app, [path](Session& session) { return run_stats(*path, session); }};
}

}  // namespace voropack::app
