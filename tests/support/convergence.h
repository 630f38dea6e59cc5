// Manufactured solutions on packed unit cubes, and their errors by control volumes.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
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

/// For each manufactured solution the W norm of the error at the vertices, with Dirichlet conditions and the source
/// integrated over the cells.
inline std::vector<double> w_errors(const MeshingResult<3>& result) {
  const BoundaryAreas<3> boundary = build_boundary_areas(result.mesh);
  const CellShapes<3> shapes = build_cell_shapes(result.mesh, result.volumes);
  const VertexFlags on_hull = find_hull_vertices(result.mesh);
  std::vector<double> errors;
  for (const Manufactured& solution : manufactured_solutions()) {
    DiffusionProblem<3> problem;
    for (const int marker : boundary.patch_marker) problem.conditions[marker] = Dirichlet<3>{solution.u};
    if (solution.source)
      problem.source_integrals =
          integrate_over_cells<3>(shapes, result.volumes, [&](const Vec<3>& x, int) { return solution.source(x); });
    const auto found = solve(result.volumes, boundary, problem);
    errors.push_back(w_norm(result.volumes, vertex_errors<3>(result.volumes.sites, found.values, solution.u), on_hull));
  }
  return errors;
}

/// The errors of one solution on some meshes.
struct ErrorHistory {
  std::vector<double> n_vertices, errors;

  /// The order in h ~ n^(-1/3): the slope of the line that fits the logarithms best. Single pairs of lattice meshes say
  /// little: how well a lattice fits the cube is not a smooth function of its size.
  [[nodiscard]] double order() const {
    const auto n = static_cast<double>(errors.size());
    double x_mean = 0, y_mean = 0, xy = 0, xx = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      x_mean += log_h(i) / n;
      y_mean += std::log(errors[i]) / n;
    }
    for (std::size_t i = 0; i < errors.size(); ++i) {
      xy += (log_h(i) - x_mean) * (std::log(errors[i]) - y_mean);
      xx += (log_h(i) - x_mean) * (log_h(i) - x_mean);
    }
    return xy / xx;
  }
  /// Error over h, on the last mesh.
  [[nodiscard]] double constant() const { return errors.back() / std::exp(log_h(errors.size() - 1)); }

 private:
  [[nodiscard]] double log_h(std::size_t i) const { return -std::log(n_vertices[i]) / 3; }
};

}  // namespace voropack::test
