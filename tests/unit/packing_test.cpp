// Stages 3 and 4 and the pipeline on small domains: invariants, limits, errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "geom/hilbert.h"
#include "support/cases.h"
#include "support/sharp_domains.h"
#include "voropack/error.h"

namespace voropack {
namespace {

using test::all_cases;
using test::all_fillings;

template <int D>
Spacing<D> constant_spacing(const Domain<D>& domain, double f) {
  SizeWishes<D> wishes;
  wishes.spacing = f;
  return build_spacing(domain, wishes);
}

template <int D>
PackingOptions options_of(const test::Filling& f) {
  PackingOptions options;
  options.form = f.form;
  options.interior = f.interior;
  return options;
}

template <int D>
void packings_have_no_fault() {
  for (const auto& c : all_cases<D>()) {
    DomainOptions how;
    how.min_angle_deg = c.min_angle_deg;
    const Domain<D> domain = build_domain(c.input, how);
    const Spacing<D> spacing = build_spacing(domain, SizeWishes<D>{});
    for (const auto& f : all_fillings()) {
      const Packing<D> packing = pack(domain, spacing, options_of<D>(f));
      EXPECT_EQ(find_packing_fault(packing, domain, spacing), "") << c.name << ", " << f.name;
      EXPECT_TRUE(std::is_sorted(packing.carrier.begin(), packing.carrier.end(),
                                 [](PolytopeId a, PolytopeId b) { return a.dimension < b.dimension; }));
      EXPECT_EQ(packing.triangulation.simplices.empty(), f.form != PackingForm::kVoronoi);
    }
  }
}
TEST(Pack, HasNoFaultInThePlane) { packings_have_no_fault<2>(); }
TEST(Pack, HasNoFaultInSpace) { packings_have_no_fault<3>(); }

/// Spheres on two polytopes of a sharp feature may overlap; everything else holds there too.
template <int D>
void sharp_packings_have_no_fault(const std::vector<test::Case<D>>& cases) {
  for (const auto& c : cases)
    for (const auto& f : all_fillings()) {
      const Domain<D> domain = build_domain(c.input);
      const Spacing<D> spacing = build_spacing(domain, SizeWishes<D>{});
      const Packing<D> packing = pack(domain, spacing, options_of<D>(f));
      EXPECT_EQ(find_packing_fault(packing, domain, spacing), "") << c.name << ", " << f.name;
    }
}
TEST(Pack, HasNoFaultAtSmallAnglesInThePlane) {
  sharp_packings_have_no_fault<2>({test::sharp::fan(5, 3), test::sharp::sliver(2), test::sharp::leaning_slit(5)});
}
TEST(Pack, HasNoFaultAtSmallAnglesInSpace) {
  sharp_packings_have_no_fault<3>({test::sharp::wedge(20), test::sharp::skew_wedge(45), test::sharp::pyramid(5, 60)});
}

TEST(FindPackingFault, SeesEachInvariantBroken) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Spacing<3> spacing = constant_spacing(domain, 0.1);
  const Packing<3> good = pack(domain, spacing);
  Packing<3> bad = good;
  bad.radius[SphereId(3)] *= 1.01;
  EXPECT_NE(find_packing_fault(bad, domain, spacing).find("radius"), std::string::npos);
  bad = good;
  bad.center.back() = bad.center[SphereId(bad.center.size() - 2)] + Vec<3>{0.05, 0, 0};
  EXPECT_NE(find_packing_fault(bad, domain, spacing).find("overlaps"), std::string::npos);
  bad = good;  // A ball around half of the cube holds something.
  bad.subsegments[0].spheres = {SphereId(0), SphereId(6)};
  EXPECT_NE(find_packing_fault(bad, domain, spacing).find("protecting ball"), std::string::npos);
}

/// Segments are chains from end to end, and the chains have the gaps that their spheres demand.
TEST(Pack, SubsegmentsAreChains) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Packing<3> packing = pack(domain, constant_spacing(domain, 0.07));
  std::vector<double> length(domain.segments.size(), 0);
  for (const auto& e : packing.subsegments) {
    const double gap = distance(packing.center[e.spheres[0]], packing.center[e.spheres[1]]);
    EXPECT_GE(gap, 0.14 * (1 - 1e-12));
    EXPECT_LT(gap, 0.28);
    length[e.carrier.index] += gap;
  }
  for (const double l : length) EXPECT_NEAR(l, 1, 1e-12);
}

TEST(Pack, RefusesTooManyVerticesBeforeTheWork) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Spacing<3> spacing = constant_spacing(domain, 1e-3);  // Some fifty million.
  PackingOptions options;
  options.max_vertices = 1000;
  try {
    pack(domain, spacing, options);
    FAIL();
  } catch (const LimitError& e) {
    EXPECT_EQ(e.id(), "packing.too_many_vertices");
    EXPECT_NE(e.faults()[0].fix.find("--max-vertices"), std::string::npos);
  }
}

/// Cancels at the n-th question.
class Impatient : public Observer {
 public:
  explicit Impatient(int patience) : patience_(patience) {}
  [[nodiscard]] bool cancelled() const override { return patience_-- <= 0; }

