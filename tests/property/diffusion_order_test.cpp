// How fast the control volume method converges on packed meshes, and where it is exact. The orders up to 10^6 vertices
// are in docs/theory/diffusion.md (bench/micro/orders.cpp).
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "support/balance_checks.h"
#include "support/cases.h"
#include "support/convergence.h"

namespace voropack {
namespace {

/// For each manufactured solution.
std::vector<test::ErrorHistory> measure(Interior interior, const std::vector<double>& counts) {
  std::vector<test::ErrorHistory> histories(test::manufactured_solutions().size());
  for (const double count : counts) {
    const MeshingResult<3> result = test::packed_cube(count, interior);
    const std::vector<double> errors = test::w_errors(result);
    for (std::size_t k = 0; k < errors.size(); ++k) {
      histories[k].n_vertices.push_back(static_cast<double>(result.mesh.points.size()));
      histories[k].errors.push_back(errors[k]);
    }
  }
  return histories;
}

TEST(DiffusionOrder, IsAboutOneOnRandomInteriorsAndHigherOnLattices) {
  const auto lattice = measure(Interior::kLattice, {3e3, 4e3, 6e3, 8e3, 1e4, 1.4e4, 2e4, 2.8e4});
  const auto random = measure(Interior::kRandom, {3e3, 1e4, 2.8e4});
  for (std::size_t k = 0; k < lattice.size(); ++k) {
    SCOPED_TRACE(test::manufactured_solutions()[k].name);
    EXPECT_GE(random[k].order(), 0.95);
    EXPECT_GE(lattice[k].order(), 1.3);
    EXPECT_LT(lattice[k].constant(), random[k].constant());
  }
}

/// Test 7 of the FVCA5 benchmark [Herbin2008]: a thin oblique layer that conducts a hundredth of what is around it. The
/// solution is linear in each of the three materials.
TEST(DiffusionOrder, TheObliqueBarrierIsExact) {
  const auto line = [](double x) { return 0.2 * (x - 0.5) + 0.475; };
  const double thickness = 0.05;
  DomainInput<2> input;
  domains::add_loop(input, {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{1, line(1)}, Vec<2>{1, line(1) + thickness},
                            Vec<2>{1, 1}, Vec<2>{0, 1}, Vec<2>{0, line(0) + thickness}, Vec<2>{0, line(0)}});
  domains::add_segment(input, 7, 2);
  domains::add_segment(input, 6, 3);
  input.region_seeds = {{{0.5, 0.1}, 1, {}}, {{0.5, line(0.5) + 0.5 * thickness}, 2, {}}, {{0.5, 0.9}, 3, {}}};
  const auto exact = [&](const Vec<2>& x) {
    const double height = x[1] - line(x[0]);
    if (height <= 0) return -height;
    return height <= thickness ? -height / 0.01 : thickness - height - 5;
  };
  for (const test::Filling& filling : test::all_fillings()) {
    SCOPED_TRACE(filling.name);
    const auto result = make_mesh(input, test::meshing_options<2>(filling, 0.04));
    const auto boundary = build_boundary_areas(result.mesh);
    DiffusionProblem<2> problem;
    problem.conductivity = std::map<int, double>{{1, 1.0}, {2, 0.01}, {3, 1.0}};
    for (const int marker : boundary.patch_marker) problem.conditions[marker] = Dirichlet<2>{exact};
    const auto u = solve(result.volumes, boundary, problem);
    for (const VertexId v : ids(u.values)) EXPECT_NEAR(u.values[v], exact(result.volumes.sites[v]), 1e-10);
    EXPECT_TRUE(u.matrix.is_m_matrix);
    test::expect_balanced(u.balances);
  }
}

}  // namespace
}  // namespace voropack
