// What keeps protecting balls empty in space and what the verify-and-adapt loop answers: zones of books, groups,
// protection.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

#include "packing/book.h"
#include "packing/protection.h"
#include "support/sharp_domains.h"

namespace voropack {
namespace {

namespace sharp = test::sharp;

template <int D>
Spacing<D> constant_spacing(const Domain<D>& domain, double f) {
  SizeWishes<D> wishes;
  wishes.spacing = f;
  return build_spacing(domain, wishes);
}

/// Makes books of all pages of every segment.
void bind_all(Protection<3>& protection) {
  for (const SegmentId s : ids(protection.domain().segments)) {
    const auto pages = protection.incidence.pages_of(s);
    for (std::size_t i = 1; i < pages.size(); ++i) protection.books.join(s, pages[0], pages[i]);
  }
}

/// All zones of a facet's segments, each with all pages of its segment.
std::vector<BookZone> zones_of(const Protection<3>& protection, FacetId facet) {
  const Domain<3>& domain = protection.domain();
  const Spacing<3> spacing = constant_spacing<3>(domain, 0.02);
  std::vector<BookZone> zones;
  for (const SegmentId s : domain.facet_segments[facet]) {
    const auto pages = protection.incidence.pages_of(s);
    zones.emplace_back(domain, protection, spacing, s, BookLevel{{pages.begin(), pages.end()}});
  }
  return zones;
}

template <class Test>
void for_each_sampled_point(const Domain<3>& domain, FacetId facet, Test&& test) {
  Random random(1);
  for (const auto& t : domain.facet_triangles[facet])
    for (int i = 0; i < 2000; ++i) {
      double u = random.unit(), v = random.unit();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec<3> a = domain.points[t[0]], b = domain.points[t[1]], c = domain.points[t[2]];
      test(a + u * (b - a) + v * (c - a));
    }
}

std::size_t page_on(const BookZone& zone, FacetId facet) {
  std::size_t k = 0;
  while (zone.pages()[k].facet != facet) ++k;
  return k;
}

TEST(BookZone, ZonesOfOneFacetAreDisjoint) {
  for (const auto& input :
       {sharp::wedge(20).input, sharp::skew_wedge(5).input, sharp::pyramid(5, 30).input, domains::l_shape<3>()}) {
    const Domain<3> domain = build_domain(input);
    Protection<3> protection(domain);
    bind_all(protection);
    for (const FacetId f : ids(domain.facet_frame)) {
      const std::vector<BookZone> zones = zones_of(protection, f);
      int n_held = 0;
      for_each_sampled_point(domain, f, [&](const Vec<3>& x) {
        int n = 0;
        for (const BookZone& z : zones) n += z.holds(z.to_page(page_on(z, f), x)) ? 1 : 0;
        EXPECT_LE(n, 1);
        n_held += n;
      });
      EXPECT_GT(n_held, 100);
    }
  }
}

TEST(BookZone, HoldsEverythingBelowWhatItHolds) {
  const Domain<3> domain = build_domain(sharp::skew_wedge(10).input);
  const Protection<3> protection(domain);
  Random random(2);
  for (const FacetId f : ids(domain.facet_frame))
    for (const BookZone& z : zones_of(protection, f)) {
      EXPECT_GT(z.largest_height(), 0);
      for (int i = 0; i < 500; ++i) {
        const double s = z.length() * random.unit(), y = 1.2 * z.largest_height() * random.unit();
        if (!z.holds({s, y})) continue;
        EXPECT_LE(y, z.largest_height());
        for (int k = 0; k < 10; ++k) EXPECT_TRUE(z.holds({s, 0.1 * k * y}));
      }
      EXPECT_FALSE(z.holds({0.5 * z.length(), -1e-9}));
      EXPECT_FALSE(z.holds({-1e-9, 0}));
      EXPECT_FALSE(z.holds({0.5 * z.length(), 1.001 * z.largest_height()}));
    }
}

/// Pages are turned into each other: the same place of a page is at the same distances from the spine and its ends, and
/// it lies on the facet, inside.
TEST(BookZone, PagesAreTurnedAboutTheSpine) {
  const Domain<3> domain = build_domain(domains::tilted(sharp::random_book(5, 5, 3).input, 4));
  const Protection<3> protection(domain);
  Random random(3);
  for (const SegmentId spine : ids(domain.segments)) {
    const auto pages = protection.incidence.pages_of(spine);
    if (pages.size() != 5) continue;
    const BookZone z(domain, protection, constant_spacing<3>(domain, 0.02), spine, {{pages.begin(), pages.end()}});
    const Vec<3> a = domain.points[domain.segments[spine][0]], b = domain.points[domain.segments[spine][1]];
    for (int i = 0; i < 200; ++i) {
      const Vec<2> x{z.length() * random.unit(), z.largest_height() * random.unit()};
      for (std::size_t k = 0; k < 5; ++k) {
        const Vec<3> p = z.from_page(k, x);
        EXPECT_NEAR(distance(p, a), norm(x), 1e-12);
        EXPECT_NEAR(distance(p, b), norm(x - Vec<2>{z.length(), 0.0}), 1e-12);
        EXPECT_NEAR(domain.facet_frame[pages[k].facet].height(p), 0, 1e-12);
        EXPECT_NEAR(distance(z.to_page(k, p), x), 0, 1e-12);
      }
    }
  }
}

TEST(BookZone, KeepsClearOfCorners) {
  const Domain<3> domain = build_domain(sharp::wedge(20).input);
  Protection<3> protection(domain);
  const SegmentId spine(0);
  const auto pages = protection.incidence.pages_of(spine);
  protection.corners[domain.segments[spine][0]] = 0.2;
  const BookZone z(domain, protection, constant_spacing<3>(domain, 0.02), spine, {{pages.begin(), pages.end()}});
  EXPECT_FALSE(z.holds({0.19, 0.0}));
  EXPECT_FALSE(z.holds({0.15, 0.1}));
  EXPECT_TRUE(z.holds({0.21, 0.0}));
  EXPECT_TRUE(z.holds({z.length() - 0.01, 0.0}));
}

/// A book of a box, at these angles, with its only spine.
struct OneBook {
  explicit OneBook(const std::vector<double>& angles)
      : domain(build_domain(domains::tilted(sharp::book(angles, "").input, 7))), protection(domain) {
    for (const SegmentId s : ids(domain.segments))
      if (protection.incidence.pages_of(s).size() == angles.size()) spine = s;
  }
  [[nodiscard]] std::vector<BookLevel> levels() const {
    const auto pages = protection.incidence.pages_of(spine);
    return levels_of_book(protection, spine, {pages.begin(), pages.end()});
  }
  [[nodiscard]] double angle(const Page& p, const Page& q) const { return protection.least_angle(spine, {p, q}); }

