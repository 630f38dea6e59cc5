// voropack coarsen: a hierarchy of coarser meshes, node-nested, for multigrid.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <regex>
#include <set>
#include <vector>

#include "command.h"
#include "known_domain.h"
#include "print.h"
#include "voropack/coarsening.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

const std::map<std::string, InitialSpacing> kInitialNames = {{"nearest", InitialSpacing::kNearest},
                                                             {"mean-edge", InitialSpacing::kMeanEdge}};
const std::map<std::string, CoarseningOrder> kOrderNames = {
    {"front", CoarseningOrder::kFront}, {"curve", CoarseningOrder::kCurve}, {"random", CoarseningOrder::kRandom}};

const std::map<std::string, LocalImprovement> kImprovementNames = {
    {"none", LocalImprovement::kNone}, {"packed", LocalImprovement::kPacked}, {"free", LocalImprovement::kFree}};

struct CoarsenArguments {
  fs::path mesh;
  fs::path folder;
  KnownDomain domain;
  CoarseningOptions options;
  BeyondBoundaryOptions beyond;
  bool is_beyond = false;
  std::optional<double> lipschitz;
  bool redelaunay = false;
  bool counts_intersections = false;
  std::vector<std::string> level_boundaries;  ///< K=FILE.
};

Json options_json(const CoarsenArguments& arguments) {
  const CoarseningOptions& options = arguments.options;
  Json json;
  json["output"] = arguments.folder.string();
  if (options.target_vertices.empty()) {
    json["levels"] = options.levels;
    json["growth"] = options.growth;
  } else {
    json["target_nodes"] = options.target_vertices;
  }
  if (!arguments.is_beyond) json["lipschitz"] = options.lipschitz;
  if (arguments.is_beyond && arguments.lipschitz) json["lipschitz"] = *arguments.lipschitz;
  json["initial"] = name_of(kInitialNames, options.initial);
  json["order"] = name_of(kOrderNames, options.order);
  json["quasi_uniform"] = options.quasi_uniform;
  json["redelaunay"] = arguments.redelaunay;
  describe_known_domain(arguments.domain, json);
  if (!arguments.level_boundaries.empty()) json["level_boundary"] = arguments.level_boundaries;
  json["beyond_boundary"] = arguments.is_beyond;
  if (!arguments.is_beyond) return json;
  json["improve"] = name_of(kImprovementNames, arguments.beyond.improvement);
  json["restarts"] = arguments.beyond.restarts;
  json["max_area_change"] = arguments.beyond.max_area_change;
  json["merge_markers"] = arguments.beyond.merge_markers;
  json["feature_angle"] = arguments.beyond.feature_angle_deg;
  return json;
}

/// What is known of one level once it is certified.
struct LevelFigures {
  QualityReport quality;
  Certificate certificate;
  double ratio = 0;  ///< Vertices over those of the next finer mesh.
  double epsilon = 0, growth = 1, boundary_distance = 0;
  /// Simplices of the next finer mesh that one of this level meets.
  std::optional<double> most_intersections, mean_intersections;
  // Beyond the boundary.
  std::optional<double> area_change, lipschitz, largest_overlap;
  std::optional<std::size_t> n_exchanges;
};

Json level_json(const LevelFigures& level) {
  Json json;
  json["vertices"] = level.quality.n_vertices;
  json["simplices"] = level.quality.n_simplices;
  json["ratio"] = level.ratio;
  json["growth"] = level.growth;
  json["radius_edge"] = {{"max", level.quality.radius_edge.max}, {"mean", level.quality.radius_edge.mean}};
  json["angle_deg"] = {{"min", level.quality.angle_deg.min}, {"max", level.quality.angle_deg.max}};
  double measure = 0;
  for (const auto& region : level.quality.regions) measure += region.volume;
  json["volume"] = measure;
  json["boundary_distance"] = level.boundary_distance;
  if (level.most_intersections)
    json["intersections"] = {{"max", *level.most_intersections}, {"mean", *level.mean_intersections}};
  if (level.area_change) json["area_change"] = *level.area_change;
  if (level.lipschitz) json["lipschitz"] = *level.lipschitz;
  if (level.largest_overlap) json["largest_overlap"] = *level.largest_overlap;
  if (level.n_exchanges) json["exchanges"] = *level.n_exchanges;
  if (level.epsilon > 0) json["epsilon"] = level.epsilon;
  json["certificate"] = certificate_json(level.certificate);
  return json;
}

