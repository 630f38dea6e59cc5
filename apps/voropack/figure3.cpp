#include "figure3.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "perturbed_cube.h"
#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/dual.h"
#include "voropack/error.h"
#include "voropack/fem.h"
#include "voropack/norms.h"
#include "voropack/quality.h"

namespace voropack::app {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFrequency = std::numbers::pi / std::numbers::sqrt2;  // Of y and z: u is harmonic.

/// -Laplace u = 0 with the exact values on every marker of the hull.
DiffusionProblem<3> figure3_problem(const BoundaryAreas<3>& boundary) {
  DiffusionProblem<3> problem;
  for (const int marker : boundary.patch_marker)
    problem.conditions[marker] = Dirichlet<3>{std::function<double(const Vec<3>&)>(figure3_solution)};
  return problem;
}

}  // namespace

double figure3_solution(const Vec<3>& x) {
  return std::exp(kPi * x[0]) * std::cos(kFrequency * x[1]) * std::sin(kFrequency * x[2]);
}

Vec<3> figure3_gradient(const Vec<3>& x) {
  const double e = std::exp(kPi * x[0]), cy = std::cos(kFrequency * x[1]), sy = std::sin(kFrequency * x[1]);
  const double cz = std::cos(kFrequency * x[2]), sz = std::sin(kFrequency * x[2]);
  return {kPi * e * cy * sz, -kFrequency * e * sy * sz, kFrequency * e * cy * cz};
}

namespace {

/// The Frobenius norm of the second derivatives of `figure3_solution`.
double hessian_norm(const Vec<3>& x) {
  const double e = std::exp(kPi * x[0]), cy = std::cos(kFrequency * x[1]), sy = std::sin(kFrequency * x[1]);
  const double cz = std::cos(kFrequency * x[2]), sz = std::sin(kFrequency * x[2]);
  const double xx = kPi * kPi * cy * sz, yy = -kFrequency * kFrequency * cy * sz;  // zz = yy
  const double xy = -kPi * kFrequency * sy * sz, xz = kPi * kFrequency * cy * cz;
  const double yz = -kFrequency * kFrequency * sy * cz;
  return e * std::sqrt(xx * xx + 2 * yy * yy + 2 * (xy * xy + xz * xz + yz * yz));
}

/// The sides of the inequalities of Theorems 2.1 and 2.3.
void add_theorems(const Mesh<3>& mesh, const Figure3Solutions& solutions, const VertexValues& interpolant,
                  Figure3Details& details) {
  const ControlVolumes<3>& volumes = solutions.volumes;
  const VertexFlags hull = find_hull_vertices(mesh);
  const EdgeValues u = difference_quotients(volumes, solutions.cvm), u1 = difference_quotients(volumes, interpolant);
  const EdgeValues u2 = mean_fluxes<3>(mesh, volumes, figure3_gradient);
  const auto w_distance = [&](const EdgeValues& a, const EdgeValues& b) {
    EdgeValues difference(a.size());
    for (const DualFaceId f : ids(a)) difference[f] = a[f] - b[f];
    return std::sqrt(w_product(volumes, difference, difference, hull));
  };
  details.discrete_error = w_distance(u, u1);
  details.consistency_error = w_distance(u1, u2);
  const double rho = max_shape_ratios(mesh).radius_edge;
  const double h = *std::max_element(volumes.face_edge_length.begin(), volumes.face_edge_length.end());
  const double hessian = l2_error<3>(mesh, VertexValues(mesh.points.size(), 0.0), hessian_norm);
  details.bound = (1 + 4 * rho * rho) * hessian * h;
}

}  // namespace

Figure3Solutions solve_figure3(const Mesh<3>& mesh, Observer& observer) {
  Figure3Solutions solutions;
  solutions.volumes = build_control_volumes(mesh, observer);
  const BoundaryAreas<3> boundary = build_boundary_areas(mesh);
  const DiffusionProblem<3> problem = figure3_problem(boundary);
  solutions.cvm = solve(solutions.volumes, boundary, problem, {}, observer).values;
  try {
    solutions.fem = solve_fem(mesh, problem, fem_linear_options(), observer).values;
  } catch (const NumericalError& error) {
    observer.log(LogLevel::kWarning, std::string("finite elements: ") + error.what());
    solutions.fem = VertexValues(mesh.points.size(), NAN);
  }
  return solutions;
}

Figure3 measure_figure3(const Mesh<3>& mesh, const Figure3Solutions& solutions) {
  const VertexFlags hull = find_hull_vertices(mesh);
  const auto w_error = [&](const VertexValues& values) {
    return w_norm(solutions.volumes, vertex_errors<3>(mesh.points, values, figure3_solution), hull);
  };
  const ShapeRatios ratios = max_shape_ratios(mesh);
  return {.cvm_w = w_error(solutions.cvm),
          .fem_w = w_error(solutions.fem),
          .fem_h1 = h1_error<3>(mesh, solutions.fem, figure3_gradient),
          .radius_ratio = ratios.radius_ratio,
          .radius_edge = ratios.radius_edge};
}

