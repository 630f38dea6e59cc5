// Every kind of wish against its definition, and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/random.h"
#include "spacing/affine_envelope.h"
#include "support/allow_threads.h"
#include "support/plain_domain.h"
#include "support/point_sets.h"
#include "support/spacing_reference.h"
#include "voropack/spacing.h"

namespace voropack {
namespace {

constexpr double kRounding = 1e-12;
constexpr double kRatio = 3.3;  // SpacingOptions::edge_per_spacing
constexpr SpacingOptions kOptions{.gradation = 0.2, .feature_factor = 0.45};

template <int D>
std::vector<Vec<D>> probes(int n, double scale = 1) {
  Random random(5);
  std::vector<Vec<D>> x;
  for (int i = 0; i < n; ++i) x.push_back(scale * test::random_point<D>(random));
  return x;
}

/// Checks min(geometry, wish(x)) at random points, inside and outside of the box.
template <int D, class Wish>
void expect_wish(const Domain<D>& domain, const SizeWishes<D>& wishes, Wish&& wish) {
  const Spacing<D> geometry = build_spacing<D>(domain, {}, kOptions);
  const Spacing<D> f = build_spacing(domain, wishes, kOptions);
  int n_wished = 0;
  for (const Vec<D>& x : probes<D>(500, 1.1)) {
    const double wanted = wish(x);
    const double expected = std::min(geometry(x), wanted);
    if (wanted < geometry(x)) ++n_wished;
    ASSERT_NEAR(f(x), expected, kRounding * expected);
  }
  EXPECT_GT(n_wished, 50);
}

TEST(Spacing, OfTheUnitCubeIsThatOfItsThreePairsOfSides) {
  const Domain<3> cube = plain::unit_box<3>();
  const LocalFeatureSize<3> lfs(cube);
  const Spacing<3> f = build_spacing<3>(cube, {}, kOptions);
  for (const Vec<3>& x : probes<3>(300)) {
    double expected = 1;
    for (int k = 0; k < 3; ++k) expected = std::min(expected, std::max(x[k], 1 - x[k]));
    EXPECT_NEAR(lfs(x), expected, kRounding);
    EXPECT_NEAR(f(x), 0.2 * expected + 0.125, kRounding);
  }
}

TEST(Spacing, TakesTheSmallestConstant) {
  SizeWishes<2> wishes;
  wishes.size = 0.066;
  wishes.spacing = 0.01;
  expect_wish(plain::unit_box<2>(), wishes, [](const Vec<2>&) { return 0.01; });
  wishes.spacing = 0.05;
  const Spacing<2> f = build_spacing(plain::unit_box<2>(), wishes, kOptions);
  EXPECT_DOUBLE_EQ(f({0.3, 0.4}), 0.02);
  EXPECT_EQ(f.constant_on({{0.1, 0.1}, {0.9, 0.9}}), 0.066 / kRatio);
}

template <int D>
void expect_region_wish() {
  SizeWishes<D> wishes;
  wishes.region_size[7] = 0.02 * kRatio;
  const Box<D> small = [] {
    Box<D> box;
    for (int k = 0; k < D; ++k) {
      box.lo[k] = 0.4;
      box.hi[k] = 0.6;
    }
    return box;
  }();
  expect_wish<D>(plain::nested_boxes<D>(), wishes,
                 [&](const Vec<D>& x) { return 0.02 + 0.2 * std::sqrt(small.distance_sq(x)); });
  // The other way: the region with a hole.
  wishes.region_size = {{1, 0.01 * kRatio}};
  Box<D> large({}, Vec<D>(small.lo + small.hi));
  expect_wish<D>(plain::nested_boxes<D>(), wishes, [&](const Vec<D>& x) {
    if (!large.contains(x)) return 0.01 + 0.2 * std::sqrt(large.distance_sq(x));
    double depth = 1;
    for (int k = 0; k < D; ++k) depth = std::min({depth, x[k] - 0.4, 0.6 - x[k]});
    return 0.01 + 0.2 * std::max(0.0, depth);
  });
}

TEST(Spacing, RegionSizesHoldInTheirClosureAndGrowOutside) {
  expect_region_wish<2>();
  expect_region_wish<3>();
}

TEST(Spacing, LargestSimplexIsARegionSize) {
  Domain<2> square = plain::nested_boxes<2>();
  square.region_max_simplex[RegionId(1)] = std::sqrt(3.0) / 4 * 0.02 * 0.02;  // Side 0.02.
  EXPECT_NEAR(build_spacing<2>(square, {}, kOptions)({0.5, 0.5}), 0.02 / kRatio, kRounding);
  Domain<3> cube = plain::nested_boxes<3>();
  cube.region_max_simplex[RegionId(1)] = std::sqrt(2.0) / 12 * 0.02 * 0.02 * 0.02;
  EXPECT_NEAR(build_spacing<3>(cube, {}, kOptions)({0.5, 0.5, 0.5}), 0.02 / kRatio, kRounding);
}

TEST(Spacing, MarkerSizesGrowWithTheDistanceFromFacetsSegmentsAndPoints) {
  SizeWishes<3> wishes;
  wishes.marker_size[3] = 0.03 * kRatio;  // The facet y = 0.
  expect_wish(plain::unit_box<3>(), wishes, [](const Vec<3>& x) {
    return 0.03 + 0.2 * norm(Vec<3>{std::max(0.0, x[0] - 1), x[1], std::max(0.0, x[2] - 1)});
  });
  Domain<3> cube = plain::unit_box<3>();
  cube.point_marker[PointId(7)] = 11;
  wishes.marker_size = {{11, 0.02 * kRatio}};
  expect_wish(cube, wishes, [](const Vec<3>& x) { return 0.02 + 0.2 * distance(x, {1, 1, 1}); });
  Domain<2> square = plain::unit_box<2>();
  square.segment_marker[SegmentId(0)] = 5;  // y = 0.
  SizeWishes<2> flat;
  flat.marker_size[5] = 0.02 * kRatio;
  expect_wish(square, flat, [](const Vec<2>& x) { return 0.02 + 0.2 * norm(Vec<2>{std::max(0.0, x[0] - 1), x[1]}); });
}

/// min over a fine barycentric grid, and how far that can be above the true minimum.
template <int D>
void expect_envelope(std::uint64_t seed, double slope, double steepness) {
  Random random(seed);
  std::array<Vec<D>, D + 1> corner;
  std::array<double, D + 1> value;
  for (std::size_t i = 0; i <= D; ++i) {
    corner[i] = test::random_point<D>(random);
    value[i] = 1 + steepness * random.unit();
  }
  constexpr int kGrid = D == 2 ? 120 : 40;
  for (int trial = 0; trial < 5; ++trial) {
    Vec<D> x = test::random_point<D>(random);
    for (int k = 0; k < D; ++k) x[k] = 2 * x[k] - 0.5;
    double sampled = reference::kInfinity;
    for (int i = 0; i <= kGrid; ++i) {
      for (int j = 0; i + j <= kGrid; ++j) {
        for (int k = 0; k <= (D == 3 ? kGrid - i - j : 0); ++k) {
          const std::array<int, 4> weight = {kGrid - i - j - k, i, j, k};
          Vec<D> y;
          double v = 0;
          for (std::size_t c = 0; c <= D; ++c) {
            y += weight[c] * (1.0 / kGrid) * corner[c];
            v += weight[c] * (1.0 / kGrid) * value[c];
          }
          sampled = std::min(sampled, v + slope * distance(x, y));
        }
      }
    }
    const double envelope = affine_envelope<D>(corner, value, slope, x);
    EXPECT_LE(envelope, sampled + kRounding) << "seed " << seed;
    EXPECT_GE(envelope, sampled - 2 * (slope + steepness) / kGrid) << "seed " << seed;
  }
}

TEST(AffineEnvelope, EqualsDenseSampling) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (double steepness : {0.01, 0.1, 1.0}) {
      expect_envelope<2>(seed, 0.2, steepness);
      expect_envelope<3>(seed, 0.2, steepness);
    }
  }
}

