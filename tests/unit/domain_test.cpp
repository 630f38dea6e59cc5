#include "voropack/domain.h"

#include <gtest/gtest.h>

#include "support/domains.h"

namespace voropack {
namespace {

struct Counts {
  std::size_t points, segments, facets, regions;
  friend bool operator==(const Counts&, const Counts&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Counts& c) {
    return out << c.points << " points, " << c.segments << " segments, " << c.facets << " facets, " << c.regions
               << " regions";
  }
};

template <int D>
Counts counts(const Domain<D>& d) {
  return {d.points.size(), d.segments.size(), d.facet_frame.size(), d.region_id.size()};
}

TEST(Domain, UnitShapesHaveTheirCountsAndMeasures) {
  const auto square = build_domain(domains::unit_square());
  EXPECT_EQ(counts(square), (Counts{4, 4, 0, 1}));
  EXPECT_DOUBLE_EQ(square.region_measure[RegionId(0)], 1);
  const auto cube = build_domain(domains::unit_cube());
  EXPECT_EQ(counts(cube), (Counts{8, 12, 6, 1}));
  EXPECT_DOUBLE_EQ(cube.region_measure[RegionId(0)], 1);
  EXPECT_EQ(counts(build_domain(domains::l_shape<2>())), (Counts{6, 6, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::l_shape<3>())), (Counts{12, 18, 8, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_hole<2>())), (Counts{8, 8, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_hole<3>())), (Counts{16, 24, 12, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_through_hole())), (Counts{16, 24, 10, 1}));
  EXPECT_EQ(counts(build_domain(domains::two_material_box<2>())), (Counts{6, 7, 0, 2}));
  EXPECT_EQ(counts(build_domain(domains::two_material_box<3>())), (Counts{12, 20, 11, 2}));
  EXPECT_EQ(counts(build_domain(domains::box_with_internal_wall<2>())), (Counts{6, 5, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_internal_wall<3>())), (Counts{12, 16, 7, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_dangling_segment<2>())), (Counts{6, 6, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_dangling_segment<3>())), (Counts{10, 13, 6, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_isolated_point<2>())), (Counts{5, 4, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_isolated_point<3>())), (Counts{9, 12, 6, 1}));
  EXPECT_EQ(counts(build_domain(domains::box_with_marked_facet())), (Counts{11, 13, 6, 1}));
  EXPECT_EQ(counts(build_domain(domains::regular_simplex<2>())), (Counts{3, 3, 0, 1}));
  EXPECT_EQ(counts(build_domain(domains::regular_simplex<3>(), {.min_angle_deg = 54})), (Counts{4, 6, 4, 1}));
  EXPECT_EQ(counts(build_domain(domains::tessellated_cube(3))), (Counts{8, 12, 6, 1}));
  EXPECT_EQ(counts(build_domain(domains::tilted_box<3>())), (Counts{8, 12, 6, 1}));
}

}  // namespace
}  // namespace voropack
