// Refinement: old vertices stay to the bit, and what comes out is certified as a new mesh is.
#include "voropack/refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "support/allow_threads.h"
#include "support/cases.h"
#include "support/faults.h"
#include "support/sharp_domains.h"
#include "voropack/coarsening.h"

namespace voropack {
namespace {

template <int D>
struct Refined {
  MeshDomain<D> place;
  Spacing<D> spacing;
  RefinedMesh<D> result;
};

template <int D>
Refined<D> refine_by(const Mesh<D>& mesh, double factor, const SizeWishes<D>& wishes = {},
                     const RefinementOptions& options = {}) {
  MeshDomain<D> place = domain_of(mesh);
  Spacing<D> spacing = refined_spacing(mesh, place.domain, factor, wishes);
  RefinedMesh<D> result = refine(mesh, place, spacing, options);
  return {std::move(place), std::move(spacing), std::move(result)};
}

template <int D>
Certificate certificate_of(const Refined<D>& refined, const PackingOptions& packing = {}) {
  const CertificateOptions claims = packing_claims(refined.spacing.with_caps(refined.result.repairs), packing);
  const Mesh<D>& mesh = refined.result.mesh;
  return certify(mesh, build_control_volumes(mesh), &refined.place.domain, claims);
}

template <int D>
void expect_certified(const Refined<D>& refined, const PackingOptions& packing = {}) {
  for (const Certificate::Check& check : certificate_of(refined, packing).checks)
    EXPECT_TRUE(check.ok) << check.name << ": " << check.violations << " of " << check.tested << ", " << check.where;
}

template <int D>
void expect_all_kept(const Mesh<D>& old, const RefinedMesh<D>& refined) {
  std::vector<std::uint8_t> is_found(old.points.size(), 0);
  for (const VertexId v : ids(refined.mesh.points))
    if (const VertexId before = refined.old_vertex[v]; !before.is_none()) {
      EXPECT_EQ(refined.mesh.points[v], old.points[before]);
      EXPECT_EQ(refined.mesh.vertex_marker[v], old.vertex_marker[before]);
      EXPECT_EQ(refined.mesh.vertex_carrier_dimension[v], old.vertex_carrier_dimension[before]);
      is_found[before.value()] = 1;
    }
  EXPECT_EQ(std::ranges::count(is_found, 1), static_cast<std::ptrdiff_t>(old.points.size()));
  EXPECT_EQ(refined.n_kept, old.points.size());
  EXPECT_EQ(refined.n_removed, 0U);
  EXPECT_EQ(refined.n_kept + refined.n_added, refined.mesh.points.size());
}

template <int D>
double largest_radius_edge(const Mesh<D>& mesh) {
  return measure_quality(mesh, build_control_volumes(mesh)).radius_edge.max;
}

template <class Dimension>
class Refinement : public testing::Test {};
template <int D>
struct Dimension {
  static constexpr int value = D;
};
using Dimensions = testing::Types<Dimension<2>, Dimension<3>>;
TYPED_TEST_SUITE(Refinement, Dimensions);

TYPED_TEST(Refinement, KeepsAllVerticesOfEveryDomain) {
  constexpr int D = TypeParam::value;
  for (const test::Case<D>& c : test::all_cases<D>()) {
    SCOPED_TRACE(c.name);
    const Mesh<D> mesh = make_mesh(c.input).mesh;
    const Refined<D> refined = refine_by(mesh, 0.5);
    expect_all_kept(mesh, refined.result);
    expect_certified(refined);
    EXPECT_EQ(refined.place.domain.segments.size(), build_domain(c.input).segments.size());
  }
}

TYPED_TEST(Refinement, HalvesTheSpacingAtEveryVertex) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.expression = D == 2 ? "0.05 + 0.2 * x" : "0.15 + 0.2 * x";
  const Mesh<D> mesh = make_mesh(domains::unit_box<D>(), options).mesh;
  const Refined<D> refined = refine_by(mesh, 0.5);
  expect_all_kept(mesh, refined.result);
  expect_certified(refined);
  for (const VertexId v : ids(refined.result.mesh.points))
    if (const VertexId before = refined.result.old_vertex[v]; !before.is_none()) {
      const double old = mesh.vertex_spacing[before];
      EXPECT_NEAR(refined.result.mesh.vertex_spacing[v], old / 2, 1e-12 * old);
    }
}

/// Level by level, R / l is at most a tenth larger than that of a mesh made from scratch.
TYPED_TEST(Refinement, StaysAsWellShapedOverLevels) {
  constexpr int D = TypeParam::value;
  const std::vector<DomainInput<D>> inputs = {domains::unit_box<D>(), domains::l_shape<D>(),
                                              domains::two_material_box<D>()};
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    MeshingOptions<D> options;
    options.wishes.size = D == 2 ? 0.2 : 0.4;
    Mesh<D> mesh = make_mesh(inputs[k], options).mesh;
    for (int level = 1; level <= (D == 2 ? 5 : 3 - static_cast<int>(k > 0)); ++level) {
      SCOPED_TRACE(testing::Message() << "domain " << k << ", level " << level);
      Refined<D> refined = refine_by(mesh, 0.5);
      expect_all_kept(mesh, refined.result);
      expect_certified(refined);
      options.wishes.size = *options.wishes.size / 2;
      const double scratch = largest_radius_edge(make_mesh(inputs[k], options).mesh);
      EXPECT_LE(largest_radius_edge(refined.result.mesh), 1.1 * scratch);
      mesh = std::move(refined.result.mesh);
    }
  }
}

