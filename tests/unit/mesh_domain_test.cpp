// The domain of a mesh is the one that it was made from.
#include "voropack/mesh_domain.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/cases.h"

namespace voropack {
namespace {

template <int D>
std::vector<int> sorted_markers(const IdVector<SegmentId, int>& segments, const IdVector<FacetId, int>& facets) {
  std::vector<int> markers = D == 3 ? facets.raw() : segments.raw();
  std::sort(markers.begin(), markers.end());
  return markers;
}

template <int D>
void expect_same(const Domain<D>& a, const Domain<D>& b, const std::string& name) {
  SCOPED_TRACE(name);
  EXPECT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.segments.size(), b.segments.size());
  EXPECT_EQ(a.facet_frame.size(), b.facet_frame.size());
  EXPECT_EQ((sorted_markers<D>(a.segment_marker, a.facet_marker)),
            (sorted_markers<D>(b.segment_marker, b.facet_marker)));
  auto measures = [](const Domain<D>& d) {
    std::vector<std::pair<int, double>> result;
    for (const RegionId r : ids(d.region_id)) result.emplace_back(d.region_id[r], d.region_measure[r]);
    std::sort(result.begin(), result.end());
    return result;
  };
  const auto ma = measures(a), mb = measures(b);
  ASSERT_EQ(ma.size(), mb.size());
  for (std::size_t i = 0; i < ma.size(); ++i) {
    EXPECT_EQ(ma[i].first, mb[i].first);
    EXPECT_NEAR(ma[i].second, mb[i].second, 1e-12 * ma[i].second);
  }
}

template <int D>
void domains_come_back() {
  for (const test::Case<D>& c : test::all_cases<D>()) {
    MeshingOptions<D> options;
    options.wishes.size = D == 2 ? 0.15 : 0.4;
    const MeshingResult<D> made = make_mesh(c.input, options);
    const MeshDomain<D> found = domain_of(made.mesh);
    expect_same(found.domain, made.domain, c.name);
    for (const VertexId v : ids(made.mesh.points))
      EXPECT_EQ(found.carrier[v].dimension, made.mesh.vertex_carrier_dimension[v])
          << c.name << ", vertex " << v.value();
  }
}
template <int D>
void meshes_are_found_in_their_domains() {
  for (const test::Case<D>& c : test::all_cases<D>()) {
    SCOPED_TRACE(c.name);
    MeshingOptions<D> options;
    options.wishes.size = D == 2 ? 0.15 : 0.4;
    const MeshingResult<D> made = make_mesh(c.input, options);
    Mesh<D> bare = made.mesh;  // As most files tell it.
    bare.vertex_carrier_dimension.clear();
    const MeshDomain<D> told = place_in_domain(made.mesh, made.domain), found = place_in_domain(bare, made.domain);
    EXPECT_EQ(told.domain.points, made.domain.points);
    EXPECT_EQ(told.carrier, found.carrier);
    EXPECT_EQ(told.segment_chains, found.segment_chains);
    for (const VertexId v : ids(made.mesh.points))
      EXPECT_EQ(told.carrier[v].dimension, made.mesh.vertex_carrier_dimension[v]) << "vertex " << v.value();
  }
}
TEST(MeshDomain, MeshesAreFoundInTheirDomainsInThePlane) { meshes_are_found_in_their_domains<2>(); }
TEST(MeshDomain, MeshesAreFoundInTheirDomainsInSpace) { meshes_are_found_in_their_domains<3>(); }

TEST(MeshDomain, OtherDomainsAreRefused) {
  const MeshingResult<3> made = make_mesh(domains::two_material_box<3>());
  const auto expect_refused = [&](const Domain<3>& domain) {
    try {
      place_in_domain(made.mesh, domain);
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      EXPECT_EQ(error.faults().front().id, "mesh.other_domain");
    }
  };
  expect_refused(build_domain(domains::unit_box<3>()));  // Other regions.
  Domain<3> other_ids = made.domain;
  other_ids.region_id[RegionId(0)] = 77;
  expect_refused(other_ids);
  Domain<3> moved = made.domain;  // As large as the mesh, but elsewhere.
  for (Vec<3>& x : moved.points) x[0] += 1e-3;
  expect_refused(moved);
  EXPECT_NO_THROW(place_in_domain(made.mesh, moved, 2e-3));
}

TEST(MeshDomain, FacetsMayBeFlatUpToTheTolerance) {
  MeshingResult<3> made = make_mesh(domains::unit_box<3>());
  // As if the domain's corners had been rounded: no point may move, although their facets are not quite flat.
  for (const VertexId v : ids(made.mesh.points))
    if (made.mesh.vertex_carrier_dimension[v] == 0) made.mesh.points[v][2] += (v.value() % 2 == 0 ? 4e-10 : -4e-10);
  const MeshDomain<3> found = domain_of(made.mesh);
  EXPECT_EQ(found.domain.facet_frame.size(), 6U);
  for (const VertexId v : ids(found.carrier))
    if (found.carrier[v].dimension == 0) {
      EXPECT_EQ(found.domain.points[PointId(found.carrier[v].index)], made.mesh.points[v]);
    }
}

TEST(MeshDomain, DomainsComeBackInThePlane) { domains_come_back<2>(); }
TEST(MeshDomain, DomainsComeBackInSpace) { domains_come_back<3>(); }

TEST(MeshDomain, TiltedBoxesComeBack) {
  const MeshingResult<3> made = make_mesh(domains::tilted(domains::two_material_box<3>()));
  expect_same(domain_of(made.mesh).domain, made.domain, "tilted");
}

/// Where a file says nothing of segments and carriers, creases and corners are found by the geometry.
TEST(MeshDomain, ASurfaceWithoutListsIsEnough) {
  MeshingOptions<3> options;
  options.wishes.size = 0.3;
  Mesh<3> mesh = make_mesh(domains::box_with_through_hole(), options).mesh;
  const Domain<3> before = domain_of(mesh).domain;
  mesh.segment_edges.clear();
  mesh.segment_edge_marker.clear();
  mesh.vertex_carrier_dimension.clear();
  mesh.vertex_marker.clear();
  expect_same(domain_of(mesh).domain, before, "without lists");
}

TEST(MeshDomain, ChainsRunAlongTheirSegments) {
  MeshingOptions<3> options;
  options.wishes.size = 0.2;
  const Mesh<3> mesh = make_mesh(domains::unit_cube(), options).mesh;
  const MeshDomain<3> found = domain_of(mesh);
  ASSERT_EQ(found.segment_chains.offsets.size(), 13U);
  for (const SegmentId s : ids(found.domain.segments)) {
    const auto row = found.segment_chains[s];
    EXPECT_EQ(mesh.points[row.front()], found.domain.points[found.domain.segments[s][0]]);
    EXPECT_EQ(mesh.points[row.back()], found.domain.points[found.domain.segments[s][1]]);
    double length = 0;
    for (std::size_t i = 1; i < row.size(); ++i) length += distance(mesh.points[row[i - 1]], mesh.points[row[i]]);
    EXPECT_NEAR(length, 1, 1e-12);
  }
}

}  // namespace
}  // namespace voropack
