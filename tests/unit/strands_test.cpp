// Centers along curves that leave a point at small angles: at common distances until the curves are apart.
#include <gtest/gtest.h>

#include <cmath>

#include "packing/strands.h"
#include "support/sharp_domains.h"

namespace voropack {
namespace {

namespace sharp = test::sharp;

Spacing<2> constant_spacing(const Domain<2>& domain, double f) {
  SizeWishes<2> wishes;
  wishes.spacing = f;
  return build_spacing(domain, wishes);
}

/// Straight strands from the center of the unit square at these angles.
struct Star {
  Vec<2> tip{0.5, 0.5};
  std::vector<Strand<2>> strands;
  Tie tie;

  Star(const std::vector<double>& angles_deg, const std::vector<double>& lengths) {
    for (std::size_t i = 0; i < angles_deg.size(); ++i) {
      const Vec<2> along{std::cos(sharp::radians(angles_deg[i])), std::sin(sharp::radians(angles_deg[i]))};
      strands.push_back({.length = lengths[i],
                         .at = [t = tip, along](double s) { return t + s * along; },
                         .positions = {},
                         .kept = {}});
      tie.ends.push_back({static_cast<std::uint32_t>(i), false});
    }
    tie.angle = sharp::radians(180);
    for (StrandEnd& e : tie.ends) {
      e.angle = sharp::radians(180);
      for (std::size_t i = 0; i < angles_deg.size(); ++i)
        if (i != e.strand) e.angle = std::min(e.angle, sharp::radians(std::abs(angles_deg[i] - angles_deg[e.strand])));
      tie.angle = std::min(tie.angle, e.angle);
    }
  }
};

void expect_room(const Strand<2>& strand, const PackedStrand& packed, const Spacing<2>& spacing) {
  ASSERT_EQ(packed.position.size(), packed.radius.size());
  double last = 0, last_radius = spacing(strand.at(0));
  for (std::size_t k = 0; k < packed.position.size(); ++k) {
    EXPECT_GT(packed.radius[k], 0);
    EXPECT_LE(packed.radius[k], spacing(strand.at(packed.position[k])) * (1 + 1e-12));
    EXPECT_GE(packed.position[k] - last, (last_radius + packed.radius[k]) * (1 - 1e-9)) << "center " << k;
    last = packed.position[k];
    last_radius = packed.radius[k];
  }
  EXPECT_GE(strand.length - last, (last_radius + spacing(strand.at(strand.length))) * (1 - 1e-9));
}

TEST(Strands, AloneTakeEqualSteps) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.011);
  const Star star({0, 5}, {0.4, 0.3});
  const auto packed = pack_strands<2>(star.strands, {}, spacing, kTieJitter, 1);
  for (std::size_t i = 0; i < 2; ++i) {
    expect_room(star.strands[i], packed[i], spacing);
    EXPECT_EQ(packed[i].tied_begin, 0);
    EXPECT_EQ(packed[i].tied_end, 0);
    const double step = packed[i].position[0];
    EXPECT_LT(step, 3 * 0.011);
    for (std::size_t k = 0; k < packed[i].position.size(); ++k)
      EXPECT_NEAR(packed[i].position[k], step * static_cast<double>(k + 1), 1e-12);
  }
}

TEST(Strands, TiedOnesCarryCommonDistancesUntilTheyAreApart) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const double f = 0.004;
  const Spacing<2> spacing = constant_spacing(domain, f);
  for (const double degrees : {2.0, 5.0, 20.0, 50.0}) {
    const Star star({0, degrees, 2.5 * degrees}, {0.4, 0.37, 0.31});
    const auto packed = pack_strands<2>(star.strands, {star.tie}, spacing, 0, 1);
    const std::array<double, 3> ends = {0.37, 0.37, 0.31};
    for (std::size_t i = 0; i < 3; ++i) {
      expect_room(star.strands[i], packed[i], spacing);
      const double tied = packed[i].tied_begin;
      EXPECT_GT(tied, 0);
      for (std::size_t k = 0; packed[i].position[k] < tied; ++k)
        EXPECT_EQ(packed[i].position[k], packed[1].position[k]) << degrees;
      // No longer than needed: where they go their own ways, or the shorter one ends.
      const double apart = 1.5 * f / std::sin(star.tie.ends[i].angle);
      EXPECT_LT(tied, std::min(ends[i], apart) + 3 * f) << degrees;
      EXPECT_GT(tied, std::min(ends[i] - 4 * f, apart - f)) << degrees;
    }
  }
}

