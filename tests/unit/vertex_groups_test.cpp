// What spheres and balls leave of the vertices of groups, against every vertex on its own.
#include "coarsening/vertex_groups.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geom/hilbert.h"
#include "geom/tolerance.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

template <int D>
struct Case {
  IdVector<VertexId, Vec<D>> points;
  IdVector<VertexId, double> f;
  VertexGroups<D> groups;
};

/// f is large at a few vertices, so that boxes do not tell how far their spheres reach.
template <int D>
Case<D> a_case(std::size_t n, const Vec<D>& offset) {
  Case<D> made;
  Random random(5);
  std::vector<VertexId> along_curve;
  for (std::size_t i = 0; i < n; ++i) {
    made.points.push_back(test::random_point<D>(random) + offset);
    made.f.push_back(random.unit() < 0.02 ? 0.1 : 0.01 * random.unit());
  }
  for (const std::uint32_t v : hilbert_order<D>(made.points.raw())) along_curve.push_back(VertexId(v));
  made.groups = VertexGroups<D>(along_curve, made.points);
  return made;
}

template <int D>
void leaves_what_nothing_is_in_the_way_of(const Vec<D>& offset) {
  for (const std::size_t n : {0U, 1U, 16U, 17U, 130U, 5000U}) {
    const Case<D> given = a_case<D>(n, offset);
    Vacancies<D> vacancies(given.groups, given.f);
    std::vector<std::uint8_t> is_gone(n, 0);
    std::size_t n_gone = 0;
    Random random(6);
    for (int k = 0; k < 60; ++k) {
      const Ball<D> ball{test::random_point<D>(random) + offset, 0.15 * random.unit()};
      const bool is_sphere = k % 3 != 0;
      if (is_sphere)
        vacancies.take_sphere(ball);
      else
        vacancies.take_ball(ball);
      for (std::size_t i = 0; i < n; ++i) {
        const VertexId v = given.groups.vertices[i];
        const bool is_hit =
            is_sphere ? SphereSet<D>::overlap(ball, given.points[v], given.f[v])
                      : distance_sq(given.points[v], ball.center) <= ball.radius * ball.radius * (1 + kBallMargin);
        n_gone += is_hit && is_gone[i] == 0 ? 1 : 0;
        is_gone[i] |= is_hit ? 1 : 0;
        ASSERT_EQ(vacancies.contain(static_cast<std::uint32_t>(i)), is_gone[i] == 0) << n << " vertices, step " << k;
      }
    }
    if (n == 5000) {
      EXPECT_GT(n_gone, 500U);
      EXPECT_LT(n_gone, 4950U);
    }
  }
}
TEST(Vacancies, AreWhatNothingIsInTheWayOfInThePlane) { leaves_what_nothing_is_in_the_way_of<2>({0, 0}); }
TEST(Vacancies, AreWhatNothingIsInTheWayOfInSpace) { leaves_what_nothing_is_in_the_way_of<3>({0, 0, 0}); }
TEST(Vacancies, AreTheSameFarFromTheOrigin) { leaves_what_nothing_is_in_the_way_of<2>({1e6, -3e7}); }

TEST(Vacancies, AFlatBallTakesNothing) {
  const Case<2> given = a_case<2>(100, {0, 0});
  Vacancies<2> vacancies(given.groups, given.f);
  vacancies.take_ball({{0.5, 0.5}, std::numeric_limits<double>::infinity()});
  vacancies.take_ball({{std::nan(""), 0.5}, 1});
  vacancies.take_ball({given.points[VertexId(0)], 0});
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_TRUE(vacancies.contain(i));
}

}  // namespace
}  // namespace voropack
