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

struct Measured {
  double order = 0;
  double constant = 0;  ///< Of the finer mesh: error times n^(1/3).
};

/// By name of the solution, between about 6,000 and 40,000 vertices.
std::map<std::string, Measured> measure(Interior interior) {
  std::map<std::string, Measured> measured;
  const auto coarse = test::packed_cube(6000, interior), fine = test::packed_cube(40'000, interior);
  const auto n_coarse = static_cast<double>(coarse.mesh.points.size());
  const auto n_fine = static_cast<double>(fine.mesh.points.size());
  for (const test::Manufactured& problem : test::manufactured_solutions()) {
    const double before = test::w_error(coarse, problem), after = test::w_error(fine, problem);
    measured[problem.name] = {test::observed_order(n_coarse, before, n_fine, after), after * std::cbrt(n_fine)};
  }
  return measured;
}

TEST(DiffusionOrder, IsAboutOneOnRandomInteriorsAndHigherOnLattices) {
  const auto lattice = measure(Interior::kLattice), random = measure(Interior::kRandom);
  for (const auto& [name, on_lattice] : lattice) {
    SCOPED_TRACE(name);
    EXPECT_GE(random.at(name).order, 0.95);
    EXPECT_GE(on_lattice.order, 1.3);
    EXPECT_LT(on_lattice.constant, random.at(name).constant);
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
