// voropack paper figure8: coarsening beyond the boundary, the paper's table beside ours.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "command.h"
#include "print.h"
#include "voropack/coarsening.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

/// One row of the paper's table. Angles in degrees; averages over the triangles.
struct Figure8Row {
  std::string source;
  std::size_t level = 0, nodes = 0, elements = 0;
  double max_angle = 0, min_angle = 0, average_max = 0, average_min = 0;
};

/// [Miller1996], Figure 8. The average of the smallest angles of the first row must be a misprint: 55.5 would be more
/// than the average of the middle ones.
const std::vector<Figure8Row> kPaperRows = {{"paper", 0, 4253, 8034, 117.08, 8.18, 69.5, 55.5},
                                            {"paper", 1, 1039, 1848, 132.67, 15.45, 77.9, 45.10},
                                            {"paper", 2, 416, 706, 127.28, 20.09, 80.99, 42.42},
                                            {"paper", 3, 217, 359, 131.84, 20.21, 82.67, 41.67},
                                            {"paper", 4, 86, 134, 126.76, 17.38, 81.93, 41.04}};

struct Figure8Arguments {
  fs::path mesh;
  std::vector<fs::path> outputs;
  BeyondBoundaryOptions packed, improved;
};

Figure8Row measure(const Mesh<2>& mesh, const std::string& source, std::size_t level) {
  constexpr double kDegrees = 57.295779513082323;
  Figure8Row row{source, level, mesh.points.size(), mesh.simplex_vertices.size(), 0, 180, 0, 0};
  for (const auto& c : mesh.simplex_vertices) {
    double least = 180, largest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec<2> x = mesh.points[c[i]];
      const Vec<2> u = mesh.points[c[(i + 1) % 3]] - x, v = mesh.points[c[(i + 2) % 3]] - x;
      const double angle = kDegrees * std::atan2(cross(u, v), dot(u, v));
      least = std::min(least, angle);
      largest = std::max(largest, angle);
    }
    row.max_angle = std::max(row.max_angle, largest);
    row.min_angle = std::min(row.min_angle, least);
    row.average_max += largest / static_cast<double>(row.elements);
    row.average_min += least / static_cast<double>(row.elements);
  }
  return row;
}

std::string table(const std::vector<Figure8Row>& rows) {
  std::string text = fmt::format("{:<7}{:<10}{:>7}{:>10}{:>11}{:>11}{:>15}{:>15}\n", "level", "", "nodes", "elements",
                                 "max angle", "min angle", "avg max angle", "avg min angle");
  for (const Figure8Row& r : rows)
    text += fmt::format("{:<7}{:<10}{:>7}{:>10}{:>11.2f}{:>11.2f}{:>15.2f}{:>15.2f}\n", r.level, r.source, r.nodes,
                        r.elements, r.max_angle, r.min_angle, r.average_max, r.average_min);
  return text;
}

std::string csv(const std::vector<Figure8Row>& rows) {
  std::string text = "source,level,nodes,elements,max_angle,min_angle,avg_max_angle,avg_min_angle\n";
  for (const Figure8Row& r : rows)
    text += fmt::format("{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g}\n", r.source, r.level, r.nodes, r.elements,
                        r.max_angle, r.min_angle, r.average_max, r.average_min);
  return text;
}

Json level_json(const Figure8Row& row, const SimplifiedLevel<2>& level) {
  return {{"source", row.source},
          {"level", row.level},
          {"vertices", row.nodes},
          {"simplices", row.elements},
          {"angle_deg", {{"min", row.min_angle}, {"max", row.max_angle}}},
          {"growth", level.growth},
          {"lipschitz", level.lipschitz},
          {"area_change", level.area_change},
          {"boundary_distance", level.boundary_distance},
          {"largest_overlap", level.largest_overlap}};
}

/// What the rows do not show.
std::string remarks(const std::string& source, const std::vector<SimplifiedLevel<2>>& levels) {
  double area = 0, distance = 0, overlap = 0;
  for (const SimplifiedLevel<2>& level : levels) {
    area = std::max(area, level.area_change);
    distance = std::max(distance, level.boundary_distance);
    overlap = std::max(overlap, level.largest_overlap);
  }
  return fmt::format("{}: area within {:.2g} %, boundary within {:.3g}, f-spheres overlap by at most {:.2g}\n", source,
                     100 * area, distance, overlap);
}