Figure3Details measure_figure3_details(const Mesh<3>& mesh, const Figure3Solutions& solutions) {
  IdVector<SimplexId, std::uint8_t> is_sliver(mesh.simplex_vertices.size());
  for (const SimplexId s : ids(is_sliver)) is_sliver[s] = min_dihedral_deg(mesh, s) < kSliverDihedralDeg ? 1 : 0;
  VertexValues interpolant;
  for (const Vec<3>& x : mesh.points) interpolant.push_back(figure3_solution(x));
  const auto h1 = [&](const VertexValues& values) { return h1_error<3>(mesh, values, figure3_gradient); };
  const auto h1_without_slivers = [&](const VertexValues& values) {
    return h1_error<3>(mesh, values, figure3_gradient, [&](SimplexId s) { return is_sliver[s] == 0; });
  };
  Figure3Details details;
  details.n_slivers = static_cast<std::uint64_t>(std::count(is_sliver.begin(), is_sliver.end(), 1));
  details.cvm_max = max_norm(vertex_errors<3>(mesh.points, solutions.cvm, figure3_solution));
  details.fem_max = max_norm(vertex_errors<3>(mesh.points, solutions.fem, figure3_solution));
  details.h1 = {h1(solutions.fem), h1(solutions.cvm), h1(interpolant)};
  details.h1_without_slivers = {h1_without_slivers(solutions.fem), h1_without_slivers(solutions.cvm),
                                h1_without_slivers(interpolant)};
  add_theorems(mesh, solutions, interpolant, details);
  return details;
}

std::string name_of(Column column) {
  switch (column) {
    case Column::kRadiusRatio:
      return "R_over_rho";
    case Column::kFemH1:
      return "fem_H1";
    case Column::kFemW:
      return "fem_W";
    case Column::kCvmW:
      return "cvm_W";
  }
  return {};
}

double value_of(const Figure3& figures, Column column) {
  switch (column) {
    case Column::kRadiusRatio:
      return figures.radius_ratio;
    case Column::kFemH1:
      return figures.fem_h1;
    case Column::kFemW:
      return figures.fem_w;
    case Column::kCvmW:
      return figures.cvm_w;
  }
  return 0;
}

std::optional<double> paper_value(std::uint32_t n, double eps, Column column) {
  struct Row {
    std::uint32_t n;
    double eps;
    std::array<double, 4> values;
  };
  constexpr std::array<Row, 9> kPaper = {{{4, 0.01, {1126, 30.22479, 7.696399, 0.2425438}},
                                          {4, 0.001, {11125, 92.97309, 8.692323, 0.2411516}},
                                          {4, 0.0001, {111296, 291.6406, 8.917005, 0.2410718}},
                                          {8, 0.01, {26230, 12.98964, 4.344101, 0.07617430}},
                                          {8, 0.001, {166051, 35.13775, 6.865007, 0.07531520}},
                                          {8, 0.0001, {1621745, 108.1435, 7.525118, 0.07538803}},
                                          {16, 0.01, {14194, 6.023042, 2.262189, 0.02155074}},
                                          {16, 0.001, {105551, 15.48025, 4.457009, 0.02005826}},
                                          {16, 0.0001, {1030956, 45.91799, 6.140328, 0.02007369}}}};
  for (const Row& row : kPaper)
    if (row.n == n && row.eps == eps) return row.values[static_cast<std::size_t>(column)];
  return std::nullopt;
}

Summary summarize(const Figure3Row& row, Column column) {
  std::vector<double> values;
  for (const Figure3& mesh : row.meshes)
    if (std::isfinite(value_of(mesh, column))) values.push_back(value_of(mesh, column));
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  Summary summary{.n = n, .mean = 0, .deviation = 0};
  // From the least one on, so that equal values have no deviation.
  for (const double value : values) summary.mean += (value - values.front()) / static_cast<double>(n);
  summary.mean += values.front();
  for (const double value : values)
    if (n > 1) summary.deviation += (value - summary.mean) * (value - summary.mean) / static_cast<double>(n - 1);
  summary.deviation = std::sqrt(summary.deviation);
  summary.min = values.front();
  summary.median = (values[(n - 1) / 2] + values[n / 2]) / 2;
  summary.max = values.back();
  return summary;
}

namespace {

/// Meshes of a row: `seeds` up to n = 16; beyond, about as many points in all.
std::uint32_t mesh_count(std::uint32_t seeds, std::uint32_t n) {
  constexpr double kFullGrid = 16;
  const double share = std::min(1.0, std::pow(kFullGrid / n, 3));
  return std::max(1U, static_cast<std::uint32_t>(share * seeds));
}

}  // namespace

std::vector<Figure3Row> run_figure3(const Figure3Options& options, Observer& observer) {
  std::vector<Figure3Row> rows;
  struct Task {
    std::size_t row, seed;
  };
  std::vector<Task> tasks;
  for (const std::uint32_t n : options.grids)
    for (const double eps : options.perturbations) {
      rows.push_back({n, eps, std::vector<Figure3>(mesh_count(options.seeds, n))});
      for (std::size_t seed = 0; seed < rows.back().meshes.size(); ++seed) tasks.push_back({rows.size() - 1, seed});
    }
  // The large meshes first, so that no thread is left alone with one.
  std::stable_sort(tasks.begin(), tasks.end(),
                   [&](const Task& a, const Task& b) { return rows[a.row].n > rows[b.row].n; });
  observer.begin_stage("figure3");
  std::atomic<std::uint64_t> n_done = 0;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, tasks.size(), 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
          observer.check_cancelled();
          Figure3Row& row = rows[tasks[t].row];
          const std::uint64_t seed = options.first_seed + tasks[t].seed;
          const Mesh<3> mesh = delaunay_mesh(perturbed_cube_points(row.n, row.eps, seed));
          row.meshes[tasks[t].seed] = measure_figure3(mesh, solve_figure3(mesh, silent_observer()));
          observer.progress(++n_done, tasks.size());
        }
      },
      tbb::simple_partitioner());
  return rows;
}

}  // namespace voropack::app
