// Laws of build_domain: its result follows motions, scalings and renumberings of the input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/domains.h"
#include "voropack/domain.h"

namespace voropack {
namespace {

/// Counts and measures: what does not depend on the position or numbering of the input.
template <int D>
std::vector<std::size_t> signature(const Domain<D>& d) {
  std::vector<std::size_t> s = {d.points.size(), d.segments.size(), d.n_walls(), d.region_id.size()};
  s.push_back(d.facet_points.values.size());
  s.push_back(d.facet_segments.values.size());
  s.push_back(d.facet_triangles.values.size());
  std::size_t n_sides = 0;
  for (const auto& sides : d.wall_regions) n_sides += !sides[0].is_none() + !sides[1].is_none();
  s.push_back(n_sides);
  return s;
}

template <int D>
std::vector<double> sorted_measures(const Domain<D>& d) {
  std::vector<double> measures = d.region_measure.raw();
  std::sort(measures.begin(), measures.end());
  return measures;
}

template <int D>
std::vector<DomainInput<D>> shapes() {
  std::vector<DomainInput<D>> all = {domains::unit_box<D>(),
                                     domains::box_with_hole<D>(),
                                     domains::l_shape<D>(),
                                     domains::two_material_box<D>(),
                                     domains::box_with_internal_wall<D>(),
                                     domains::box_with_dangling_segment<D>(),
                                     domains::box_with_isolated_point<D>()};
  if constexpr (D == 3) {
    all.push_back(domains::box_with_through_hole());
    all.push_back(domains::box_with_marked_facet());
    all.push_back(domains::tessellated_cube(2));
  }
  return all;
}

template <int D>
void expect_same(const DomainInput<D>& moved, const Domain<D>& original, double scale, double slack) {
  const Domain<D> domain = build_domain(moved);
  EXPECT_EQ(find_domain_fault(domain), "");
  EXPECT_EQ(signature(domain), signature(original));
  const auto expected = sorted_measures(original), found = sorted_measures(domain);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], expected[i] * std::pow(scale, D), slack * expected[i] * std::pow(scale, D));
}

template <int D>
void follow_motions() {
  for (const auto& shape : shapes<D>()) {
    const Domain<D> original = build_domain(shape);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      expect_same(domains::tilted(shape, seed), original, 1, 1e-13);
      expect_same(domains::tilted(shape, seed, 1e-20), original, 1e-20, 1e-13);
      expect_same(domains::tilted(shape, seed, 1e20), original, 1e20, 1e-13);
      expect_same(domains::tilted(shape, seed, 1, 1e4), original, 1, 1e-10);
      expect_same(domains::tilted(shape, seed, 1, 1e6), original, 1, 1e-8);
      expect_same(domains::tilted(shape, seed, 1e-6, 1), original, 1e-6, 1e-8);
    }
  }
}
TEST(DomainProperty, FollowsMotionsAndScalings) {
  follow_motions<2>();
  follow_motions<3>();
}

/// `input` with points, segments, facets and starts of polygons in another order, and some of them reversed.
template <int D>
DomainInput<D> renumbered(const DomainInput<D>& input, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint32_t> order(input.points.size()), new_index(input.points.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto shuffle = [&](auto& list) {
    for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
  };
  shuffle(order);
  DomainInput<D> result = input;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    new_index[order[i]] = i;
    result.points[i] = input.points[order[i]];
  }
  for (auto& segment : result.segments) {
    for (auto& p : segment.points) p = new_index[p];
    if (random.bits() % 2 == 0) std::swap(segment.points[0], segment.points[1]);
  }
  for (auto& facet : result.facets)
    for (auto& polygon : facet.polygons) {
      for (auto& p : polygon) p = new_index[p];
      std::rotate(polygon.begin(), polygon.begin() + static_cast<std::ptrdiff_t>(random.bits() % polygon.size()),
                  polygon.end());
      if (random.bits() % 2 == 0) std::reverse(polygon.begin(), polygon.end());
    }
  shuffle(result.segments);
  shuffle(result.facets);
  return result;
}