 private:
  mutable std::atomic<int> patience_;
};

TEST(Pack, StopsWhenAsked) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Spacing<3> spacing = constant_spacing(domain, 0.05);
  for (const int patience : {0, 1, 10, 25}) {
    Impatient observer(patience);
    EXPECT_THROW(pack(domain, spacing, {}, observer), Cancelled) << patience;
  }
  Impatient observer(0);
  EXPECT_THROW(triangulate(domain, pack(domain, spacing), observer), Cancelled);
  EXPECT_THROW(make_mesh(domains::unit_cube(), MeshingOptions<3>{}, observer), Cancelled);
}

/// The triangulation that a Voronoi-maximal packing brings along is the one that is made from its centers alone.
template <int D>
void both_ways_give_one_mesh() {
  for (const auto& c : all_cases<D>()) {
    DomainOptions how;
    how.min_angle_deg = c.min_angle_deg;
    const Domain<D> domain = build_domain(c.input, how);
    const Spacing<D> spacing = build_spacing(domain, SizeWishes<D>{});
    Packing<D> packing = pack(domain, spacing);
    ASSERT_FALSE(packing.triangulation.simplices.empty());
    const Mesh<D> grown = triangulate(domain, packing);
    packing.triangulation = {};
    const Mesh<D> anew = triangulate(domain, std::move(packing));
    EXPECT_EQ(find_mesh_fault(grown), "") << c.name;
    EXPECT_EQ(grown, anew) << c.name;
  }
}
TEST(Triangulate, BothWaysGiveOneMeshInThePlane) { both_ways_give_one_mesh<2>(); }
TEST(Triangulate, BothWaysGiveOneMeshInSpace) { both_ways_give_one_mesh<3>(); }

TEST(Triangulate, OrdersAlongAHilbertCurve) {
  const Domain<3> domain = build_domain(domains::unit_cube());
  const Mesh<3> mesh = triangulate(domain, pack(domain, constant_spacing(domain, 0.08)));
  std::uint64_t last = 0;
  for (const Vec<3>& x : mesh.points) {
    const std::uint64_t key = hilbert_key<3>(x, domain.box);
    EXPECT_GE(key, last);
    last = key;
  }
  for (const auto& corners : mesh.simplex_vertices)
    EXPECT_EQ(*std::min_element(corners.begin(), corners.end()), corners[0]);
  EXPECT_TRUE(std::is_sorted(mesh.simplex_vertices.begin(), mesh.simplex_vertices.end()));
}

TEST(Triangulate, RefusesAPackingThatDoesNotConform) {
  const Domain<2> domain = build_domain(domains::unit_square());
  Packing<2> packing = pack(domain, constant_spacing(domain, 0.1));
  packing.triangulation = {};
  packing.subsegments[0].spheres = {SphereId(0), SphereId(packing.center.size() - 1)};
  try {
    triangulate(domain, packing);
    FAIL();
  } catch (const InternalError& e) {
    EXPECT_EQ(e.id(), "delaunay.not_conforming");
  }
}

TEST(DelaunayTriangulation, CoversTheConvexHull) {
  const auto t = delaunay_triangulation<2>({Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{1, 1}, Vec<2>{0, 1}, Vec<2>{0.4, 0.6}});
  EXPECT_EQ(t.simplices.size(), 4U);
  EXPECT_EQ(t.neighbors.size(), 4U);
}

TEST(DelaunayTriangulation, RefusesIdenticalPoints) {
  try {
    delaunay_triangulation<3>(
        {Vec<3>{0, 0, 0}, Vec<3>{1, 0, 0}, Vec<3>{0, 1, 0}, Vec<3>{0, 0, 1}, Vec<3>{0, 1, 0}, Vec<3>{1, 1, 1}});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_EQ(e.id(), "delaunay.duplicate_points");
  }
}

TEST(MakeMesh, TellsHowLongEachStageTook) {
  const auto r = make_mesh(domains::unit_cube());
  for (const char* stage : {"domain", "spacing", "packing", "delaunay", "dual", "quality", "certificate"}) {
    ASSERT_TRUE(r.times.contains(stage)) << stage;
    EXPECT_GE(r.times.at(stage), 0) << stage;
  }
  EXPECT_GT(r.spacing_integral, 0);
}

TEST(MakeMesh, ReportsRepairsAsCapsOnTheSpacing) {
  // Somewhere among these a ball is not empty at first.
  int repaired = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    auto options = test::meshing_options<3>(all_fillings()[1]);
    options.packing.seed = seed;
    options.gradation = 0.2;
    options.feature_factor = 0.6;
    const auto r = make_mesh(domains::box_with_hole<3>(), options);
    EXPECT_TRUE(r.certificate.ok);
    EXPECT_EQ(r.repairs.empty(), r.repair_rounds == 0);
    repaired += r.repair_rounds > 0 ? 1 : 0;
    const Spacing<3> f = test::spacing_of(r, options);
    for (const VertexId v : ids(r.mesh.points)) ASSERT_EQ(r.mesh.vertex_spacing[v], f(r.mesh.points[v]));
  }
  EXPECT_GT(repaired, 0);
}

}  // namespace
}  // namespace voropack