TEST(AffineEnvelope, IsTheFunctionItselfWhereThatIsLipschitz) {
  const std::array<Vec<2>, 3> corner = {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{0, 1}};
  const std::array<double, 3> value = {1.0, 1.1, 1.05};
  EXPECT_NEAR(affine_envelope<2>(corner, value, 0.2, {0.25, 0.5}), 1.05, 1e-15);
  // Stationary point on the edge x = 0, by hand: gradient 0.05 there, distance 1 from it.
  EXPECT_NEAR(affine_envelope<2>(corner, value, 0.2, {-1, 0.5}), 1.025 + std::sqrt(0.04 - 0.0025), 1e-15);
}

SizeWishes<2>::Field two_triangles() {
  SizeWishes<2>::Field field;
  field.mesh.points = IdVector<VertexId, Vec<2>>({{0.2, 0.2}, {0.8, 0.2}, {0.8, 0.8}, {0.2, 0.8}});
  const VertexId a(0), b(1), c(2), d(3);
  field.mesh.simplex_vertices.push_back({a, b, c});
  field.mesh.simplex_vertices.push_back({a, c, d});
  field.size = {0.01 * kRatio, 0.05 * kRatio, 0.4 * kRatio, 0.03 * kRatio};
  return field;
}

TEST(Spacing, FieldIsTheLeastEnvelopeOfItsSimplices) {
  SizeWishes<2> wishes;
  wishes.field = two_triangles();
  const auto& mesh = wishes.field->mesh;
  expect_wish(plain::unit_box<2>(), wishes, [&](const Vec<2>& x) {
    double best = reference::kInfinity;
    for (const auto& t : mesh.simplex_vertices) {
      std::array<Vec<2>, 3> corner;
      std::array<double, 3> value;
      for (std::size_t i = 0; i < 3; ++i) {
        corner[i] = mesh.points[t[i]];
        value[i] = wishes.field->size[t[i].value()] / kRatio;
      }
      best = std::min(best, affine_envelope<2>(corner, value, 0.2, x));
    }
    return best;
  });
}