template <int D>
void follow_renumberings() {
  for (const auto& shape : shapes<D>()) {
    const Domain<D> original = build_domain(shape);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      expect_same(renumbered(shape, seed), original, 1, 1e-13);
      expect_same(renumbered(domains::tilted(shape, seed), seed), original, 1, 1e-13);
    }
  }
}
TEST(DomainProperty, FollowsRenumberings) {
  follow_renumberings<2>();
  follow_renumberings<3>();
}

template <int D>
void nest_boxes() {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    // A tower of boxes in a row of cells: each cell holds up to three boxes in each other, some emptied by hole seeds.
    DomainInput<D> input;
    std::vector<double> expected;
    Vec<D> hi = domains::all<D>(10);
    hi[0] = 40;
    domains::add_box<D>(input, domains::all<D>(0), hi);
    double rest = 4 * std::pow(10, D);
    for (int cell = 0; cell < 4; ++cell) {
      Vec<D> box_lo = domains::all<D>(1), box_hi = domains::all<D>(9);
      box_lo[0] += 10 * cell;
      box_hi[0] += 10 * cell;
      double* around = nullptr;
      for (auto depth = random.bits() % 4; depth > 0; --depth) {
        double measure = 1;
        Vec<D> seed_point;
        for (int k = 0; k < D; ++k) {
          box_lo[k] += 0.1 + random.unit();
          box_hi[k] -= 0.1 + random.unit();
          measure *= box_hi[k] - box_lo[k];
          seed_point[k] = box_lo[k] + 0.05;
        }
        domains::add_box<D>(input, box_lo, box_hi);
        if (around != nullptr)
          *around -= measure;
        else
          rest -= measure;
        expected.reserve(100);
        // A hole next to a hole would leave a wall that bounds nothing.
        if (depth == 1 && random.bits() % 2 == 0) {
          input.hole_seeds.push_back(seed_point);
        } else {
          expected.push_back(measure);
          around = &expected.back();
        }
      }
    }
    expected.push_back(rest);
    std::sort(expected.begin(), expected.end());
    for (const auto& moved : {input, domains::tilted(input, seed)}) {
      const Domain<D> domain = build_domain(moved);
      const auto found = sorted_measures(domain);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-11 * rest);
      EXPECT_EQ(find_domain_fault(domain), "");
    }
  }
}
TEST(DomainProperty, BoxesInBoxesHaveTheirMeasures) {
  nest_boxes<2>();
  nest_boxes<3>();
}

TEST(DomainProperty, TwoTetrahedraOnOneTriangleAreTwoRegions) {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    const double thickness = std::pow(10, -3 * random.unit());  // Of the triangle, whose third corner is anywhere.
    DomainInput<3> input;
    for (const Vec<3>& x : {Vec<3>{0, 0, 0},
                            {1, 0, 0},
                            {random.unit(), thickness, 0},
                            {random.unit(), thickness * random.unit(), 0.1 + random.unit()},
                            {random.unit(), thickness * random.unit(), -0.1 - random.unit()}})
      domains::add_point(input, x);
    domains::add_facet(input, {0, 1, 2});
    for (const domains::Corner apex : {3U, 4U})
      for (domains::Corner k = 0; k < 3; ++k) domains::add_facet(input, {k, (k + 1) % 3, apex});
    const Domain<3> pair =
        build_domain(domains::tilted(input, static_cast<std::uint64_t>(i)), {.merge_coplanar = false});
    ASSERT_EQ(pair.region_id.size(), 2U);
    const std::vector<double> measures = sorted_measures(pair);
    EXPECT_NEAR(measures[0], thickness * std::min(input.points[3][2], -input.points[4][2]) / 6, 1e-13);
    EXPECT_NEAR(measures[1], thickness * std::max(input.points[3][2], -input.points[4][2]) / 6, 1e-13);
  }
}

