// Where segments that rise from a facet at a small angle would lie in it.
#include <gtest/gtest.h>

#include <algorithm>

#include "geom/distance.h"
#include "packing/book.h"
#include "packing/strands.h"
#include "packing/traces.h"
#include "support/sharp_domains.h"
#include "voropack/packing.h"

namespace voropack {
namespace {

namespace sharp = test::sharp;

/// A cube with a crack that rises from its bottom.
struct Crack {
  explicit Crack(double degrees, double f)
      : domain(build_domain(sharp::leaning_crack(degrees).input)), incidence(domain), spacing([&] {
          SizeWishes<3> wishes;
          wishes.spacing = f;
          return build_spacing(domain, wishes);
        }()) {
    // The crack's bottom, in which two facets share a segment at the angle, and its sides.
    for (const SegmentId s : ids(domain.segments))
      for (const Page& p : incidence.pages_of(s))
        for (const Page& q : incidence.pages_of(s))
          if (p.facet != q.facet &&
              angle_between(incidence.inward(p, s), incidence.inward(q, s)) < sharp::radians(degrees + 1)) {
            spine = s;
            if (domain.facet_segments[p.facet].size() < domain.facet_segments[q.facet].size())
              leaf = p, ground = q;
            else
              leaf = q, ground = p;
          }
  }
  [[nodiscard]] std::vector<TraceSite> sites() const {
    std::vector<TraceSite> result;
    for (const PointId tip : domain.segments[spine])
      for (const SegmentId s : incidence.segments_at(tip))
        if (s != spine && incidence.contains(PolytopeId(leaf.facet), PolytopeId(s)))
          result.push_back({tip, s, ground.facet});
    return result;
  }

