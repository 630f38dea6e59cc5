// Near-planar noise: facets whose points were rounded become planar, by displacements within the merge distance.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <numeric>

#include "support/domains.h"
#include "voropack/domain.h"
#include "voropack/error.h"
#include "voropack/io.h"

namespace voropack {
namespace {

struct Shape {
  std::size_t points, segments, facets;
  friend bool operator==(const Shape&, const Shape&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Shape& s) {
    return out << s.points << " points, " << s.segments << " segments, " << s.facets << " facets";
  }
};

Shape shape_of(const Domain<3>& d) { return {d.points.size(), d.segments.size(), d.facet_frame.size()}; }

constexpr Shape kBox{8, 12, 6};

Domain<3> build(const DomainInput<3>& input, DomainOptions options = {}) {
  options.min_angle_deg = 0;
  return build_domain(input, options);
}

std::vector<Fault> faults_of(const DomainInput<3>& input, const DomainOptions& options = {}) {
  try {
    build(input, options);
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

/// Every coordinate as a file of so many significant digits gives it back.
DomainInput<3> with_digits(const DomainInput<3>& input, int digits) {
  return domains::mapped(input, [&](const Vec<3>& x) {
    Vec<3> y;
    for (int k = 0; k < 3; ++k) y[k] = std::strtod(fmt::format("{:.{}g}", x[k], digits).c_str(), nullptr);
    return y;
  });
}

DomainInput<3> in_single_precision(const DomainInput<3>& input) {
  return domains::mapped(input, [](const Vec<3>& x) {
    return Vec<3>{static_cast<double>(static_cast<float>(x[0])), static_cast<double>(static_cast<float>(x[1])),
                  static_cast<double>(static_cast<float>(x[2]))};
  });
}

/// A random displacement of every position by at most `size` in each coordinate; equal positions stay equal.
DomainInput<3> with_noise(const DomainInput<3>& input, double size, std::uint64_t seed) {
  std::map<Vec<3>, Vec<3>> moved;
  Random random(seed);
  return domains::mapped(input, [&](const Vec<3>& x) {
    const auto [it, added] = moved.try_emplace(x, x);
    for (int k = 0; k < 3 && added; ++k) it->second[k] += size * (2 * random.unit() - 1);
    return it->second;
  });
}

double total_measure(const Domain<3>& d) {
  return std::accumulate(d.region_measure.begin(), d.region_measure.end(), 0.0);
}

/// The prism over an L with a bevel, all facets triangulated by fans: a bracket of 24 triangles with an angle of 135
/// degrees.
DomainInput<3> bracket() {
  DomainInput<3> input;
  domains::add_prism(input, {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {1, 2}, {1, 3}, {0, 3}}, 0, 1.3);
  DomainInput<3> triangles;
  triangles.is_surface = true;
  triangles.points = input.points;
  // The L is not convex, but seen from its corner at the origin it is star shaped.
  for (const auto& facet : input.facets) {
    domains::Polygon p = facet.polygons.front();
    std::rotate(p.begin(),
                std::find_if(p.begin(), p.end(), [](auto i) { return i == 0 || i == 7; }) == p.end()
                    ? p.begin()
                    : std::find_if(p.begin(), p.end(), [](auto i) { return i == 0 || i == 7; }),
                p.end());
    for (std::size_t i = 1; i + 1 < p.size(); ++i) domains::add_facet(triangles, {p[0], p[i], p[i + 1]});
  }
  return triangles;
}

constexpr double kBracketVolume = 1.3 * (1 * 3 + 2 * 1 + 0.5);
constexpr Shape kBracket{14, 21, 9};

void expect_flat(const Domain<3>& domain, const Shape& shape, double volume, double slack) {
  EXPECT_EQ(shape_of(domain), shape);
  EXPECT_NEAR(total_measure(domain), volume, slack);
  EXPECT_EQ(find_domain_fault(domain), "");
}

TEST(DomainMerge, BoxesOfSixDigitsHaveSixFacets) {
  for (const int n : {1, 2, 7})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(testing::Message() << n << " squares, seed " << seed);
      const Domain<3> box = build(with_digits(domains::tilted(domains::tessellated_cube(n), seed), 6));
      expect_flat(box, kBox, 1, 3e-5);
      ASSERT_TRUE(box.merge.has_value());
      EXPECT_GT(box.merge->largest_displacement, 0);
      EXPECT_LT(box.merge->largest_displacement, 1e-5);
      EXPECT_LE(box.merge->largest_displacement, box.merge->distance);
      EXPECT_FALSE(box.warnings.empty());
    }
}

TEST(DomainMerge, BracketsOfSixDigitsHaveNineFacets) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    expect_flat(build(with_digits(domains::tilted(bracket(), seed, 37), 6)), kBracket, kBracketVolume * std::pow(37, 3),
                1e-4 * std::pow(37, 3));
    expect_flat(build(in_single_precision(domains::tilted(bracket(), seed))), kBracket, kBracketVolume, 1e-5);
  }
}

TEST(DomainMerge, NoiseFollowsScalesAndShifts) {
  const DomainInput<3> rounded = with_digits(domains::tilted(bracket(), 3), 6);
  for (const double scale : {1e-6, 1.0, 1e6})
    for (const double shift : {0.0, 1e3, 1e6}) {
      SCOPED_TRACE(testing::Message() << "scale " << scale << ", shift " << shift);
      const auto moved = domains::tilted(rounded, 5, scale, shift * scale * 3);
      const Domain<3> domain = build(moved);
      expect_flat(domain, kBracket, kBracketVolume * std::pow(scale, 3), 1e-4 * std::pow(scale, 3));
      ASSERT_TRUE(domain.merge.has_value());
      EXPECT_LE(domain.merge->largest_displacement, 1e-5 * scale);
    }
}

TEST(DomainMerge, CoordinatesFarFromTheOriginShowTheirPrecision) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Domain<3> box = build(with_digits(domains::tilted(domains::tessellated_cube(2), seed, 1, 10), 6));
    expect_flat(box, kBox, 1, 1e-3);
    expect_flat(build(in_single_precision(domains::tilted(domains::tessellated_cube(2), seed, 1, 1000))), kBox, 1,
                1e-3);
    // At this distance six digits are two for the box: not without being asked.
    try {
      EXPECT_NE(shape_of(build(with_digits(domains::tilted(domains::tessellated_cube(2), seed, 1, 1000), 6))), kBox);
    } catch (const InputError&) {
    }
  }
}

