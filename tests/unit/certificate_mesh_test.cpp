// The certificate accepts a good mesh and names what is wrong with a spoiled one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/faces.h"
#include "support/certificate_case.h"
#include "support/delaunay_mesh.h"
#include "voropack/dual.h"

namespace voropack {
namespace {

using test::CertificateCase;

template <class Dimension>
class CertificateOf : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CertificateOf, Dimensions);

template <int D>
const CertificateCase<D>& golden() {
  static const CertificateCase<D> golden = test::golden_case<D>(6);
  return golden;
}

template <int D>
Certificate judge(const CertificateCase<D>& c, bool with_domain = true, const CertificateOptions& options = {}) {
  return certify(c.mesh, c.volumes, with_domain ? &c.domain : nullptr, options);
}

/// The named check fails and its `where` contains each of `words`.
void expect_rejected(const Certificate& certificate, const char* name, const std::vector<std::string>& words) {
  const Certificate::Check& check = test::check_named(certificate, name);
  EXPECT_FALSE(certificate.ok);
  EXPECT_FALSE(check.ok) << test::summary(certificate);
  EXPECT_GT(check.violations, 0U);
  for (const std::string& word : words)
    EXPECT_NE(check.where.find(word), std::string::npos) << word << " is not in: " << check.where;
}

std::string vertex(VertexId v) { return "vertex " + std::to_string(v.value()) + ' '; }
std::string simplex(SimplexId s) { return "simplex " + std::to_string(s.value()) + ' '; }

TYPED_TEST(CertificateOf, AcceptsAGoodMeshAndTestsEverything) {
  constexpr int D = TypeParam::value;
  const Certificate certificate = judge(golden<D>());
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
  ASSERT_EQ(certificate.checks.size(), 11U);
  for (const Certificate::Check& check : certificate.checks) {
    EXPECT_TRUE(check.ok) << check.name;
    EXPECT_GT(check.tested, 0U) << check.name;
    EXPECT_FALSE(check.where.empty()) << check.name;
  }
}

TYPED_TEST(CertificateOf, AcceptsAGoodMeshWithoutADomain) {
  constexpr int D = TypeParam::value;
  const Certificate certificate = judge(golden<D>(), false);
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
}

TYPED_TEST(CertificateOf, DoesNotTestWhatIsAbsent) {
  constexpr int D = TypeParam::value;
  Mesh<D> mesh = golden<D>().mesh;
  mesh.vertex_spacing.clear();
  mesh.boundary_vertices.clear();
  mesh.boundary_marker.clear();
  mesh.segment_edges.clear();
  mesh.segment_edge_marker.clear();
  mesh.vertex_carrier_dimension.clear();
  mesh.simplex_neighbors.clear();
  const Certificate certificate = certify(mesh, ControlVolumes<D>{});
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
  for (const char* name :
       {"packing", "spacing_lipschitz", "voronoi_maximal", "conformity", "dual_nonnegative", "volume_sum", "closure"})
    EXPECT_EQ(test::check_named(certificate, name).tested, 0U) << name;
  for (const char* name : {"delaunay", "protecting_balls", "voronoi_containment", "radius_edge"})
    EXPECT_GT(test::check_named(certificate, name).tested, 0U) << name;
}

TYPED_TEST(CertificateOf, RejectsAMeshWithoutSimplices) {
  constexpr int D = TypeParam::value;
  expect_rejected(certify(Mesh<D>{}, ControlVolumes<D>{}), "delaunay", {"no simplices"});
}

TYPED_TEST(CertificateOf, RejectsAMovedVertex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const VertexId v = test::interior_vertex(c.mesh);
  c.mesh.points[v][0] += 0.3;
  expect_rejected(judge(c), "delaunay", {"flat or inverted", ' ' + std::to_string(v.value())});
}

TYPED_TEST(CertificateOf, RejectsASlightlyMovedVertexByItsVolumes) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const VertexId v = test::interior_vertex(c.mesh);
  c.mesh.points[v][0] += 1e-6;
  expect_rejected(judge(c), "dual_nonnegative", {vertex(v), "site"});
}

TYPED_TEST(CertificateOf, RejectsANonFiniteVertex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.mesh.points[test::interior_vertex(c.mesh)][1] = std::numeric_limits<double>::quiet_NaN();
  expect_rejected(judge(c), "delaunay", {"not finite"});
}

