// One test for each fault that build_domain finds: class, id, place and how to mend it.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "support/domains.h"
#include "voropack/domain.h"
#include "voropack/error.h"

namespace voropack {
namespace {

using domains::add_facet;
using domains::add_point;
using domains::add_segment;
using domains::Corner;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <int D>
std::vector<Fault> faults_of(const DomainInput<D>& input, const DomainOptions& options = {}) {
  try {
    build_domain(input, options);
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

constexpr DomainOptions kAtSixty{.min_angle_deg = 60};

/// The first fault with this id; fails the test if there is none, or if it does not say how to mend it.
template <int D>
Fault expect_fault(const DomainInput<D>& input, const std::string& id, const DomainOptions& options = {}) {
  std::string found;
  for (const Fault& fault : faults_of(input, options)) {
    if (fault.id == "domain." + id) {
      EXPECT_FALSE(fault.fix.empty()) << fault.text();
      EXPECT_FALSE(fault.message.empty());
      EXPECT_EQ(fault.file, input.file);
      return fault;
    }
    found += fault.text() + '\n';
  }
  ADD_FAILURE() << "no fault domain." << id << ", but: " << found;
  return {};
}

void expect_near(const Fault& fault, std::initializer_list<double> place) {
  ASSERT_EQ(fault.position.size(), place.size()) << fault.text();
  std::size_t k = 0;
  for (const double c : place) EXPECT_NEAR(fault.position[k++], c, 1e-9) << fault.text();
}

bool mentions(const Fault& fault, const std::string& words) { return fault.message.find(words) != std::string::npos; }

TEST(DomainFaults, CoordinatesMustBeFinite) {
  auto square = domains::unit_square();
  square.file = "square.poly";
  square.first_index = 1;
  square.points[2][0] = kNan;
  EXPECT_TRUE(mentions(expect_fault(square, "not_finite"), "point 3"));
  auto cube = domains::unit_cube();
  cube.hole_seeds.push_back({0.5, 0.5, std::numeric_limits<double>::infinity()});
  EXPECT_TRUE(mentions(expect_fault(cube, "not_finite"), "hole seed 0"));
  auto sized = domains::unit_cube();
  sized.region_seeds.push_back({{0.5, 0.5, 0.5}, 1, kNan});
  expect_fault(sized, "not_finite");
  sized.facets[0].holes.push_back({kNan, 0, 0});
  expect_fault(sized, "not_finite");
}

TEST(DomainFaults, CoordinatesMustBeInRange) {
  auto square = domains::unit_square();
  square.points[1][0] = 1e300;
  expect_near(expect_fault(square, "too_large"), {1e300, 0});
  expect_fault(domains::mapped(domains::unit_cube(), [](const Vec<3>& x) { return 1e-200 * x; }), "too_small");
  expect_fault(domains::mapped(domains::unit_cube(), [](const Vec<3>&) { return Vec<3>{}; }), "too_small");
  const auto cube_at = [](double far) {
    return domains::mapped(domains::unit_cube(), [far](const Vec<3>& x) { return x + Vec<3>{far, 0, 0}; });
  };
  EXPECT_EQ(expect_fault(cube_at(1e13), "too_far").position[0], 1e13);
  EXPECT_NO_THROW(build_domain(cube_at(1e11)));
}

TEST(DomainFaults, IndicesMustNamePoints) {
  auto square = domains::unit_square();
  square.first_index = 1;
  square.segments[3] = {{3, 4}, {}, 17};
  const Fault fault = expect_fault(square, "index_out_of_range");
  EXPECT_TRUE(mentions(fault, "point 5")) << fault.text();
  EXPECT_TRUE(mentions(fault, "1 to 4")) << fault.text();
  EXPECT_EQ(fault.line, 17);
  auto cube = domains::unit_cube();
  cube.facets[5].polygons[0][1] = 4'000'000'000U;
  expect_fault(cube, "index_out_of_range");
  auto marked = domains::unit_square();
  marked.point_markers = {1, 2};
  expect_fault(marked, "index_out_of_range");
  DomainInput<3> none;
  add_facet(none, {0, 1, 2});
  expect_fault(none, "index_out_of_range");
}

TEST(DomainFaults, ADomainHasWalls) {
  expect_fault(DomainInput<2>{}, "empty");
  expect_fault(DomainInput<3>{}, "empty");
  auto points = domains::unit_square();
  points.segments.clear();
  expect_fault(points, "empty");
}

TEST(DomainFaults, APlaneDomainHasNoFacets) {
  auto square = domains::unit_square();
  square.facets.push_back({{{0, 1, 2}}, {}, {}, {}});
  expect_fault(square, "facet_in_2d");
}

TEST(DomainFaults, SegmentsHaveLength) {
  auto square = domains::unit_square();
  add_segment(square, 2, 2);
  expect_near(expect_fault(square, "zero_size_segment"), {1, 1});
  auto twins = domains::unit_square();
  add_segment(twins, 2, add_point<2>(twins, {1, 1}));
  expect_near(expect_fault(twins, "zero_size_segment"), {1, 1});
}

TEST(DomainFaults, FacetsHaveArea) {
  auto cube = domains::unit_cube();
  add_facet(cube, {0, 6, 6});
  EXPECT_TRUE(mentions(expect_fault(cube, "zero_size_facet"), "facet 6"));
  auto thin = domains::unit_cube();
  add_facet(thin, {0, 6, add_point<3>(thin, {0.5, 0.5, 0.5 + 1e-12})});
  expect_fault(thin, "zero_size_facet");
  auto none = domains::unit_cube();
  none.facets.push_back({{}, {}, {}, {}});
  expect_fault(none, "zero_size_facet");
  auto emptied = domains::unit_cube();
  emptied.facets[0].holes.push_back({0.5, 0.5, 0});
  expect_fault(emptied, "zero_size_facet");
}

TEST(DomainFaults, FacetsArePlanar) {
  auto cube = domains::unit_cube();
  cube.points[6] = {1, 1, 1.25};
  const Fault fault = expect_fault(cube, "nonplanar_facet");
  EXPECT_TRUE(mentions(fault, "facet 1 ")) << fault.text();
}

TEST(DomainFaults, SegmentsDoNotCross) {
  auto square = domains::unit_square();
  add_segment(square, 0, 2);
  add_segment(square, 1, 3);
  const Fault fault = expect_fault(square, "self_intersection");
  expect_near(fault, {0.5, 0.5});
  EXPECT_TRUE(mentions(fault, "segment 4")) << fault.text();
  EXPECT_TRUE(mentions(fault, "segment 5")) << fault.text();
  // A crossing between points that are nearly in line.
  auto flat = domains::unit_square();
  const Corner a = add_point<2>(flat, {0.1, 0.5}), b = add_point<2>(flat, {0.9, 0.5 + 1e-7});
  const Corner c = add_point<2>(flat, {0.2, 0.5 + 1e-7}), d = add_point<2>(flat, {0.8, 0.5 - 1e-7});
  add_segment(flat, a, b);
  add_segment(flat, c, d);
  expect_fault(flat, "self_intersection");
}

TEST(DomainFaults, SegmentsThatPassWithinTheToleranceCross) {
  auto cube = domains::unit_cube();
  const Corner a = add_point<3>(cube, {0.2, 0.5, 0.5}), b = add_point<3>(cube, {0.8, 0.5, 0.5});
  const Corner c = add_point<3>(cube, {0.5, 0.2, 0.5 + 1e-10}), d = add_point<3>(cube, {0.5, 0.8, 0.5 + 1e-10});
  add_segment(cube, a, b);
  add_segment(cube, c, d);
  expect_fault(cube, "self_intersection");
  cube.points[c][2] = cube.points[d][2] = 0.5 + 1e-6;
  EXPECT_TRUE(faults_of(cube).empty());
}

TEST(DomainFaults, SegmentsDoNotPierceFacets) {
  auto cube = domains::unit_cube();
  const Corner a = add_point<3>(cube, {0.3, 0.4, 0.5}), b = add_point<3>(cube, {0.3, 0.4, 1.5});
  add_segment(cube, a, b);
  const Fault fault = expect_fault(cube, "self_intersection");
  expect_near(fault, {0.3, 0.4, 1});
  EXPECT_TRUE(mentions(fault, "facet 1 ")) << fault.text();
  // Through an edge of the facet's triangulation.
  cube.points[a] = {0.5, 0.5, 0.5};
  cube.points[b] = {0.5, 0.5, 1.5};
  expect_near(expect_fault(cube, "self_intersection"), {0.5, 0.5, 1});
}

TEST(DomainFaults, FacetsDoNotCross) {
  auto boxes = domains::unit_cube();
  domains::add_box<3>(boxes, {0.5, 0.5, 0.5}, {1.5, 1.5, 1.5});
  expect_fault(boxes, "self_intersection");
}

TEST(DomainFaults, FacetsDoNotOverlap) {
  auto twice = domains::unit_cube();
  add_facet(twice, twice.facets[1].polygons[0]);
  EXPECT_TRUE(mentions(expect_fault(twice, "self_intersection"), "facet 1 "));
  auto inside = domains::unit_cube();
  const Corner first = add_point<3>(inside, {0.2, 0.2, 1});
  add_point<3>(inside, {0.8, 0.2, 1});
  add_point<3>(inside, {0.8, 0.8, 1});
  add_facet(inside, {first, first + 1, first + 2});
  EXPECT_TRUE(mentions(expect_fault(inside, "self_intersection"), "overlap"));
  auto corner = domains::unit_cube();
  add_facet(corner, {4, 5, 6});
  EXPECT_TRUE(mentions(expect_fault(corner, "self_intersection"), "overlap"));
}

TEST(DomainFaults, BoundariesAreClosed) {
  auto square = domains::unit_square();
  square.segments.pop_back();
  const Fault ends = expect_fault(square, "open_boundary");
  EXPECT_TRUE(mentions(ends, "point 0")) << ends.text();
  EXPECT_TRUE(mentions(ends, "point 3")) << ends.text();
  auto cube = domains::unit_cube();
  cube.facets.erase(cube.facets.begin() + 1);
  const Fault fault = expect_fault(cube, "open_boundary");
  EXPECT_TRUE(mentions(fault, "4 edges")) << fault.text();
  EXPECT_EQ(fault.position.size(), 3U);
}

TEST(DomainFaults, NothingLiesOutside) {
  auto fin = domains::unit_cube();
  const Corner first = add_point<3>(fin, {2, 0, 0});
  add_point<3>(fin, {2, 0, 1});
  add_facet(fin, {1, first, first + 1, 5});
  EXPECT_TRUE(mentions(expect_fault(fin, "outside"), "facet 6"));
  auto spike = domains::unit_square();
  add_segment(spike, 1, add_point<2>(spike, {2, 0}));
  EXPECT_TRUE(mentions(expect_fault(spike, "outside"), "segment 4"));
  auto point = domains::unit_cube();
  add_point<3>(point, {0.5, 0.5, 2});
  expect_near(expect_fault(point, "outside"), {0.5, 0.5, 2});
  auto segment = domains::unit_cube();
  add_segment(segment, 6, add_point<3>(segment, {2, 2, 2}));
  expect_fault(segment, "outside");
  auto in_hole = domains::box_with_hole<2>();
  add_point<2>(in_hole, {1.25, 1.25});
  EXPECT_TRUE(mentions(expect_fault(in_hole, "outside"), "in a hole"));
}

TEST(DomainFaults, AWallBetweenHolesIsAnInconsistency) {
  auto emptied = domains::unit_cube();
  emptied.hole_seeds.push_back({0.5, 0.5, 0.5});
  EXPECT_TRUE(mentions(expect_fault(emptied, "outside"), "hole seeds"));
  auto half = domains::two_material_box<2>();
  half.region_seeds.pop_back();
  half.hole_seeds.push_back({1.5, 0.5});
  const auto faults = faults_of(half);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_TRUE(mentions(faults[0], "3 segments bound no region")) << faults[0].text();
}

TEST(DomainFaults, SeedsLieInVolumes) {
  auto square = domains::unit_square();
  square.region_seeds.push_back({{2, 2}, 1, {}});
  expect_near(expect_fault(square, "seed_outside"), {2, 2});
  auto cube = domains::unit_cube();
  cube.hole_seeds.push_back({0.5, 0.5, -1});
  expect_near(expect_fault(cube, "seed_outside"), {0.5, 0.5, -1});
  auto wall = domains::unit_cube();
  wall.region_seeds.push_back({{0.5, 0.5, 1}, 1, {}});
  expect_near(expect_fault(wall, "seed_on_wall"), {0.5, 0.5, 1});
}

TEST(DomainFaults, SeedsInOneVolumeAgree) {
  auto square = domains::unit_square();
  square.region_seeds = {{{0.2, 0.5}, 1, {}}, {{0.8, 0.5}, 2, {}}};
  expect_near(expect_fault(square, "seed_conflict"), {0.8, 0.5});
  square.region_seeds[1].id = 1;
  EXPECT_TRUE(faults_of(square).empty());
  square.region_seeds.pop_back();
  square.hole_seeds.push_back({0.8, 0.5});
  expect_fault(square, "seed_conflict");
}

TEST(DomainFaults, NoAngleIsTooSmallUnlessALimitIsSet) {
  DomainInput<2> triangle;
  domains::add_loop(triangle, {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{0.6, 1e-4}});
  EXPECT_TRUE(faults_of(triangle).empty());
  EXPECT_EQ(faults_of(triangle, kAtSixty).size(), 2U);
}

TEST(DomainFaults, AnglesBetweenSegmentsReachTheLimit) {
  DomainInput<2> triangle;
  domains::add_loop(triangle, {Vec<2>{0, 0}, Vec<2>{4, 0}, Vec<2>{0, 1}});
  const auto faults = faults_of(triangle, kAtSixty);
  ASSERT_EQ(faults.size(), 1U);
  const Fault fault = expect_fault(triangle, "small_angle", kAtSixty);
  expect_near(fault, {4, 0});
  EXPECT_TRUE(mentions(fault, "14.0362 degrees")) << fault.text();
  EXPECT_TRUE(faults_of(triangle, {.min_angle_deg = 0}).empty());
  EXPECT_TRUE(faults_of(triangle, {.min_angle_deg = 14}).empty());
  EXPECT_FALSE(faults_of(triangle, {.min_angle_deg = 14.1}).empty());
}

TEST(DomainFaults, SixtyDegreesAreEnough) {
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    EXPECT_TRUE(faults_of(domains::tilted(domains::regular_simplex<2>(), seed), kAtSixty).empty());
}

TEST(DomainFaults, AnglesBetweenSegmentsAndFacetsReachTheLimit) {
  const auto with_segment_at = [](double degrees) {
    auto cube = domains::unit_cube();
    const double angle = degrees * std::acos(-1) / 180;
    const Corner a = add_point<3>(cube, {0.5, 0.5, 0});
    add_segment(cube, a, add_point<3>(cube, {0.5 + 0.3 * std::cos(angle), 0.5, 0.3 * std::sin(angle)}));
    return cube;
  };
  const Fault fault = expect_fault(with_segment_at(40), "small_angle", kAtSixty);
  expect_near(fault, {0.5, 0.5, 0});
  EXPECT_TRUE(mentions(fault, "40 degrees")) << fault.text();
  EXPECT_TRUE(mentions(fault, "segment 0")) << fault.text();
  EXPECT_TRUE(mentions(fault, "facet 0")) << fault.text();
  EXPECT_TRUE(faults_of(with_segment_at(60), kAtSixty).empty());
}

TEST(DomainFaults, AnglesBetweenFacetsReachTheLimit) {
  const auto with_roof_at = [](double degrees) {
    const double angle = degrees * std::acos(-1) / 180;
    DomainInput<3> input;
    domains::add_prism(
        input, {Vec<2>{0, 0}, Vec<2>{10, 0}, Vec<2>{10, 1}, Vec<2>{std::cos(angle) * 9, std::sin(angle) * 9}}, 0, 1);
    return input;
  };
  const auto faults = faults_of(with_roof_at(45), kAtSixty);
  ASSERT_EQ(faults.size(), 3U);  // Two corners and the dihedral angle between them.
  bool found = false;
  for (const Fault& fault : faults)
    if (mentions(fault, "facet 2") && mentions(fault, "facet 5") && !mentions(fault, "edge")) {
      expect_near(fault, {0, 0, 0.5});
      EXPECT_TRUE(mentions(fault, "45 degrees")) << fault.text();
      found = true;
    }
  EXPECT_TRUE(found);
}

TEST(DomainFaults, SeveralFaultsComeTogetherUpToTwenty) {
  auto square = domains::unit_square();
  for (int i = 0; i < 50; ++i) add_segment(square, 0, 0);
  EXPECT_EQ(faults_of(square).size(), kMaxFaults);
}

TEST(DomainFaults, TheLimitIsAnAngle) {
  EXPECT_THROW(build_domain(domains::unit_square(), {.min_angle_deg = -1}), OptionError);
  EXPECT_THROW(build_domain(domains::unit_square(), {.min_angle_deg = kNan}), OptionError);
}

TEST(DomainFaults, GarbageIsRefusedWithoutACrash) {
  Random random(7);
  const std::array<double, 6> values = {0, 1, 0.5, -1e60, 1e-300, 1e59};
  int n_refused = 0;
  for (int round = 0; round < 300; ++round) {
    DomainInput<3> input;
    input.is_surface = round % 2 == 0;
    for (int i = 0; i < 7; ++i) {
      Vec<3> x;
      const auto n_values = static_cast<std::size_t>(round % 3 == 0 ? 6 : 3);
      for (int k = 0; k < 3; ++k) x[k] = values[random.bits() % n_values];
      input.points.push_back(x);
    }
    for (int f = 0; f < 6; ++f) {
      domains::Polygon polygon;
      for (std::uint64_t i = 1 + random.bits() % 5; i > 0; --i)
        polygon.push_back(static_cast<Corner>(random.bits() % 7));
      add_facet(input, polygon);
    }
    add_segment(input, random.bits() % 7, random.bits() % 7);
    try {
      EXPECT_EQ(find_domain_fault(build_domain(input, {.min_angle_deg = 0})), "");
    } catch (const InputError&) {
      ++n_refused;
    }
  }
  EXPECT_GT(n_refused, 250);
}

}  // namespace
}  // namespace voropack