TEST(DomainMerge, ExactInputStaysAsItIs) {
  for (const double shift : {0.0, 1e6}) {
    const auto input = domains::tilted(bracket(), 2, 1, shift);
    const Domain<3> domain = build(input);
    EXPECT_EQ(shape_of(domain), kBracket);
    EXPECT_FALSE(domain.merge.has_value());
    for (const Vec<3>& x : domain.points)
      EXPECT_NE(std::find(input.points.begin(), input.points.end(), x), input.points.end());
  }
}

TEST(DomainMerge, RenumberingDoesNotChangeTheFacets) {
  const DomainInput<3> rounded = with_digits(domains::tilted(domains::tessellated_cube(5), 3), 6);
  const Domain<3> original = build(rounded);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    DomainInput<3> shuffled = rounded;
    for (std::size_t i = shuffled.facets.size(); i > 1; --i)
      std::swap(shuffled.facets[i - 1], shuffled.facets[random.bits() % i]);
    for (auto& facet : shuffled.facets) {
      auto& polygon = facet.polygons.front();
      std::rotate(polygon.begin(), polygon.begin() + static_cast<std::ptrdiff_t>(random.bits() % 3), polygon.end());
      if (random.bits() % 2 == 0) std::reverse(polygon.begin(), polygon.end());
    }
    const auto n = static_cast<domains::Corner>(shuffled.points.size());
    std::reverse(shuffled.points.begin(), shuffled.points.end());
    for (auto& facet : shuffled.facets)
      for (auto& p : facet.polygons.front()) p = n - 1 - p;
    const Domain<3> domain = build(shuffled);
    EXPECT_EQ(shape_of(domain), kBox);
    for (const Vec<3>& x : domain.points) {
      double nearest = 1;
      for (const Vec<3>& y : original.points) nearest = std::min(nearest, distance(x, y));
      EXPECT_LT(nearest, 1e-9);
    }
  }
}

TEST(DomainMerge, NoiseBeyondTheDistanceIsNotMergedAndPolygonsAreRefused) {
  const double noise = 3e-4;
  const auto triangles = with_noise(domains::tilted(domains::tessellated_cube(1), 1), noise, 4);
  const Domain<3> rough = build(triangles);
  EXPECT_EQ(shape_of(rough), (Shape{8, 18, 12}));
  EXPECT_FALSE(rough.merge.has_value());
  const Domain<3> merged = build(triangles, {.merge_distance = 1e-3, .merge_angle_deg = 1});
  expect_flat(merged, kBox, 1, 10 * noise);
  EXPECT_GT(merged.merge->largest_displacement, 1e-5);

  auto polygons = with_noise(domains::tilted(domains::unit_cube(), 1), noise, 4);
  const auto faults = faults_of(polygons);
  ASSERT_FALSE(faults.empty());
  EXPECT_EQ(faults.front().id, "domain.nonplanar_facet");
  ASSERT_EQ(faults.front().position.size(), 3U);
  double nearest = 1;
  for (const Vec<3>& x : polygons.points)
    nearest = std::min(
        nearest, distance(x, {faults.front().position[0], faults.front().position[1], faults.front().position[2]}));
  EXPECT_EQ(nearest, 0);
  expect_flat(build(polygons, {.merge_distance = 1e-3}), kBox, 1, 10 * noise);
  EXPECT_FALSE(faults_of(with_digits(domains::tilted(domains::unit_cube(), 1), 6), {.merge_distance = 0}).empty());
}

