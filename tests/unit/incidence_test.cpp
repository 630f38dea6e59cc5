// Which polytopes meet, where, and at what angle.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "packing/incidence.h"
#include "support/sharp_domains.h"

namespace voropack {
namespace {

using std::numbers::pi;
namespace sharp = test::sharp;

Domain<3> domain_of(const DomainInput<3>& input) { return build_domain(input); }

/// The segment between two points given by position.
template <int D>
SegmentId segment_between(const Domain<D>& domain, const Vec<D>& a, const Vec<D>& b) {
  for (const SegmentId s : ids(domain.segments)) {
    const Vec<D> p = domain.points[domain.segments[s][0]], q = domain.points[domain.segments[s][1]];
    if ((p == a && q == b) || (p == b && q == a)) return s;
  }
  return SegmentId::none();
}

TEST(Incidence, OfACube) {
  const Domain<3> domain = domain_of(domains::unit_cube());
  const Incidence<3> incidence(domain);
  for (const PointId p : ids(domain.points)) {
    EXPECT_EQ(incidence.segments_at(p).size(), 3U);
    EXPECT_EQ(incidence.facets_at(p).size(), 3U);
  }
  for (const SegmentId s : ids(domain.segments)) {
    const auto pages = incidence.pages_of(s);
    ASSERT_EQ(pages.size(), 2U);
    EXPECT_NE(pages[0].facet, pages[1].facet);
    const auto shared = incidence.common_segments(pages[0].facet, pages[1].facet);
    EXPECT_EQ(shared, std::vector<SegmentId>{s});
    EXPECT_TRUE(incidence.contains(PolytopeId(pages[0].facet), PolytopeId(s)));
    EXPECT_FALSE(incidence.contains(PolytopeId(s), PolytopeId(pages[0].facet)));
    EXPECT_NEAR(*incidence.meeting_angle(PolytopeId(pages[0].facet), PolytopeId(pages[1].facet)), pi / 2, 1e-14);
    EXPECT_FALSE(incidence.meeting_angle(PolytopeId(pages[0].facet), PolytopeId(s)));
  }
  // Opposite facets do not meet.
  EXPECT_TRUE(incidence.common_points(PolytopeId(FacetId(0)), PolytopeId(FacetId(1))).empty());
  EXPECT_FALSE(incidence.meeting_angle(PolytopeId(FacetId(0)), PolytopeId(FacetId(1))));
}

TEST(Incidence, PagesAreTheSidesOfASegment) {
  const Domain<3> wall = domain_of(domains::box_with_internal_wall<3>());
  const Incidence<3> of_wall(wall);
  const SegmentId rim = segment_between<3>(wall, {0.5, 0.3, 0.3}, {0.5, 0.7, 0.3});
  ASSERT_FALSE(rim.is_none());
  EXPECT_EQ(of_wall.pages_of(rim).size(), 1U);

  const Domain<3> marked = domain_of(domains::box_with_marked_facet());
  const Incidence<3> of_marked(marked);
  const SegmentId inside = segment_between<3>(marked, {0.3, 0.3, 1}, {0.7, 0.3, 1});
  ASSERT_FALSE(inside.is_none());
  const auto pages = of_marked.pages_of(inside);
  ASSERT_EQ(pages.size(), 2U);
  EXPECT_EQ(pages[0].facet, pages[1].facet);
  EXPECT_NE(pages[0].side, pages[1].side);
  EXPECT_NEAR(norm(of_marked.inward(pages[0], inside) + of_marked.inward(pages[1], inside)), 0, 1e-15);
}

/// Every page lies where `inward` points: there, and not on the other side, the facet has triangles.
TEST(Incidence, InwardPointsIntoThePage) {
  for (const auto& input : {domains::unit_cube(), domains::l_shape<3>(), sharp::skew_wedge(20).input,
                            sharp::equal_book(5).input, domains::tilted(sharp::pyramid(7, 30).input)}) {
    const Domain<3> domain = domain_of(input);
    const Incidence<3> incidence(domain);
    for (const SegmentId s : ids(domain.segments)) {
      const auto [a, b] = domain.segments[s];
      const Vec<3> axis = domain.points[b] - domain.points[a];
      for (const Page& page : incidence.pages_of(s)) {
        const Vec<3> inward = incidence.inward(page, s);
        EXPECT_NEAR(norm(inward), 1, 1e-14);
        EXPECT_NEAR(dot(inward, axis), 0, 1e-14);
        int n_triangles = 0;
        for (const auto& t : domain.facet_triangles[page.facet]) {
          if (std::ranges::count(t, a) == 0 || std::ranges::count(t, b) == 0) continue;
          for (const PointId p : t)
            if (p != a && p != b && dot(domain.points[p] - domain.points[a], inward) > 0) ++n_triangles;
        }
        EXPECT_EQ(n_triangles, 1);
      }
    }
  }
}

TEST(Incidence, SectorsOfACorner) {
  const auto angle_of = [](const Sector& s) { return s.end - s.begin; };
  const Domain<3> cube = domain_of(domains::unit_cube());
  const Incidence<3> of_cube(cube);
  for (const FacetId f : ids(cube.facet_frame))
    for (const PointId p : cube.facet_points[f]) {
      const auto sectors = of_cube.sectors(f, p);
      ASSERT_EQ(sectors.size(), 1U);
      EXPECT_NEAR(angle_of(sectors[0]), pi / 2, 1e-14);
      EXPECT_NE(sectors[0].first, sectors[0].second);
      // From the first segment counterclockwise to the second one.
      const PlaneFrame& frame = cube.facet_frame[f];
      for (const auto& [segment, angle] :
           {std::pair(sectors[0].first, sectors[0].begin), std::pair(sectors[0].second, sectors[0].end)}) {
        const Vec<3> along = std::cos(angle) * frame.u + std::sin(angle) * frame.v;
        EXPECT_NEAR(distance(along, of_cube.direction(segment, p)), 0, 1e-14);
      }
    }

  const Domain<3> l_shape = domain_of(domains::l_shape<3>());
  const Incidence<3> of_l(l_shape);
  int n_reentrant = 0;
  for (const FacetId f : ids(l_shape.facet_frame))
    for (const PointId p : l_shape.facet_points[f])
      for (const Sector& s : of_l.sectors(f, p)) n_reentrant += std::abs(angle_of(s) - 1.5 * pi) < 1e-12 ? 1 : 0;
  EXPECT_EQ(n_reentrant, 2);

  // In the top facet: a segment that ends inside has the whole turn around its end, and so has a point alone.
  const Domain<3> marked = domain_of(domains::box_with_marked_facet());
  const Incidence<3> of_marked(marked);
  for (const PointId p : ids(marked.points)) {
    const Vec<3>& x = marked.points[p];
    if (x == Vec<3>{0.3, 0.3, 1} || x == Vec<3>{0.5, 0.7, 1}) {
      const FacetId top = of_marked.facets_at(p)[0];
      const auto sectors = of_marked.sectors(top, p);
      ASSERT_EQ(sectors.size(), 1U);
      EXPECT_NEAR(angle_of(sectors[0]), 2 * pi, 1e-14);
      EXPECT_EQ(sectors[0].first, sectors[0].second);
      EXPECT_EQ(sectors[0].first.is_none(), x == (Vec<3>{0.5, 0.7, 1}));
    }
  }
}

TEST(Incidence, MeetingAnglesOfWedgesAndFans) {
  for (const double degrees : {1.0, 20.0, 61.0, 89.0}) {
    const Domain<3> wedge = domain_of(sharp::skew_wedge(degrees).input);
    const Incidence<3> incidence(wedge);
    const SegmentId spine = segment_between<3>(wedge, {0, 0, 0}, {0, 1, 0});
    const auto pages = incidence.pages_of(spine);
    ASSERT_EQ(pages.size(), 2U);
    const PolytopeId f(pages[0].facet), g(pages[1].facet);
    EXPECT_NEAR(*incidence.meeting_angle(f, g), sharp::radians(degrees), 1e-13);
    EXPECT_EQ(incidence.form_sharp_feature(f, g), degrees < 60);

    const Domain<2> fan = build_domain(sharp::fan(3, degrees / 2).input);
    const Incidence<2> of_fan(fan);
    std::vector<double> angles;
    for (const SegmentId s : ids(fan.segments))
      for (const SegmentId t : ids(fan.segments))
        if (s < t &&
            std::ranges::count(fan.segments[s], PointId(4)) + std::ranges::count(fan.segments[t], PointId(4)) == 2)
          angles.push_back(*of_fan.meeting_angle(PolytopeId(s), PolytopeId(t)));
    std::sort(angles.begin(), angles.end());
    ASSERT_EQ(angles.size(), 3U);
    EXPECT_NEAR(angles[0], sharp::radians(degrees / 2), 1e-13);
    EXPECT_NEAR(angles[2], sharp::radians(degrees), 1e-13);
  }
}

TEST(Incidence, SegmentsMeetFacetsAtTheNearestDirection) {
  auto input = domains::unit_cube();
  const double angle = sharp::radians(40);
  const auto a = domains::add_point<3>(input, {0.5, 0.5, 0});
  domains::add_segment(input, a,
                       domains::add_point<3>(input, {0.5 + 0.3 * std::cos(angle), 0.5, 0.3 * std::sin(angle)}));
  const Domain<3> domain = domain_of(input);
  const Incidence<3> incidence(domain);
  const PolytopeId segment(segment_between<3>(domain, input.points[8], input.points[9]));
  const PolytopeId facet(incidence.facets_at(PointId(8))[0]);
  EXPECT_NEAR(*incidence.meeting_angle(segment, facet), angle, 1e-14);
  EXPECT_TRUE(incidence.form_sharp_feature(segment, facet));
}

/// Facets that have one point in common: no two directions of them are nearer than the angle, and some nearly are.
TEST(Incidence, MeetingAnglesAgreeWithSampledDirections) {
  const Domain<3> domain = domain_of(sharp::heap<3>(9, 0.6, 3).input);
  const Incidence<3> incidence(domain);
  constexpr int kSamples = 60;
  const auto directions = [&](FacetId f, PointId p) {
    std::vector<Vec<3>> result;
    for (const Sector& s : incidence.sectors(f, p))
      for (int i = 0; i <= kSamples; ++i) {
        const double angle = s.begin + (s.end - s.begin) * i / kSamples;
        result.push_back(std::cos(angle) * domain.facet_frame[f].u + std::sin(angle) * domain.facet_frame[f].v);
      }
    return result;
  };
  int n_pairs = 0;
  for (const FacetId f : ids(domain.facet_frame))
    for (const FacetId g : ids(domain.facet_frame)) {
      const auto common = incidence.common_points(PolytopeId(f), PolytopeId(g));
      if (!(f < g) || common.size() != 1) continue;
      ++n_pairs;
      double least = pi;
      for (const Vec<3>& u : directions(f, common[0]))
        for (const Vec<3>& v : directions(g, common[0])) least = std::min(least, std::acos(std::min(1.0, dot(u, v))));
      const double angle = *incidence.meeting_angle(PolytopeId(f), PolytopeId(g));
      EXPECT_LE(angle, least + 1e-7);
      EXPECT_GE(angle, least - pi / kSamples);
    }
  EXPECT_GT(n_pairs, 5);
}

}  // namespace
}  // namespace voropack