/// What the level's maker promises of it.
template <int D>
CertificateOptions claims_of(const CoarseLevel<D>& level, const CoarsenArguments& arguments) {
  CertificateOptions claims;
  if (!arguments.is_beyond) claims.gradation = arguments.options.lipschitz;
  if (level.epsilon > 0) {
    claims.form = PackingForm::kMaximal;
    claims.epsilon = level.epsilon;
  }
  return claims;
}

template <int D>
LevelFigures judge(const CoarseLevel<D>& level, const Domain<D>* domain, const CoarsenArguments& arguments,
                   std::size_t n_finer, Report& report, Observer& observer) {
  const ControlVolumes<D> volumes =
      timed(report.times, "dual", [&] { return build_control_volumes(level.mesh, observer); });
  LevelFigures figures;
  figures.ratio = static_cast<double>(level.mesh.points.size()) / static_cast<double>(n_finer);
  figures.epsilon = level.epsilon;
  figures.growth = level.growth;
  figures.boundary_distance = level.boundary_distance;
  figures.quality = timed(report.times, "quality", [&] { return measure_quality(level.mesh, volumes, observer); });
  figures.certificate = timed(report.times, "certificate", [&] {
    return certify(level.mesh, volumes, domain, claims_of(level, arguments), observer);
  });
  return figures;
}

std::string level_table(std::size_t n_finest, const std::vector<LevelFigures>& levels,
                        const CoarsenArguments& arguments, int dimension) {
  const bool is_beyond = arguments.is_beyond, has_counts = arguments.counts_intersections;
  const bool has_distance = is_beyond || !arguments.level_boundaries.empty();
  std::string text = fmt::format("{:<7}{:>11}{:>8}{:>12}{:>13}{:>11}{:>11}", "level", "vertices", "ratio", "simplices",
                                 "max R / l", "min angle", "max angle");
  if (has_distance) text += fmt::format("{:>12}", "distance");
  if (is_beyond) text += fmt::format("{:>12}{:>10}", dimension == 2 ? "area, %" : "volume, %", "overlap");
  if (has_counts) text += fmt::format("{:>11}{:>12}", "meets max", "meets mean");
  text += fmt::format("  certificate\n{:<7}{:>11}\n", 0, grouped(n_finest));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const LevelFigures& level = levels[i];
    text += fmt::format("{:<7}{:>11}{:>8.3f}{:>12}{:>13.4g}{:>11.2f}{:>11.2f}", i + 1,
                        grouped(level.quality.n_vertices), level.ratio, grouped(level.quality.n_simplices),
                        level.quality.radius_edge.max, level.quality.angle_deg.min, level.quality.angle_deg.max);
    if (has_distance) text += fmt::format("{:>12.3g}", level.boundary_distance);
    if (is_beyond) text += fmt::format("{:>12.3g}{:>10.2g}", 100 * *level.area_change, *level.largest_overlap);
    if (has_counts) text += fmt::format("{:>11}{:>12.4g}", *level.most_intersections, *level.mean_intersections);
    text += fmt::format("  {}\n", level.certificate.ok ? "ok" : "failed");
  }
  return text;
}

std::string remarks(const std::vector<LevelFigures>& levels, const CoarsenArguments& arguments) {
  std::string text;
  const std::size_t n_wanted = arguments.options.target_vertices.empty()
                                   ? static_cast<std::size_t>(arguments.options.levels)
                                   : arguments.options.target_vertices.size();
  if (levels.size() < n_wanted)
    text += fmt::format("{} of {} levels: others would have hardly fewer vertices than the next finer one.\n",
                        levels.size(), n_wanted);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const LevelFigures& level = levels[i];
    if (levels.size() == arguments.options.target_vertices.size() &&
        level.quality.n_vertices > arguments.options.target_vertices[i])
      text += fmt::format("level {}: the boundary allows no fewer vertices\n", i + 1);
    if (level.epsilon > 0)
      text += fmt::format("level {}: check it with --packing maximal --epsilon {:.17g}\n", i + 1, level.epsilon);
    if (!level.certificate.ok) text += fmt::format("\nlevel {}\n{}", i + 1, certificate_table(level.certificate));
  }
  return text;
}

template <int D>
void write_levels(const std::vector<const CoarseLevel<D>*>& levels, const fs::path& folder, Session& session) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    session.observer.check_cancelled();
    const CoarseLevel<D>& level = *levels[i];
    std::vector<double> finest;
    for (const VertexId v : level.finest_vertex) finest.push_back(v.value());
    write_mesh(level.mesh, session.outputs.stage(folder / fmt::format("level-{}.node", i + 1)),
               {.vertex = {{"finest_vertex", finest}}, .simplex = {}});
    const SparseMatrix& p = level.prolongation;
    write_matrix_market(p.offsets, p.columns, p.values, level.mesh.points.size(),
                        session.outputs.stage(folder / fmt::format("prolongation-{}.mtx", i + 1)));
  }
}

