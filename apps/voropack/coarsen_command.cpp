// voropack coarsen: a hierarchy of coarser meshes, node-nested, for multigrid.
#include <fmt/format.h>

#include <memory>

#include "command.h"
#include "print.h"
#include "voropack/coarsening.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

const std::map<std::string, InitialSpacing> kInitialNames = {{"nearest", InitialSpacing::kNearest},
                                                             {"mean-edge", InitialSpacing::kMeanEdge}};
const std::map<std::string, CoarseningOrder> kOrderNames = {
    {"front", CoarseningOrder::kFront}, {"curve", CoarseningOrder::kCurve}, {"random", CoarseningOrder::kRandom}};

struct CoarsenArguments {
  fs::path mesh;
  fs::path folder;
  CoarseningOptions options;
  bool redelaunay = false;
};

Json options_json(const CoarsenArguments& arguments) {
  const CoarseningOptions& options = arguments.options;
  Json json;
  json["output"] = arguments.folder.string();
  json["levels"] = options.levels;
  json["growth"] = options.growth;
  json["lipschitz"] = options.lipschitz;
  json["initial"] = name_of(kInitialNames, options.initial);
  json["order"] = name_of(kOrderNames, options.order);
  json["quasi_uniform"] = options.quasi_uniform;
  return json;
}

/// What is known of one level once it is certified.
struct LevelFigures {
  QualityReport quality;
  Certificate certificate;
  double ratio = 0;  ///< Vertices over those of the next finer mesh.
  double epsilon = 0;
};

Json level_json(const LevelFigures& level) {
  Json json;
  json["vertices"] = level.quality.n_vertices;
  json["simplices"] = level.quality.n_simplices;
  json["ratio"] = level.ratio;
  json["radius_edge"] = {{"max", level.quality.radius_edge.max}, {"mean", level.quality.radius_edge.mean}};
  json["angle_deg"] = {{"min", level.quality.angle_deg.min}, {"max", level.quality.angle_deg.max}};
  if (level.epsilon > 0) json["epsilon"] = level.epsilon;
  json["certificate"] = certificate_json(level.certificate);
  return json;
}

template <int D>
LevelFigures judge(const CoarseLevel<D>& level, const Domain<D>& domain, const CoarseningOptions& options,
                   std::size_t n_finer, Report& report, Observer& observer) {
  const ControlVolumes<D> volumes =
      timed(report.times, "dual", [&] { return build_control_volumes(level.mesh, observer); });
  LevelFigures figures;
  figures.ratio = static_cast<double>(level.mesh.points.size()) / static_cast<double>(n_finer);
  figures.epsilon = level.epsilon;
  figures.quality = timed(report.times, "quality", [&] { return measure_quality(level.mesh, volumes, observer); });
  CertificateOptions claims;
  claims.gradation = options.lipschitz;
  if (level.epsilon > 0) {
    claims.form = PackingForm::kMaximal;
    claims.epsilon = level.epsilon;
  }
  figures.certificate =
      timed(report.times, "certificate", [&] { return certify(level.mesh, volumes, &domain, claims, observer); });
  return figures;
}

std::string level_table(std::size_t n_finest, const std::vector<LevelFigures>& levels) {
  std::string text = fmt::format("{:<8}{:>12}{:>8}{:>13}{:>18}{:>18}  {}\n", "level", "vertices", "ratio", "simplices",
                                 "radius/edge max", "angle min, deg", "certificate");
  text += fmt::format("{:<8}{:>12}\n", 0, grouped(n_finest));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const LevelFigures& level = levels[i];
    text += fmt::format("{:<8}{:>12}{:>8.3f}{:>13}{:>18.4g}{:>18.4g}  {}\n", i + 1, grouped(level.quality.n_vertices),
                        level.ratio, grouped(level.quality.n_simplices), level.quality.radius_edge.max,
                        level.quality.angle_deg.min, level.certificate.ok ? "ok" : "failed");
  }
  return text;
}

/// Rows of the finer level, columns of the coarser one, counted from 1.
std::string matrix_market(const SparseMatrix& matrix, std::size_t n_columns) {
  std::string text = "%%MatrixMarket matrix coordinate real general\n";
  text += fmt::format("{} {} {}\n", matrix.size(), n_columns, matrix.columns.size());
  for (std::size_t row = 0; row < matrix.size(); ++row)
    for (std::uint64_t k = matrix.offsets[row]; k < matrix.offsets[row + 1]; ++k)
      text += fmt::format("{} {} {}\n", row + 1, matrix.columns[k] + 1, matrix.values[k]);
  return text;
}