  Domain<3> domain;
  Protection<3> protection;
  SegmentId spine;
};

TEST(BookLevels, HoldTheirPagesApartAndGoOnUntilEachIsAlone) {
  Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> angles = {0};
    while (angles.size() < 3U + static_cast<std::size_t>(trial) % 8)
      angles.push_back(angles.back() + 0.5 + 40 * std::pow(random.unit(), 3));
    const OneBook book(angles);
    const std::vector<BookLevel> levels = book.levels();
    ASSERT_FALSE(levels.empty());
    EXPECT_EQ(levels[0].pages.size(), angles.size());
    std::vector<std::map<Page, std::size_t>> child_of(levels.size());  // By level: which child holds a page.
    for (std::size_t i = 1; i < levels.size(); ++i) {
      ASSERT_LT(*levels[i].parent, i);
      EXPECT_EQ(levels[i].depth, levels[*levels[i].parent].depth + 1);
      EXPECT_LT(levels[i].angle, levels[*levels[i].parent].angle);
      for (const Page& p : levels[i].pages) {
        EXPECT_EQ(std::ranges::count(levels[*levels[i].parent].pages, p), 1);
        EXPECT_TRUE(child_of[*levels[i].parent].emplace(p, i).second);
      }
    }
    for (std::size_t i = 0; i < levels.size(); ++i)
      for (const Page& p : levels[i].pages)
        for (const Page& q : levels[i].pages) {
          const auto a = child_of[i].find(p), b = child_of[i].find(q);
          const bool go_on = a != child_of[i].end() && b != child_of[i].end() && a->second == b->second;
          if (p != q && !go_on) {
            EXPECT_GE(book.angle(p, q), levels[i].angle * (1 - 1e-9));
          }
        }
  }
}

TEST(BookLevels, EqualAnglesAreOneLevel) {
  EXPECT_EQ(OneBook({0, 30, 60, 90, 120}).levels().size(), 1U);
  EXPECT_EQ(OneBook({0, 2, 60, 62, 180}).levels().size(), 4U);  // 180 from the rest, 60 apart, and both pairs.
}

TEST(BookLevels, TheirZonesAreDisjointAndAsHighAsTheirAngleNeeds) {
  const OneBook book({0, 2, 50, 53});
  constexpr double f = 0.004;
  const Spacing<3> spacing = constant_spacing<3>(book.domain, f);
  std::vector<std::unique_ptr<BookZone>> zones;
  const std::vector<BookLevel> levels = book.levels();
  ASSERT_EQ(levels.size(), 3U);
  for (const BookLevel& level : levels)
    zones.push_back(std::make_unique<BookZone>(book.domain, book.protection, spacing, book.spine, level,
                                               level.parent ? zones[*level.parent].get() : nullptr));
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    const Vec<2> x{zones[0]->length() * (0.3 + 0.4 * random.unit()), 0.3 * random.unit()};
    for (std::size_t k = 0; k < zones.size(); ++k) {
      const double sine = std::sin(levels[k].angle / 2), needed = f * (1 + std::sqrt(1 + 1 / (sine * sine)));
      const bool below = levels[k].parent && zones[*levels[k].parent]->holds(x);
      if (x[1] <= needed) {
        EXPECT_EQ(zones[k]->holds(x), !below);
      }
      if (x[1] > 1.5 * needed || below) {
        EXPECT_FALSE(zones[k]->holds(x));
      }
      const Vec<2> side{f, f};
      const Box<2> box(x - side, x + side);
      if (zones[k]->misses(box)) {
        for (int j = 0; j < 20; ++j)
          EXPECT_FALSE(zones[k]->holds(box.lo + Vec<2>{2 * f * random.unit(), 2 * f * random.unit()}));
      }
    }
  }
}

