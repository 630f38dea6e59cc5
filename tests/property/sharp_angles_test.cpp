// Polytopes at any angle: from domain to certified mesh for families with small angles, wherever they lie, however
// large they are and in whatever order they list their polytopes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "support/sharp_domains.h"

namespace voropack {
namespace {

using test::Case;
namespace sharp = test::sharp;

template <int D, std::size_t N>
double measure_of(const std::array<Vec<D>, N>& x) {
  if constexpr (N == 2)
    return distance(x[0], x[1]);
  else
    return 0.5 * norm(cross(x[1] - x[0], x[2] - x[0]));
}

/// Lengths of segments, or areas of facets, added up by marker.
using Measures = std::map<int, double>;

template <int D>
void expect_same_measures(const Measures& expected, const Measures& found, double tolerance) {
  ASSERT_EQ(expected.size(), found.size());
  for (const auto& [marker, measure] : expected) {
    ASSERT_TRUE(found.contains(marker)) << marker;
    EXPECT_NEAR(found.at(marker), measure, tolerance) << marker;
  }
}

template <int D>
void expect_every_polytope(const Domain<D>& domain, const Mesh<D>& mesh, double tolerance) {
  Measures segments, found_segments, facets, found_facets;
  for (const SegmentId s : ids(domain.segments))
    segments[domain.segment_marker[s]] +=
        distance(domain.points[domain.segments[s][0]], domain.points[domain.segments[s][1]]);
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    std::array<Vec<D>, D> corners;
    for (std::size_t i = 0; i < D; ++i) corners[i] = mesh.points[mesh.boundary_vertices[b][i]];
    (D == 2 ? found_segments : found_facets)[mesh.boundary_marker[b]] += measure_of(corners);
  }
  if constexpr (D == 3) {
    for (const EdgeId e : ids(mesh.segment_edges))
      found_segments[mesh.segment_edge_marker[e]] +=
          distance(mesh.points[mesh.segment_edges[e][0]], mesh.points[mesh.segment_edges[e][1]]);
    for (const FacetId f : ids(domain.facet_frame))
      for (const auto& t : domain.facet_triangles[f])
        facets[domain.facet_marker[f]] +=
            measure_of<3, 3>({domain.points[t[0]], domain.points[t[1]], domain.points[t[2]]});
    expect_same_measures<D>(facets, found_facets, tolerance * domain.diameter());
  }
  expect_same_measures<D>(segments, found_segments, tolerance);
}

/// `excepted`: a check whose result is open.
template <int D>
MeshingResult<D> expect_certified(const Case<D>& c, const MeshingOptions<D>& options = {},
                                  std::string_view excepted = {}) {
  SCOPED_TRACE(c.name);
  MeshingResult<D> r = make_mesh(c.input, options);
  EXPECT_EQ(r.certificate.checks.size(), 11U);
  for (const Certificate::Check& check : r.certificate.checks) {
    if (check.name == excepted) continue;
    EXPECT_TRUE(check.ok) << check.name << ": " << check.where;
    EXPECT_EQ(check.violations, 0U) << check.name << ": " << check.where;
    EXPECT_GT(check.tested, 0U) << check.name;
  }
  EXPECT_EQ(find_mesh_fault(r.mesh), "");
  EXPECT_EQ(r.quality.n_negative_faces, 0U);
  // Far from the origin the domain's own points are rounded: each moves by at most this.
  double largest = 0;
  for (const Vec<D>& x : c.input.points)
    for (int k = 0; k < D; ++k) largest = std::max(largest, std::abs(x[k]));
  const double rounding = D * largest * std::numeric_limits<double>::epsilon();
  const double size = r.domain.diameter(), surface = 8 * std::pow(size, D - 1);
  EXPECT_NEAR(r.quality.domain_volume, c.measure, 1e-10 * c.measure + rounding * surface);
  EXPECT_NEAR(r.quality.volume_sum, r.quality.domain_volume, 1e-10 * c.measure);
  expect_every_polytope(r.domain, r.mesh, 1e-10 * size + 100 * rounding);
  return r;
}

TEST(SharpAngles3, WedgesOfManyAngles) {
  for (const double degrees : {1.0, 2.0, 5.0, 10.0, 20.0, 45.0, 60.0, 89.0}) expect_certified(sharp::wedge(degrees));
}

TEST(SharpAngles3, SkewWedgesOfManyAngles) {
  for (const double degrees : {20.0, 45.0, 60.0, 89.0}) expect_certified(sharp::skew_wedge(degrees));
}

TEST(SharpAngles3, PyramidsOfManySides) {
  expect_certified(sharp::pyramid(3, 15));
  expect_certified(sharp::pyramid(4, 30));
  expect_certified(sharp::pyramid(5, 60));
  expect_certified(sharp::pyramid(7, 60));
}

TEST(SharpAngles3, BooksOfManyPages) {
  for (const int n : {3, 4, 6, 12}) expect_certified(sharp::equal_book(n));
  for (int n = 3; n <= 12; ++n) expect_certified(sharp::random_book(n, 1, static_cast<std::uint64_t>(n)));
}

/// Two pages near to each other do not make a third one pay.
TEST(SharpAngles3, PagesOfABookPayForTheirOwnAngles) {
  const std::size_t pair = expect_certified(sharp::book({0, 2}, "pair")).mesh.points.size();
  const std::size_t three = expect_certified(sharp::book({0, 2, 53}, "pair and one")).mesh.points.size();
  EXPECT_LT(three, 2 * pair);
}

TEST(SharpAngles3, CracksThatEndInside) {
  for (const double degrees : {10.0, 30.0}) expect_certified(sharp::leaning_crack(degrees));
}

TEST(SharpAngles3, Needles) { expect_certified(sharp::needle(0.1)); }

/// Without moves of single spheres `radius_edge` fails in most of these.
TEST(SharpAngles3, HeapsOfTetrahedra) {
  for (const std::uint64_t seed : {0, 1, 8}) expect_certified(sharp::heap<3>(6, 0.4, seed));
  for (const std::uint64_t seed : {2, 3, 6, 7}) expect_certified(sharp::heap<3>(5, 0.4, seed));
  // The rest of the 200 is in bench/micro/heaps.
  for (const std::uint64_t seed : {0, 1, 2, 4, 22, 113}) expect_certified(sharp::tetrahedra(2 + seed % 4, 3, seed));
}

/// Pages take no steps as small as those of segments that are far from them in angle: R / l where both meet would be
/// their product.
TEST(SharpAngles3, SmallAnglesInOneCornerDoNotMultiply) {
  expect_certified(sharp::heap<3>(12, 0.4, 7));
  expect_certified(sharp::heap<3>(7, 0.4, 34));
}

TEST(SharpAngles2, FansOfManyAngles) {
  for (const double degrees : {0.5, 1.0, 3.0, 10.0, 30.0})
    for (const int n : {2, 5}) expect_certified(sharp::fan(n, degrees));
}

TEST(SharpAngles2, SliversOfManyAngles) {
  for (const double degrees : {0.5, 2.0, 10.0, 40.0}) expect_certified(sharp::sliver(degrees));
}

TEST(SharpAngles2, SlitsThatEndInside) {
  for (const double degrees : {0.5, 5.0, 45.0}) expect_certified(sharp::leaning_slit(degrees));
}

TEST(SharpAngles2, HeapsOfTriangles) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) expect_certified(sharp::heap<2>(6 + seed, 0.4, seed));
}