TYPED_TEST(CertificateOf, RejectsAnInvalidCorner) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.mesh.simplex_vertices[SimplexId(5)][1] = VertexId(1'000'000);
  expect_rejected(judge(c), "delaunay", {"simplex 5 ", "no vertex"});
  c.mesh.simplex_vertices[SimplexId(5)][1] = c.mesh.simplex_vertices[SimplexId(5)][0];
  expect_rejected(judge(c), "delaunay", {"simplex 5 ", "same corner twice"});
}

TYPED_TEST(CertificateOf, RejectsAnInvertedSimplex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  std::swap(c.mesh.simplex_vertices[s][0], c.mesh.simplex_vertices[s][1]);
  std::swap(c.mesh.simplex_neighbors[s][0], c.mesh.simplex_neighbors[s][1]);
  expect_rejected(judge(c), "delaunay", {simplex(s), "inverted"});
}

TYPED_TEST(CertificateOf, RejectsAWrongNeighbor) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  const SimplexId n = c.mesh.simplex_neighbors[s][0];
  c.mesh.simplex_neighbors[s][0] = c.mesh.simplex_neighbors[n][c.mesh.simplex_neighbors[n][0] == s ? 1 : 0];
  expect_rejected(judge(c), "delaunay", {"wrong neighbor"});
  c.mesh.simplex_neighbors[s][0] = SimplexId(std::size_t{123'456'789});
  expect_rejected(judge(c), "delaunay", {simplex(s), "wrong neighbor 123456789"});
}

TYPED_TEST(CertificateOf, RejectsNeighborsThatDoNotKnowEachOther) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  const SimplexId n = c.mesh.simplex_neighbors[s][0];
  c.mesh.simplex_neighbors[s][0] = SimplexId::none();
  std::replace(c.mesh.simplex_neighbors[n].begin(), c.mesh.simplex_neighbors[n].end(), s, SimplexId::none());
  expect_rejected(judge(c), "delaunay", {"shares a face", simplex(s), simplex(n)});
}

TYPED_TEST(CertificateOf, RejectsASimplexThatOccursTwice) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  c.mesh.simplex_vertices.push_back(c.mesh.simplex_vertices[s]);
  c.mesh.simplex_region.push_back(c.mesh.simplex_region[s]);
  c.mesh.simplex_neighbors.clear();
  expect_rejected(judge(c), "delaunay", {"shares a face"});
}

TYPED_TEST(CertificateOf, RejectsTwoSheets) {
  constexpr int D = TypeParam::value;
  const Mesh<D> single = test::delaunay_mesh<D>(test::perturbed_grid<D>(4, 0.02));
  Mesh<D> mesh = single;
  const auto shift = static_cast<std::uint32_t>(single.points.size());
  for (Vec<D> p : single.points) {
    p[0] += 0.3;
    mesh.points.push_back(p);
  }
  for (auto corners : single.simplex_vertices) {
    for (VertexId& v : corners) v = VertexId(v.value() + shift);
    mesh.simplex_vertices.push_back(corners);
    mesh.simplex_region.push_back(1);
  }
  mesh.simplex_neighbors.clear();
  expect_rejected(certify(mesh, ControlVolumes<D>{}), "delaunay", {"overlap"});
}

