// Integrals over control volumes: the volumes themselves, and polynomials whose integral over the domain is known.
#include "voropack/cell_integrals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/cases.h"

namespace voropack {
namespace {

template <int D>
IdVector<CellId, double> integrate(const MeshingResult<D>& result, const std::function<double(const Vec<D>&, int)>& f) {
  return integrate_over_cells<D>(build_cell_shapes(result.mesh, result.volumes), result.volumes, f);
}

template <int D>
void constants_give_volumes() {
  for (const test::Case<D>& c : test::all_cases<D>()) {
    SCOPED_TRACE(c.name);
    const auto result = make_mesh(c.input, test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.1 : 0.4));
    const auto integrals = integrate<D>(result, [](const Vec<D>&, int region) { return region; });
    for (const CellId cell : ids(integrals))
      EXPECT_NEAR(integrals[cell], result.volumes.cell_region[cell] * result.volumes.cell_volume[cell],
                  1e-11 * std::abs(integrals[cell]));
  }
}
TEST(CellIntegrals, ConstantsGiveVolumesInThePlane) { constants_give_volumes<2>(); }
TEST(CellIntegrals, ConstantsGiveVolumesInSpace) { constants_give_volumes<3>(); }

/// Every monomial up to degree 3 over two halves of [0, 2] x [0, 1]^(D-1).
template <int D>
void cubics_are_exact() {
  const auto result =
      make_mesh(domains::two_material_box<D>(), test::meshing_options<D>(test::all_fillings()[1], D == 2 ? 0.2 : 0.5));
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= (D == 3 ? 3 : i + j); ++k) {
        const auto integrals = integrate<D>(result, [=](const Vec<D>& x, int) {
          return std::pow(x[0], i) * std::pow(x[1], j) * std::pow(x[D - 1], k);
        });
        std::map<int, double> sums;
        for (const CellId c : ids(integrals)) sums[result.volumes.cell_region[c]] += integrals[c];
        const double rest = 1.0 / ((j + 1) * (k + 1)), left = 1.0 / (i + 1), both = std::pow(2, i + 1) / (i + 1);
        EXPECT_NEAR(sums[7], left * rest, 1e-12) << i << j << k;
        EXPECT_NEAR(sums[9], (both - left) * rest, 1e-12) << i << j << k;
      }
}
TEST(CellIntegrals, CubicsAreExactInThePlane) { cubics_are_exact<2>(); }
TEST(CellIntegrals, CubicsAreExactInSpace) { cubics_are_exact<3>(); }

}  // namespace
}  // namespace voropack
