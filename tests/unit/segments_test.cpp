// Spheres along segments from round to round: what is packed again, and that it does not show in the result.
#include <gtest/gtest.h>

#include <vector>

#include "base/random.h"
#include "packing/segments.h"
#include "support/curved_domains.h"
#include "support/sharp_domains.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

namespace sharp = test::sharp;

template <int D>
void expect_same(const Domain<D>& domain, const SegmentPacker<D>& a, const SegmentPacker<D>& b) {
  for (const PointId p : ids(domain.points)) ASSERT_EQ(a.f_at(p), b.f_at(p)) << "point " << p.value();
  for (const SegmentId s : ids(domain.segments)) {
    const auto &of_a = a.centers(s), &of_b = b.centers(s);
    ASSERT_EQ(of_a.size(), of_b.size()) << "segment " << s.value();
    for (std::size_t k = 0; k < of_a.size(); ++k) {
      ASSERT_EQ(of_a[k].position, of_b[k].position) << "segment " << s.value();
      ASSERT_EQ(of_a[k].radius, of_b[k].radius) << "segment " << s.value();
      ASSERT_EQ(of_a[k].f, of_b[k].f) << "segment " << s.value();
    }
  }
}

/// Rounds in which f shrinks at random places, and segments are tied, corners opened and segments shaken at random.
template <int D>
void expect_same_over_rounds(const DomainInput<D>& input, PackingForm form, double size, std::uint64_t seed) {
  const Domain<D> domain = build_domain(input);
  SizeWishes<D> wishes;
  wishes.size = size;
  const Spacing<D> given = build_spacing(domain, wishes);
  PackingOptions options;
  options.form = form;
  const Observer& observer = silent_observer();
  Protection<D> protection(domain);
  SegmentPacker<D> packer(options, observer);
  Random random(seed);
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random.bits() % n); };
  std::vector<SpacingCap<D>> caps, lowered;
  std::size_t n_reused = 0, n_packed = 0;
  for (int round = 0; round < 12; ++round) {
    const Spacing<D> f = caps.empty() ? given : given.with_caps(caps);
    packer.pack(protection, f, lowered);
    SegmentPacker<D> fresh(options, observer);
    fresh.pack(protection, f, {});
    expect_same(domain, packer, fresh);
    if (round > 0)
      for (const SegmentId s : ids(domain.segments)) ++(packer.is_new(s) ? n_packed : n_reused);

    lowered.clear();
    for (std::size_t i = pick(3); i > 0; --i) {
      const auto [a, b] = domain.segments[SegmentId(pick(domain.segments.size()))];
      const Vec<D> x = domain.points[a] + random.unit() * (domain.points[b] - domain.points[a]);
      const double here = f(x);
      lowered.push_back({x, random.unit() * here, (0.4 + 0.5 * random.unit()) * here});
    }
    caps.insert(caps.end(), lowered.begin(), lowered.end());
    const PointId p(pick(domain.points.size()));
    const auto around = protection.incidence.segments_at(p);
    if (around.size() > 1 && round % 2 == 0) protection.fans.join(p, around[0], around[1 + pick(around.size() - 1)]);
    if (round % 3 == 1) {
      double radius = 2 * f(domain.points[p]);
      for (const SegmentId s : around)
        radius = std::min(radius,
                          0.3 * distance(domain.points[domain.segments[s][0]], domain.points[domain.segments[s][1]]));
      protection.corners.emplace(p, radius);
    }
    if (round % 4 == 2) protection.shaken.insert(SegmentId(pick(domain.segments.size())));
    if (round % 5 == 3) {
      const SegmentId s(pick(domain.segments.size()));
      packer.pack_again(s);
    }
  }
  EXPECT_GT(n_packed, 0U);
  EXPECT_GT(n_reused, 0U);
}

TEST(Segments, PackedAgainWhereSomethingChangedAreAsPackedAtOnce) {
  for (const PackingForm form : {PackingForm::kVoronoi, PackingForm::kMaximal})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      expect_same_over_rounds(domains::spheroid(1, 1.7), form, 0.2, seed);
      expect_same_over_rounds(sharp::fan(5, 8).input, form, 0.02, seed);
    }
}

TEST(Segments, NothingIsPackedAgainWhereNothingChanged) {
  const Domain<3> domain = build_domain(domains::spheroid(1, 1));
  const Spacing<3> f = build_spacing(domain, {});
  const PackingOptions options;
  const Observer& observer = silent_observer();
  const Protection<3> protection(domain);
  SegmentPacker<3> packer(options, observer);
  packer.pack(protection, f, {});
  for (const SegmentId s : ids(domain.segments)) EXPECT_TRUE(packer.is_new(s));
  packer.pack_again(SegmentId(7));
  packer.pack(protection, f, {});
  for (const SegmentId s : ids(domain.segments)) EXPECT_EQ(packer.is_new(s), s == SegmentId(7));
}

}  // namespace
}  // namespace voropack
