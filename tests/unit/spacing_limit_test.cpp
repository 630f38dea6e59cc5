// What the domain allows f to be at the vertices of a mesh, against the spacing function itself.
#include "coarsening/spacing_limit.h"

#include <gtest/gtest.h>

#include "support/domains.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

template <int D>
void is_the_least_of_both() {
  MeshingOptions<D> options;
  options.wishes.size = D == 2 ? 0.05 : 0.25;
  const Mesh<D> mesh = make_mesh(domains::box_with_hole<D>(), options).mesh;
  const FineMesh<D> fine(mesh, domain_of(mesh), {});
  ASSERT_GT(fine.interior.size(), 500U);
  const Spacing<D> spacing =
      build_spacing<D>(fine.place.domain, {}).with_caps({{mesh.points[fine.interior[100]], 0.1, 0.02, std::nullopt}});
  SpacingLimit<D> limit(fine, spacing);
  std::size_t n_bound = 0;
  for (const double f : {0.01, 0.2, 0.1, 1.0, 0.3})
    for (const VertexId v : ids(mesh.points)) {
      const double allowed = spacing(mesh.points[v]);
      ASSERT_EQ(limit(v, f), std::min(f, allowed));
      n_bound += allowed < f ? 1 : 0;
    }
  // Both are the least somewhere.
  EXPECT_GT(n_bound, mesh.points.size());
  EXPECT_LT(n_bound, 4 * mesh.points.size());
}
TEST(SpacingLimit, IsTheLeastOfBothInThePlane) { is_the_least_of_both<2>(); }
TEST(SpacingLimit, IsTheLeastOfBothInSpace) { is_the_least_of_both<3>(); }

}  // namespace
}  // namespace voropack