TEST(Groups, JoinIsAnEquivalence) {
  Groups<int, int> groups;
  EXPECT_EQ(groups.of(1), nullptr);
  EXPECT_TRUE(groups.join(1, 5, 3));
  EXPECT_FALSE(groups.join(1, 3, 5));
  EXPECT_TRUE(groups.join(1, 7, 8));
  EXPECT_FALSE(groups.joined(1, 5, 8));
  EXPECT_TRUE(groups.join(1, 8, 3));
  for (const int a : {3, 5, 7, 8})
    for (const int b : {3, 5, 7, 8})
      if (a != b) {
        EXPECT_TRUE(groups.joined(1, a, b));
        EXPECT_FALSE(groups.join(1, a, b));
      }
  EXPECT_FALSE(groups.joined(2, 3, 5)) << "another key";
  ASSERT_NE(groups.of(1), nullptr);
  EXPECT_EQ(*groups.of(1), (std::vector<std::vector<int>>{{3, 5, 7, 8}}));
}

/// First something is protected; within one round this is answer enough; if it fails again, f shrinks.
TEST(Protection, TiesSegmentsBeforeItShrinksF) {
  const Domain<2> domain = build_domain(sharp::fan(2, 5).input);
  const Spacing<2> spacing = constant_spacing<2>(domain, 0.05);
  Protection<2> protection(domain);
  std::vector<SegmentId> fan;
  for (const SegmentId s : protection.incidence.segments_at(PointId(4))) fan.push_back(s);
  ASSERT_EQ(fan.size(), 2U);
  const Vec<2> x = 0.4 * protection.incidence.direction(fan[1], PointId(4));
  const Vec<2> c = 0.4 * protection.incidence.direction(fan[0], PointId(4));
  const Intrusion<2> intrusion{x, PolytopeId(fan[1]), {c, 0.06}, PolytopeId(fan[0]), c, {}, {}};
  protection.begin_round();
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(protection.adapt(intrusion, spacing));
    EXPECT_TRUE(protection.fans.joined(PointId(4), fan[0], fan[1]));
  }
  protection.begin_round();
  const auto cap = protection.adapt(intrusion, spacing);
  ASSERT_TRUE(cap);
  EXPECT_LT(cap->value, spacing(cap->center));
  EXPECT_GT(cap->value, 0);
}

