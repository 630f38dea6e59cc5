// voropack paper figure5: repeated maximal independent sets of the mesh's graph beside COARSEN.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <numeric>
#include <random>

#include "command.h"
#include "print.h"
#include "voropack/coarsening.h"
#include "voropack/delaunay.h"
#include "voropack/pipeline.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct Figure5Arguments {
  double size = 0.01;
  int levels = 4;
  std::vector<fs::path> outputs;
};

struct Figure5Row {
  std::string method;
  std::size_t level = 0, vertices = 0;
  double radius_edge = 0, min_angle = 180;
};

/// The rows, and the coarsest mesh of each method for a picture.
struct Figure5Study {
  std::vector<Figure5Row> rows;
  std::vector<std::pair<std::string, Mesh<2>>> coarsest;
};

Figure5Row measure(const std::string& method, std::size_t level, const IdVector<VertexId, Vec<2>>& points,
                   const std::vector<std::array<VertexId, 3>>& triangles) {
  constexpr double kDegrees = 57.295779513082323;
  Figure5Row row{method, level, points.size()};
  for (const auto& c : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec<2> u = points[c[(i + 1) % 3]] - points[c[i]], v = points[c[(i + 2) % 3]] - points[c[i]];
      row.min_angle = std::min(row.min_angle, kDegrees * std::atan2(cross(u, v), dot(u, v)));
    }
  // Circumradius over shortest edge of a triangle: half the inverse sine of its smallest angle.
  row.radius_edge = 0.5 / std::sin(row.min_angle / kDegrees);
  return row;
}

/// The Delaunay triangles of points in a square whose sides are full of them: none is flat.
std::vector<std::array<VertexId, 3>> triangles_of(const IdVector<VertexId, Vec<2>>& points) {
  const Triangulation<2> t = delaunay_triangulation<2>(points.raw());
  std::vector<std::array<VertexId, 3>> triangles;
  for (const auto& c : t.simplices)
    triangles.push_back({VertexId(std::size_t{c[0]}), VertexId(std::size_t{c[1]}), VertexId(std::size_t{c[2]})});
  return triangles;
}

/// How many sides of the unit square a point lies on.
int n_sides(const Vec<2>& x) {
  int n = 0;
  for (int k = 0; k < 2; ++k) n += x[k] == 0 || x[k] == 1 ? 1 : 0;
  return n;
}

/// A maximal independent set of the graph of the edges: corners, then vertices on sides, then inner ones, each in
/// random order.
IdVector<VertexId, Vec<2>> independent_set(const IdVector<VertexId, Vec<2>>& points,
                                           const std::vector<std::array<VertexId, 3>>& triangles, std::uint64_t seed) {
  std::vector<std::vector<VertexId>> neighbors(points.size());
  for (const auto& c : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      neighbors[c[i].value()].push_back(c[(i + 1) % 3]);
      neighbors[c[(i + 1) % 3].value()].push_back(c[i]);
    }
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return n_sides(points[VertexId(std::size_t{a})]) > n_sides(points[VertexId(std::size_t{b})]);
  });
  std::vector<std::uint8_t> is_out(points.size(), 0);
  IdVector<VertexId, Vec<2>> chosen;
  for (const std::uint32_t v : order) {
    if (is_out[v] != 0) continue;
    chosen.push_back(points[VertexId(std::size_t{v})]);
    for (const VertexId w : neighbors[v]) is_out[w.value()] = 1;
  }
  return chosen;
}

Mesh<2> packed_square(double size, std::uint64_t seed, Observer& observer) {
  DomainInput<2> square;
  square.points = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
  for (std::uint32_t i = 0; i < 4; ++i) square.segments.push_back({{i, (i + 1) % 4}, 1, std::nullopt});
  MeshingOptions<2> options;
  options.wishes.size = size;
  options.packing.seed = seed;
  return make_mesh(square, options, observer).mesh;
}

Mesh<2> mesh_of(const IdVector<VertexId, Vec<2>>& points, const std::vector<std::array<VertexId, 3>>& triangles) {
  Mesh<2> mesh;
  mesh.points = points;
  for (const auto& c : triangles) {
    mesh.simplex_vertices.push_back(c);
    mesh.simplex_region.push_back(1);
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId a = c[i], b = c[(i + 1) % 3];
      for (int k = 0; k < 2; ++k)
        if (points[a][k] == points[b][k] && (points[a][k] == 0 || points[a][k] == 1)) {
          mesh.boundary_vertices.push_back({a, b});
          mesh.boundary_marker.push_back(1);
        }
    }
  }
  build_neighbors(mesh);
  return mesh;
}