TEST(DomainProperty, TessellatedBoxesAreBoxes) {
  for (int n = 1; n <= 5; ++n)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(testing::Message() << n << " squares, seed " << seed);
      for (const auto& input : {domains::tilted(domains::tessellated_cube(n), seed, 1, 3),
                                domains::tilted(domains::tessellated_cube(n), seed, 1, 1e6),
                                renumbered(domains::tilted(domains::tessellated_cube(n), seed), seed)}) {
        const Domain<3> box = build_domain(input);
        EXPECT_EQ(box.points.size(), 8U);
        EXPECT_EQ(box.segments.size(), 12U);
        EXPECT_EQ(box.facet_frame.size(), 6U);
        EXPECT_NEAR(box.region_measure[RegionId(0)], 1, 1e-13 + 1e-15 * norm(input.points[0]));
      }
    }
}

TEST(DomainProperty, SliversDoNotStopMerging) {
  // Squares whose diagonal is split by a point that nearly lies on it: triangles 1e-7 high, whose normals are noise
  // after a rotation.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DomainInput<3> input;
    input.is_surface = true;
    const DomainInput<3> cube = domains::unit_cube();
    input.points = cube.points;
    for (const auto& facet : cube.facets) {
      const auto& p = facet.polygons[0];
      const Vec<3>&a = cube.points[p[0]], &b = cube.points[p[1]], &c = cube.points[p[2]];
      const domains::Corner m = domains::add_point(input, 0.5 * (a + c) + 1e-7 * (b - a));
      for (const domains::Polygon& t : {domains::Polygon{p[0], p[1], m}, domains::Polygon{p[1], p[2], m},
                                        domains::Polygon{p[0], m, p[2]}, domains::Polygon{p[0], p[2], p[3]}})
        domains::add_facet(input, t);
    }
    const Domain<3> box = build_domain(domains::tilted(input, seed));
    EXPECT_EQ(box.points.size(), 8U);
    EXPECT_EQ(box.segments.size(), 12U);
    EXPECT_EQ(box.facet_frame.size(), 6U);
    EXPECT_EQ(find_domain_fault(box), "");
  }
}

TEST(DomainProperty, RandomSegmentsInASquareAreARegionOrAFault) {
  // Segments between points of a coarse lattice overlap, touch and cross in all ways.
  int n_built = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    auto input = domains::box<2>({0, 0}, {6, 6});
    for (auto n = 1 + random.bits() % 4; n > 0; --n) {
      const auto lattice_point = [&] {
        return domains::add_point<2>(input,
                                     {static_cast<double>(random.bits() % 7), static_cast<double>(random.bits() % 7)});
      };
      const auto a = lattice_point(), b = lattice_point();
      domains::add_segment(input, a, b);
    }
    try {
      const Domain<2> domain = build_domain(domains::tilted(input, seed), {.min_angle_deg = 0});
      ASSERT_EQ(find_domain_fault(domain), "");
      double sum = 0;
      for (const double measure : domain.region_measure) sum += measure;
      ASSERT_NEAR(sum, 36, 1e-11);
      // Euler's formula for the plane graph: V - E + F = 1 + C, where F counts the outside.
      std::vector<std::uint32_t> root(domain.points.size());
      std::iota(root.begin(), root.end(), 0U);
      const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i];
        return i;
      };
      for (const auto& s : domain.segments) root[find(s[0].value())] = find(s[1].value());
      std::size_t n_components = 0;
      for (std::uint32_t i = 0; i < root.size(); ++i) n_components += root[i] == i;
      ASSERT_EQ(domain.points.size() + domain.region_id.size() + 1, domain.segments.size() + 1 + n_components);
      ++n_built;
    } catch (const InputError& error) {
      ASSERT_TRUE(error.id() == "domain.self_intersection" || error.id() == "domain.zero_size_segment") << error.what();
    }
  }
  EXPECT_GT(n_built, 50);
}

TEST(DomainProperty, TheSameInputGivesTheSameDomain) {
  const auto input = domains::tilted(domains::two_material_box<3>(), 3);
  const Domain<3> a = build_domain(input), b = build_domain(input);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.segments, b.segments);
  EXPECT_EQ(a.facet_triangles, b.facet_triangles);
  EXPECT_EQ(a.wall_regions, b.wall_regions);
}

}  // namespace
}  // namespace voropack