/// Nothing is known of the part of a cell that a field does not reach, however constant it is.
TEST(Spacing, AConstantFieldOnAPartOfTheDomainGrowsBesideIt) {
  SizeWishes<2> wishes;
  wishes.field = two_triangles();
  wishes.field->size.assign(4, 0.01 * kRatio);
  const Box<2> patch({0.2, 0.2}, {0.8, 0.8});
  expect_wish(plain::unit_box<2>(), wishes,
              [&](const Vec<2>& x) { return 0.01 + 0.2 * std::sqrt(patch.distance_sq(x)); });
}

TEST(Spacing, ExpressionIsMetFromBelowWithinTenPercent) {
  SizeWishes<2> wishes;
  wishes.expression = "0.033 + 0.3*hypot(x-0.5, y-0.5)";  // f grows by 0.09 < b: nothing to smooth.
  const Domain<2> square = plain::unit_box<2>();
  const Spacing<2> f = build_spacing(square, wishes, kOptions);
  const Spacing<2> geometry = build_spacing<2>(square, {}, kOptions);
  for (const Vec<2>& x : probes<2>(500)) {
    const double wanted = std::min(geometry(x), (0.033 + 0.3 * distance(x, {0.5, 0.5})) / kRatio);
    EXPECT_LE(f(x), wanted * (1 + kRounding));
    EXPECT_GE(f(x), wanted * 0.9);
  }
}

TEST(Spacing, CapsAreCones) {
  const Spacing<2> base = build_spacing<2>(plain::unit_box<2>(), {}, kOptions);
  const std::vector<SpacingCap<2>> caps = {{{0.5, 0.5}, 0.1, 0.02}, {{0.2, 0.2}, 0.0, 0.01}};
  const Spacing<2> together = base.with_caps(caps);
  const Spacing<2> twice = base.with_caps({caps[0]}).with_caps({caps[1]});
  for (const Vec<2>& x : probes<2>(300)) {
    double expected = base(x);
    for (const auto& cap : caps)
      expected = std::min(expected, cap.value + 0.2 * std::max(0.0, distance(x, cap.center) - cap.radius));
    EXPECT_NEAR(together(x), expected, kRounding);
    EXPECT_EQ(together(x), twice(x));
  }
}

TEST(Spacing, CapsEndConstantBoxes) {
  SizeWishes<2> wishes;
  wishes.spacing = 0.02;
  const Spacing<2> f = build_spacing(plain::unit_box<2>(), wishes, kOptions).with_caps({{{0.5, 0.5}, 0.1, 0.01}});
  EXPECT_FALSE(f.constant_on({{0.1, 0.1}, {0.9, 0.9}}).has_value());
  EXPECT_EQ(f.constant_on({{0.1, 0.1}, {0.2, 0.2}}), 0.02);
}