template <int D>
ExitCode coarsen_mesh(const Mesh<D>& mesh, const CoarsenArguments& arguments, StageTimes times, Session& session) {
  Observer& observer = session.observer;
  Report report;
  report.command = "coarsen";
  report.options = options_json(arguments);
  report.input = describe_file(arguments.mesh, D);
  report.times = std::move(times);
  const CoarseningHierarchy<D> hierarchy =
      timed(report.times, "coarsen", [&] { return coarsen(mesh, arguments.options, observer); });

  std::vector<LevelFigures> figures;
  bool ok = true;
  std::size_t n_finer = mesh.points.size();
  report.levels = Json::array();
  for (const CoarseLevel<D>& level : hierarchy.levels) {
    figures.push_back(judge(level, hierarchy.domain, arguments.options, n_finer, report, observer));
    report.levels->push_back(level_json(figures.back()));
    ok = ok && figures.back().certificate.ok;
    n_finer = level.mesh.points.size();
  }

  observer.begin_stage("write");
  timed(report.times, "write", [&] {
    for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
      observer.check_cancelled();
      const CoarseLevel<D>& level = hierarchy.levels[i];
      std::vector<double> finest;
      for (const VertexId v : level.finest_vertex) finest.push_back(v.value());
      const fs::path stem = arguments.folder / fmt::format("level-{}", i + 1);
      write_mesh(level.mesh, session.outputs.stage(fs::path(stem).concat(".node")),
                 {.vertex = {{"finest_vertex", finest}}, .simplex = {}});
      const std::string name = fmt::format("prolongation-{}.mtx", i + 1);
      write_text(matrix_market(level.prolongation, level.mesh.points.size()),
                 session.outputs.stage(arguments.folder / name));
    }
  });
  std::string text = level_table(mesh.points.size(), figures);
  if (hierarchy.levels.size() < static_cast<std::size_t>(arguments.options.levels))
    text += fmt::format("The boundary allows {} of {} levels.\n", hierarchy.levels.size(), arguments.options.levels);
  for (std::size_t i = 0; i < figures.size(); ++i)
    if (!figures[i].certificate.ok)
      text += fmt::format("\nlevel {}\n{}", i + 1, certificate_table(figures[i].certificate));
  text += fmt::format("levels: {}\n", arguments.folder.string());
  session.finish(report, text);
  return ok ? ExitCode::kDone : ExitCode::kCheckFailed;
}

ExitCode run_coarsen(const CoarsenArguments& arguments, Session& session) {
  session.outputs.protect(arguments.mesh);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(
      times, "read", [&] { return read_mesh_or_triangulate(arguments.mesh, arguments.redelaunay, session.observer); });
  return std::visit([&](const auto& any) { return coarsen_mesh(any, arguments, times, session); }, mesh);
}

}  // namespace

Command add_coarsen_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("coarsen", "A hierarchy of coarser meshes whose vertices are nested");
  const auto arguments = std::make_shared<CoarsenArguments>();
  CoarseningOptions& options = arguments->options;
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele) or .vtu, of any program")->required();
  app->add_option("-o,--output", arguments->folder, "Folder for level-1.node, ..., prolongation-1.mtx, ...")
      ->required();
  app->add_option("--levels", options.levels, "Coarser meshes to make; fewer where the boundary allows no more")
      ->check(whole_number(1, 60))
      ->capture_default_str();
  app->add_option("--growth", options.growth, "Distances of vertices grow by this factor from level to level")
      ->check(CLI::Range(1.0 + 1e-6, 1e6))
      ->capture_default_str();
  app->add_option("--lipschitz", options.lipschitz, "Lipschitz constant of the spacing of each level")
      ->check(positive_number(0.9))
      ->capture_default_str();
  app->add_option("--initial", options.initial, "Spacing of MESH at a vertex: half of its nearest or of its mean edge")
      ->transform(CLI::CheckedTransformer(kInitialNames))
      ->default_str(std::string(name_of(kInitialNames, options.initial)));
  app->add_option("--order", options.order, "Order in which vertices are tried")
      ->transform(CLI::CheckedTransformer(kOrderNames))
      ->default_str(std::string(name_of(kOrderNames, options.order)));
  app->add_flag("--quasi-uniform", options.quasi_uniform,
                "Spacing max(growth^i min f0, f0) of algorithm COARSEN, for meshes of about one size");
  app->add_flag("--redelaunay", arguments->redelaunay, "Triangulate the points of MESH anew if it is not Delaunay");
  add_common_options(*app, common);
  app->footer(
      "In level-K.node, attribute 1 is the spacing, attribute 2 the vertex's place in MESH, counted from 0.\n"
      "prolongation-K.mtx interpolates from level K to level K - 1; MESH is level 0.\n"
      "Example: voropack coarsen part.vtu --levels 5 -o hierarchy");
  return {app, [arguments, &common](Session& session) {
            arguments->options.seed = common.seed;
            return run_coarsen(*arguments, session);
          }};
}

}  // namespace voropack::app
