// The laws of the control volumes on small meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/delaunay_mesh.h"
#include "voropack/dual.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

template <int D>
double volume_sum(const ControlVolumes<D>& volumes, int region) {
  double sum = 0;
  for (const CellId c : ids(volumes.cell_volume))
    if (volumes.cell_region[c] == region) sum += volumes.cell_volume[c];
  return sum;
}

TEST(Dual, VolumesSumToTheCube) {
  for (const double eps : {0.0, 1e-14, 1e-6, 0.3}) {
    const auto volumes = build_control_volumes(delaunay_mesh(perturbed_grid<3>(4, eps)));
    EXPECT_NEAR(volume_sum(volumes, 1), 1.0, 1e-13) << "eps " << eps;
    for (const double v : volumes.cell_volume) EXPECT_GT(v, 0);
    for (const double a : volumes.face_area) EXPECT_GT(a, 0);
  }
}

TEST(Dual, VolumesSumToTheSquare) {
  for (const double eps : {0.0, 1e-14, 1e-6, 0.2}) {
    const auto volumes = build_control_volumes(delaunay_mesh(perturbed_grid<2>(8, eps)));
    EXPECT_NEAR(volume_sum(volumes, 1), 1.0, 1e-13) << "eps " << eps;
    for (const double a : volumes.face_area) EXPECT_GT(a, 0);
  }
}

}  // namespace
}  // namespace voropack