TYPED_TEST(Refinement, IsTheSameForAnyNumberOfThreads) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = 0.3;
  const Mesh<D> mesh = make_mesh(domains::two_material_box<D>(), options).mesh;
  const auto with_threads = [&](std::size_t n) {
    const test::AllowThreads threads(n);
    return refine_by(mesh, 0.5).result.mesh;
  };
  EXPECT_EQ(with_threads(1), with_threads(8));
}

TYPED_TEST(Refinement, FillsInEveryForm) {
  constexpr int D = TypeParam::value;
  for (const test::Filling& filling : test::all_fillings()) {
    SCOPED_TRACE(filling.name);
    const MeshingOptions<D> options = test::meshing_options<D>(filling, 0.4);
    const Mesh<D> mesh = make_mesh(domains::l_shape<D>(), options).mesh;
    const Refined<D> refined = refine_by(mesh, 0.5, {}, {.packing = options.packing});
    expect_all_kept(mesh, refined.result);
    expect_certified(refined, options.packing);
  }
}

TYPED_TEST(Refinement, RefinesWhereASizeIsWished) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = 0.2;
  const Mesh<D> mesh = make_mesh(domains::two_material_box<D>(), options).mesh;
  SizeWishes<D> wishes;
  wishes.region_size[mesh.simplex_region[SimplexId(0)]] = 0.1;
  const Refined<D> refined = refine_by(mesh, 1, wishes);
  expect_all_kept(mesh, refined.result);
  expect_certified(refined);
  EXPECT_GT(refined.result.n_added, mesh.points.size() / 2);
}

TYPED_TEST(Refinement, RefinesInPlaces) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = 0.3;
  const Mesh<D> mesh = make_mesh(domains::unit_box<D>(), options).mesh;
  Vec<D> corner, center;
  for (int k = 0; k < D; ++k) corner[k] = 1, center[k] = 0.5;
  SizeWishes<D> wishes;
  wishes.tubes.push_back({{center}, 0.1, 0.06});
  wishes.tubes.push_back({{Vec<D>{}, center}, 0, 0.06});
  wishes.boxes.push_back({Box<D>(0.9 * corner, corner), 0.06});
  const Refined<D> refined = refine_by(mesh, 1, wishes);
  expect_all_kept(mesh, refined.result);
  expect_certified(refined);
  const double f = 0.06 / SpacingOptions{}.edge_per_spacing;
  for (const VertexId v : ids(refined.result.mesh.points)) {
    const Vec<D>& x = refined.result.mesh.points[v];
    const bool in_box = std::ranges::all_of(x.coord, [](double c) { return c >= 0.9; });
    if (in_box || distance(x, center) <= 0.1) {
      EXPECT_LE(refined.result.mesh.vertex_spacing[v], f * (1 + 1e-12));
    }
  }
}

