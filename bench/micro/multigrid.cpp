// Multigrid on a packed square or cube, or on a box of two materials: times of setup and solution, iterations,
// contraction, beside conjugate gradients with incomplete Cholesky. bench/peers/boomer_amg.cpp solves the same systems,
// and bench/multigrid.py puts both into one table. Levels end at some 2000 vertices, as in `voropack solve`.
//
// Usage: multigrid DIMENSION [n_vertices = 100000] [growth = 2.5] [right conductivity = 1] [n_loads = 1] [threads = 0]
//                  [FILE for boomer_amg] [only = 0]
// With a right conductivity other than 1 the box has two materials. With only = 1 nothing is run but control volumes
// with symmetric Gauss-Seidel.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "clock.h"
#include "process_memory.h"
#include "support/domains.h"
#include "voropack/coarsening.h"
#include "voropack/diffusion.h"
#include "voropack/multigrid.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

struct Settings {
  double n_vertices = 1e5;
  double growth = 2.5;
  double right = 1;
  int n_loads = 1;
  std::string file;
  bool is_only = false;
};

/// u = 0 on the outer boundary, source 1.
template <int D>
LinearSystem system_of(const Mesh<D>& mesh, double right) {
  const BoundaryAreas<D> boundary = build_boundary_areas(mesh);
  DiffusionProblem<D> problem;
  problem.source = 1.0;
  problem.conductivity = RegionFunction<D>([&](const Vec<D>&, int region) { return region == 9 ? right : 1.0; });
  for (const int marker : boundary.patch_marker) problem.conditions[marker] = Dirichlet<D>{0.0};
  return assemble(build_control_volumes(mesh), boundary, problem);
}

/// The free part of the system, as boomer_amg reads it.
void write_system(const LinearSystem& system, const std::string& file) {
  const SparseMatrix& matrix = system.matrix;
  std::vector<std::uint32_t> unknown(matrix.size());
  std::uint32_t n = 0;
  for (std::size_t v = 0; v < matrix.size(); ++v)
    if (system.is_fixed[VertexId(v)] == 0) unknown[v] = n++;
  std::vector<std::uint64_t> offsets = {0};
  std::vector<std::uint32_t> columns;
  std::vector<double> values, load;
  for (std::size_t v = 0; v < matrix.size(); ++v) {
    if (system.is_fixed[VertexId(v)] != 0) continue;
    for (std::uint64_t e = matrix.offsets[v]; e != matrix.offsets[v + 1]; ++e) {
      if (system.is_fixed[VertexId(matrix.columns[e])] != 0) continue;
      columns.push_back(unknown[matrix.columns[e]]);
      values.push_back(matrix.values[e]);
    }
    offsets.push_back(columns.size());
    load.push_back(system.load[VertexId(v)]);
  }
  std::ofstream out(file, std::ios::binary);
  const auto put = [&](const auto& array) {
    out.write(reinterpret_cast<const char*>(array.data()),
              static_cast<std::streamsize>(array.size() * sizeof(array[0])));
  };
  put(std::vector<std::uint64_t>{n, columns.size()});
  put(offsets);
  put(columns);
  put(values);
  put(load);
}

struct LoadTimes {
  bench::Seconds first, all;
};

/// Solves for some loads, and prints the times.
LoadTimes solve_loads(const std::string& what, LinearSystem system, const std::shared_ptr<const Preconditioner>& own,
                      int n_loads) {
  LinearOptions options;
  options.method = LinearMethod::kConjugateGradients;
  if (own) options.own_preconditioner = [own](const LinearSystem&) { return own; };
  options.tolerance = 1e-8;
  const IdVector<VertexId, double> load = system.load;
  const bench::Clock clock;
  LoadTimes times;
  std::string iterations;
  for (int k = 0; k < n_loads; ++k) {
    std::uint64_t unknown = 0;
    for (const VertexId v : ids(load))
      if (system.is_fixed[v] == 0)
        system.load[v] = load[v] * (1 + 0.1 * static_cast<double>(unknown++ % (2 + static_cast<std::uint64_t>(k))));
    iterations += fmt::format(" {}", solve_linear_system(system, options).report.n_iterations);
    if (k == 0) times.first = clock.passed();
  }
  times.all = clock.passed();
  fmt::print("  {}: {} loads in {}; iterations{}\n", what, n_loads, clock.text(), iterations);
  return times;
}

