// voropack paper: the paper's tables, its figures beside ours.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>

#include "command.h"
#include "figure3.h"
#include "perturbed_cube.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kMaxGrid = 400;  // More points than 32-bit ids of dual faces leave room for.
constexpr std::uint64_t kMaxSeeds = 10'000;

struct Figure3Arguments {
  std::optional<fs::path> mesh;
  bool redelaunay = false;  ///< Take the points of `mesh` only.
  std::vector<fs::path> outputs;
  Figure3Options study;
};

/// The counts of a mesh under the names of the reference data.
Json count_json(const Mesh<3>& mesh) {
  std::vector<std::array<VertexId, 2>> edges;
  IdVector<VertexId, std::uint8_t> used(mesh.points.size(), 0);
  for (const auto& corners : mesh.simplex_vertices)
    for (std::size_t i = 0; i < 4; ++i) {
      used[corners[i]] = 1;
      for (std::size_t j = i + 1; j < 4; ++j)
        edges.push_back({std::min(corners[i], corners[j]), std::max(corners[i], corners[j])});
    }
  std::sort(edges.begin(), edges.end());
  const auto n_edges = std::unique(edges.begin(), edges.end()) - edges.begin();
  std::size_t n_hull_faces = 0;
  for (const auto& neighbors : mesh.simplex_neighbors)
    for (const SimplexId t : neighbors) n_hull_faces += t.is_none() ? 1U : 0U;
  return {{"ntet", mesh.simplex_vertices.size()},
          {"nused", std::count(used.begin(), used.end(), 1)},
          {"nedges", n_edges},
          {"nbfaces", n_hull_faces}};
}

/// The T<3> that a file holds; `any` is a T of either dimension.
template <class T, class Any>
T take_3d(Any any, const fs::path& path) {
  if (auto* const value = std::get_if<T>(&any)) return std::move(*value);
  throw InputError(Fault{.id = "cli.dimension",
                         .message = "Figure 3 is about tetrahedra, this file is 2D",
                         .fix = "give a 3D mesh.",
                         .file = path.string()});
}

Mesh<3> read_or_triangulate(const Figure3Arguments& arguments, Observer& observer) {
  const fs::path& path = *arguments.mesh;
  if (!arguments.redelaunay) return take_3d<Mesh<3>>(read_mesh(path, observer), path);
  check_extension(path, {".node"});
  return delaunay_mesh(take_3d<DomainInput<3>>(read_domain(path, observer), path).points);
}

ExitCode measure_mesh_file(const Figure3Arguments& arguments, Session& session) {
  const fs::path& path = *arguments.mesh;
  session.outputs.protect(path);
  Report report;
  report.command = "paper figure3";
  report.options["redelaunay"] = arguments.redelaunay;
  session.observer.begin_stage("read");
  const Mesh<3> mesh = timed(report.times, "read", [&] { return read_or_triangulate(arguments, session.observer); });
  report.input = describe_file(path, 3);
  session.observer.begin_stage("figure3");
  const Figure3Solutions solutions =
      timed(report.times, "solve", [&] { return solve_figure3(mesh, session.observer); });
  const Figure3 figures = timed(report.times, "norms", [&] { return measure_figure3(mesh, solutions); });
  const Figure3Details details = timed(report.times, "norms", [&] { return measure_figure3_details(mesh, solutions); });
  Json json = count_json(mesh);
  std::string text = fmt::format("{:<14}{:>16}\n", "tetrahedra", grouped(mesh.simplex_vertices.size()));
  text += fmt::format("{:<14}{:>16}\n", "slivers", grouped(details.n_slivers));
  const auto add = [&](const std::string& key, double value) {
    if (std::isfinite(value)) json[key] = value;
    text += fmt::format("{:<14}{:>16}\n", key, std::isfinite(value) ? fmt::format("{:.10g}", value) : "-");
  };
  json["nsliv"] = details.n_slivers;
  json["zero_areas"] = solutions.volumes.n_zero_areas;
  add("zeroed_area", solutions.volumes.zeroed_area);
  add("zeroed_area_bound", solutions.volumes.zeroed_area_bound);
  add("radius_edge", figures.radius_edge);
  for (const Column column : kColumns) add(name_of(column), value_of(figures, column));
  add("fem_max", details.fem_max);
  add("cvm_max", details.cvm_max);
  add("fem_H1ns", details.h1_without_slivers.fem);
  add("cvm_H1", details.h1.cvm);
  add("cvm_H1ns", details.h1_without_slivers.cvm);
  add("int_H1", details.h1.interpolant);
  add("int_H1ns", details.h1_without_slivers.interpolant);
  add("U_minus_U1", details.discrete_error);
  add("U1_minus_U2", details.consistency_error);
  add("bound_2_3", details.bound);
  report.figure3 = std::move(json);
  session.finish(report, text);
  return ExitCode::kDone;
}

Json options_json(const Figure3Options& options) {
  return {{"grids", options.grids},
          {"perturbations", options.perturbations},
          {"seeds", options.seeds},
          {"seed", options.first_seed}};
}

