// Hierarchies: nested, certified, and with an interpolation that is exact for linear functions.
#include "voropack/coarsening.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/allow_threads.h"
#include "support/cases.h"
#include "support/level_checks.h"

namespace voropack {
namespace {

/// P x = x for the coordinates, and every row adds up to one.
template <int D>
void expect_linear_exact(const CoarseningHierarchy<D>& hierarchy, const Mesh<D>& finest) {
  const Mesh<D>* finer = &finest;
  for (const CoarseLevel<D>& level : hierarchy.levels) {
    const SparseMatrix& p = level.prolongation;
    ASSERT_EQ(p.size(), finer->points.size());
    for (std::size_t row = 0; row < p.size(); ++row) {
      double sum = 0;
      Vec<D> x;
      for (std::uint64_t k = p.offsets[row]; k < p.offsets[row + 1]; ++k) {
        EXPECT_GT(p.values[k], 0);
        sum += p.values[k];
        x += p.values[k] * level.mesh.points[VertexId(p.columns[k])];
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_LT(distance(x, finer->points[VertexId(row)]), 1e-9);
      EXPECT_LE(p.offsets[row + 1] - p.offsets[row], static_cast<std::uint64_t>(D + 1));
    }
    finer = &level.mesh;
  }
}

template <int D>
void every_domain_coarsens() {
  for (const test::Case<D>& c : test::all_cases<D>())
    for (const Interior interior : {Interior::kLattice, Interior::kRandom}) {
      SCOPED_TRACE(c.name);
      const Mesh<D> finest = test::mesh_of(c.input, D == 2 ? 0.03 : 0.15, interior);
      CoarseningOptions options;
      options.levels = 3;
      const CoarseningHierarchy<D> hierarchy = coarsen(finest, options);
      EXPECT_GE(hierarchy.levels.size(), 1U);
      test::expect_nested(finest, hierarchy);
      expect_linear_exact(hierarchy, finest);
      for (const CoarseLevel<D>& level : hierarchy.levels) {
        EXPECT_EQ(level.epsilon, 0);  // Voronoi-maximal, as the finest mesh is.
        test::expect_certified(level, &hierarchy.domain, options.lipschitz);
      }
    }
}
TEST(Coarsening, EveryDomainCoarsensInThePlane) { every_domain_coarsens<2>(); }
TEST(Coarsening, EveryDomainCoarsensInSpace) { every_domain_coarsens<3>(); }

template <int D>
void options_work() {
  const Mesh<D> finest = test::mesh_of(domains::two_material_box<D>(), D == 2 ? 0.03 : 0.12);
  for (const InitialSpacing initial : {InitialSpacing::kNearest, InitialSpacing::kMeanEdge})
    for (const CoarseningOrder order : {CoarseningOrder::kFront, CoarseningOrder::kCurve, CoarseningOrder::kRandom})
      for (const double growth : {1.3, 2.0}) {
        CoarseningOptions options;
        options.levels = 2;
        options.growth = growth;
        options.initial = initial;
        options.order = order;
        const CoarseningHierarchy<D> hierarchy = coarsen(finest, options);
        test::expect_nested(finest, hierarchy);
        for (const CoarseLevel<D>& level : hierarchy.levels)
          test::expect_certified(level, &hierarchy.domain, options.lipschitz);
      }
}
TEST(Coarsening, OptionsWorkInThePlane) { options_work<2>(); }
TEST(Coarsening, OptionsWorkInSpace) { options_work<3>(); }

/// f_0 is what the mesh was packed with, up to what a lattice makes of it: about 2^-D of the vertices stay.
template <int D>
void first_level_keeps_its_part() {
  for (const Interior interior : {Interior::kLattice, Interior::kRandom}) {
    const Mesh<D> finest = test::mesh_of(domains::unit_box<D>(), D == 2 ? 0.012 : 0.05, interior);
    CoarseningOptions options;
    options.levels = 1;
    const CoarseningHierarchy<D> hierarchy = coarsen(finest, options);
    ASSERT_EQ(hierarchy.levels.size(), 1U);
    const double kept = static_cast<double>(hierarchy.levels[0].mesh.points.size()) /
                        static_cast<double>(finest.points.size()) * std::pow(2, D);
    EXPECT_GT(kept, 0.7);
    EXPECT_LT(kept, 1.5);
  }
}
TEST(Coarsening, FirstLevelKeepsItsPartInThePlane) { first_level_keeps_its_part<2>(); }
TEST(Coarsening, FirstLevelKeepsItsPartInSpace) { first_level_keeps_its_part<3>(); }

/// Shapes do not get worse from level to level (Theorem 4.1).
TEST(Coarsening, ShapesDoNotDecay) {
  const Mesh<2> finest = test::mesh_of(domains::unit_square(), 0.004, Interior::kRandom);
  CoarseningOptions options;
  options.levels = 6;
  options.growth = 1.6;
  const CoarseningHierarchy<2> hierarchy = coarsen(finest, options);
  ASSERT_EQ(hierarchy.levels.size(), 6U);
  std::size_t finer = finest.points.size();
  for (const CoarseLevel<2>& level : hierarchy.levels) {
    const QualityReport quality = measure_quality(level.mesh, build_control_volumes(level.mesh));
    EXPECT_LT(quality.radius_edge.max, 2);
    EXPECT_LT(static_cast<double>(level.mesh.points.size()), 0.75 * static_cast<double>(finer));
    finer = level.mesh.points.size();
  }
}

/// A lattice fits some growths badly: such a level has hardly fewer vertices than the next finer one, and coarser ones
/// follow nevertheless.
TEST(Coarsening, SmallGrowthsGoOnBeyondALevelThatGainsNothing) {
  const Mesh<2> finest = test::mesh_of(domains::l_shape<2>(), 0.02);
  for (const double growth : {1.3, 1.4}) {
    CoarseningOptions options;
    options.levels = 10;
    options.growth = growth;
    const CoarseningHierarchy<2> hierarchy = coarsen(finest, options);
    test::expect_nested(finest, hierarchy);
    EXPECT_GE(hierarchy.levels.size(), 4U) << growth;
    EXPECT_LT(15 * hierarchy.levels.back().mesh.points.size(), finest.points.size()) << growth;
    for (const auto& level : hierarchy.levels) test::expect_certified(level, &hierarchy.domain, options.lipschitz);
  }
}

TEST(Coarsening, ThreadsDoNotMatter) {
  const test::AllowThreads allow(8);
  const Mesh<3> finest = test::mesh_of(domains::l_shape<3>(), 0.15);
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    return coarsen(finest);
  };
  const CoarseningHierarchy<3> one = run(1), many = run(8);
  ASSERT_EQ(one.levels.size(), many.levels.size());
  for (std::size_t i = 0; i < one.levels.size(); ++i) {
    EXPECT_EQ(one.levels[i].mesh, many.levels[i].mesh);
    EXPECT_EQ(one.levels[i].prolongation, many.levels[i].prolongation);
    EXPECT_EQ(one.levels[i].finest_vertex, many.levels[i].finest_vertex);
  }
}

TEST(Coarsening, BadOptionsAreRefused) {
  const Mesh<2> mesh = test::mesh_of(domains::unit_square(), 0.3);
  for (const auto& change : std::vector<std::function<void(CoarseningOptions&)>>{
           [](auto& o) { o.levels = 0; }, [](auto& o) { o.growth = 1; }, [](auto& o) { o.lipschitz = 0; },
           [](auto& o) { o.lipschitz = 1; }}) {
    CoarseningOptions options;
    change(options);
    EXPECT_THROW(coarsen(mesh, options), OptionError);
  }
}

}  // namespace
}  // namespace voropack