TEST(Spacing, KnownConstantsAreRight) {
  SizeWishes<3> wishes;
  wishes.size = 0.1;
  const Spacing<3> f = build_spacing(plain::random_features<3>(3, 3), wishes);
  Random random(1);
  int n_known = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec<3> lo = 0.9 * test::random_point<3>(random);
    const Vec<3> size = 0.1 * test::random_point<3>(random);
    const auto constant = f.constant_on({lo, lo + size});
    if (!constant) continue;
    ++n_known;
    for (int j = 0; j < 20; ++j) {
      const Vec<3> t = test::random_point<3>(random);
      ASSERT_EQ(f(lo + Vec<3>{t[0] * size[0], t[1] * size[1], t[2] * size[2]}), *constant);
    }
  }
  EXPECT_GT(n_known, 10);
}

TEST(Spacing, IsTheSameForAnyNumberOfThreads) {
  const test::AllowThreads allow(8);
  const Domain<3> domain = plain::random_features<3>(2, 3);
  std::vector<double> values[2];
  for (int run : {0, 1}) {
    run_with_threads(run == 0 ? 1 : 8, [&] {
      const Spacing<3> f = build_spacing<3>(domain, {});
      for (const Vec<3>& x : probes<3>(2000, 1.1)) values[run].push_back(f(x));
      values[run].push_back(f.integral(domain));
    });
  }
  EXPECT_EQ(values[0], values[1]);
}

TEST(Spacing, IntegralOfAConstantIsExact) {
  SizeWishes<3> wishes;
  wishes.spacing = 0.01;
  const Domain<3> cube = plain::unit_box<3>();
  EXPECT_NEAR(build_spacing(cube, wishes).integral(cube), 1e6, 1e-3);
}

TEST(Spacing, IntegralAgreesWithADenseSum) {
  const Domain<2> domain = plain::random_features<2>(4, 5);
  const Spacing<2> f = build_spacing<2>(domain, {});
  constexpr int kGrid = 300;
  double expected = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) expected += std::pow(kGrid * f({(i + 0.5) / kGrid, (j + 0.5) / kGrid}), -2);
  EXPECT_NEAR(f.integral(domain), expected, 0.05 * expected);
}

template <int D>
std::string refusal(const SizeWishes<D>& wishes, const SpacingOptions& options = {}) {
  try {
    build_spacing(plain::nested_boxes<D>(), wishes, options);
  } catch (const OptionError& error) {
    EXPECT_FALSE(error.faults()[0].fix.empty());
    return error.what();
  }
  return {};
}

void expect_refusal(const std::string& text, const std::string& id, const std::string& detail) {
  EXPECT_NE(text.find("[" + id + "]"), std::string::npos) << text;
  EXPECT_NE(text.find(detail), std::string::npos) << text;
}

TEST(Spacing, RefusesWhatMakesNoSense) {
  SizeWishes<2> wishes;
  wishes.size = -1;
  expect_refusal(refusal(wishes), "spacing.bad_size", "-1");
  wishes = {};
  wishes.region_size[3] = 0.1;
  expect_refusal(refusal(wishes), "spacing.unknown_region", "1, 7");
  wishes = {};
  wishes.marker_size[99] = 0.1;
  expect_refusal(refusal(wishes), "spacing.unknown_marker", "0");
  wishes = {};
  wishes.expression = "0.1 + sqr(x)";
  expect_refusal(refusal(wishes), "spacing.expression", "column 7");
  wishes.expression = "x - 0.5";
  expect_refusal(refusal(wishes), "spacing.expression", "at (0, 0)");
  wishes.expression = "z";
  expect_refusal(refusal(wishes), "spacing.expression", "unknown name 'z'");
  wishes = {};
  wishes.field = two_triangles();
  wishes.field->size.pop_back();
  expect_refusal(refusal(wishes), "spacing.bad_size", "3 sizes for 4 points");
  SpacingOptions options;
  options.gradation = 0.5;
  expect_refusal(refusal<2>({}, options), "spacing.bad_gradation", "0.5");
  options = {};
  options.feature_factor = 0;
  expect_refusal(refusal<2>({}, options), "spacing.bad_feature_factor", "0");
}

TEST(Spacing, RefusesADomainWithoutExtent) { EXPECT_THROW(build_spacing(Domain<2>{}, {}), OptionError); }

}  // namespace
}  // namespace voropack
