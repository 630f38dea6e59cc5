// Manufactured solutions on packed unit cubes, and their errors by control volumes.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "support/domains.h"
#include "voropack/cell_integrals.h"
#include "voropack/diffusion.h"
#include "voropack/norms.h"
#include "voropack/pipeline.h"

namespace voropack::test {

struct Manufactured {
  std::string name;
  std::function<double(const Vec<3>&)> u;
  std::function<double(const Vec<3>&)> source;  ///< -laplace u; empty: 0.
};

/// The solution of the paper's Figure 3, and those of tests 1 and 3 of the FVCA6 benchmark [Eymard2011] with the unit
/// matrix for K.
inline std::vector<Manufactured> manufactured_solutions() {
  using std::numbers::pi, std::numbers::sqrt2;
  const auto waves = [](const Vec<3>& x) {
    return std::sin(pi * x[0]) * std::sin(pi * (x[1] + 0.5)) * std::sin(pi * (x[2] + 1.0 / 3));
  };
  const auto fast_waves = [](const Vec<3>& x) {
    return std::sin(2 * pi * x[0]) * std::sin(2 * pi * x[1]) * std::sin(2 * pi * x[2]);
  };
  return {
      {"exponential",
       [](const Vec<3>& x) { return std::exp(pi * x[0]) * std::cos(pi * x[1] / sqrt2) * std::sin(pi * x[2] / sqrt2); },
       {}},
      {"FVCA6 T1", [=](const Vec<3>& x) { return 1 + waves(x); },
       [=](const Vec<3>& x) { return 3 * pi * pi * waves(x); }},
      {"FVCA6 T3", fast_waves, [=](const Vec<3>& x) { return 12 * pi * pi * fast_waves(x); }}};
}

/// About n vertices.
inline MeshingResult<3> packed_cube(double n, Interior interior) {
  MeshingOptions<3> options;
  options.wishes.size = std::cbrt(1.3 / n);
  options.packing.interior = interior;
  return make_mesh(domains::unit_cube(), options);
}

/// The W norm of the error at the vertices, with Dirichlet conditions and the source integrated over the cells.
inline double w_error(const MeshingResult<3>& result, const Manufactured& problem) {
  const BoundaryAreas<3> boundary = build_boundary_areas(result.mesh);
  DiffusionProblem<3> diffusion;
  for (const int marker : boundary.patch_marker) diffusion.conditions[marker] = Dirichlet<3>{problem.u};
  if (problem.source)
    diffusion.source_integrals = integrate_over_cells<3>(build_cell_shapes(result.mesh, result.volumes), result.volumes,
                                                         [&](const Vec<3>& x, int) { return problem.source(x); });
  const auto solution = solve(result.volumes, boundary, diffusion);
  const VertexValues errors = vertex_errors<3>(result.volumes.sites, solution.values, problem.u);
  return w_norm(result.volumes, errors, find_hull_vertices(result.mesh));
}

/// The order in h ~ n^(-1/3) between two meshes.
inline double observed_order(double n_coarse, double coarse, double n_fine, double fine) {
  return std::log(coarse / fine) / (std::log(n_fine / n_coarse) / 3);
}

}  // namespace voropack::test