/// A file under one of the names that a hierarchy has in its folder.
struct HierarchyFile {
  fs::path path;
  std::size_t level = 0;
};

/// What an earlier hierarchy left in the folder.
std::vector<HierarchyFile> hierarchy_files(const fs::path& folder) {
  static const std::regex kName(R"((?:level-([1-9]\d{0,2})\.(?:node|ele|face|edge)|prolongation-([1-9]\d{0,2})\.mtx))");
  std::vector<HierarchyFile> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::smatch match;
    if (!entry.is_regular_file(error) || !std::regex_match(name, match, kName)) continue;
    files.push_back({entry.path(), std::stoul(match[1].matched ? match[1] : match[2])});
  }
  return files;
}

/// The coarser levels of an earlier hierarchy, which go when the new one appears.
std::string stale_line(const std::vector<HierarchyFile>& earlier, std::size_t n_levels) {
  std::set<std::size_t> stale;
  for (const HierarchyFile& file : earlier)
    if (file.level > n_levels) stale.insert(file.level);
  if (stale.empty()) return {};
  return fmt::format("removed: level {} of an earlier hierarchy there\n", fmt::join(stale, ", "));
}

const CLI::Validator kLevelFile(
    [](const std::string& text) -> std::string {
      const std::size_t at = text.find('=');
      const bool is_fine = at != std::string::npos && at > 0 && at < 4 && at + 1 < text.size() &&
                           text.find_first_not_of("0123456789") == at && text[0] != '0';
      return is_fine ? "" : "not of the form K=FILE with a level K from 1 on: " + text;
    },
    "K=FILE");

/// FILE of K=FILE.
fs::path level_file(const std::string& text) { return text.substr(text.find('=') + 1); }

template <int D>
std::vector<LevelBoundary<D>> read_boundaries(const std::vector<std::string>& texts, Observer& observer) {
  std::vector<LevelBoundary<D>> boundaries;
  for (const std::string& text : texts) {
    const fs::path path = level_file(text);
    const AnyDomainInput any = read_domain(path, observer);
    const auto* const input = std::get_if<DomainInput<D>>(&any);
    if (input == nullptr)
      throw InputError(Fault{.id = "cli.dimension",
                             .message = "the mesh and the boundary of a level have different dimensions",
                             .fix = fmt::format("give a {}D domain.", D),
                             .file = path.string()});
    // Its points are vertices of the mesh: none may move.
    boundaries.push_back({std::stoi(text), build_domain(*input, {.merge_distance = 0}, observer)});
  }
  return boundaries;
}

/// Levels of either kind, and what is known of each.
template <int D>
struct Levels {
  CoarseningHierarchy<D> hierarchy;            ///< Within the boundary.
  std::vector<SimplifiedLevel<D>> simplified;  ///< Beyond it.
  std::vector<const CoarseLevel<D>*> all;
  std::vector<LevelFigures> figures;
};

template <int D>
void count(const Mesh<D>& finer, const CoarseLevel<D>& level, LevelFigures& figures) {
  const auto counts = count_intersections(finer, level);
  figures.most_intersections = *std::max_element(counts.begin(), counts.end());
  figures.mean_intersections = std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
}

template <int D>
void make_levels(const Mesh<D>& mesh, const CoarsenArguments& arguments, Report& report, Observer& observer,
                 Levels<D>& out) {
  std::vector<LevelBoundary<D>> boundaries =
      timed(report.times, "read", [&] { return read_boundaries<D>(arguments.level_boundaries, observer); });
  if (arguments.is_beyond) {
    timed(report.times, "coarsen", [&] { out.simplified = coarsen_beyond_boundary(mesh, arguments.beyond, observer); });
  } else {
    MeshDomain<D> place = timed(report.times, "domain", [&] { return find_place(mesh, arguments.domain, observer); });
    timed(report.times, "coarsen", [&] {
      out.hierarchy = coarsen<D>(mesh, std::move(place), std::move(boundaries), arguments.options, observer);
    });
  }
  for (const CoarseLevel<D>& level : out.hierarchy.levels) out.all.push_back(&level);
  for (const CoarseLevel<D>& level : out.simplified) out.all.push_back(&level);
  const Mesh<D>* finer = &mesh;
  for (std::size_t i = 0; i < out.all.size(); ++i) {
    const CoarseLevel<D>& level = *out.all[i];
    LevelFigures figures = judge<D>(level, arguments.is_beyond ? nullptr : &out.hierarchy.domain_of(i), arguments,
                                    finer->points.size(), report, observer);
    if (arguments.counts_intersections) timed(report.times, "intersections", [&] { count(*finer, level, figures); });
    if (arguments.is_beyond) {
      figures.area_change = out.simplified[i].area_change;
      figures.lipschitz = out.simplified[i].lipschitz;
      figures.largest_overlap = out.simplified[i].largest_overlap;
      figures.n_exchanges = out.simplified[i].n_exchanges;
    }
    out.figures.push_back(std::move(figures));
    finer = &level.mesh;
  }
}

