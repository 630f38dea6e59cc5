// What vertices are due to: the features of a packing against the packing of the same domain without them, and against
// the definition by sums over vertices.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "packing/budget.h"
#include "support/allow_threads.h"
#include "support/sharp_domains.h"
#include "support/spacing_reference.h"
#include "voropack/error.h"

namespace voropack {
namespace {

namespace sharp = test::sharp;

template <int D>
using Kind = typename CostlyFeature<D>::Kind;

template <int D>
struct Meshed {
  Domain<D> domain;
  Spacing<D> spacing;  ///< With the repairs.
  Packing<D> packing;
  std::vector<CostlyFeature<D>> features;
  [[nodiscard]] double n() const { return static_cast<double>(packing.center.size()); }
  [[nodiscard]] double listed() const {
    return std::accumulate(features.begin(), features.end(), 0.0,
                           [](double sum, const auto& f) { return sum + f.vertices; });
  }
};

template <int D>
Meshed<D> packed(const DomainInput<D>& input, std::optional<double> size = {}) {
  Domain<D> domain = build_domain(input);
  SizeWishes<D> wishes;
  wishes.size = size;
  Spacing<D> spacing = build_spacing(domain, wishes);
  Packing<D> packing = pack(domain, spacing);
  if (!packing.repairs.empty()) spacing = spacing.with_caps(packing.repairs);
  auto features = costliest_features(domain, spacing, packing);
  return {std::move(domain), std::move(spacing), std::move(packing), std::move(features)};
}

/// A square plate (a segment in the plane) of side 2 `half` around (x, y) at height z.
void add_plate(DomainInput<3>& input, double x, double y, double half, double z) {
  domains::Polygon polygon;
  for (const Vec<2>& c : domains::rectangle({x - half, y - half}, {x + half, y + half}))
    polygon.push_back(domains::add_point<3>(input, {c[0], c[1], z}));
  domains::add_facet(input, polygon);
}
void add_plate(DomainInput<2>& input, double x, double /*y*/, double half, double z) {
  const auto a = domains::add_point<2>(input, {x - half, z});
  domains::add_segment(input, a, domains::add_point<2>(input, {x + half, z}));
}

/// A unit box with a plate at height 0.5 and, if there is a gap, another one above it.
template <int D>
DomainInput<D> box_with_plates(std::optional<double> gap) {
  DomainInput<D> input = domains::unit_box<D>();
  add_plate(input, 0.5, 0.5, 0.2, 0.5);
  if (gap) add_plate(input, 0.5, 0.5, 0.2, 0.5 + *gap);
  return input;
}

template <int D>
void slit_is_named(double gap) {
  const Meshed<D> with = packed(box_with_plates<D>(gap)), without = packed(box_with_plates<D>({}));
  const double beyond = with.n() - without.n();
  ASSERT_FALSE(with.features.empty());
  const CostlyFeature<D>& slit = with.features[0];
  EXPECT_EQ(slit.kind, Kind<D>::kGap);
  EXPECT_NEAR(slit.size, gap, 1e-12);
  EXPECT_NEAR(slit.place[D - 1], 0.5 + gap / 2, 1e-12);
  for (int k = 0; k + 1 < D; ++k) EXPECT_NEAR(slit.place[k], 0.5, 0.2);
  EXPECT_EQ(slit.polytopes[0].dimension, D - 1);
  EXPECT_EQ(slit.polytopes[1].dimension, D - 1);
  EXPECT_GE(slit.vertices, 0.9 * beyond);
  EXPECT_LE(slit.vertices, 1.1 * beyond);
  EXPECT_GE(with.listed(), 0.8 * beyond);
  EXPECT_LE(with.listed(), with.n());
}
TEST(CostlyFeatures, NameASlitInThePlane) {
  slit_is_named<2>(0.01);
  slit_is_named<2>(0.001);
}
TEST(CostlyFeatures, NameASlitInSpace) { slit_is_named<3>(0.01); }

TEST(CostlyFeatures, JoinMoreThanTenThinPlacesUntilTheyMakeUpMost) {
  DomainInput<3> with = domains::unit_cube(), without = with;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const double x = 0.15 + 0.23 * i, y = 0.15 + 0.23 * j, gap = 0.02 + 0.001 * i;
      add_plate(with, x, y, 0.06, 0.5);
      add_plate(without, x, y, 0.06, 0.5);
      add_plate(with, x, y, 0.06, 0.5 + gap);
    }
  const Meshed<3> a = packed(with), b = packed(without);
  EXPECT_GE(a.features.size(), 5U) << "joined no more than necessary";
  EXPECT_LE(a.features.size(), 10U);
  EXPECT_GE(a.listed(), 0.8 * (a.n() - b.n()));
  std::size_t n_joined = 0;
  double n_between = 0;
  for (const auto& f : a.features) {
    if (f.n_pairs == 1) {
      EXPECT_EQ(f.radius, 0);
    }
    n_joined += f.n_pairs > 1 ? 1 : 0;
    EXPECT_GE(f.size, 0.02 - 1e-12);
    if (f.size < 0.024) {
      EXPECT_NEAR(f.place[2], 0.5 + f.size / 2, 1e-12) << "between the plates";
      n_between += f.vertices;
    }
  }
  EXPECT_GT(n_joined, 0U);
  EXPECT_GE(n_between, 0.7 * (a.n() - b.n()));
}

/// Facets carry equal centers at the angle; what costs is the end of the crack over the bottom. What the copies and the
/// crack itself add is not counted as due to a feature: it does not make f smaller.
TEST(CostlyFeatures, NameTheThinEndOfACrack) {
  const Meshed<3> without = packed(domains::unit_cube());
  for (const double degrees : {5.0, 2.0}) {
    const Meshed<3> with = packed(sharp::leaning_crack(degrees).input);
    ASSERT_FALSE(with.features.empty());
    const CostlyFeature<3>& end = with.features[0];
    const double height = 0.4 * std::sin(sharp::radians(degrees));
    EXPECT_EQ(end.kind, Kind<3>::kGap);
    EXPECT_NEAR(end.size, height, 1e-9);
    EXPECT_NEAR(end.place[2], height / 2, 1e-9);
    EXPECT_GE(with.listed(), 0.5 * (with.n() - without.n()));
    EXPECT_LE(with.listed(), with.n());
  }
}

TEST(CostlyFeatures, NameTheThinEndOfAWedgeInThePlane) {
  const Meshed<2> without = packed(domains::unit_square());
  for (const double degrees : {0.5, 1.0, 2.0, 3.0}) {
    const Meshed<2> with = packed(sharp::leaning_slit(degrees).input);
    ASSERT_FALSE(with.features.empty());
    EXPECT_GE(with.listed(), 0.8 * (with.n() - without.n()) - 1) << "so few vertices are not whole";
    EXPECT_LE(with.listed(), with.n());
    // Segments carry common distances from the tip; what costs is the end of the slit over the side.
    const CostlyFeature<2>& end = with.features[0];
    const double height = 0.6 * std::sin(sharp::radians(degrees));
    EXPECT_EQ(end.kind, Kind<2>::kGap);
    EXPECT_NEAR(end.size, height, 1e-9);
    EXPECT_NEAR(end.place[1], height / 2, 1e-9);
  }
}

template <int D>
void are_none_where_sizes_decide() {
  const double size = 0.2;
  const Meshed<D> box = packed(domains::unit_box<D>(), size);
  EXPECT_TRUE(box.features.empty());
  EXPECT_TRUE(estimate_costliest_features(box.domain, box.spacing).empty());
}
TEST(CostlyFeatures, AreNoneWhereSizesDecideInThePlane) { are_none_where_sizes_decide<2>(); }
TEST(CostlyFeatures, AreNoneWhereSizesDecideInSpace) { are_none_where_sizes_decide<3>(); }

/// Where reference::polytopes lists it.
template <int D>
std::size_t index_of(const Domain<D>& domain, PolytopeId p) {
  return p.index + (p.dimension > 0 ? domain.points.size() : 0) + (p.dimension > 1 ? domain.segments.size() : 0);
}

/// The definition: a vertex on a polytope of dimension d is due to geometry by 1 - (f / wish)^d.
template <int D>
double due_to_geometry(const Meshed<D>& m) {
  double sum = 0;
  for (const SphereId s : ids(m.packing.center)) {
    const Vec<D>& x = m.packing.center[s];
    sum += 1 - std::pow(std::min(1.0, m.spacing(x) / m.spacing.wished(x)), m.packing.carrier[s].dimension);
  }
  return sum;
}

template <int D>
void make_up_most_of_what_geometry_asks_for(const std::vector<DomainInput<D>>& inputs) {
  for (const DomainInput<D>& input : inputs)
    for (const std::optional<double> size : {std::optional<double>{}, std::optional<double>{0.2}}) {
      const Meshed<D> m = packed(input, size);
      const double all = due_to_geometry(m);
      // Those of less than one vertex are left out; beyond 3000 vertices, samples stand for all.
      EXPECT_GE(m.listed(), 0.78 * all - 10);
      EXPECT_LE(m.listed(), 1.02 * all + 1e-6);
      EXPECT_LE(m.features.size(), 10U);
      const auto polytopes = reference::polytopes(m.domain);
      for (std::size_t i = 0; i < m.features.size(); ++i) {
        const auto& f = m.features[i];
        const auto &p = polytopes[index_of(m.domain, f.polytopes[0])],
                   &q = polytopes[index_of(m.domain, f.polytopes[1])];
        if (f.kind == Kind<D>::kGap) {
          EXPECT_NEAR(f.size, reference::distance_between(p, q), 1e-9);
          EXPECT_NEAR(reference::distance_to(f.place, p), f.size / 2, 1e-9);
          EXPECT_NEAR(reference::distance_to(f.place, q), f.size / 2, 1e-9);
        } else if (f.kind == Kind<D>::kAngle) {
          EXPECT_NEAR(reference::distance_to(f.place, p), 0, 1e-9);
          EXPECT_NEAR(reference::distance_to(f.place, q), 0, 1e-9);
          EXPECT_LT(f.angle_deg, 60);
        }
        EXPECT_GE(f.vertices, 1);
        if (i > 0) {
          EXPECT_LE(m.features[i].vertices, m.features[i - 1].vertices);
        }
      }
    }
}
TEST(CostlyFeatures, MakeUpMostOfWhatGeometryAsksForInThePlane) {
  make_up_most_of_what_geometry_asks_for<2>({sharp::fan(5, 3).input, sharp::sliver(2).input,
                                             sharp::heap<2>(12, 0.5, 1).input, domains::box_with_hole<2>(),
                                             box_with_plates<2>(0.02)});
}
TEST(CostlyFeatures, MakeUpMostOfWhatGeometryAsksForInSpace) {
  make_up_most_of_what_geometry_asks_for<3>({sharp::wedge(10).input, sharp::pyramid(10, 20).input,
                                             sharp::equal_book(5).input, sharp::heap<3>(7, 0.5, 1).input,
                                             box_with_plates<3>(0.02)});
}

TEST(CostlyFeatures, AreTheSameForAnyNumberOfThreads) {
  const Meshed<3> m = packed(sharp::wedge(5).input);
  const test::AllowThreads allow(4);
  for (const int n_threads : {1, 2, 4})
    run_with_threads(n_threads, [&] {
      const auto again = costliest_features(m.domain, m.spacing, m.packing);
      ASSERT_EQ(again.size(), m.features.size());
      for (std::size_t i = 0; i < again.size(); ++i) {
        EXPECT_EQ(again[i].vertices, m.features[i].vertices);
        EXPECT_EQ(again[i].place, m.features[i].place);
        EXPECT_EQ(describe(again[i], m.domain), describe(m.features[i], m.domain));
      }
    });
}

/// Every cause against its definition, with distances from elsewhere.
template <int D>
void causes_are_what_they_claim(const DomainInput<D>& input, double gradation, double factor) {
  const Domain<D> domain = build_domain(input);
  const Spacing<D> f = build_spacing(domain, SizeWishes<D>{}, {gradation, factor, 3.3});
  const auto all = reference::polytopes(domain);
  const double slope = std::min(gradation, factor), weight = std::max(0.0, 0.5 * (factor - gradation));
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    Vec<D> x;
    for (int k = 0; k < D; ++k) x[k] = domain.box.lo[k] + random.unit() * (domain.box.hi[k] - domain.box.lo[k]);
    const auto causes = f.causes(x, 2);
    ASSERT_FALSE(causes.empty());
    EXPECT_NEAR(causes.front().value, f(x), 1e-9 * f(x));
    for (std::size_t c = 0; c < causes.size(); ++c) {
      const auto [p, q] = causes[c].polytopes;
      const auto &first = all[index_of(domain, p)], &second = all[index_of(domain, q)];
      const double gap = reference::distance_between(first, second);
      const double away = std::max(reference::distance_to(x, first), reference::distance_to(x, second));
      EXPECT_NEAR(causes[c].size, gap, 1e-9);
      EXPECT_NEAR(causes[c].value, slope * away + weight * gap, 1e-9);
      EXPECT_LE(causes[c].value, 2 * f(x) * (1 + 1e-9));
      if (c > 0) {
        EXPECT_GE(causes[c].value, causes[c - 1].value);
      }
    }
  }
}
TEST(SpacingCauses, AreWhatTheyClaim) {
  causes_are_what_they_claim<2>(box_with_plates<2>(0.05), 0.1, 0.45);
  causes_are_what_they_claim<3>(box_with_plates<3>(0.05), 0.1, 0.45);
  causes_are_what_they_claim<3>(domains::l_shape<3>(), 0.3, 0.45);  // Without a table of pairs.
}

