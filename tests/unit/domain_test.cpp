// Hand-worked domains: what build_domain makes of valid input.
#include "voropack/domain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "support/domains.h"
#include "voropack/error.h"

namespace voropack {

struct Counts {
  std::size_t points, segments, facets, regions;
  friend bool operator==(const Counts&, const Counts&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Counts& c) {
    return out << c.points << " points, " << c.segments << " segments, " << c.facets << " facets, " << c.regions
               << " regions";
  }
};

namespace {

using domains::add_facet;
using domains::add_point;
using domains::add_segment;
using domains::Corner;

template <int D>
Domain<D> build(const DomainInput<D>& input, const DomainOptions& options = {}) {
  Domain<D> domain = build_domain(input, options);
  EXPECT_EQ(find_domain_fault(domain), "");
  return domain;
}

template <int D>
Counts counts(const Domain<D>& d) {
  return {d.points.size(), d.segments.size(), d.facet_frame.size(), d.region_id.size()};
}

template <int D>
void expect_shape(const DomainInput<D>& input, const Counts& expected, double measure) {
  const Domain<D> domain = build(input);
  EXPECT_EQ(counts(domain), expected);
  double sum = 0;
  for (const double m : domain.region_measure) sum += m;
  EXPECT_NEAR(sum, measure, 1e-13 * measure);
}

TEST(Domain, PlaneShapesHaveTheirCountsAndAreas) {
  expect_shape(domains::unit_square(), {4, 4, 0, 1}, 1);
  expect_shape(domains::l_shape<2>(), {6, 6, 0, 1}, 3);
  expect_shape(domains::box_with_hole<2>(), {8, 8, 0, 1}, 8);
  expect_shape(domains::two_material_box<2>(), {6, 7, 0, 2}, 2);
  expect_shape(domains::box_with_internal_wall<2>(), {6, 5, 0, 1}, 1);
  expect_shape(domains::box_with_dangling_segment<2>(), {6, 6, 0, 1}, 1);
  expect_shape(domains::box_with_isolated_point<2>(), {5, 4, 0, 1}, 1);
  expect_shape(domains::regular_simplex<2>(), {3, 3, 0, 1}, std::sqrt(3.0) / 4);
}

TEST(Domain, SolidShapesHaveTheirCountsAndVolumes) {
  expect_shape(domains::unit_cube(), {8, 12, 6, 1}, 1);
  expect_shape(domains::l_shape<3>(), {12, 18, 8, 1}, 3);
  expect_shape(domains::box_with_hole<3>(), {16, 24, 12, 1}, 26);
  expect_shape(domains::box_with_through_hole(), {16, 24, 10, 1}, 24);
  expect_shape(domains::two_material_box<3>(), {12, 20, 11, 2}, 2);
  expect_shape(domains::box_with_internal_wall<3>(), {12, 16, 7, 1}, 1);
  expect_shape(domains::box_with_dangling_segment<3>(), {10, 13, 6, 1}, 1);
  expect_shape(domains::box_with_isolated_point<3>(), {9, 12, 6, 1}, 1);
  expect_shape(domains::box_with_marked_facet(), {11, 13, 6, 1}, 1);
  expect_shape(domains::tessellated_cube(3), {8, 12, 6, 1}, 1);
  expect_shape(domains::tilted_box<3>(), {8, 12, 6, 1}, 1);
}

TEST(Domain, WallsOfASquareFaceItsRegion) {
  const auto square = build(domains::unit_square());
  for (const auto& sides : square.wall_regions) {
    EXPECT_EQ(sides[0], RegionId(0));  // Counterclockwise: inside is to the left.
    EXPECT_TRUE(sides[1].is_none());
  }
  EXPECT_EQ(square.segment_marker.raw(), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(square.point_marker.raw(), (std::vector<int>{0, 0, 0, 0}));
}

TEST(Domain, WallsOfACubeFaceItsRegionAndLieInAxisPlanesExactly) {
  const auto cube = build(domains::unit_cube());
  for (const FacetId f : ids<FacetId>(6)) {
    const PlaneFrame& frame = cube.facet_frame[f];
    const bool outward = frame.height({0.5, 0.5, 0.5}) < 0;
    EXPECT_EQ(cube.wall_regions[f.value()][outward ? 1 : 0], RegionId(0));
    EXPECT_TRUE(cube.wall_regions[f.value()][outward ? 0 : 1].is_none());
    EXPECT_EQ(cube.facet_segments[f].size(), 4U);
    EXPECT_EQ(cube.facet_points[f].size(), 4U);
    EXPECT_EQ(cube.facet_triangles[f].size(), 2U);
    for (const PointId p : cube.facet_points[f]) {
      EXPECT_EQ(frame.height(cube.points[p]), 0);
      EXPECT_EQ(frame.from_plane(frame.to_plane(cube.points[p])), cube.points[p]);
    }
  }
  EXPECT_EQ(cube.facet_marker.raw(), (std::vector<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(cube.warnings.empty());
}

template <int D>
void expect_two_materials() {
  const auto box = build(domains::two_material_box<D>());
  EXPECT_EQ(box.region_id.raw(), (std::vector<int>{7, 9}));
  EXPECT_DOUBLE_EQ(box.region_measure[RegionId(0)], 1);
  EXPECT_DOUBLE_EQ(box.region_measure[RegionId(1)], 1);
  std::size_t n_between = 0;
  for (const auto& sides : box.wall_regions) n_between += !sides[0].is_none() && !sides[1].is_none();
  EXPECT_EQ(n_between, 1U);
}
TEST(Domain, AWallBetweenMaterialsHasOneOnEachSide) {
  expect_two_materials<2>();
  expect_two_materials<3>();
}

TEST(Domain, HalvesOfACutFacetKeepItsMarker) {
  auto input = domains::two_material_box<3>();
  input.facets[0].marker = 42;
  const auto box = build(input);
  EXPECT_EQ(std::count(box.facet_marker.begin(), box.facet_marker.end(), 42), 2);
  // Front, unmarked, is the second without a marker: it has number 2, twice.
  EXPECT_EQ(std::count(box.facet_marker.begin(), box.facet_marker.end(), 2), 2);
}

TEST(Domain, AWallInsideARegionHasItOnBothSides) {
  const auto square = build(domains::box_with_internal_wall<2>());
  EXPECT_EQ(square.wall_regions[4], (std::array{RegionId(0), RegionId(0)}));
  const auto cube = build(domains::box_with_internal_wall<3>());
  EXPECT_EQ(cube.wall_regions[6], (std::array{RegionId(0), RegionId(0)}));
}

TEST(Domain, InnerPolytopesKnowTheirRegion) {
  const auto cube = build(domains::box_with_dangling_segment<3>());
  const SegmentId dangling(0);  // Listed segments come first.
  EXPECT_EQ(cube.segment_region[dangling], RegionId(0));
  EXPECT_TRUE(cube.point_region[PointId(8)].is_none());   // On the wall x = 0,
  EXPECT_EQ(cube.point_region[PointId(9)], RegionId(0));  // at the center.
  std::size_t n_listing = 0;
  for (const FacetId f : ids<FacetId>(6))
    n_listing += std::binary_search(cube.facet_points[f].begin(), cube.facet_points[f].end(), PointId(8));
  EXPECT_EQ(n_listing, 1U);
  EXPECT_EQ(build(domains::box_with_isolated_point<2>()).point_region[PointId(4)], RegionId(0));
  const auto square = build(domains::box_with_dangling_segment<2>());
  for (const RegionId region : square.segment_region) EXPECT_TRUE(region.is_none());
}

TEST(Domain, PolygonsOfOneAndTwoPointsBelongToTheirFacet) {
  const auto cube = build(domains::box_with_marked_facet());
  EXPECT_EQ(cube.facet_segments[FacetId(1)].size(), 5U);
  EXPECT_EQ(cube.facet_points[FacetId(1)].size(), 7U);
}

TEST(Domain, PointsOnASegmentSplitIt) {
  auto input = domains::unit_square();
  input.segments[0].marker = 8;
  add_point<2>(input, {0.25, 0});
  add_point<2>(input, {0.75, 1e-12});
  const auto square = build(input);
  EXPECT_EQ(counts(square), (Counts{6, 6, 0, 1}));
  EXPECT_EQ(std::count(square.segment_marker.begin(), square.segment_marker.end(), 8), 3);
}

TEST(Domain, OverlappingSegmentsAreMerged) {
  auto input = domains::unit_square();
  const Corner a = add_point<2>(input, {0.25, 0}), b = add_point<2>(input, {0.75, 0});
  add_segment(input, a, b, 5);
  add_segment(input, 1, 0);
  const auto square = build(input);
  EXPECT_EQ(counts(square), (Counts{6, 6, 0, 1}));
  EXPECT_EQ(std::count(square.segment_marker.begin(), square.segment_marker.end(), 5), 1);
}

TEST(Domain, DuplicatePointsAreMergedWithAWarning) {
  DomainInput<3> input = domains::tessellated_cube(1);
  EXPECT_EQ(input.points.size(), 24U);
  const auto cube = build(input);
  EXPECT_EQ(counts(cube), (Counts{8, 12, 6, 1}));
  ASSERT_EQ(cube.warnings.size(), 1U);
  EXPECT_NE(cube.warnings[0].find("merged 16"), std::string::npos) << cube.warnings[0];
}

TEST(Domain, OnlySurfacesLoseUnreferencedPoints) {
  auto input = domains::unit_cube();
  add_point<3>(input, {5, 5, 5});
  EXPECT_THROW(build_domain(input), InputError);
  input.is_surface = true;
  const auto cube = build(input);
  EXPECT_EQ(cube.points.size(), 8U);
  EXPECT_EQ(cube.warnings.size(), 1U);
}

TEST(Domain, CoplanarFacetsAreJoinedUnlessAskedNotTo) {
  DomainInput<3> input = domains::tessellated_cube(2);
  EXPECT_EQ(build(input).facet_frame.size(), 6U);
  EXPECT_EQ(build(input, {.min_angle_deg = 0, .merge_coplanar = false}).facet_frame.size(), 48U);
}

TEST(Domain, FacetsWithDifferentMarkersAreNotJoined) {
  DomainInput<3> input = domains::tessellated_cube(1);
  for (std::size_t f = 0; f < 12; ++f) input.facets[f].marker = f == 0 ? 1 : 2;
  EXPECT_EQ(counts(build(input, {.min_angle_deg = 40})), (Counts{8, 13, 7, 1}));
}

TEST(Domain, PointsOfAComplexStay) {
  DomainInput<3> input = domains::tessellated_cube(2);
  input.is_surface = false;
  // 26 points remain, those in the middle of each face without a segment: 12 edges of two segments each.
  EXPECT_EQ(counts(build(input)), (Counts{26, 24, 6, 1}));
}

TEST(Domain, AnOpenSurfaceInsideABoxIsAWall) {
  auto input = domains::unit_cube();
  for (const Vec<3>& x : {Vec<3>{0.5, 0, 0}, Vec<3>{0.5, 1, 0}, Vec<3>{0.5, 1, 0.5}, Vec<3>{0.5, 0, 0.5}})
    add_point(input, x);
  add_facet(input, {8, 9, 10, 11});
  const auto box = build(input);
  // The wall stands on the bottom, front and back; these stay whole and list its edges.
  EXPECT_EQ(counts(box), (Counts{12, 18, 7, 1}));
  EXPECT_EQ(box.facet_segments[FacetId(0)].size(), 7U);
}

TEST(Domain, BoxesThatTouchInAPointAreTwoRegions) {
  auto corner = domains::unit_cube();
  domains::add_box<3>(corner, {1, 1, 1}, {2, 2, 2});
  const auto boxes = build(corner);
  EXPECT_EQ(counts(boxes), (Counts{15, 24, 12, 2}));
  EXPECT_DOUBLE_EQ(boxes.region_measure[RegionId(0)], 1);
  EXPECT_DOUBLE_EQ(boxes.region_measure[RegionId(1)], 1);
  auto edge = domains::unit_cube();
  domains::add_box<3>(edge, {1, 1, 0}, {2, 2, 1});
  EXPECT_EQ(counts(build(edge)), (Counts{14, 23, 12, 2}));
}

TEST(Domain, ABoxOnASharedPartOfAFaceCutsIt) {
  auto input = domains::box<3>({0, 0, 0}, {3, 3, 1});
  domains::add_box<3>(input, {1, 1, 1}, {2, 2, 2});
  input.facets.erase(input.facets.begin() + 6);  // Its bottom lies on the lower box's top.
  // The top of the lower box falls into a frame and a square between the two regions.
  expect_shape(input, {16, 24, 12, 2}, 10);
}

TEST(Domain, BoxesInBoxesNest) {
  DomainInput<2> input;
  for (int i = 0; i < 4; ++i) domains::add_box<2>(input, domains::all<2>(i), domains::all<2>(9 - i));
  input.hole_seeds.push_back({1.5, 5});
  input.region_seeds.push_back({{2.5, 5}, {}, 0.25});
  input.region_seeds.push_back({{5, 5}, 1, {}});
  const auto boxes = build(input);
  ASSERT_EQ(boxes.region_id.size(), 3U);
  std::set<int> used(boxes.region_id.begin(), boxes.region_id.end());
  EXPECT_EQ(used, (std::set<int>{1, 2, 3}));
  for (const RegionId r : ids(boxes.region_id)) {
    if (boxes.region_id[r] == 1) {
      EXPECT_DOUBLE_EQ(boxes.region_measure[r], 9);
    }
    EXPECT_EQ(boxes.region_max_simplex[r].has_value(), std::abs(boxes.region_measure[r] - 16) < 1e-9);
  }
}

TEST(Domain, NestedPolygonsFollowTheirFormat) {
  // A facet of two nested squares: a ring in a surface, all of it in a .poly without hole seeds.
  auto input = domains::box_with_through_hole();
  input.is_surface = true;
  for (auto& facet : input.facets) facet.holes.clear();
  expect_shape(input, {16, 24, 10, 1}, 24);
  input.is_surface = false;
  expect_shape(input, {16, 24, 12, 2}, 27);
}

TEST(Domain, PointMarkersAreKept) {
  auto input = domains::unit_square();
  input.point_markers = {3, {}, 5, {}};
  EXPECT_EQ(build(input).point_marker.raw(), (std::vector<int>{3, 0, 5, 0}));
}

TEST(Domain, TheSeamOfTwoRegionsThatMeetInADanglingWallIsFound) {
  // A hole inside a region that a wall ties to the outer boundary.
  auto input = domains::box_with_hole<2>();
  add_segment(input, 0, 4);
  const auto ring = build(input, {.min_angle_deg = 40});
  EXPECT_EQ(counts(ring), (Counts{8, 9, 0, 1}));
  EXPECT_DOUBLE_EQ(ring.region_measure[RegionId(0)], 8);
}

TEST(FindDomainFault, SeesWhatIsBroken) {
  const auto broken = [](auto&& change) {
    auto domain = build_domain(domains::two_material_box<3>());
    change(domain);
    return find_domain_fault(domain);
  };
  EXPECT_EQ(broken([](Domain<3>&) {}), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.points[PointId(3)] = d.points[PointId(2)]; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.segments[SegmentId(1)] = d.segments[SegmentId(0)]; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.wall_regions[0] = {RegionId::none(), RegionId::none()}; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { std::swap(d.wall_regions[0][0], d.wall_regions[0][1]); }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.facet_triangles.values[0] = d.facet_triangles.values[1]; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.region_measure[RegionId(0)] *= 2; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.facet_frame[FacetId(0)].origin[2] += 0.5; }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.point_region[PointId(0)] = RegionId(0); }), "");
  EXPECT_NE(broken([](Domain<3>& d) { d.facet_segments.values[0] = SegmentId(19); }), "");
}

}  // namespace
}  // namespace voropack