Json rows_json(const std::vector<Figure3Row>& rows) {
  Json list = Json::array();
  for (const Figure3Row& row : rows) {
    Json json = {{"n", row.n}, {"eps", row.eps}, {"seeds", row.meshes.size()}};
    for (const Column column : kColumns) {
      const Summary s = summarize(row, column);
      Json& figures = json[name_of(column)];
      if (const auto paper = paper_value(row.n, row.eps, column)) figures["paper"] = *paper;
      figures["meshes"] = s.n;
      if (s.n == 0) continue;
      figures["mean"] = s.mean;
      figures["sd"] = s.deviation;
      figures["min"] = s.min;
      figures["median"] = s.median;
      figures["max"] = s.max;
    }
    list.push_back(std::move(json));
  }
  return list;
}

ExitCode run_study(const Figure3Arguments& arguments, Session& session) {
  std::vector<fs::path> staged;
  for (const fs::path& output : arguments.outputs) check_extension(output, {".csv", ".svg"});
  for (const fs::path& output : arguments.outputs) staged.push_back(session.outputs.stage(output));
  Figure3Options options = arguments.study;
  options.first_seed = session.common.seed;
  Report report;
  report.command = "paper figure3";
  report.options = options_json(options);
  const std::vector<Figure3Row> rows =
      timed(report.times, "figure3", [&] { return run_figure3(options, session.observer); });
  report.figure3 = Json{{"rows", rows_json(rows)}};
  std::string text = figure3_table(rows);
  for (std::size_t i = 0; i < staged.size(); ++i) {
    const bool is_csv = std::tolower(arguments.outputs[i].extension().string()[1]) == 'c';
    write_text(is_csv ? figure3_csv(rows) : figure3_svg(rows), staged[i]);
    report.options["output"].push_back(arguments.outputs[i].string());
  }
  session.finish(report, text);
  return ExitCode::kDone;
}

void add_figure3_options(CLI::App& app, Figure3Arguments& arguments) {
  CLI::Option* const mesh = app.add_option("--mesh", arguments.mesh,
                                           "Measure this mesh of the unit cube instead of making some: .node\n"
                                           "(with .ele) or .vtu")
                                ->type_name("MESH");
  app.add_flag("--redelaunay", arguments.redelaunay,
               "With --mesh: take the points only (.node) and triangulate them anew")
      ->needs(mesh);
  app.add_option("-o,--output", arguments.outputs, "Write the table (.csv) or a picture (.svg); may be given again")
      ->allow_extra_args(false)
      ->type_name("FILE")
      ->excludes(mesh);
  app.add_option("--grid", arguments.study.grids,
                 "Grids of width h = 1/N, separated by commas; finite elements at 1/64 take\n"
                 "minutes")
      ->delimiter(',')
      ->check(whole_number(2, kMaxGrid))
      ->type_name("N")
      ->capture_default_str()
      ->excludes(mesh);
  app.add_option("--eps", arguments.study.perturbations,
                 "Points move by up to EPS h per coordinate; below 1/2, separated by commas")
      ->delimiter(',')
      ->check(number_below(0.5))
      ->type_name("EPS")
      ->capture_default_str()
      ->excludes(mesh);
  app.add_option("--seeds", arguments.study.seeds,
                 "Meshes for each h and EPS, with the seeds from --seed on; beyond h = 1/16 fewer, so that\n"
                 "each row has about as many points, but at least one")
      ->check(whole_number(1, kMaxSeeds))
      ->type_name("K")
      ->capture_default_str()
      ->excludes(mesh);
}

}  // namespace

Command add_paper_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const paper = root.add_subcommand("paper", "The tables of the paper, its figures beside ours");
  paper->require_subcommand(1);
  paper->footer("Example: voropack paper figure3 --grid 4,8 -o figure3.svg");
  CLI::App* const app = paper->add_subcommand("figure3", "Control volumes and finite elements on cubes with slivers");
  const auto arguments = std::make_shared<Figure3Arguments>();
  add_figure3_options(*app, *arguments);
  add_common_options(*app, common);
  app->footer(
      "Figures: R_over_rho is the largest circumradius over inradius; fem_H1 the H1 seminorm of the error of the "
      "finite\n"
      "element method; fem_W and cvm_W the W norm of the errors of finite elements and control volumes at the\n"
      "vertices, over the edges with an end inside. With --mesh also H1 of control volumes and of the interpolant, "
      "once\n"
      "without slivers (H1ns), which have a dihedral angle below 10 degrees, the largest errors at a vertex, and the\n"
      "sides of the inequalities of Theorems 2.1 (|U - U1| <= |U1 - U2|) and 2.3 (|U1 - U2| <= bound_2_3).\n"
      "Example: voropack paper figure3 --grid 4,8,16 --seeds 24 -o figure3.csv -o figure3.svg\n"
      "Example: voropack paper figure3 --mesh cube.node --report cube.json");
  return {app, [arguments](Session& session) {
            return arguments->mesh ? measure_mesh_file(*arguments, session) : run_study(*arguments, session);
          }};
}

}  // namespace voropack::app