/// `before` is what the hierarchy and its matrices took.
void run_multigrid(const std::string& what, const LinearSystem& system, const std::vector<MultigridLevel>& levels,
                   const MultigridOptions& options, int n_loads, const bench::Seconds& before) {
  const bench::Clock clock;
  const auto multigrid = make_multigrid(system, levels, options);
  const bench::Seconds setup = clock.passed();
  fmt::print("{}: setup {}\n", what, clock.text());
  const MultigridReport& report = multigrid->report();
  fmt::print("  operator complexity {:.3f}, unknowns", report.operator_complexity);
  for (const MultigridLevelReport& level : report.levels) fmt::print(" {}", level.n_unknowns);
  const LinearReport alone = solve_by_multigrid(system, *multigrid, {.starts_with_full = false}).report;
  fmt::print("\n  alone: {} cycles, contraction {:.3f}\n", alone.n_iterations, alone.contraction);
  const LoadTimes times = solve_loads("conjugate gradients", system, multigrid, n_loads);
  const auto total = [&](const bench::Seconds& loads) { return before + setup + loads; };
  fmt::print("  with coarsening and setup: 1 load {:.2f} s, {:.2f} s of processor time; {} loads {:.2f} s, {:.2f} s\n",
             total(times.first).wall, total(times.first).processor, n_loads, total(times.all).wall,
             total(times.all).processor);
}

template <int D>
void run(const Settings& settings) {
  MeshingOptions<D> options;
  const double volume = settings.right == 1 ? 1 : 2;
  options.wishes.size = std::pow(1.2 * volume / settings.n_vertices, 1.0 / D);
  options.packing.interior = Interior::kRandom;
  const DomainInput<D> input = settings.right == 1 ? domains::unit_box<D>() : domains::two_material_box<D>();
  const MeshingResult<D> result = make_mesh(input, options);
  fmt::print("{} vertices; Delaunay triangulation {:.2f} s\n", result.mesh.points.size(), result.times.at("delaunay"));
  const LinearSystem system = system_of(result.mesh, settings.right);
  if (!settings.file.empty()) write_system(system, settings.file);

  constexpr double kCoarsest = 2000;
  const bench::Clock clock;
  CoarseningOptions coarsening;
  coarsening.growth = settings.growth;
  coarsening.levels =
      std::max(1, static_cast<int>(std::lround(std::log(static_cast<double>(result.mesh.points.size()) / kCoarsest) /
                                               (D * std::log(settings.growth)))));
  const CoarseningHierarchy<D> hierarchy = coarsen(result.mesh, coarsening);
  const bench::Seconds coarsened = clock.passed();
  fmt::print("coarsening {}\n", clock.text());
  const bench::Clock assembly;
  std::vector<LinearSystem> coarse;
  for (const CoarseLevel<D>& level : hierarchy.levels) coarse.push_back(system_of(level.mesh, settings.right));
  const bench::Seconds assembled = assembly.passed();
  fmt::print("control volumes and matrices of the levels {}\n", assembly.text());

  for (const bool with_matrices : {true, false}) {
    std::vector<MultigridLevel> levels;
    for (std::size_t k = 0; k < coarse.size(); ++k)
      levels.push_back({.prolongation = &hierarchy.levels[k].prolongation,
                        .finest_vertex = hierarchy.levels[k].finest_vertex.raw(),
                        .matrix = with_matrices ? &coarse[k].matrix : nullptr});
    const char* operators = with_matrices ? "control volumes" : "Galerkin";
    const bench::Seconds before = with_matrices ? coarsened + assembled : coarsened;
    MultigridOptions multigrid;
    run_multigrid(fmt::format("{}, symmetric Gauss-Seidel", operators), system, levels, multigrid, settings.n_loads,
                  before);
    if (settings.is_only) return;
    multigrid.smoother = MultigridSmoother::kGaussSeidel;
    run_multigrid(fmt::format("{}, Gauss-Seidel", operators), system, levels, multigrid, settings.n_loads, before);
    multigrid.smoother = MultigridSmoother::kChebyshev;
    run_multigrid(fmt::format("{}, Chebyshev", operators), system, levels, multigrid, settings.n_loads, before);
  }
  fmt::print("incomplete Cholesky\n");
  solve_loads("conjugate gradients with setup", system, nullptr, 1);
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  voropack::bench::keep_freed_memory();
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  const voropack::Settings settings{.n_vertices = number(2, 1e5),
                                    .growth = number(3, 2.5),
                                    .right = number(4, 1),
                                    .n_loads = static_cast<int>(number(5, 1)),
                                    .file = argc > 7 ? argv[7] : "",
                                    .is_only = number(8, 0) != 0};
  voropack::run_with_threads(static_cast<int>(number(6, 0)),
                             [&] { number(1, 3) == 2 ? voropack::run<2>(settings) : voropack::run<3>(settings); });
}