TYPED_TEST(CertificateOf, RejectsADroppedSimplex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  const std::array<VertexId, D + 1> corners = c.mesh.simplex_vertices[s];
  c.mesh.simplex_vertices[s] = c.mesh.simplex_vertices.back();
  c.mesh.simplex_region[s] = c.mesh.simplex_region.back();
  c.mesh.simplex_vertices.raw().pop_back();
  c.mesh.simplex_region.raw().pop_back();
  test::refresh(c);
  for (const bool with_domain : {false, true}) {
    const Certificate certificate = judge(c, with_domain);
    expect_rejected(certificate, "conformity", {"unlisted boundary face", "is not listed"});
    const std::string& where = test::check_named(certificate, "conformity").where;
    int n_named = 0;
    for (const VertexId v : corners) n_named += where.find(' ' + std::to_string(v.value())) != std::string::npos;
    EXPECT_GE(n_named, D) << where;
  }
  expect_rejected(judge(c), "volume_sum", {"domain"});

  // As a reader sees it, which lists hull faces itself, with marker 0.
  Mesh<D> derived = c.mesh;
  test::connect(derived);
  for (std::size_t b = c.mesh.boundary_vertices.size(); b < derived.boundary_vertices.size(); ++b) {
    const BoundaryId id(b);
    std::array<VertexId, D> face = derived.boundary_vertices[id];
    std::sort(face.begin(), face.end());
    bool of_dropped = true;
    for (const VertexId v : face)
      of_dropped = of_dropped && std::find(corners.begin(), corners.end(), v) != corners.end();
    if (!of_dropped) continue;
    c.mesh.boundary_vertices.push_back(face);
    c.mesh.boundary_marker.push_back(0);
  }
  ASSERT_EQ(c.mesh.boundary_vertices.size(), golden<D>().mesh.boundary_vertices.size() + D + 1);
  expect_rejected(judge(c, false), "conformity", {"marker 0", "belongs to no facet", "missing"});
  c.mesh.vertex_carrier_dimension.clear();
  expect_rejected(judge(c, false), "conformity", {"marker 0", "belongs to no facet", "missing"});
}

TYPED_TEST(CertificateOf, AcceptsFacetsWithoutMarker) {
  constexpr int D = TypeParam::value;
  for (const bool has_carriers : {true, false}) {
    CertificateCase<D> c = golden<D>();
    if (!has_carriers) c.mesh.vertex_carrier_dimension.clear();
    const int dropped = c.mesh.boundary_marker[BoundaryId(0)];
    for (int& marker : c.mesh.boundary_marker)
      if (marker == dropped) marker = 0;
    const Certificate certificate = judge(c, false);
    EXPECT_TRUE(certificate.ok) << test::summary(certificate);
    EXPECT_FALSE(judge(c).ok) << "its domain has markers";
  }
}

TYPED_TEST(CertificateOf, RejectsALostMarker) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  BoundaryId b(0);
  const auto is_inside = [&](VertexId v) { return c.mesh.vertex_carrier_dimension[v] == D - 1; };
  while (!std::ranges::all_of(c.mesh.boundary_vertices[b], is_inside)) ++b;
  c.mesh.boundary_marker[b] = 0;
  expect_rejected(judge(c, false), "conformity", {"marker 0"});
  // Segments tell where markers may change, too.
  c.mesh.vertex_carrier_dimension.clear();
  if (D == 3) expect_rejected(judge(c, false), "conformity", {"marker 0"});
}

TYPED_TEST(CertificateOf, RejectsADroppedSimplexAtTheBoundary) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  SimplexId s(0);
  while (!c.mesh.simplex_neighbors[s][0].is_none()) ++s;
  c.mesh.simplex_vertices[s] = c.mesh.simplex_vertices.back();
  c.mesh.simplex_region[s] = c.mesh.simplex_region.back();
  c.mesh.simplex_vertices.raw().pop_back();
  c.mesh.simplex_region.raw().pop_back();
  test::refresh(c);
  expect_rejected(judge(c, false), "conformity", {"boundary simplex ", "is no face of a simplex"});
}

TYPED_TEST(CertificateOf, RejectsASwappedRegion) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const SimplexId s = test::interior_simplex(c.mesh);
  c.mesh.simplex_region[s] = 3 - c.mesh.simplex_region[s];
  c.volumes = build_control_volumes(c.mesh);
  expect_rejected(judge(c, false), "conformity", {"simplex " + std::to_string(s.value())});
  // As a reader sees it, which lists interfaces itself, with marker 0.
  CertificateCase<D> read = c;
  read.mesh.vertex_carrier_dimension.clear();
  for (int i = 0; i <= D; ++i) {
    read.mesh.boundary_vertices.push_back(boundary_face<D>(c.mesh.simplex_vertices[s], i));
    read.mesh.boundary_marker.push_back(0);
  }
  expect_rejected(judge(read, false), "conformity", {"marker 0", "belongs to no facet", "from its region"});
  // In a region of its own it has not strayed.
  read.mesh.simplex_region[s] = 3;
  const Certificate alone = judge(read, false);
  EXPECT_TRUE(test::check_named(alone, "conformity").ok) << test::summary(alone);
  expect_rejected(judge(c), "volume_sum", {"region "});
  // All of them: only the domain tells.
  for (int& region : c.mesh.simplex_region) region = 3 - region;
  c.mesh.simplex_region[s] = 3 - c.mesh.simplex_region[s];
  c.volumes = build_control_volumes(c.mesh);
  EXPECT_TRUE(judge(c, false).ok);
  expect_rejected(judge(c), "conformity", {"boundary simplex ", "where the domain has"});
}