/// T3: no center is in the diametral ball of another strand's piece, with the jitter or without; where the tie ends
/// because the strands are apart, nowhere.
TEST(Strands, TiedOnesDoNotEncroach) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const double f = 0.004;
  const Spacing<2> spacing = constant_spacing(domain, f);
  for (const double jitter : {0.0, kTieJitter})
    for (const double degrees : {0.5, 2.0, 5.0, 20.0, 50.0}) {
      const Star star({0, degrees, 2 * degrees}, {0.4, 0.37, 0.31});
      const auto packed = pack_strands<2>(star.strands, {star.tie}, spacing, jitter, 1);
      const bool are_apart = 1.5 * f / std::sin(sharp::radians(degrees)) < 0.3;
      std::vector<std::vector<Vec<2>>> centers(3);
      for (std::size_t i = 0; i < 3; ++i) {
        centers[i].push_back(star.tip);
        for (const double t : packed[i].position)
          if (are_apart || t <= packed[i].tied_begin) centers[i].push_back(star.strands[i].at(t));
      }
      int n_tested = 0;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          for (std::size_t k = 0; i != j && k + 1 < centers[i].size(); ++k)
            for (std::size_t l = 1; l < centers[j].size(); ++l, ++n_tested)
              EXPECT_GE(dot(centers[i][k] - centers[j][l], centers[i][k + 1] - centers[j][l]), 0)
                  << degrees << " degrees: piece " << k << " of strand " << i << ", center " << l << " of " << j;
      EXPECT_GT(n_tested, 1000);
    }
}

/// Those that are near to each other throughout, and end one after the other: each of them leaves room before its end,
/// and the others go on.
TEST(Strands, AShortOneEndsAmongOthers) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const double f = 0.004;
  const Spacing<2> spacing = constant_spacing(domain, f);
  for (const double shortest : {0.05, 0.0513, 0.0527, 0.06}) {
    const Star star({0, 0.1, 0.2, 0.3}, {0.4, shortest, 0.21, 0.4});
    const auto packed = pack_strands<2>(star.strands, {star.tie}, spacing, 0, 1);
    for (std::size_t i = 0; i < 4; ++i) {
      expect_room(star.strands[i], packed[i], spacing);
      EXPECT_GT(packed[i].tied_begin, star.strands[i].length - 5 * f);
      EXPECT_LE(packed[i].tied_begin, star.strands[i].length);
    }
  }
}

/// Two strands that are tied at both of their ends share their length between the ties.
TEST(Strands, TiedAtBothEnds) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.004);
  Star star({0, 4, 8}, {0.4, 0.4, 0.4});
  Tie far = star.tie;
  far.ends = {{0, true, star.tie.angle}, {1, true, star.tie.angle}};
  star.tie.ends = {{1, false, star.tie.angle}, {2, false, star.tie.angle}};
  const auto packed = pack_strands<2>(star.strands, {star.tie, far}, spacing, 0, 1);
  for (std::size_t i = 0; i < 3; ++i) expect_room(star.strands[i], packed[i], spacing);
  EXPECT_EQ(packed[0].tied_begin, 0);
  EXPECT_GT(packed[0].tied_end, 0);
  EXPECT_GT(packed[1].tied_begin, 0);
  EXPECT_GT(packed[1].tied_end, 0);
  EXPECT_LE(packed[1].tied_begin + packed[1].tied_end, 0.4);
  EXPECT_EQ(packed[2].tied_end, 0);
}

/// A tie at a tiny angle may have what one at a wide angle leaves: most of a strand.
TEST(Strands, ATieTakesWhatTheOtherDoesNotWant) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.004);
  Star star({0, 0.1, 0.2}, {0.4, 0.4, 0.4});
  Tie far;
  far.angle = sharp::radians(50);
  far.ends = {{0, true, far.angle}, {1, true, far.angle}};
  star.tie.ends = {{1, false, star.tie.angle}, {2, false, star.tie.angle}};
  const auto packed = pack_strands<2>(star.strands, {star.tie, far}, spacing, 0, 1);
  for (std::size_t i = 0; i < 3; ++i) expect_room(star.strands[i], packed[i], spacing);
  EXPECT_GT(packed[1].tied_begin, 0.9 * 0.4);
  EXPECT_GT(packed[1].tied_end, 0.004);
}

TEST(Strands, AStepIsNoLongerThanAsked) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.2);
  Star star({0}, {0.45});
  EXPECT_TRUE(pack_strands<2>(star.strands, {}, spacing, 0, 1)[0].position.size() <= 1U);
  star.strands[0].longest_step = 0.1;
  EXPECT_EQ(pack_strands<2>(star.strands, {}, spacing, 0, 1)[0].position.size(), 4U);
}