  Domain<3> domain;
  Incidence<3> incidence;
  Spacing<3> spacing;
  SegmentId spine;
  Page leaf, ground;
};

TEST(Traces, OfACracksSides) {
  for (const double degrees : {1.0, 10.0, 40.0}) {
    const Crack c(degrees, 0.05);
    const auto sites = c.sites();
    ASSERT_EQ(sites.size(), 2U);
    for (const TraceSite& site : sites) {
      const auto trace = find_trace(c.domain, c.incidence, site, c.spacing);
      ASSERT_TRUE(trace) << degrees;
      EXPECT_NEAR(trace->angle, sharp::radians(degrees), 1e-12);
      EXPECT_NEAR(norm(trace->direction), 1, 1e-12);
      EXPECT_NEAR(trace->direction[2], 0, 1e-15) << "the bottom is horizontal";
      EXPECT_NEAR(dot(trace->direction, c.incidence.direction(c.spine, site.tip)), 0, 1e-12) << "as the side is";
      EXPECT_GT(trace->length, 0);
      const auto [a, b] = c.domain.segments[site.segment];
      EXPECT_LE(trace->length, distance(c.domain.points[a], c.domain.points[b]));
      // It ends where it does for a reason: the segment ends too, or is apart.
      if (trace->length < distance(c.domain.points[a], c.domain.points[b]) * (1 - 1e-9)) {
        const Vec<3> end = c.domain.points[site.tip] + trace->length * trace->direction;
        EXPECT_GE(2 * trace->length * std::sin(trace->angle / 2), kTieApart * c.spacing(end));
      }
    }
  }
}

/// T6: a center above has a power to every circle of the facet that is not behind the tip no less than the center of
/// the trace below it.
TEST(Traces, CentersAboveEncroachNoMoreThanThoseBelow) {
  const Crack c(5, 0.05);
  Random random(7);
  for (const TraceSite& site : c.sites()) {
    const auto trace = find_trace(c.domain, c.incidence, site, c.spacing);
    ASSERT_TRUE(trace);
    const Vec<3> tip = c.domain.points[site.tip], up = c.incidence.direction(site.segment, site.tip);
    const Vec<3> across = cross(Vec<3>{0, 0, 1}, trace->direction);
    for (int i = 0; i < 1000; ++i) {
      const double t = random.unit(), r = random.unit();
      const Vec<3> center = tip + random.unit() * trace->direction + (2 * random.unit() - 1) * across;
      const auto power = [&](const Vec<3>& x) { return distance_sq(x, center) - r * r; };
      EXPECT_GE(power(tip + t * up), power(tip + t * trace->direction) - 1e-14);
    }
  }
}

TEST(Traces, AreNotLaidBesideOtherSegments) {
  // A cube's edges rise from its facets at right angles.
  const Domain<3> cube = build_domain(domains::unit_cube());
  const Incidence<3> incidence(cube);
  const Spacing<3> spacing = build_spacing(cube, SizeWishes<3>{});
  for (const PointId p : ids(cube.points))
    for (const SegmentId s : incidence.segments_at(p))
      for (const FacetId f : incidence.facets_at(p))
        if (!incidence.contains(PolytopeId(f), PolytopeId(s))) {
          EXPECT_FALSE(find_trace(cube, incidence, {p, s, f}, spacing));
        }
  // A wedge's sides are as long as each other: each would lie on the other facet's side.
  const Domain<3> wedge = build_domain(sharp::wedge(5).input);
  const Incidence<3> pages(wedge);
  for (const PointId p : ids(wedge.points))
    for (const SegmentId s : pages.segments_at(p))
      for (const FacetId f : pages.facets_at(p))
        if (!pages.contains(PolytopeId(f), PolytopeId(s))) {
          EXPECT_FALSE(find_trace(wedge, pages, {p, s, f}, spacing));
        }
}

/// With the traces of its sides a crack's zone reaches to where its far side needs room.
TEST(Traces, LetBooksReachToTheSides) {
  const Crack c(5, 0.01);
  Protection<3> protection(c.domain);
  protection.books.join(c.spine, c.leaf, c.ground);
  const auto held = [&](const Protection<3>& p) {
    const BookZone zone(p.domain(), p, c.spacing, c.spine, {{c.leaf, c.ground}});
    int n = 0;
    for (int i = 0; i < 40; ++i)
      for (int k = 0; k < 40; ++k) n += zone.holds({zone.length() * (i + 0.5) / 40, 0.4 * (k + 0.5) / 40}) ? 1 : 0;
    return n / 1600.0;
  };
  const double before = held(protection);
  EXPECT_GT(before, 0.3);
  // A center of one page in a ball of the other, near either end of the spine, asks for traces of the sides.
  const auto [a, b] = c.domain.segments[c.spine];
  for (const PointId end : {a, b}) {
    const Vec<3> base = c.domain.points[end] + 0.02 * c.incidence.direction(c.spine, end);
    const auto at = [&](const Page& p) { return base + 0.2 * c.incidence.inward(p, c.spine); };
    protection.begin_round();
    EXPECT_FALSE(protection.adapt(
        {at(c.leaf), PolytopeId(c.leaf.facet), {at(c.ground), 0.03}, PolytopeId(c.ground.facet), base, {}, {}},
        c.spacing));
  }
  protection.add_traces(c.spacing);
  ASSERT_TRUE(protection.incidence.has_traces());
  EXPECT_EQ(protection.domain().segments.size(), c.domain.segments.size() + 2);
  const SegmentId trace(protection.domain().segments.size() - 1);
  EXPECT_EQ(protection.incidence.given(PolytopeId(trace)), PolytopeId(c.ground.facet));
  EXPECT_EQ(protection.incidence.pages_of(trace).size(), 2U);
  EXPECT_TRUE(protection.incidence.contains(PolytopeId(c.ground.facet), PolytopeId(trace)));
  EXPECT_GT(held(protection), before);
  // The packer finds the same by itself, and what it returns knows nothing of traces.
  const Packing<3> packing = pack(c.domain, c.spacing);
  EXPECT_EQ(find_packing_fault(packing, c.domain, c.spacing), "");
  for (const auto& s : packing.subsegments) EXPECT_LT(s.carrier.index, c.domain.segments.size());
  for (const PolytopeId p : packing.carrier)
    if (p.dimension == 1) {
      EXPECT_LT(p.index, c.domain.segments.size());
    }
}

}  // namespace
}  // namespace voropack