/// Every way to fill the interior keeps the balls of sharp features empty.
TEST(SharpAngles2, EveryFilling) {
  for (const auto& filling : test::all_fillings()) {
    expect_certified(sharp::fan(5, 3), test::meshing_options<2>(filling));
    expect_certified(sharp::sliver(5), test::meshing_options<2>(filling));
  }
}
TEST(SharpAngles3, EveryFilling) {
  for (const auto& filling : test::all_fillings()) {
    expect_certified(sharp::wedge(30), test::meshing_options<3>(filling));
    expect_certified(sharp::pyramid(4, 60), test::meshing_options<3>(filling));
  }
}

template <int D>
void expect_certified_anywhere(const Case<D>& c, std::uint64_t seed) {
  expect_certified(sharp::moved(c, seed, 1, 0));
  expect_certified(sharp::moved(c, seed + 1, 1e-6, 0));
  expect_certified(sharp::moved(c, seed + 2, 1e6, 0));
  expect_certified(sharp::moved(c, seed + 3, 1, 1e6));
  expect_certified(sharp::renumbered(c, seed));
}
/// Where coordinates are rounded to 1e-10, as much as centers keep from protecting balls elsewhere; fine meshes have
/// enough balls for that to show.
TEST(SharpAngles3, ManyBallsFarFromTheOrigin) {
  const Vec<3> low{1e6, 1e6, 1e6}, high{1e6 + 1, 1e6 + 1, 1e6 + 1};
  for (const double size : {0.13, 0.1, 0.08}) {
    MeshingOptions<3> options;
    options.wishes.size = size;
    expect_certified(sharp::make_case("far box", domains::box<3>(low, high), 1), options);
  }
}
TEST(SharpAngles2, AnywhereAndInAnyOrder) {
  expect_certified_anywhere(sharp::fan(5, 5), 1);
  expect_certified_anywhere(sharp::sliver(5), 2);
  expect_certified_anywhere(sharp::heap<2>(16, 0.35, 11), 3);
}
TEST(SharpAngles3, AnywhereAndInAnyOrder) {
  expect_certified_anywhere(sharp::wedge(20), 1);
  expect_certified_anywhere(sharp::pyramid(4, 60), 2);
}

/// A wide book pays nothing for a small angle: between equal pages f need not shrink with it.
TEST(SharpAngles2, TheNumberOfVerticesGrowsSlowlyWithTheAngle) {
  const std::size_t at_ten = expect_certified(sharp::fan(2, 10)).mesh.points.size();
  const std::size_t at_one = expect_certified(sharp::fan(2, 1)).mesh.points.size();
  EXPECT_LT(at_one, 5 * at_ten);
}

/// The same input gives the same mesh for any number of threads, in sharp features too.
TEST(SharpAngles3, ThreadsChangeNothing) {
  MeshingOptions<3> one, two;
  one.threads = 1;
  two.threads = 2;
  const Case<3> c = sharp::skew_wedge(30);
  EXPECT_EQ(make_mesh(c.input, one).mesh, make_mesh(c.input, two).mesh);
}

}  // namespace
}  // namespace voropack