Figure5Study run_study(const Figure5Arguments& arguments, std::uint64_t seed, Observer& observer) {
  const Mesh<2> mesh = packed_square(arguments.size, seed, observer);
  Figure5Study study;
  std::vector<Figure5Row>& rows = study.rows;
  rows = {measure("mesh", 0, mesh.points, mesh.simplex_vertices.raw())};
  IdVector<VertexId, Vec<2>> points = mesh.points;
  std::vector<std::array<VertexId, 3>> triangles = mesh.simplex_vertices.raw();
  for (int i = 1; i <= arguments.levels; ++i) {
    points = independent_set(points, triangles, seed + static_cast<std::uint64_t>(i));
    triangles = triangles_of(points);
    rows.push_back(measure("mis", static_cast<std::size_t>(i), points, triangles));
  }
  study.coarsest.emplace_back("mis", mesh_of(points, triangles));
  for (const bool is_literal : {true, false}) {
    CoarseningOptions options;
    options.levels = arguments.levels;
    options.quasi_uniform = is_literal;
    options.seed = seed;
    const auto hierarchy = coarsen(mesh, options, observer);
    for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
      const Mesh<2>& level = hierarchy.levels[i].mesh;
      rows.push_back(measure(is_literal ? "literal" : "graded", i + 1, level.points, level.simplex_vertices.raw()));
    }
    if (!hierarchy.levels.empty())
      study.coarsest.emplace_back(is_literal ? "literal" : "graded", hierarchy.levels.back().mesh);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Figure5Row& a, const Figure5Row& b) { return a.level < b.level; });
  return study;
}

ExitCode run_figure5(const Figure5Arguments& arguments, Session& session) {
  for (const fs::path& output : arguments.outputs) check_extension(output, {".csv", ".svg"});
  Report report;
  report.command = "paper figure5";
  report.options = {{"size", arguments.size}, {"levels", arguments.levels}, {"seed", session.common.seed}};
  const Figure5Study study =
      timed(report.times, "figure5", [&] { return run_study(arguments, session.common.seed, session.observer); });
  std::string text =
      fmt::format("{:<7}{:<10}{:>10}{:>18}{:>18}\n", "level", "", "vertices", "radius/edge max", "angle min, deg");
  std::string csv = "method,level,vertices,radius_edge,min_angle\n";
  report.levels = Json::array();
  for (const Figure5Row& r : study.rows) {
    text +=
        fmt::format("{:<7}{:<10}{:>10}{:>18.4g}{:>18.4g}\n", r.level, r.method, r.vertices, r.radius_edge, r.min_angle);
    csv += fmt::format("{},{},{},{:.6g},{:.6g}\n", r.method, r.level, r.vertices, r.radius_edge, r.min_angle);
    report.levels->push_back({{"method", r.method},
                              {"level", r.level},
                              {"vertices", r.vertices},
                              {"radius_edge", r.radius_edge},
                              {"min_angle_deg", r.min_angle}});
  }
  for (const fs::path& output : arguments.outputs) {
    if (std::tolower(output.extension().string()[1]) == 'c') {
      write_text(csv, session.outputs.stage(output));
      continue;
    }
    for (const auto& [method, mesh] : study.coarsest) {
      const ControlVolumes<2> volumes = build_control_volumes(mesh);
      const fs::path name = fmt::format("{}-{}.svg", output.stem().string(), method);
      write_svg(mesh, build_cell_shapes(mesh, volumes), volumes, session.outputs.stage(output.parent_path() / name));
    }
  }
  session.finish(report, text);
  return ExitCode::kDone;
}

}  // namespace

Command add_figure5_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.get_subcommand("paper")->add_subcommand(
      "figure5", "Repeated maximal independent sets beside COARSEN: shapes per level");
  const auto arguments = std::make_shared<Figure5Arguments>();
  app->add_option("--size", arguments->size, "Largest spacing of the packed square of side 1")
      ->check(CLI::Range(0.001, 0.2))
      ->type_name("H")
      ->capture_default_str();
  app->add_option("--levels", arguments->levels, "Coarse levels")
      ->check(whole_number(1, 20))
      ->type_name("K")
      ->capture_default_str();
  app->add_option("-o,--output", arguments->outputs,
                  "Write the table (.csv) or the coarsest level of each method (NAME.svg:\n"
                  "NAME-mis.svg, ...); may be given again")
      ->allow_extra_args(false)
      ->type_name("FILE");
  add_common_options(*app, common);
  app->footer(
      "Rows: mis, a maximal independent set of the graph of the level before; literal, algorithm COARSEN of Figure 6;\n"
      "graded, with a spacing function that grows everywhere.\n"
      "Example: voropack paper figure5 --size 0.005 --levels 5");
  return {app, [arguments](Session& session) { return run_figure5(*arguments, session); }};
}

}  // namespace voropack::app