TEST(DomainMerge, ABendBeyondTheAngleStays) {
  // A box whose top is bent along its diagonal by a height far below the merge distance given.
  for (const double height : {1e-4, 1e-2}) {
    auto input = domains::tessellated_cube(1);
    for (Vec<3>& x : input.points)
      if (x == Vec<3>{1, 1, 1}) x[2] += height;
    const Domain<3> domain = build(input, {.merge_distance = 0.1, .merge_angle_deg = 0.1});
    EXPECT_EQ(domain.facet_frame.size(), height < 1e-3 ? 6U : 7U);
  }
}

/// A prism over a regular polygon: top and bottom have n corners.
DomainInput<3> polygon_prism(int n) {
  std::vector<Vec<2>> base;
  for (int i = 0; i < n; ++i)
    base.push_back({std::cos(2 * std::numbers::pi * i / n), std::sin(2 * std::numbers::pi * i / n)});
  DomainInput<3> input;
  domains::add_prism(input, base, 0, 1);
  return input;
}

TEST(DomainMerge, PolygonsOfManyRoundedCornersBecomePlanar) {
  for (const int n : {20, 64})
    for (const bool surface : {false, true})
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(testing::Message() << n << " corners, seed " << seed);
        auto input = with_digits(domains::tilted(polygon_prism(n), seed), 6);
        input.is_surface = surface;
        const auto size = static_cast<std::size_t>(n);
        const double volume = 0.5 * n * std::sin(2 * std::numbers::pi / n);
        expect_flat(build(input), {2 * size, 3 * size, size + 2}, volume, 5e-5);
      }
}

TEST(DomainMerge, PlanesThroughOnePointAreMovedTogether) {
  // Every corner of a cuboctahedron lies on four facets, half of them squares.
  DomainInput<3> input;
  const auto corner = [&](double x, double y, double z) { return domains::add_point<3>(input, {x, y, z}); };
  std::map<std::array<int, 3>, domains::Corner> at;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x * x + y * y + z * z == 2) at[{x, y, z}] = corner(x, y, z);
  for (const int s : {-1, 1}) {
    domains::add_facet(input, {at[{s, 1, 0}], at[{s, 0, 1}], at[{s, -1, 0}], at[{s, 0, -1}]});
    domains::add_facet(input, {at[{1, s, 0}], at[{0, s, 1}], at[{-1, s, 0}], at[{0, s, -1}]});
    domains::add_facet(input, {at[{1, 0, s}], at[{0, 1, s}], at[{-1, 0, s}], at[{0, -1, s}]});
    for (const int t : {-1, 1})
      for (const int u : {-1, 1}) domains::add_facet(input, {at[{s, t, 0}], at[{s, 0, u}], at[{0, t, u}]});
  }
  const double volume = 20.0 / 3;
  expect_flat(build(input), {12, 24, 14}, volume, 1e-12);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Domain<3> domain = build(with_digits(domains::tilted(input, seed), 6));
    expect_flat(domain, {12, 24, 14}, volume, 1e-4);
    EXPECT_TRUE(domain.merge.has_value());
  }
}

