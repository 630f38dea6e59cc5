// The same input, options and seed give the same bytes, for any number of threads.
#include <gtest/gtest.h>

#include "support/allow_threads.h"
#include "support/cases.h"

namespace voropack {
namespace {

template <int D>
void threads_do_not_matter(double size) {
  const test::AllowThreads allow(8);
  for (const test::Filling& f : test::all_fillings())
    for (const auto& input : {domains::l_shape<D>(), domains::tilted(domains::two_material_box<D>())}) {
      auto options = test::meshing_options<D>(f, size);
      options.threads = 1;
      const auto one = make_mesh(input, options);
      for (const int threads : {2, 8}) {
        options.threads = threads;
        const auto many = make_mesh(input, options);
        EXPECT_EQ(one.mesh, many.mesh) << f.name << ", threads " << threads;
        EXPECT_EQ(one.volumes.cell_volume, many.volumes.cell_volume);
        EXPECT_EQ(one.volumes.face_vertices, many.volumes.face_vertices);
        EXPECT_EQ(one.volumes.face_area, many.volumes.face_area);
        EXPECT_EQ(one.quality.volume_sum, many.quality.volume_sum);
      }
    }
}
TEST(Determinism, ThreadsDoNotMatterInThePlane) { threads_do_not_matter<2>(0.1); }
TEST(Determinism, ThreadsDoNotMatterInSpace) { threads_do_not_matter<3>(0.25); }

template <int D>
void seeds_matter() {
  for (const test::Filling& f : test::all_fillings()) {
    auto options = test::meshing_options<D>(f, 0.2);
    const auto one = make_mesh(domains::unit_box<D>(), options);
    options.packing.seed = 2;
    const auto two = make_mesh(domains::unit_box<D>(), options);
    EXPECT_TRUE(two.certificate.ok);
    EXPECT_FALSE(one.mesh.points == two.mesh.points) << f.name;
  }
}
TEST(Determinism, SeedsMatterInThePlane) { seeds_matter<2>(); }
TEST(Determinism, SeedsMatterInSpace) { seeds_matter<3>(); }

}  // namespace
}  // namespace voropack