TEST(SpacingCauses, NameTheCapThatDecides) {
  const Domain<2> domain = build_domain(domains::unit_square());
  const PolytopeId p(1, 0), q(1, 1);
  const Spacing<2> f = build_spacing(domain, SizeWishes<2>{}).with_caps({{{0.5, 0.5}, 0.1, 0.01, std::array{p, q}}});
  const auto causes = f.causes({0.55, 0.5}, 2);
  ASSERT_EQ(causes.size(), 1U);
  EXPECT_TRUE(causes[0].is_cap);
  EXPECT_EQ(causes[0].value, 0.01);
  EXPECT_EQ(causes[0].polytopes, (std::array{p, q}));
}

template <int D>
void samples_add_up_to_the_integral(const DomainInput<D>& input) {
  const Domain<D> domain = build_domain(input);
  const Spacing<D> f = build_spacing(domain, SizeWishes<D>{});
  double sum = 0;
  for (const IntegralSample<D>& s : f.integral_samples(domain)) {
    EXPECT_GT(s.part, 0);
    EXPECT_TRUE(domain.box.contains(s.position));
    sum += s.part;
  }
  EXPECT_NEAR(sum, f.integral(domain), 1e-9 * sum);
}
TEST(SpacingSamples, AddUpToTheIntegral) {
  samples_add_up_to_the_integral<2>(box_with_plates<2>(0.02));
  samples_add_up_to_the_integral<3>(box_with_plates<3>(0.05));
  samples_add_up_to_the_integral<3>(sharp::wedge(10).input);
}