TYPED_TEST(Refinement, LetsVerticesGoWhereTheSpacingGrows) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = D == 2 ? 0.05 : 0.15;
  const Mesh<D> mesh = make_mesh(domains::unit_box<D>(), options).mesh;
  const MeshDomain<D> place = domain_of(mesh);
  SizeWishes<D> wishes;
  wishes.expression = D == 2 ? "0.03 + 0.2 * x" : "0.12 + 0.3 * x";
  const Spacing<D> spacing = build_spacing(place.domain, wishes);
  EXPECT_EQ(test::fault_of<OptionError>([&] { refine(mesh, place, spacing); }).id, "refine.spacing_grows");
  const Refined<D> refined{place, spacing, refine(mesh, place, spacing, {.packing = {}, .keep_all = false})};
  expect_certified(refined);
  EXPECT_GT(refined.result.n_kept, 0U);
  EXPECT_GT(refined.result.n_added, 0U);
  EXPECT_GT(refined.result.n_removed, 0U);
  EXPECT_EQ(refined.result.n_kept + refined.result.n_removed, mesh.points.size());
}

TYPED_TEST(Refinement, ComposesWithCoarsening) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = D == 2 ? 0.05 : 0.2;
  const Mesh<D> mesh = make_mesh(domains::l_shape<D>(), options).mesh;
  CoarseningOptions coarsening;
  coarsening.levels = 1;
  const Mesh<D> coarse = coarsen(mesh, coarsening).levels.at(0).mesh;
  const Refined<D> refined = refine_by(coarse, 0.5);
  expect_all_kept(coarse, refined.result);
  expect_certified(refined);
  const auto again = coarsen(refined.result.mesh, coarsening);
  EXPECT_FALSE(again.levels.empty());
}

TYPED_TEST(Refinement, MakesLevelsForMultigrid) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = D == 2 ? 0.3 : 0.6;
  std::vector<Mesh<D>> meshes = {make_mesh(domains::two_material_box<D>(), options).mesh};
  for (int level = 0; level < 2; ++level) meshes.insert(meshes.begin(), refine_by(meshes.front(), 0.5).result.mesh);
  const auto levels = nested_levels<D>(meshes.front(), {meshes[1], meshes[2]});
  ASSERT_EQ(levels.size(), 2U);
  const Mesh<D>* finer = &meshes.front();
  for (const CoarseLevel<D>& level : levels) {
    const SparseMatrix& p = level.prolongation;
    ASSERT_EQ(p.size(), finer->points.size());
    for (std::size_t row = 0; row < p.size(); ++row) {
      Vec<D> x;
      for (std::uint64_t k = p.offsets[row]; k < p.offsets[row + 1]; ++k)
        x += p.values[k] * level.mesh.points[VertexId(p.columns[k])];
      EXPECT_LT(distance(x, finer->points[VertexId(row)]), 1e-9);
    }
    finer = &level.mesh;
  }
  const auto refuse = [&](const Mesh<D>& finest, std::vector<Mesh<D>> coarser) {
    return test::fault_of<InputError>([&] { nested_levels(finest, std::move(coarser)); }).id;
  };
  EXPECT_EQ(refuse(meshes[2], {meshes[1]}), "refine.not_nested");
  EXPECT_EQ(refuse(meshes[0], {meshes[2], meshes[1]}), "refine.not_nested") << "each has to be in the one before";
}

