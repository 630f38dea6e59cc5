// Triangulated surfaces with no sharp angle whose triangles are nearly equilateral and as long as f allows: where one
// edge is cut, its neighbors have to follow, ring after ring.
#include <gtest/gtest.h>

#include "support/curved_domains.h"
#include "support/plc_files.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

void expect_certified(const DomainInput<3>& input, std::optional<double> size) {
  MeshingOptions<3> options;
  options.wishes.size = size;
  const MeshingResult<3> r = make_mesh(input, options);
  EXPECT_EQ(r.certificate.checks.size(), 11U);
  for (const Certificate::Check& check : r.certificate.checks) {
    EXPECT_TRUE(check.ok) << check.name << ": " << check.where;
    EXPECT_GT(check.tested, 0U) << check.name;
  }
  double volume = 0;
  for (const auto& [a, b, c, d] : r.mesh.simplex_vertices) {
    const Vec<3> o = r.mesh.points[a];
    volume += dot(r.mesh.points[b] - o, cross(r.mesh.points[c] - o, r.mesh.points[d] - o)) / 6;
  }
  EXPECT_NEAR(volume, test::enclosed_volume(input), 1e-10);
}

TEST(CurvedSurfaces, ADumbbellOfAnySize) {
  for (const double size : {0.17, 0.19, 0.2, 0.21, 0.23, 0.25, 0.3, 0.5}) {
    SCOPED_TRACE(size);
    expect_certified(domains::dumbbell(), size);
  }
}

TEST(CurvedSurfaces, SpheroidsOfAnySize) {
  for (const double stretch : {1.0, 1.7, 3.0}) {
    SCOPED_TRACE(stretch);
    expect_certified(domains::spheroid(2, stretch), {});
    for (const double size : {0.33, 0.3, 0.27, 0.24, 0.2}) expect_certified(domains::spheroid(2, stretch), size);
  }
}

TEST(CurvedSurfaces, RingAfterRingFollows) { expect_certified(domains::spheroid(3, 1.7), {}); }

}  // namespace
}  // namespace voropack
