// The local feature size and the geometric part of f against their definitions.
#include <gtest/gtest.h>

#include "base/random.h"
#include "support/plain_domain.h"
#include "support/point_sets.h"
#include "support/spacing_reference.h"
#include "voropack/spacing.h"

namespace voropack {
namespace {

constexpr double kRounding = 1e-12;

template <int D>
void expect_lfs_equals_all_pairs(std::uint64_t seed, int cells) {
  SCOPED_TRACE(testing::Message() << "dimension " << D << " seed " << seed);
  const Domain<D> domain = plain::random_features<D>(seed, cells);
  const LocalFeatureSize<D> lfs(domain);
  const reference::AllPairs<D> all(domain);
  Random random(seed + 100);
  for (int i = 0; i < 200; ++i) {
    const Vec<D> x = 1.5 * test::random_point<D>(random);
    const double expected = all.lfs(x);
    EXPECT_NEAR(lfs(x), expected, kRounding * expected);
  }
  for (const Vec<D>& x : domain.points) EXPECT_NEAR(lfs(x), all.lfs(x), kRounding * all.lfs(x));
}

TEST(LocalFeatureSize, EqualsBruteForceOverAllPairs) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    expect_lfs_equals_all_pairs<2>(seed, 5);
    expect_lfs_equals_all_pairs<3>(seed, 3);
  }
}

template <int D>
void expect_f_equals_all_pairs(std::uint64_t seed, int cells, double a, double b) {
  SCOPED_TRACE(testing::Message() << "dimension " << D << " seed " << seed << " a " << a << " b " << b);
  const Domain<D> domain = plain::random_features<D>(seed, cells);
  SpacingOptions options;
  options.feature_factor = a;
  options.gradation = b;
  const Spacing<D> f = build_spacing<D>(domain, {}, options);
  const reference::AllPairs<D> all(domain);
  Random random(seed + 100);
  for (int i = 0; i < 500; ++i) {
    Vec<D> x = test::random_point<D>(random);
    if (i % 10 == 0) x *= 1.5;
    const double expected = std::min(all.f(x, a, b), a * domain.diameter());
    EXPECT_NEAR(f(x), expected, kRounding * expected);
  }
}

TEST(Spacing, EqualsBruteForceOverAllPairs) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    expect_f_equals_all_pairs<2>(seed, 6, 0.45, 0.2);
    expect_f_equals_all_pairs<3>(seed, 3, 0.45, 0.2);
    expect_f_equals_all_pairs<2>(seed, 4, 0.25, 0.3);
    expect_f_equals_all_pairs<3>(seed, 3, 0.25, 0.25);
  }
}

template <int D>
void expect_lipschitz(std::uint64_t seed) {
  const Domain<D> domain = plain::random_features<D>(seed, 4);
  const Spacing<D> f = build_spacing<D>(domain, {});
  Random random(seed);
  for (int i = 0; i < 20000; ++i) {
    const Vec<D> x = 1.2 * test::random_point<D>(random);
    const double reach = std::pow(10.0, -4 * random.unit());
    const Vec<D> y = x + reach * (test::random_point<D>(random) - test::random_point<D>(random));
    const double fx = f(x);
    ASSERT_LE(std::abs(fx - f(y)), f.lipschitz() * distance(x, y) + 1e-14) << "seed " << seed;
  }
}

TEST(Spacing, IsLipschitzAcrossLeavesAndOutsideTheBox) {
  expect_lipschitz<2>(1);
  expect_lipschitz<3>(2);
}

template <int D>
void expect_below_feature_size(std::uint64_t seed) {
  const Domain<D> domain = plain::random_features<D>(seed, 4);
  const Spacing<D> f = build_spacing<D>(domain, {});
  const LocalFeatureSize<D> lfs(domain);
  Random random(seed);
  for (const Vec<D>& x : domain.points) EXPECT_LE(f(x), f.feature_factor() * lfs(x) * (1 + kRounding));
  for (const auto& [p, q] : domain.segments) {
    const Vec<D> x = domain.points[p] + random.unit() * (domain.points[q] - domain.points[p]);
    EXPECT_LE(f(x), f.feature_factor() * lfs(x) * (1 + kRounding));
  }
  for (FacetId facet : ids(domain.facet_frame)) {
    const auto t = domain.facet_triangles[facet][0];
    const double s = random.unit();
    const Vec<D> x = domain.points[t[0]] + 0.5 * s * (domain.points[t[1]] - domain.points[t[0]]) +
                     0.5 * (1 - s) * (domain.points[t[2]] - domain.points[t[0]]);
    EXPECT_LE(f(x), f.feature_factor() * lfs(x) * (1 + kRounding));
  }
}

TEST(Spacing, IsAtMostFeatureFactorTimesLfsOnPolytopes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    expect_below_feature_size<2>(seed);
    expect_below_feature_size<3>(seed);
  }
}

}  // namespace
}  // namespace voropack
