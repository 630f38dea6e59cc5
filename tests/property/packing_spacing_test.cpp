// What sizes mean, and how many vertices they cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "geom/circumcenter.h"
#include "support/cases.h"

namespace voropack {
namespace {

using test::all_fillings;
using test::Filling;

template <int D>
double depth(const Vec<D>& x) {
  double least = 1;
  for (int k = 0; k < D; ++k) least = std::min({least, x[k], 1 - x[k]});
  return least;
}

/// Mean length of the edges of a mesh of the unit box whose ends are both farther than `margin` from its walls.
template <int D>
double mean_edge(const Mesh<D>& mesh, double margin) {
  std::set<std::array<VertexId, 2>> edges;
  for (const auto& corners : mesh.simplex_vertices)
    for (std::size_t i = 0; i <= D; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (depth(mesh.points[corners[i]]) > margin && depth(mesh.points[corners[j]]) > margin)
          edges.insert({std::min(corners[i], corners[j]), std::max(corners[i], corners[j])});
  double sum = 0;
  for (const auto& [a, b] : edges) sum += distance(mesh.points[a], mesh.points[b]);
  EXPECT_GT(edges.size(), 100U);
  return sum / static_cast<double>(edges.size());
}

template <int D>
void size_is_the_mean_edge(double size) {
  for (const Filling& f : all_fillings()) {
    const auto r = make_mesh(domains::unit_box<D>(), test::meshing_options<D>(f, size));
    EXPECT_TRUE(r.certificate.ok) << f.name;
    EXPECT_NEAR(mean_edge(r.mesh, 2 * size), size, 0.1 * size) << f.name;
  }
}
TEST(Size, IsTheMeanEdgeFarFromTheBoundaryInThePlane) { size_is_the_mean_edge<2>(0.03); }
TEST(Size, IsTheMeanEdgeFarFromTheBoundaryInSpace) { size_is_the_mean_edge<3>(0.12); }

/// Meshes of less than some hundred vertices are as much by chance.
constexpr double kFewSpheres = 20;
template <int D>
void estimate_is_near(const char* name, const DomainInput<D>& input, const SizeWishes<D>& wishes,
                      double tolerance = 0.1) {
  const auto domain = build_domain(input);
  const Spacing<D> spacing = build_spacing(domain, wishes);
  for (const Filling& filling : all_fillings()) {
    const PackingOptions options = test::meshing_options<D>(filling, 1).packing;
    const Packing<D> packing = pack(domain, spacing, options);
    if (packing.repair_rounds > 0) continue;  // Nothing foresees how much smaller repairs make f.
    const auto real = static_cast<double>(packing.center.size());
    EXPECT_NEAR(estimate_sphere_count(domain, spacing, options), real, tolerance * real + kFewSpheres)
        << name << ' ' << filling.name;
  }
}
/// `relative` is the largest f by the diameter of the box of all points.
template <int D>
SizeWishes<D> largest_spacing(const DomainInput<D>& input, double relative) {
  Box<D> box;
  for (const Vec<D>& x : input.points) box.add(x);
  SizeWishes<D> wishes;
  wishes.spacing = relative * box.diagonal();
  return wishes;
}
template <int D>
void estimate_is_near(const char* name, const DomainInput<D>& input, double relative) {
  estimate_is_near(name, input, largest_spacing(input, relative));
}
template <int D>
SizeWishes<D> expression(const char* text) {
  SizeWishes<D> wishes;
  wishes.expression = text;
  return wishes;
}
TEST(Estimate, IsNearTheCountInThePlane) {
  for (const double f : {0.05, 0.02, 0.005}) estimate_is_near("square", domains::unit_square(), f);
  estimate_is_near("hole", domains::box_with_hole<2>(), SizeWishes<2>{});
  estimate_is_near("hole", domains::box_with_hole<2>(), 0.01);
  estimate_is_near("L", domains::l_shape<2>(), 0.01);
  estimate_is_near("two materials", domains::two_material_box<2>(), 0.01);
  estimate_is_near("strip", domains::box<2>({0, 0}, {10, 0.2}), SizeWishes<2>{}, 0.15);
  estimate_is_near("strip", domains::box<2>({0, 0}, {10, 0.2}), 0.005);
}
TEST(Estimate, IsNearTheCountInSpace) {
  for (const double f : {0.06, 0.03, 0.02}) estimate_is_near("cube", domains::unit_cube(), f);
  estimate_is_near("hole", domains::box_with_hole<3>(), 0.03);
  estimate_is_near("L", domains::l_shape<3>(), 0.03);
  estimate_is_near("two materials", domains::two_material_box<3>(), 0.02);
  estimate_is_near("wall", domains::box_with_internal_wall<3>(), SizeWishes<3>{}, 0.3);
  estimate_is_near("plate", domains::box<3>({0, 0, 0}, {4, 4, 0.2}), SizeWishes<3>{});
  estimate_is_near("rod", domains::box<3>({0, 0, 0}, {5, 0.3, 0.3}), 0.01);
}

/// Lattices come in few sizes: a region that asks for a size between two of them gets more spheres than it needs.
template <int D>
void estimate_knows_lattices(double size) {
  for (const double part : {0.55, 0.62, 0.8}) {
    SizeWishes<D> wishes;
    wishes.size = size;
    wishes.region_size[7] = part * size;
    estimate_is_near("regions", domains::two_material_box<D>(), wishes);
  }
}
TEST(Estimate, KnowsTheSizesOfLatticesInThePlane) { estimate_knows_lattices<2>(0.03); }
TEST(Estimate, KnowsTheSizesOfLatticesInSpace) { estimate_knows_lattices<3>(0.15); }

TEST(Estimate, KnowsThatGradedPartsHaveNoLattice) {
  estimate_is_near("linear", domains::unit_square(), expression<2>("0.008 + 0.08 * x"));
  estimate_is_near("bowl", domains::unit_square(), expression<2>("0.02 + 0.1 * ((x - 0.5)^2 + (y - 0.5)^2)"));
  estimate_is_near("linear", domains::unit_cube(), expression<3>("0.07 + 0.15 * x"));
}

/// f is constant but near one small region, which few samples would miss.
TEST(Estimate, FindsASmallFinePart) {
  auto input = domains::unit_square();
  domains::add_box<2>(input, {0.02, 0.02}, {0.03, 0.03});
  input.region_seeds.push_back({{0.025, 0.025}, 7, {}});
  SizeWishes<2> wishes;
  wishes.size = 0.2;
  wishes.region_size[7] = 0.0004;
  estimate_is_near("inclusion", input, wishes);
}

MeshingResult<3> uniform_cube(Interior interior) {
  MeshingOptions<3> options;
  options.wishes.spacing = 0.0425;
  options.packing.interior = interior;
  return make_mesh(domains::unit_cube(), options);
}

/// Table 1 of the paper has packings of this density. Lemma 3.1 with b = 0: a circumcenter that a sphere blocks is at
/// most two radii away. At facets the protecting balls block too.
TEST(UniformSpacing, HasTheCountsAndRatiosOfRandomPackings) {
  const auto r = uniform_cube(Interior::kRandom);
  EXPECT_NEAR(static_cast<double>(r.mesh.points.size()), 1435, 0.05 * 1435);
  EXPECT_NEAR(r.quality.radius_edge.mean, 0.82, 0.02);
  std::vector<std::pair<Vec<3>, double>> balls;
  const auto& x = r.mesh.points;
  for (const auto& [a, b, c] : r.mesh.boundary_vertices) {
    const Vec<3> m = triangle_circumcenter(x[a], x[b], x[c]);
    balls.push_back({m, distance(m, x[a])});
  }
  for (const auto& [a, b] : r.mesh.segment_edges) balls.push_back({0.5 * (x[a] + x[b]), 0.5 * distance(x[a], x[b])});
  double worst_inside = 0, worst_at_boundary = 0;
  for (const auto& s : r.mesh.simplex_vertices) {
    const std::array<Vec<3>, 4> p = {x[s[0]], x[s[1]], x[s[2]], x[s[3]]};
    const Vec<3> c = circumcenter<3>(p);
    double shortest = 1;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) shortest = std::min(shortest, distance(p[i], p[j]));
    const bool in_ball = std::any_of(balls.begin(), balls.end(), [&](const auto& ball) {
      return distance(c, ball.first) <= ball.second * (1 + 1e-8);
    });
    double& worst = in_ball ? worst_at_boundary : worst_inside;
    worst = std::max(worst, distance(c, p[0]) / shortest);
  }
  EXPECT_LE(worst_inside, 1.0);
  EXPECT_GT(worst_inside, 0.9);
  EXPECT_LE(worst_at_boundary, 2.0);
}

TEST(UniformSpacing, LatticesNeedFewerVertices) {
  const auto lattice = uniform_cube(Interior::kLattice), random = uniform_cube(Interior::kRandom);
  EXPECT_LT(lattice.mesh.points.size(), 0.8 * static_cast<double>(random.mesh.points.size()));
  EXPECT_TRUE(lattice.certificate.ok);
}

/// Brute force: no circumcenter of a simplex (of some 500) could be one more center, under the very f of the packing.
template <int D>
void no_circumcenter_can_be_added(const test::Case<D>& c, const Filling& filling) {
  MeshingOptions<D> options = test::meshing_options<D>(filling);
  options.domain.min_angle_deg = c.min_angle_deg;
  const auto r = make_mesh(c.input, options);
  const Spacing<D> f = test::spacing_of(r, options);
  const Mesh<D>& mesh = r.mesh;
  const auto ball_holds = [&](const Vec<D>& x, const auto& corners) {
    const auto& p = mesh.points;
    Vec<D> m;
    if constexpr (std::tuple_size_v<std::decay_t<decltype(corners)>> == 2)
      m = 0.5 * (p[corners[0]] + p[corners[1]]);
    else
      m = triangle_circumcenter(p[corners[0]], p[corners[1]], p[corners[2]]);
    return distance_sq(x, m) <= distance_sq(p[corners[0]], m) * (1 + 2e-9);
  };
  const std::size_t stride = 1 + mesh.simplex_vertices.size() / 500;
  for (std::size_t k = 0; k < mesh.simplex_vertices.size(); k += stride) {
    const auto& s = mesh.simplex_vertices[SimplexId(k)];
    std::array<Vec<D>, D + 1> p;
    for (std::size_t i = 0; i <= D; ++i) p[i] = mesh.points[s[i]];
    const Vec<D> center = circumcenter<D>(p);
    const double fc = f(center);
    bool blocked = false;
    for (const VertexId v : ids(mesh.points))
      blocked = blocked || distance(center, mesh.points[v]) < (fc + mesh.vertex_spacing[v]) * (1 + 1e-11);
    for (const auto& b : mesh.boundary_vertices) blocked = blocked || ball_holds(center, b);
    for (const auto& e : mesh.segment_edges) blocked = blocked || ball_holds(center, e);
    EXPECT_TRUE(blocked) << c.name << ", " << filling.name;
  }
}
template <int D>
void voronoi_maximality() {
  for (const auto& c : test::all_cases<D>())
    for (std::size_t i = 0; i < 2; ++i) no_circumcenter_can_be_added(c, all_fillings()[i]);
}
TEST(VoronoiMaximality, NoCircumcenterCanBeAddedInThePlane) { voronoi_maximality<2>(); }
TEST(VoronoiMaximality, NoCircumcenterCanBeAddedInSpace) { voronoi_maximality<3>(); }

}  // namespace
}  // namespace voropack