template <int D>
ExitCode coarsen_mesh(const Mesh<D>& mesh, const CoarsenArguments& arguments, const std::vector<HierarchyFile>& earlier,
                      StageTimes times, Session& session) {
  Observer& observer = session.observer;
  Report report;
  report.command = "coarsen";
  report.options = options_json(arguments);
  report.input = describe_file(arguments.mesh, D);
  report.times = std::move(times);
  Levels<D> levels;
  make_levels(mesh, arguments, report, observer, levels);
  observer.begin_stage("write");
  timed(report.times, "write", [&] { write_levels(levels.all, arguments.folder, session); });
  report.levels = Json::array();
  bool ok = true;
  for (const LevelFigures& level : levels.figures) {
    report.levels->push_back(level_json(level));
    ok = ok && level.certificate.ok;
  }
  session.finish(report, level_table(mesh.points.size(), levels.figures, arguments, D) +
                             remarks(levels.figures, arguments) + stale_line(earlier, levels.all.size()) +
                             (levels.all.empty() ? "" : fmt::format("levels: {}\n", arguments.folder.string())));
  return ok ? ExitCode::kDone : ExitCode::kCheckFailed;
}

ExitCode run_coarsen(const CoarsenArguments& arguments, Session& session) {
  session.outputs.protect(arguments.mesh);
  for (const fs::path& file : arguments.domain.files()) session.outputs.protect(file);
  for (const std::string& text : arguments.level_boundaries) session.outputs.protect(level_file(text));
  const std::vector<HierarchyFile> earlier = hierarchy_files(arguments.folder);
  for (const HierarchyFile& file : earlier) session.outputs.replace(file.path);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(
      times, "read", [&] { return read_mesh_or_triangulate(arguments.mesh, arguments.redelaunay, session.observer); });
  return std::visit([&](const auto& any) { return coarsen_mesh(any, arguments, earlier, times, session); }, mesh);
}

/// An option whose values have names.
template <class T>
CLI::Option* add_choice(CLI::App& app, const std::string& option, T& value, const std::map<std::string, T>& names,
                        const std::string& description) {
  std::vector<std::string> known;
  for (const auto& [name, meaning] : names) known.push_back(name);
  return app
      .add_option_function<std::string>(
          option, [&value, &names](const std::string& name) { value = names.at(name); }, description)
      ->check(one_of(known))
      ->type_name(fmt::format("{}", fmt::join(known, "|")));
}

void add_level_options(CLI::App& app, CoarsenArguments& arguments) {
  CoarseningOptions& options = arguments.options;
  CLI::Option* const levels =
      app.add_option("--levels", options.levels, "Coarser meshes to make; fewer where the boundary allows no more")
          ->check(whole_number(1, 60))
          ->capture_default_str();
  CLI::Option* const growth =
      app.add_option("--growth", options.growth, "Distances of vertices grow by this factor from level to level")
          ->check(CLI::Range(1.0 + 1e-6, 1e6))
          ->capture_default_str();
  app.add_option("--target-nodes", options.target_vertices,
                 "Vertices of level 1, 2, ...: the growth of each is the one that comes closest from below")
      ->delimiter(',')
      ->check(whole_number(1, 0xffffffffU))
      ->type_name("N1,N2,...")
      ->excludes(levels)
      ->excludes(growth);
  app.add_option(
         "--lipschitz", arguments.lipschitz,
         fmt::format("Lipschitz constant of the spacing of each level; {} by default, 0.1 beyond the boundary in "
                     "the plane",
                     options.lipschitz))
      ->check(positive_number(0.9));
  add_choice(app, "--initial", options.initial, kInitialNames,
             "Spacing of MESH at a vertex: half the distance to its nearest neighbor (nearest), or that of a\n"
             "packing with as long edges there (mean-edge)")
      ->default_str(std::string(name_of(kInitialNames, options.initial)));
  add_choice(app, "--order", options.order, kOrderNames, "Order in which vertices are tried")
      ->default_str(std::string(name_of(kOrderNames, options.order)));
  app.add_flag("--quasi-uniform", options.quasi_uniform,
               "Spacing max(growth^i min f0, f0) of algorithm COARSEN, for meshes of about one size");
}