TYPED_TEST(CertificateOf, RejectsADuplicatedInterfaceVertex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  VertexId v(0);
  while (c.mesh.points[v][0] != 0.5 || c.mesh.vertex_carrier_dimension[v] != D - 1) ++v;
  const VertexId twin = c.mesh.points.push_back(c.mesh.points[v]);
  c.mesh.vertex_spacing.push_back(c.mesh.vertex_spacing[v]);
  c.mesh.vertex_carrier_dimension.push_back(D - 1);
  for (const SimplexId s : ids(c.mesh.simplex_vertices))
    if (c.mesh.simplex_region[s] == 2)
      std::replace(c.mesh.simplex_vertices[s].begin(), c.mesh.simplex_vertices[s].end(), v, twin);
  test::refresh(c);
  for (const bool with_domain : {false, true})
    expect_rejected(judge(c, with_domain), "conformity", {vertex(v), vertex(twin), "same place"});
}

TYPED_TEST(CertificateOf, RejectsAWrongSpacing) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const VertexId v = test::interior_vertex(c.mesh);
  CertificateOptions claims;
  claims.gradation = 0.1;
  EXPECT_TRUE(judge(c, true, claims).ok);
  c.mesh.vertex_spacing[v] *= 1.2;
  expect_rejected(judge(c), "packing", {vertex(v), "overlap"});
  c.mesh.vertex_spacing[v] *= 0.5;
  expect_rejected(judge(c, true, claims), "spacing_lipschitz", {vertex(v)});
  EXPECT_TRUE(test::check_named(judge(c), "spacing_lipschitz").ok) << "without a claim, b is only measured";
  EXPECT_NEAR(*test::check_named(judge(c), "spacing_lipschitz").worst, 0.479 / 6 * 0.4 / (0.97 / 6), 0.02);
  c.mesh.vertex_spacing[v] = -1;
  expect_rejected(judge(c), "packing", {vertex(v), "not positive"});
  c.mesh.vertex_spacing[v] = 10;
  expect_rejected(judge(c), "spacing_lipschitz", {vertex(v)});
}

TYPED_TEST(CertificateOf, RejectsAPackingThatIsNotMaximal) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  CertificateOptions claims;
  claims.gradation = 0.01;
  EXPECT_TRUE(judge(c, true, claims).ok);
  for (double& f : c.mesh.vertex_spacing) f *= 0.6;
  expect_rejected(judge(c, true, claims), "voronoi_maximal", {"simplex ", "a vertex fits"});
  // The same gap is too small for what an epsilon-maximal packing promises.
  claims.form = PackingForm::kMaximal;
  claims.epsilon = 1.0;
  EXPECT_TRUE(test::check_named(judge(c, true, claims), "voronoi_maximal").ok);
  claims.epsilon = 0.01;
  EXPECT_FALSE(test::check_named(judge(c, true, claims), "voronoi_maximal").ok);
}

TYPED_TEST(CertificateOf, DecidesMaximalityByTheTrueSpacing) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  for (double& f : c.mesh.vertex_spacing) f *= 0.65;
  CertificateOptions claims;
  claims.gradation = 0.4;  // So loose that f at the circumcenters may be anything.
  const Certificate::Check open = test::check_named(judge(c, true, claims), "voronoi_maximal");
  EXPECT_TRUE(open.ok);
  EXPECT_NE(open.where.find("undecided"), std::string::npos) << open.where;
  const double f = c.mesh.vertex_spacing[VertexId(0)];
  claims.spacing = [f](std::span<const double> x) {
    EXPECT_EQ(x.size(), static_cast<std::size_t>(D));
    return f;
  };
  expect_rejected(judge(c, true, claims), "voronoi_maximal", {"simplex ", "a vertex fits"});
}