/// What is far from all others in angle goes its own way sooner, and does not keep the others from being tied.
TEST(Strands, AWideOneLeavesSooner) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.01);
  Star star({0, 5, 80}, {0.4, 0.4, 0.4});
  const auto packed = pack_strands<2>(star.strands, {star.tie}, spacing, 0, 1);
  ASSERT_FALSE(packed[2].position.empty());
  EXPECT_EQ(packed[2].position[0], packed[0].position[0]);
  EXPECT_LT(packed[2].tied_begin, 0.25 * packed[0].tied_begin);
  EXPECT_EQ(packed[0].tied_begin, packed[1].tied_begin);
  for (std::size_t i = 0; i < 3; ++i) expect_room(star.strands[i], packed[i], spacing);
}

/// Where f is small on one of two strands, the steps of the other one grow from there as f may grow.
TEST(Strands, StepsGrowFromTiedSpheres) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Star star({0, 10}, {0.45, 0.15});
  // Around the end of the shorter one, but not on the longer one.
  const Spacing<2> spacing = constant_spacing(domain, 0.08).with_caps({{star.strands[1].at(0.1), 0.03, 0.001}});
  const auto packed = pack_strands<2>(star.strands, {star.tie}, spacing, 0, 1);
  const auto& p = packed[0];
  for (std::size_t k = 0; k + 1 < p.position.size(); ++k)
    EXPECT_LE(p.position[k + 1] - p.position[k], 8 * p.radius[k]) << k;
}

/// Where steps need not follow f, they are as long as asked for.
TEST(Strands, StepsAreAtLeastAsLongAsAskedFor) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> spacing = constant_spacing(domain, 0.01);
  Star star({0}, {0.4});
  star.strands[0].least_step = 0.1;
  const auto packed = pack_strands<2>(star.strands, {}, spacing, 0, 1);
  EXPECT_EQ(packed[0].position.size(), 3U);
  for (const double r : packed[0].radius) EXPECT_DOUBLE_EQ(r, 0.01);
}

/// f falls around one strand, a tie gets one more, another tie is new: round by round.
TEST(Strands, PackedAgainAreAsPackedAtOnce) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const Spacing<2> given = constant_spacing(domain, 0.01);
  const Star star({0, 10, 20, 80, 170}, {0.4, 0.37, 0.31, 0.45, 0.35});
  const auto tie_of = [&](std::vector<std::uint32_t> members, double angle_deg) {
    Tie tie{{}, sharp::radians(angle_deg), 0};
    for (const std::uint32_t m : members) tie.ends.push_back({m, false, sharp::radians(angle_deg)});
    return tie;
  };
  const auto cap_at = [&](std::size_t strand, double t, double value) {
    return SpacingCap<2>{star.strands[strand].at(t), 0.01, value};
  };
  struct Step {
    std::vector<Tie> ties;
    std::vector<SpacingCap<2>> caps;
    std::vector<std::uint8_t> is_new, expected;
  };
  const Tie two = tie_of({0, 1}, 10), three = tie_of({0, 1, 2}, 10);
  const SpacingCap<2> far = cap_at(4, 0.3, 0.006), near = cap_at(1, 0.2, 0.004);
  const std::vector<Step> steps = {{{two}, {}, {1, 1, 1, 1, 1}, {1, 1, 1, 1, 1}},
                                   {{two}, {}, {0, 0, 0, 0, 0}, {0, 0, 0, 0, 0}},
                                   {{two}, {far}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 1}},
                                   {{three}, {far}, {0, 0, 0, 0, 0}, {1, 1, 1, 0, 0}},
                                   {{three}, {far, near}, {0, 1, 1, 0, 0}, {1, 1, 1, 0, 0}}};
  StrandPacker<2> packer(kTieJitter, 1);
  for (const Step& step : steps) {
    const Spacing<2> spacing = given.with_caps(step.caps);
    std::vector<std::uint8_t> is_new = step.is_new;
    packer.pack(star.strands, step.ties, spacing, is_new);
    EXPECT_EQ(is_new, step.expected);
    const auto at_once = pack_strands<2>(star.strands, step.ties, spacing, kTieJitter, 1);
    for (std::size_t i = 0; i < at_once.size(); ++i) {
      EXPECT_EQ(packer.packed()[i].position, at_once[i].position) << i;
      EXPECT_EQ(packer.packed()[i].radius, at_once[i].radius) << i;
    }
  }
}

}  // namespace
}  // namespace voropack