/// The paper's numbers of vertices, for a mesh of another size in proportion.
std::vector<std::size_t> wished_numbers(std::size_t n_vertices) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 1; i < kPaperRows.size(); ++i)
    numbers.push_back(kPaperRows[i].nodes * n_vertices / kPaperRows[0].nodes);
  return numbers;
}

void draw_levels(const std::vector<SimplifiedLevel<2>>& levels, const fs::path& output, OutputSet& outputs) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const fs::path name = fmt::format("{}-{}.svg", output.stem().string(), i + 1);
    const ControlVolumes<2> volumes = build_control_volumes(levels[i].mesh);
    write_svg(levels[i].mesh, build_cell_shapes(levels[i].mesh, volumes), volumes,
              outputs.stage(output.parent_path() / name));
  }
}

ExitCode run_figure8(const Figure8Arguments& arguments, Session& session) {
  for (const fs::path& output : arguments.outputs) check_extension(output, {".csv", ".svg"});
  session.outputs.protect(arguments.mesh);
  Report report;
  report.command = "paper figure8";
  session.observer.begin_stage("read");
  const AnyMesh any = timed(report.times, "read", [&] { return read_mesh(arguments.mesh, session.observer); });
  const auto* const mesh = std::get_if<Mesh<2>>(&any);
  if (mesh == nullptr)
    throw InputError(Fault{.id = "cli.dimension",
                           .message = "Figure 8 is about triangles, this mesh is 3D",
                           .fix = "give a 2D mesh.",
                           .file = arguments.mesh.string()});
  report.input = describe_file(arguments.mesh, 2);
  std::vector<Figure8Row> rows(kPaperRows);
  rows.push_back(measure(*mesh, "computed", 0));
  std::string text;
  report.levels = Json::array();
  std::vector<SimplifiedLevel<2>> improved;
  for (const bool is_packed : {true, false}) {
    BeyondBoundaryOptions options = is_packed ? arguments.packed : arguments.improved;
    options.target_vertices = wished_numbers(mesh->points.size());
    options.seed = session.common.seed;
    const std::string source = is_packed ? "packed" : "improved";
    std::vector<SimplifiedLevel<2>> levels =
        timed(report.times, "coarsen", [&] { return coarsen_beyond_boundary(*mesh, options, session.observer); });
    for (std::size_t i = 0; i < levels.size(); ++i) {
      rows.push_back(measure(levels[i].mesh, source, i + 1));
      report.levels->push_back(level_json(rows.back(), levels[i]));
    }
    text += remarks(source, levels);
    if (!is_packed) improved = std::move(levels);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Figure8Row& a, const Figure8Row& b) { return a.level < b.level; });
  for (const fs::path& output : arguments.outputs) {
    if (std::tolower(output.extension().string()[1]) == 'c')
      write_text(csv(rows), session.outputs.stage(output));
    else
      draw_levels(improved, output, session.outputs);
    report.options["output"].push_back(output.string());
  }
  session.finish(report, table(rows) + text);
  return ExitCode::kDone;
}

}  // namespace

Command add_figure8_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app =
      root.get_subcommand("paper")->add_subcommand("figure8", "Coarsening beyond the boundary: angles per level");
  const auto arguments = std::make_shared<Figure8Arguments>();
  arguments->packed.improvement = LocalImprovement::kPacked;
  app->add_option(
         "--mesh", arguments->mesh,
         "The mesh to coarsen: .node (with .ele) or .vtu. The paper's is AG-Monien/airfoil1 of the SuiteSparse\n"
         "Matrix Collection, with 4253 vertices; for another one numbers of vertices are in proportion")
      ->required()
      ->type_name("MESH");
  app->add_option(
         "-o,--output", arguments->outputs,
         "Write the table (.csv) or pictures of the improved levels (NAME.svg: NAME-1.svg, ...); may be given\n"
         "again")
      ->allow_extra_args(false)
      ->type_name("FILE");
  add_common_options(*app, common);
  app->footer(
      "Rows: paper, the published ones; packed, where vertices keep the distance that the spacing function wants;\n"
      "improved, where they were exchanged for better shapes, by default.\n"
      "Example: voropack paper figure8 --mesh airfoil.node -o figure8.csv -o figure8.svg");
  return {app, [arguments](Session& session) { return run_figure8(*arguments, session); }};
}

}  // namespace voropack::app