TYPED_TEST(CertificateOf, RejectsAChangedMarker) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  BoundaryId b(0);
  const auto inside_wall = [&](BoundaryId id) {
    return std::all_of(c.mesh.boundary_vertices[id].begin(), c.mesh.boundary_vertices[id].end(),
                       [&](VertexId v) { return c.mesh.vertex_carrier_dimension[v] == D - 1; });
  };
  while (!inside_wall(b)) ++b;
  c.mesh.boundary_marker[b] += 100;
  const std::vector<std::string> words = {"marker", std::to_string(c.mesh.boundary_marker[b])};
  expect_rejected(judge(c, false), "conformity", words);
  c.mesh.vertex_carrier_dimension.clear();
  expect_rejected(judge(c), "conformity", words);
  if (D == 3) expect_rejected(judge(c, false), "conformity", words);
}

TYPED_TEST(CertificateOf, DoesNotCompareMarkersThatAreAllTheSame) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  for (int& marker : c.mesh.boundary_marker) marker = 1;
  for (int& marker : c.mesh.segment_edge_marker) marker = 1;
  const Certificate certificate = judge(c);
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
  c.mesh.boundary_marker[BoundaryId(0)] = 2;
  EXPECT_FALSE(judge(c).ok);
}

TYPED_TEST(CertificateOf, RejectsAMeshOfAnotherDomain) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  Vec<D> x;
  for (int k = 0; k < D; ++k) x[k] = 0.26;
  c.domain.points.push_back(x);
  expect_rejected(judge(c), "conformity", {"point ", "(0.26, 0.26", "is no vertex"});
  c.domain = golden<D>().domain;
  std::swap(c.domain.wall_regions[0][0], c.domain.wall_regions[0][1]);
  expect_rejected(judge(c), "conformity", {"boundary simplex ", "where the domain has"});
  c.domain = golden<D>().domain;
  c.domain.region_measure[RegionId(0)] *= 1 + 1e-9;
  expect_rejected(judge(c), "volume_sum", {"region 1", "domain"});
}

TYPED_TEST(CertificateOf, RejectsAPointNearABoundarySimplex) {
  constexpr int D = TypeParam::value;
  std::vector<Vec<D>> points = test::perturbed_grid<D>(4, 0.02, 1, true);
  Vec<D> intruder;
  for (int k = 0; k < D; ++k) intruder[k] = 0.37;
  intruder[1] = 0.02;
  points.push_back(intruder);
  const CertificateCase<D> c = test::case_of_points<D>(points);
  CertificateOptions claims;
  claims.radius_edge = 2.5;
  const Certificate certificate = judge(c, true, claims);
  const VertexId v(points.size() - 1);
  EXPECT_TRUE(test::check_named(certificate, "delaunay").ok);
  EXPECT_TRUE(test::check_named(certificate, "conformity").ok) << test::summary(certificate);
  expect_rejected(certificate, "protecting_balls", {"boundary simplex ", vertex(v), "in its protecting ball"});
  expect_rejected(certificate, "voronoi_containment", {"simplex ", "circumcenter beyond the boundary face"});
  expect_rejected(certificate, "dual_nonnegative", {"negative area"});
  expect_rejected(certificate, "radius_edge", {"simplex "});
}

TYPED_TEST(CertificateOf, AcceptsAVertexOnAProtectingSphere) {
  constexpr int D = TypeParam::value;
  // Squares and cubes: all corners lie on one sphere, and (2D) no ball is violated.
  const CertificateCase<D> c = test::case_of_points<D>(test::perturbed_grid<D>(4, 0.0, 1, true));
  const Certificate certificate = judge(c);
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
}

TYPED_TEST(CertificateOf, HoldsTheRatioAgainstTheClaim) {
  constexpr int D = TypeParam::value;
  CertificateOptions claims;
  claims.radius_edge = 0.6;
  const Certificate certificate = judge(golden<D>(), true, claims);
  expect_rejected(certificate, "radius_edge", {"simplex "});
  EXPECT_GT(*test::check_named(certificate, "radius_edge").worst, 0.6);
}