TYPED_TEST(Refinement, TransfersValuesWithinOneDomainOnly) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = 0.3;
  const Mesh<D> whole = make_mesh(domains::unit_box<D>(), options).mesh;
  const auto scaled = [&](double factor) {
    Mesh<D> mesh = whole;
    for (Vec<D>& x : mesh.points) x = factor * x;
    return mesh;
  };
  const auto values = [](const Mesh<D>& mesh) { return IdVector<VertexId, double>(mesh.points.size(), 1.0); };
  // As far as boundaries differ that were rounded or simplified.
  const Mesh<D> near = scaled(0.95);
  for (const double value : transfer(near, values(near), whole)) EXPECT_NEAR(value, 1, 1e-12);
  EXPECT_NO_THROW(require_cover(near, whole));
  const Mesh<D> half = scaled(0.3);
  const Fault fault = test::fault_of<InputError>([&] { transfer(half, values(half), whole); });
  EXPECT_EQ(fault.id, "transfer.not_covered");
  EXPECT_GT(*std::ranges::max_element(fault.position), 0.6) << "the worst place is far outside";
  // Larger than wanted is enough, but not to conserve.
  EXPECT_NO_THROW(transfer(whole, values(whole), half));
  EXPECT_EQ(test::fault_of<InputError>([&] { transfer(whole, values(whole), half, {.conserve = true}); }).id,
            "transfer.not_covered");
}

TYPED_TEST(Refinement, TransfersValues) {
  constexpr int D = TypeParam::value;
  MeshingOptions<D> options;
  options.wishes.size = 0.3;
  const Mesh<D> coarse = make_mesh(domains::two_material_box<D>(), options).mesh;
  const Mesh<D> fine = refine_by(coarse, 0.5).result.mesh;
  const auto linear = [](const Vec<D>& x) { return 3 + 2 * x[0] - x[D - 1]; };
  const auto bent = [](const Vec<D>& x) { return x[0] * x[0] + x[D - 1]; };
  const auto at = [](const Mesh<D>& mesh, auto&& u) {
    IdVector<VertexId, double> values;
    for (const Vec<D>& x : mesh.points) values.push_back(u(x));
    return values;
  };
  const auto there = transfer(coarse, at(coarse, linear), fine);
  // A vertex that is less than 1e-10 of a simplex's height off its face is interpolated on the face.
  for (const VertexId v : ids(fine.points)) EXPECT_NEAR(there[v], linear(fine.points[v]), 1e-9);

  const auto old_vertex = same_vertices(coarse, fine);
  const IdVector<VertexId, double> before = at(coarse, bent);
  const auto plain = transfer(coarse, before, fine), kept = transfer(coarse, before, fine, {.conserve = true});
  const auto by_region = [](const Mesh<D>& mesh, const IdVector<VertexId, double>& values) {
    const ControlVolumes<D> volumes = build_control_volumes(mesh);
    std::map<int, double> sum;
    for (const CellId c : ids(volumes.cell_vertex))
      sum[volumes.cell_region[c]] += volumes.cell_volume[c] * values[volumes.cell_vertex[c]];
    return sum;
  };
  const auto wanted = by_region(coarse, before), conserved = by_region(fine, kept), lost = by_region(fine, plain);
  for (const auto& [region, integral] : wanted) {
    EXPECT_NEAR(conserved.at(region), integral, 1e-12);
    EXPECT_GT(std::abs(lost.at(region) - integral), 1e-6);
  }
  for (const VertexId v : ids(fine.points))
    if (!old_vertex[v].is_none()) {
      EXPECT_EQ(plain[v], before[old_vertex[v]]);
      EXPECT_EQ(kept[v], before[old_vertex[v]]);
    }
  EXPECT_EQ(test::fault_of<InputError>([&] { transfer(coarse, there, fine); }).id, "transfer.wrong_length");
}

TEST(RefinementAtSharpFeatures, KeepsAllVertices) {
  for (const double degrees : {5.0, 20.0, 45.0}) {
    SCOPED_TRACE(degrees);
    const Mesh<3> mesh = make_mesh(test::sharp::wedge(degrees).input).mesh;
    const Refined<3> refined = refine_by(mesh, 0.5);
    expect_all_kept(mesh, refined.result);
    expect_certified(refined);
  }
}

TEST(RefinementAtSharpFeatures, KeepsAllVerticesOfFansInThePlane) {
  const Mesh<2> mesh = make_mesh(test::sharp::fan(7, 3.0).input).mesh;
  const Refined<2> refined = refine_by(mesh, 0.5);
  expect_all_kept(mesh, refined.result);
  expect_certified(refined);
}

}  // namespace
}  // namespace voropack
