// From domain to certified mesh: whatever the shape, its position and size, and the way to fill it, the mesh is
// boundary-conforming Delaunay and its control volumes add up to the domain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/cases.h"
#include "voropack/mesh.h"

namespace voropack {
namespace {

using test::all_cases;
using test::all_fillings;
using test::Case;
using test::Filling;

std::string failures(const Certificate& certificate) {
  std::string text;
  for (const Certificate::Check& c : certificate.checks)
    if (!c.ok) text += c.name + ": " + std::to_string(c.violations) + ", worst " + c.where + "; ";
  return text;
}

void expect_all_checks_ran(const Certificate& certificate) {
  EXPECT_EQ(certificate.checks.size(), 11U);
  for (const Certificate::Check& c : certificate.checks) {
    EXPECT_TRUE(c.ok) << c.name;
    EXPECT_EQ(c.violations, 0U) << c.name;
    EXPECT_GT(c.tested, 0U) << c.name;
  }
}

/// The volumes of cells and of simplices, whole and by region, against those of the domain. `scale` is a length.
template <int D>
void expect_volumes(const MeshingResult<D>& r, const Case<D>& c, double scale) {
  const double unit = std::pow(scale, D), whole = c.measure * unit;
  EXPECT_NEAR(r.quality.volume_sum, whole, 1e-12 * whole);
  EXPECT_NEAR(r.quality.domain_volume, whole, 1e-12 * whole);
  std::vector<double> expected = c.regions;
  if (expected.empty()) expected = {c.measure};
  ASSERT_EQ(r.quality.regions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(r.quality.regions[i].volume, expected[i] * unit, 1e-12 * whole);
}

template <int D>
MeshingResult<D> mesh_and_check(const Case<D>& c, const DomainInput<D>& input, const Filling& filling,
                                std::optional<double> size, double scale) {
  SCOPED_TRACE(c.name + ", " + filling.name + ", size " + (size ? std::to_string(*size) : "none"));
  MeshingOptions<D> options = test::meshing_options<D>(filling, size);
  options.domain.min_angle_deg = c.min_angle_deg;
  MeshingResult<D> r = make_mesh(input, options);
  EXPECT_TRUE(r.certificate.ok) << failures(r.certificate);
  expect_all_checks_ran(r.certificate);
  EXPECT_EQ(find_mesh_fault(r.mesh), "");
  EXPECT_EQ(r.quality.n_negative_faces, 0U);
  EXPECT_EQ(r.quality.n_vertices, r.mesh.points.size());
  EXPECT_LT(r.mesh.points.size(), 6000U);
  expect_volumes(r, c, scale);
  return r;
}

template <int D>
void every_shape_with_every_filling() {
  for (const Case<D>& c : all_cases<D>())
    for (const Filling& f : all_fillings()) mesh_and_check(c, c.input, f, {}, 1);
}
TEST(ConformingMesh2, EveryShapeWithEveryFilling) { every_shape_with_every_filling<2>(); }
TEST(ConformingMesh3, EveryShapeWithEveryFilling) { every_shape_with_every_filling<3>(); }

template <int D>
void every_shape_in_several_sizes(const std::vector<double>& sizes) {
  const std::vector<Filling> fillings = all_fillings();
  std::size_t i = 0;
  for (const Case<D>& c : all_cases<D>()) {
    std::size_t last = 0;
    for (const double size : sizes) {
      const double wanted = size * std::pow(c.measure, 1.0 / D);
      const auto r = mesh_and_check(c, c.input, fillings[i % 2], wanted, 1);
      EXPECT_GE(r.mesh.points.size(), last) << c.name << ": a smaller size, but fewer vertices";
      last = r.mesh.points.size();
    }
    ++i;
  }
}
TEST(ConformingMesh2, EveryShapeInSeveralSizes) { every_shape_in_several_sizes<2>({0.3, 0.1, 0.03}); }
TEST(ConformingMesh3, EveryShapeInSeveralSizes) { every_shape_in_several_sizes<3>({0.3, 0.15}); }

template <int D>
void moved_shapes() {
  const std::vector<Filling> fillings = all_fillings();
  struct Motion {
    std::uint64_t seed;
    double scale, shift;
  };
  std::size_t i = 0;
  for (const Case<D>& c : all_cases<D>())
    for (const Motion& m : {Motion{1, 1, 0}, Motion{2, 1e-3, 0}, Motion{3, 1e3, 0}, Motion{4, 1, 100}}) {
      SCOPED_TRACE("seed " + std::to_string(m.seed));
      const DomainInput<D> input = domains::tilted(c.input, m.seed, m.scale, m.shift);
      // Coordinates near 100 are rounded to 1e-14, and so are the volumes of the domain itself.
      if (m.shift == 0) {
        mesh_and_check(c, input, fillings[i++ % 4], {}, m.scale);
        continue;
      }
      const auto r = make_mesh(input, [&] {
        auto options = test::meshing_options<D>(fillings[i++ % 4]);
        options.domain.min_angle_deg = c.min_angle_deg;
        return options;
      }());
      EXPECT_TRUE(r.certificate.ok) << c.name << ": " << failures(r.certificate);
      EXPECT_NEAR(r.quality.volume_sum, c.measure, 1e-11 * c.measure) << c.name;
    }
}
TEST(ConformingMesh2, MovedShapes) { moved_shapes<2>(); }
TEST(ConformingMesh3, MovedShapes) { moved_shapes<3>(); }

/// The mesh follows what the domain is scaled by: a power of two changes no digit of any coordinate.
template <int D>
void scaling_by_a_power_of_two() {
  for (const Filling& f : all_fillings()) {
    const DomainInput<D> input = domains::l_shape<D>();
    const auto by = [&](double s) { return domains::mapped(input, [&](const Vec<D>& x) { return s * x; }); };
    const Mesh<D> a = make_mesh(input, test::meshing_options<D>(f)).mesh;
    const Mesh<D> b = make_mesh(by(0x1p-10), test::meshing_options<D>(f)).mesh;
    EXPECT_EQ(a.points.size(), b.points.size()) << f.name;
    EXPECT_EQ(a.simplex_vertices, b.simplex_vertices) << f.name;
  }
}
TEST(ConformingMesh2, ScalingByAPowerOfTwoChangesNoSimplex) { scaling_by_a_power_of_two<2>(); }
TEST(ConformingMesh3, ScalingByAPowerOfTwoChangesNoSimplex) { scaling_by_a_power_of_two<3>(); }

/// Each vertex is on a polytope of the dimension that the mesh says, and polytopes' markers reach vertices and
/// boundary.
TEST(ConformingMesh3, VerticesKnowWhatCarriesThem) {
  const Mesh<3> mesh = make_mesh(domains::unit_cube()).mesh;
  std::array<std::size_t, 4> count{};
  for (const VertexId v : ids(mesh.points)) {
    int on = 0;
    for (int k = 0; k < 3; ++k) on += mesh.points[v][k] == 0 || mesh.points[v][k] == 1 ? 1 : 0;
    EXPECT_EQ(mesh.vertex_carrier_dimension[v], 3 - on);
    ++count[static_cast<std::size_t>(3 - on)];
    if (on == 1) {
      EXPECT_GE(mesh.vertex_marker[v], 1);
    }
    if (on == 0) {
      EXPECT_EQ(mesh.vertex_marker[v], 0);
    }
  }
  EXPECT_EQ(count[0], 8U);
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    EXPECT_GE(mesh.boundary_marker[b], 1);
    EXPECT_LE(mesh.boundary_marker[b], 6);
  }
}

/// Regions lie where their seeds are.
template <int D>
void regions_are_on_their_side() {
  const Mesh<D> mesh = make_mesh(domains::two_material_box<D>()).mesh;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    Vec<D> center;
    for (const VertexId v : mesh.simplex_vertices[s]) center += mesh.points[v] / (D + 1.0);
    EXPECT_EQ(mesh.simplex_region[s], center[0] < 1 ? 7 : 9);
  }
}
TEST(ConformingMesh2, RegionsAreOnTheirSide) { regions_are_on_their_side<2>(); }
TEST(ConformingMesh3, RegionsAreOnTheirSide) { regions_are_on_their_side<3>(); }

}  // namespace
}  // namespace voropack