template <int D>
std::string refusal(const Domain<D>& domain, std::uint64_t limit) {
  PackingOptions options;
  options.max_vertices = limit;
  try {
    pack(domain, build_spacing(domain, SizeWishes<D>{}), options);
  } catch (const LimitError& e) {
    EXPECT_EQ(e.id(), "packing.too_many_vertices");
    EXPECT_NE(e.faults()[0].fix.find("mend"), std::string::npos);
    return e.faults()[0].message;
  }
  return {};
}

TEST(Budget, RefusalNamesTheSameFeatureAsTheMesh) {
  for (const DomainInput<3>& input : {box_with_plates<3>(0.03), sharp::leaning_crack(5).input}) {
    const Meshed<3> m = packed(input);
    const std::string message = refusal(m.domain, 100);
    const std::string words = input.facets.size() == 7 ? " are 0.03486 apart near (" : " are 0.03 apart near (";
    const std::string first_line = message.substr(0, message.find('\n', message.find('\n') + 1));
    EXPECT_NE(first_line.find(words), std::string::npos) << message;
  }
}

TEST(Budget, IsCheckedAgainWhenRepairsShrinkTheSpacing) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Spacing<3> spacing = build_spacing(domain, SizeWishes<3>{});
  PackingOptions options;
  options.max_vertices = 2000;
  Budget<3> budget(domain, options);
  EXPECT_NO_THROW(budget.check_ahead(spacing));
  EXPECT_NO_THROW(budget.check_again(spacing, 100));
  const Spacing<3> smaller =
      spacing.with_caps({{{0.5, 0.5, 0.5}, 0.3, 0.005, std::array{PolytopeId(1, 0), PolytopeId(1, 1)}}});
  EXPECT_THROW(budget.check_again(smaller, 100), LimitError);
  EXPECT_THROW(budget.check_again(spacing, 2001), LimitError) << "so many are there already";
}

TEST(Budget, NeverRecommendsAnInfiniteLimit) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  for (const double spacing : {1e-5, 1e-150}) {
    SizeWishes<3> wishes;
    wishes.spacing = spacing;
    try {
      pack(domain, build_spacing(domain, wishes));
      FAIL();
    } catch (const LimitError& e) {
      const std::string text = e.faults()[0].message + e.faults()[0].fix;
      EXPECT_EQ(text.find("inf"), std::string::npos) << text;
      EXPECT_EQ(text.find("nan"), std::string::npos) << text;
      EXPECT_NE(text.find("larger sizes"), std::string::npos) << text;
    }
  }
}

}  // namespace
}  // namespace voropack