/// A regular octahedron whose triangles were cut in four n times, with its points on the unit sphere.
DomainInput<3> sphere(int n) {
  DomainInput<3> input;
  input.is_surface = true;
  std::map<Vec<3>, domains::Corner> at;
  const auto corner = [&](const Vec<3>& x) {
    const Vec<3> y = x / norm(x);
    const auto [it, added] = at.try_emplace(y, static_cast<domains::Corner>(input.points.size()));
    if (added) input.points.push_back(y);
    return it->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const Vec<3> a{octant & 1 ? -1.0 : 1.0, 0.0, 0.0}, b{0.0, octant & 2 ? -1.0 : 1.0, 0.0},
        c{0.0, 0.0, octant & 4 ? -1.0 : 1.0};
    const auto point = [&](int i, int j) {
      return corner(static_cast<double>(n - i - j) * a + static_cast<double>(i) * b + static_cast<double>(j) * c);
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        domains::add_facet(input, {point(i, j), point(i + 1, j), point(i, j + 1)});
        if (i + j + 1 < n) domains::add_facet(input, {point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
      }
  }
  return input;
}

TEST(DomainMerge, AFineSphereIsNotFlattenedBeyondTheDistance) {
  const int n = 112;  // 8 * 112^2 = 100,352 triangles.
  const auto input = sphere(n);
  for (const double digits : {0, 6}) {
    const Domain<3> domain = build(digits == 0 ? input : with_digits(input, 6));
    const double limit = 1.1e-5 * domain.diameter();
    // No facet leaves the original surface, which is no farther than its sagitta from the sphere.
    const double sagitta = 3 / static_cast<double>(n * n);
    for (const FacetId f : ids<FacetId>(domain.facet_frame.size()))
      for (const PointId p : domain.facet_points[f]) {
        ASSERT_NEAR(norm(domain.points[p]), 1, limit + 1e-5);
        ASSERT_NEAR(std::abs(dot(domain.facet_frame[f].normal, domain.facet_frame[f].origin)), 1, sagitta);
      }
    EXPECT_EQ(domain.points.size(), input.points.size());
    EXPECT_NEAR(total_measure(domain), 4 * std::numbers::pi / 3, 2e-3);
  }
}

TEST(DomainMerge, NoChainOfFacetsFollowsACurve) {
  // Whatever the distance, no facet is longer than a chord of a cap that deep, though each step turns by a degree only.
  const auto input = sphere(40);
  for (const double limit : {3e-4, 3e-3, 3e-2}) {
    const Domain<3> domain = build(input, {.merge_distance = limit, .merge_angle_deg = 20});
    if (domain.merge) {
      EXPECT_LE(domain.merge->largest_displacement, 1.001 * limit);
    }
    for (const FacetId f : ids<FacetId>(domain.facet_frame.size())) {
      Box<3> box;
      for (const PointId p : domain.facet_points[f]) box.add(domain.points[p]);
      ASSERT_LT(box.diagonal(), std::max(0.1, 2 * std::sqrt(8 * limit)));
    }
    EXPECT_NEAR(total_measure(domain), 4 * std::numbers::pi / 3, 0.02);
  }
}

TEST(DomainMerge, TouchingPartsMoveAlong) {
  // A dangling segment starts inside a side of the box that does not name its end.
  const auto input = domains::box_with_dangling_segment<3>();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Domain<3> domain = build(with_digits(domains::tilted(input, seed), 6));
    expect_flat(domain, {10, 13, 6}, 1, 5e-5);
    expect_flat(build(with_digits(domains::tilted(domains::two_material_box<3>(), seed), 6)), {12, 20, 11}, 2, 1e-4);
    expect_flat(build(with_digits(domains::tilted(domains::box_with_internal_wall<3>(), seed), 6)), {12, 16, 7}, 1,
                5e-5);
    expect_flat(build(with_digits(domains::tilted(domains::box_with_through_hole(), seed), 6)), {16, 24, 10}, 24, 1e-3);
  }
}

TEST(DomainMerge, TextStlFilesAreRead) {
  const auto input = with_digits(domains::tilted(bracket(), 7), 6);
  const auto path = std::filesystem::path(testing::TempDir()) / "voropack_domain_merge.stl";
  {
    std::ofstream file(path);
    file << "solid bracket\n";
    for (const auto& facet : input.facets) {
      file << "facet normal 0 0 0\nouter loop\n";
      for (const auto p : facet.polygons.front()) {
        const Vec<3>& x = input.points[p];
        file << fmt::format("vertex {:.6g} {:.6g} {:.6g}\n", x[0], x[1], x[2]);
      }
      file << "endloop\nendfacet\n";
    }
    file << "endsolid bracket\n";
  }
  const AnyDomainInput any = read_domain(path);
  std::filesystem::remove(path);
  expect_flat(build(std::get<DomainInput<3>>(any)), kBracket, kBracketVolume, 1e-4);
}

TEST(DomainMerge, OptionsAreChecked) {
  const auto cube = domains::unit_cube();
  EXPECT_THROW(build_domain(cube, {.merge_distance = -1}), OptionError);
  EXPECT_THROW(build_domain(cube, {.merge_distance = std::nan("")}), OptionError);
  EXPECT_THROW(build_domain(cube, {.merge_angle_deg = 90}), OptionError);
  EXPECT_THROW(build_domain(cube, {.merge_angle_deg = -1}), OptionError);
}

}  // namespace
}  // namespace voropack