TEST(Protection, MakesBooksOfPagesThenCornersThenShrinksF) {
  const Domain<3> domain = build_domain(sharp::wedge(10).input);
  const Spacing<3> spacing = constant_spacing<3>(domain, 0.05);
  Protection<3> protection(domain);
  const SegmentId spine = [&] {
    for (const SegmentId s : ids(domain.segments))
      if (protection.least_angle(
              s, {protection.incidence.pages_of(s).begin(), protection.incidence.pages_of(s).end()}) < 0.2)
        return s;
    return SegmentId::none();
  }();
  ASSERT_FALSE(spine.is_none());
  const auto pages = protection.incidence.pages_of(spine);
  const Vec<3> start = domain.points[domain.segments[spine][0]];
  const Vec<3> along = protection.incidence.direction(spine, domain.segments[spine][0]);
  // Near an end of the spine.
  const auto at = [&](const Page& p) { return start + 0.1 * along + 0.2 * protection.incidence.inward(p, spine); };
  const Intrusion<3> intrusion{
      at(pages[1]), PolytopeId(pages[1].facet), {at(pages[0]), 0.07}, PolytopeId(pages[0].facet), start, {}, {}};
  protection.begin_round();
  EXPECT_FALSE(protection.adapt(intrusion, spacing));
  EXPECT_TRUE(protection.books.joined(spine, pages[0], pages[1]));
  EXPECT_TRUE(protection.corners.empty());
  // Then traces, two at each end of the spine, though there is no room for them here.
  for (int end = 0; end < 2; ++end) {
    protection.begin_round();
    EXPECT_FALSE(protection.adapt(intrusion, spacing));
    EXPECT_TRUE(protection.corners.empty());
    protection.add_traces(spacing);
    EXPECT_FALSE(protection.incidence.has_traces());
  }
  protection.begin_round();
  EXPECT_FALSE(protection.adapt(intrusion, spacing));
  EXPECT_EQ(protection.corners.size(), 1U);
  EXPECT_GT(protection.corner_radius(domain.segments[spine][0]), 0);
  EXPECT_EQ(protection.corner_radius(domain.segments[spine][1]), 0);
  protection.begin_round();
  // The other end is within reach too, until nothing is left to protect.
  std::optional<SpacingCap<3>> cap = protection.adapt(intrusion, spacing);
  for (int round = 0; round < 2 && !cap; ++round) {
    protection.begin_round();
    cap = protection.adapt(intrusion, spacing);
  }
  ASSERT_TRUE(cap);
  EXPECT_LT(cap->value, spacing(cap->center));
}

TEST(Protection, ShakesWhatIsCocircularAndShrinksFWithinAPolytope) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Spacing<3> spacing = constant_spacing<3>(domain, 0.05);
  Protection<3> protection(domain);
  const FacetId f(0);
  const SegmentId s = domain.facet_segments[f][0];
  const Vec<3> x = 0.5 * (domain.points[domain.segments[s][0]] + domain.points[domain.segments[s][1]]);
  const Vec<3> inward = protection.incidence.inward(protection.incidence.pages_of(s)[0], s);
  protection.begin_round();
  const Intrusion<3> tie{x, PolytopeId(s), {x + 0.1 * inward, 0.1}, PolytopeId(f), x + 0.2 * inward, {}, {}};
  EXPECT_FALSE(protection.adapt(tie, spacing));
  EXPECT_TRUE(protection.shaken.contains(s));
  const Intrusion<3> inside{x, PolytopeId(s), {x + 0.05 * inward, 0.1}, PolytopeId(f), x + 0.2 * inward, {}, {}};
  const auto cap = protection.adapt(inside, spacing);
  ASSERT_TRUE(cap);
  EXPECT_LT(cap->value, spacing(cap->center));
}

}  // namespace
}  // namespace voropack