void add_boundary_option(CLI::App& app, CoarsenArguments& arguments) {
  app.add_option("--level-boundary", arguments.level_boundaries,
                 "Domain whose boundary level K and coarser ones get; its points are vertices of MESH. May be given\n"
                 "again for another level")
      ->check(kLevelFile)
      ->allow_extra_args(false)
      ->type_name("K=FILE");
}

void add_beyond_options(CLI::App& app, CoarsenArguments& arguments) {
  BeyondBoundaryOptions& options = arguments.beyond;
  CLI::Option* const beyond = app.add_flag("--beyond-boundary", arguments.is_beyond,
                                           "Simplify the boundary with its mesh, and report how far it moves")
                                  ->excludes("--quasi-uniform")
                                  ->excludes("--level-boundary");
  app.add_option("--feature-angle", options.feature_angle_deg,
                 "Beyond the boundary: vertices where it turns by more than this stay on all levels; in space, edges\n"
                 "where it does are features, which keep their ends")
      ->check(positive_number(180))
      ->type_name("DEG")
      ->capture_default_str()
      ->needs(beyond);
  add_choice(app, "--improve", options.improvement, kImprovementNames,
             "Beyond the boundary, in the plane: exchange vertices for better shapes as long as vertices keep "
             "their distance\n"
             "(packed), or whatever their distance (free)")
      ->default_str(std::string(name_of(kImprovementNames, options.improvement)))
      ->needs(beyond);
  app.add_option("--restarts", options.restarts,
                 "Beyond the boundary, in the plane: attempts per level, of which the best is taken")
      ->check(whole_number(1, 1000))
      ->capture_default_str()
      ->needs(beyond);
  app.add_option("--max-area-change", options.max_area_change,
                 "Beyond the boundary: how much of its area or volume a region may win or lose")
      ->check(CLI::Range(1e-9, 0.999))
      ->capture_default_str()
      ->needs(beyond);
  app.add_flag("--merge-markers", options.merge_markers,
               "Beyond the boundary, in space: join faces of different markers, as those of meshes of surface files,\n"
               "where each triangle has a marker of its own")
      ->needs(beyond);
}

/// Options that mean the same beyond the boundary.
void copy_shared_options(CoarsenArguments& arguments, std::uint64_t seed) {
  arguments.options.seed = arguments.beyond.seed = seed;
  arguments.beyond.levels = arguments.options.levels;
  arguments.beyond.growth = arguments.options.growth;
  arguments.beyond.target_vertices = arguments.options.target_vertices;
  arguments.beyond.initial = arguments.options.initial;
  arguments.beyond.order = arguments.options.order;
  if (!arguments.lipschitz) return;
  arguments.options.lipschitz = *arguments.lipschitz;
  arguments.beyond.lipschitz = arguments.lipschitz;
}

}  // namespace

Command add_coarsen_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("coarsen", "A hierarchy of coarser meshes whose vertices are nested");
  const auto arguments = std::make_shared<CoarsenArguments>();
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele) or .vtu, of any program")->required();
  app->add_option("-o,--output", arguments->folder, "Folder for level-1.node, ..., prolongation-1.mtx, ...")
      ->required();
  add_level_options(*app, *arguments);
  add_domain_options(*app, arguments->domain,
                     "The domain that MESH was made of; else what its boundary tells.\nMesh and domain may differ by "
                     "--merge-distance");
  add_boundary_option(*app, *arguments);
  add_beyond_options(*app, *arguments);
  app->add_flag("--intersections", arguments->counts_intersections,
                "Count the simplices of the next finer mesh that each one of a level meets")
      ->excludes("--beyond-boundary")
      ->excludes("--level-boundary");
  add_redelaunay_option(*app, arguments->redelaunay);
  add_common_options(*app, common);
  app->footer(
      "In level-K.node, attribute 1 is the spacing, attribute 2 the vertex's place in MESH, counted from 0.\n"
      "prolongation-K.mtx interpolates from level K to level K - 1; MESH is level 0.\n"
      "Example: voropack coarsen part.vtu --levels 5 -o hierarchy");
  return {app, [arguments, &common](Session& session) {
            copy_shared_options(*arguments, common.seed);
            return run_coarsen(*arguments, session);
          }};
}

}  // namespace voropack::app
