// The certificate finds sharp features in the mesh itself: which vertices lie on polytopes that meet at small angles.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "certificate/sharp_features.h"
#include "support/cases.h"
#include "support/sharp_domains.h"

namespace voropack {
namespace {

using std::numbers::pi;
namespace sharp = test::sharp;

template <int D>
judge::SharpFeatures<D> features_of(const Mesh<D>& mesh) {
  judge::Tally faults;
  const judge::Topology<D> topology(mesh, faults, silent_observer());
  EXPECT_EQ(faults.violations, 0U);
  return judge::SharpFeatures<D>(mesh, topology);
}

/// A wedge's vertices by place: 1 inside the page z = 0, 2 inside the other page, 4 on the spine, 0 elsewhere.
int place_of(const Vec<3>& x, double angle) {
  const bool on_first = x[1] == 0, on_second = std::abs(x[0] * std::sin(angle) - x[1] * std::cos(angle)) < 1e-12;
  const bool at_end = x[2] == 0 || x[2] == 1 || std::abs(x[0] - 1 + std::tan(angle / 2) * x[1]) < 1e-9;
  if (on_first && on_second) return 4;
  if (at_end) return 0;
  return on_first ? 1 : on_second ? 2 : 0;
}

void expect_wedge(const Mesh<3>& mesh, double angle) {
  const judge::SharpFeatures<3> features = features_of(mesh);
  EXPECT_FALSE(features.empty());
  std::array<std::vector<std::uint32_t>, 5> by_place;
  for (const VertexId v : ids(mesh.points))
    by_place[static_cast<std::size_t>(place_of(mesh.points[v], angle))].push_back(v.value());
  ASSERT_GT(by_place[1].size(), 3U);
  ASSERT_GT(by_place[2].size(), 3U);
  for (const std::uint32_t u : by_place[1]) {
    for (const std::uint32_t v : by_place[2]) {
      ASSERT_TRUE(features.carrier_angle(u, v));
      EXPECT_NEAR(*features.carrier_angle(u, v), angle, 1e-9);
      ASSERT_TRUE(features.angle(u, v));
      EXPECT_NEAR(*features.angle(u, v), angle, 1e-9);
    }
    for (const std::uint32_t v : by_place[1]) EXPECT_FALSE(features.carrier_angle(u, v));
    for (const std::uint32_t v : by_place[4]) EXPECT_FALSE(features.carrier_angle(u, v)) << "the spine is in the page";
  }
}

TEST(SharpFeatures, OfAWedge) {
  for (const double degrees : {10.0, 30.0, 55.0}) {
    Mesh<3> mesh = test::mesh_of(sharp::wedge(degrees).input, 0.2);
    expect_wedge(mesh, sharp::radians(degrees));
    // Files need not list segments' edges, nor what carries a vertex.
    mesh.segment_edges.clear();
    mesh.segment_edge_marker.clear();
    expect_wedge(mesh, sharp::radians(degrees));
    mesh.vertex_carrier_dimension.clear();
    mesh.vertex_marker.clear();
    expect_wedge(mesh, sharp::radians(degrees));
    // Nor markers.
    for (int& marker : mesh.boundary_marker) marker = 0;
    expect_wedge(mesh, sharp::radians(degrees));
  }
}

TEST(SharpFeatures, OfAFan) {
  const Mesh<2> mesh = test::mesh_of(sharp::fan(3, 10).input, 0.1);
  const judge::SharpFeatures<2> features = features_of(mesh);
  // By the segment of the fan that holds a vertex, its ends excluded.
  std::array<std::vector<std::uint32_t>, 3> on;
  for (const VertexId v : ids(mesh.points)) {
    const Vec<2>& x = mesh.points[v];
    if (mesh.vertex_carrier_dimension[v] != 1 || norm(x) > 1.31 || !(x[0] > 0)) continue;
    const double angle = std::atan2(x[1], x[0]) * 180 / pi;
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(angle - 10.0 * static_cast<double>(i)) < 1e-9) on[i].push_back(v.value());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_GT(on[i].size(), 3U);
    for (std::size_t j = 0; j < 3; ++j)
      for (const std::uint32_t u : on[i])
        for (const std::uint32_t v : on[j]) {
          const auto angle = features.carrier_angle(u, v);
          ASSERT_EQ(angle.has_value(), i != j);
          if (angle) {
            EXPECT_NEAR(*angle, sharp::radians(i + j == 2 ? 20 : 10), 1e-9);
          }
        }
  }
}

TEST(SharpFeatures, NothingIsSharpAtSixtyDegreesAndMore) {
  EXPECT_TRUE(features_of(make_mesh(domains::unit_cube()).mesh).empty());
  EXPECT_TRUE(features_of(make_mesh(domains::tilted(domains::l_shape<3>(), 2)).mesh).empty());
  EXPECT_TRUE(features_of(make_mesh(domains::box_with_marked_facet()).mesh).empty());
  EXPECT_TRUE(features_of(make_mesh(domains::tilted(domains::box_with_hole<2>(), 3)).mesh).empty());
}

/// A regular tetrahedron's edges meet the opposite facets at 54.7 degrees: a segment and a facet are sharp, too.
TEST(SharpFeatures, OfASegmentAndAFacet) {
  const Mesh<3> mesh = test::mesh_of(domains::regular_simplex<3>(), 0.15);
  const judge::SharpFeatures<3> features = features_of(mesh);
  EXPECT_FALSE(features.empty());
  const double angle = std::atan(std::sqrt(2.0));
  int n_sharp = 0;
  for (const VertexId u : ids(mesh.points))
    for (const VertexId v : ids(mesh.points))
      if (const auto found = features.carrier_angle(u.value(), v.value())) {
        EXPECT_NEAR(*found, angle, 1e-9);
        EXPECT_EQ(mesh.vertex_carrier_dimension[u] + mesh.vertex_carrier_dimension[v], 3);
        ++n_sharp;
      }
  EXPECT_GT(n_sharp, 0);
}

}  // namespace
}  // namespace voropack
