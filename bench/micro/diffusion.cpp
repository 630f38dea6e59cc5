// The solver on a packed unit cube: assembly in units of matrix-vector products, iterations, memory. The time of a
// solution is that of all of it: assembly, preconditioner (of multigrid with coarsening), iterations, flows.
//
// Usage: diffusion [n_vertices = 100000] [repetitions = 5]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "process_memory.h"
#include "support/domains.h"
#include "voropack/coarsening.h"
#include "voropack/diffusion.h"
#include "voropack/multigrid.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

/// The median time of some runs, in seconds.
double median_seconds(int repetitions, const std::function<void()>& work) {
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::nth_element(seconds.begin(), seconds.begin() + repetitions / 2, seconds.end());
  return seconds[static_cast<std::size_t>(repetitions / 2)];
}

/// The paper's problem: u = exp(pi x) cos(pi y / sqrt 2) sin(pi z / sqrt 2), given on the whole boundary.
double harmonic(const Vec<3>& x) {
  using std::numbers::pi, std::numbers::sqrt2;
  return std::exp(pi * x[0]) * std::cos(pi * x[1] / sqrt2) * std::sin(pi * x[2] / sqrt2);
}

/// As `voropack solve` makes it.
std::shared_ptr<const Preconditioner> coarsened_multigrid(const Mesh<3>& mesh, const LinearSystem& system) {
  CoarseningOptions options;
  options.growth = 2;
  const double factor = 3 * std::log(options.growth), coarsest = 2000;
  options.levels = static_cast<int>(std::lround(std::log(static_cast<double>(mesh.points.size()) / coarsest) / factor));
  options.levels = std::max(options.levels, 1);
  const CoarseningHierarchy<3> hierarchy = coarsen(mesh, options);
  std::vector<MultigridLevel> levels;
  for (const CoarseLevel<3>& level : hierarchy.levels)
    levels.push_back({.prolongation = &level.prolongation, .finest_vertex = level.finest_vertex.raw()});
  return make_multigrid(system, levels);
}

void run(double n_vertices, int repetitions) {
  MeshingOptions<3> options;
  options.wishes.size = std::cbrt(1.3 / n_vertices);
  options.packing.interior = Interior::kRandom;
  const MeshingResult<3> result = make_mesh(domains::unit_cube(), options);
  const BoundaryAreas<3> boundary = build_boundary_areas(result.mesh);
  DiffusionProblem<3> problem;
  for (const int marker : boundary.patch_marker) problem.conditions[marker] = Dirichlet<3>{harmonic};

  const LinearSystem system = assemble(result.volumes, boundary, problem);
  const double before = bench::peak_bytes();
  std::vector<double> x(system.matrix.size(), 1.0), y(x.size());
  const double product = median_seconds(10 * repetitions, [&] { multiply(system.matrix, x, y); });
  const double assembly = median_seconds(repetitions, [&] { assemble(result.volumes, boundary, problem); });
  fmt::print("{} vertices, {} entries\n", system.matrix.size(), system.matrix.values.size());
  fmt::print("matrix-vector product {:.4f} s, assembly {:.3f} s = {:.1f} products\n", product, assembly,
             assembly / product);
  LinearOptions diagonal, incomplete_cholesky, multigrid;
  diagonal.preconditioner = PreconditionerKind::kDiagonal;
  multigrid.own_preconditioner = [&](const LinearSystem& matrix) { return coarsened_multigrid(result.mesh, matrix); };
  for (LinearOptions& linear : std::array{diagonal, incomplete_cholesky, multigrid}) {
    linear.method = LinearMethod::kConjugateGradients;
    DiffusionSolution<3> u;
    const double seconds = median_seconds(1, [&] { u = solve(result.volumes, boundary, problem, linear); });
    double error = 0;
    for (const VertexId v : ids(u.values))
      error = std::max(error, std::abs(u.values[v] - harmonic(result.volumes.sites[v])));
    const RegionBalance& balance = u.balances.front();
    fmt::print("{}: {:.2f} s, {} iterations, residual {:.1e}, largest error {:.2e}, imbalance {:.1e} of {:.3g}\n",
               u.linear.preconditioner, seconds, u.linear.n_iterations, u.linear.residual, error, balance.imbalance,
               balance.throughput);
  }
  fmt::print("memory: {:.0f} MB with mesh, volumes and one matrix, {:.0f} MB at peak\n", before / 1e6,
             bench::peak_bytes() / 1e6);
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  voropack::bench::keep_freed_memory();
  const double n_vertices = argc > 1 ? std::atof(argv[1]) : 1e5;
  const int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 5;
  voropack::run(n_vertices, repetitions);
}