// A vertex right above (3D) or beside (2D) another one: the Delaunay mesh has simplices with a short edge.
TYPED_TEST(CertificateOf, RejectsAShortEdge) {
  constexpr int D = TypeParam::value;
  std::vector<Vec<D>> points = test::perturbed_grid<D>(4, 0.02, 1, true);
  Vec<D> x = points[0];
  for (const Vec<D>& p : points)
    if (p[0] > 0.2 && p[0] < 0.3 && p[1] > 0.4 && p[1] < 0.6 && p[D - 1] > 0.4 && p[D - 1] < 0.6) x = p;
  x[0] += 0.01;
  points.push_back(x);
  expect_rejected(judge(test::case_of_points<D>(points)), "radius_edge", {"simplex ", "longer"});
}

TEST(Certificate, RejectsANonDelaunayFlipInThePlane) {
  CertificateCase<2> c = golden<2>();
  const SimplexId s = test::interior_simplex(c.mesh);
  auto& v = c.mesh.simplex_vertices[s];
  // Across the longest side, the two triangles are half a square each.
  std::size_t i = 0;
  const auto side_sq = [&](std::size_t k) {
    return distance_sq(c.mesh.points[v[(k + 1) % 3]], c.mesh.points[v[(k + 2) % 3]]);
  };
  for (std::size_t k = 1; k < 3; ++k)
    if (side_sq(k) > side_sq(i)) i = k;
  const SimplexId n = c.mesh.simplex_neighbors[s][i];
  auto& w = c.mesh.simplex_vertices[n];
  const auto& back = c.mesh.simplex_neighbors[n];
  const auto j = static_cast<std::size_t>(std::find(back.begin(), back.end(), s) - back.begin());
  const VertexId top = v[i], left = v[(i + 1) % 3], right = v[(i + 2) % 3], bottom = w[j];
  v = {top, left, bottom};
  w = {top, bottom, right};
  test::refresh(c);
  const Certificate certificate = judge(c);
  expect_rejected(certificate, "delaunay", {"in its circumball"});
  EXPECT_GT(*test::check_named(certificate, "delaunay").worst, 0);
}

TEST(Certificate, RejectsANonDelaunayFlipInSpace) {
  // A double pyramid: two tetrahedra over a common face are Delaunay, the three around its axis are not.
  Mesh<3> mesh;
  mesh.points = IdVector<VertexId, Vec<3>>(
      {Vec<3>{1, 0, 0}, Vec<3>{-0.5, 0.9, 0}, Vec<3>{-0.5, -0.9, 0}, Vec<3>{0, 0, 2}, Vec<3>{0, 0, -2}});
  const auto v = [](std::size_t i) { return VertexId(i); };
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, 4>>(
      {std::array<VertexId, 4>{v(0), v(1), v(2), v(3)}, std::array<VertexId, 4>{v(0), v(2), v(1), v(4)}});
  mesh.simplex_region = IdVector<SimplexId, int>(2, 1);
  EXPECT_TRUE(test::check_named(certify(mesh, ControlVolumes<3>{}), "delaunay").ok);
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, 4>>(
      {std::array<VertexId, 4>{v(0), v(1), v(4), v(3)}, std::array<VertexId, 4>{v(1), v(2), v(4), v(3)},
       std::array<VertexId, 4>{v(2), v(0), v(4), v(3)}});
  mesh.simplex_region = IdVector<SimplexId, int>(3, 1);
  const Certificate certificate = certify(mesh, ControlVolumes<3>{});
  expect_rejected(certificate, "delaunay", {"in its circumball"});
}

TEST(Certificate, RejectsASegmentEdgeThatIsNone) {
  CertificateCase<3> c = golden<3>();
  const std::array<VertexId, 2> edge = {VertexId(0), VertexId(c.mesh.points.size() - 1)};
  c.mesh.segment_edges.push_back(edge);
  c.mesh.segment_edge_marker.push_back(1);
  expect_rejected(judge(c, false), "conformity", {vertex(edge[0]), vertex(edge[1]), "no edge of a simplex"});
  c.mesh.segment_edges.raw().pop_back();
  c.mesh.segment_edge_marker.raw().pop_back();
  c.mesh.segment_edges.raw().pop_back();
  c.mesh.segment_edge_marker.raw().pop_back();
  expect_rejected(judge(c), "conformity", {"segment ", "is not listed"});
}

}  // namespace
}  // namespace voropack
