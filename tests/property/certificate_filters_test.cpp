// Laws of the certificate's own geometry: filtered signs are the exact ones, error bounds hold.
#include <gtest/gtest.h>

#include <CGAL/Exact_rational.h>

#include "base/random.h"
#include "certificate/box_tree.h"
#include "certificate/geometry.h"
#include "certificate/tally.h"

namespace voropack::judge {
namespace {

/// Points of very different kinds: anywhere, on a small lattice (ties), nearly on a plane or sphere, far from the
/// origin.
template <int D>
Vec<D> sample_point(Random& random, std::uint64_t kind) {
  Vec<D> p;
  for (int k = 0; k < D; ++k) {
    const double u = random.unit();
    p[k] = kind % 4 == 1 ? std::floor(4 * u) : u;
    if (kind % 4 == 2 && k == D - 1) p[k] = 0.5 * p[0] + 1e-15 * (u - 0.5);
    if (kind % 4 == 3) p[k] = 1e6 + 1e-6 * u;
  }
  return p;
}

template <int D>
std::array<Vec<D>, D + 1> sample_simplex(Random& random, std::uint64_t kind) {
  std::array<Vec<D>, D + 1> p;
  for (Vec<D>& corner : p) corner = sample_point<D>(random, kind);
  return p;
}

TEST(CertificateFilters, AgreeWithExactPredicates) {
  Random random(7);
  for (std::uint64_t trial = 0; trial < 20'000; ++trial) {
    double size = 0;
    const auto t = sample_simplex<2>(random, trial);
    const Vec<2> e = sample_point<2>(random, trial);
    const int side_2d = orientation(t[0], t[1], t[2]);
    ASSERT_EQ(certain_orientation<2>(t).sign, side_2d) << trial;
    if (side_2d != 0) {
      ASSERT_EQ(certain_in_circumball(t, e, size).sign, in_circumball(t[0], t[1], t[2], e)) << trial;
    }
    const auto u = sample_simplex<3>(random, trial);
    const Vec<3> f = sample_point<3>(random, trial);
    const int side_3d = orientation(u[0], u[1], u[2], u[3]);
    ASSERT_EQ(certain_orientation<3>(u).sign, side_3d) << trial;
    if (side_3d != 0) {
      ASSERT_EQ(certain_in_circumball(u, f, size).sign, in_circumball(u[0], u[1], u[2], u[3], f)) << trial;
    }
  }
}

/// The circumcenter in rational arithmetic, by Cramer's rule.
template <int D>
std::array<CGAL::Exact_rational, D> exact_center(const std::array<Vec<D>, D + 1>& p) {
  using Q = CGAL::Exact_rational;
  std::array<std::array<Q, D + 1>, D> row;  // 2 (p_k - p_0) . x = |p_k|^2 - |p_0|^2
  for (std::size_t k = 0; k < D; ++k) {
    row[k][D] = 0;
    for (std::size_t i = 0; i < D; ++i) {
      const Q a(p[k + 1].coord[i]), b(p[0].coord[i]);
      row[k][i] = 2 * (a - b);
      row[k][D] += a * a - b * b;
    }
  }
  for (std::size_t k = 0; k < D; ++k) {
    std::size_t pivot = k;
    while (row[pivot][k] == 0) ++pivot;
    std::swap(row[k], row[pivot]);
    for (std::size_t r = 0; r < D; ++r) {
      if (r == k) continue;
      const Q factor = row[r][k] / row[k][k];
      for (std::size_t i = k; i <= D; ++i) row[r][i] -= factor * row[k][i];
    }
  }
  std::array<Q, D> center;
  for (std::size_t k = 0; k < D; ++k) center[k] = row[k][D] / row[k][k];
  return center;
}

template <int D>
void expect_error_bound_holds(const std::array<Vec<D>, D + 1>& p) {
  const Circumball<D> ball = circumball<D>(p);
  const auto center = exact_center<D>(p);
  CGAL::Exact_rational off_sq = 0;
  for (std::size_t k = 0; k < D; ++k) {
    const CGAL::Exact_rational d = center[k] - CGAL::Exact_rational(ball.center.coord[k]);
    off_sq += d * d;
  }
  EXPECT_LE(std::sqrt(CGAL::to_double(off_sq)), ball.error);
  double sum = 0;
  for (const double b : ball.barycentric) sum += b;
  EXPECT_NEAR(sum, 1, 1e-9 * (1 + std::abs(ball.barycentric[0])));
}

TEST(CertificateFilters, CircumcentersKeepTheirErrorBound) {
  Random random(8);
  int n_flat = 0;
  for (std::uint64_t trial = 0; trial < 400; ++trial) {
    const auto t = sample_simplex<2>(random, trial % 2 == 0 ? 0 : 3);
    if (orientation(t[0], t[1], t[2]) > 0) expect_error_bound_holds<2>(t);
    auto u = sample_simplex<3>(random, trial % 2 == 0 ? 0 : 3);
    // A sliver: the last corner moved next to the plane of the others.
    const double flatness = std::pow(10.0, -static_cast<double>(trial % 13));
    u[3] = (u[0] + u[1] + u[2]) / 3 + flatness * (u[3] - u[0]);
    if (orientation(u[0], u[1], u[2], u[3]) <= 0) continue;
    expect_error_bound_holds<3>(u);
    n_flat += flatness < 1e-8 ? 1 : 0;
  }
  EXPECT_GT(n_flat, 10);
}

TEST(CertificateFilters, DiametralBallsKeepTheirErrorBound) {
  Random random(9);
  for (std::uint64_t trial = 0; trial < 400; ++trial) {
    const auto p = sample_simplex<3>(random, trial % 2 == 0 ? 0 : 3);
    const DiametralBall<3> ball = diametral_ball(p[0], p[1], p[2]);
    // The center is at equal distances and in the plane, up to the error.
    const double r = std::sqrt(ball.radius_sq);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LE(std::abs(distance(ball.center, p[i]) - r), 2 * ball.error + 1e-15);
    EXPECT_FALSE(ball.degenerate);
  }
  EXPECT_TRUE(diametral_ball(Vec<3>{0, 0, 0}, Vec<3>{1, 2, 3}, Vec<3>{2, 4, 6}).degenerate);
  EXPECT_TRUE(diametral_ball(Vec<2>{1, 2}, Vec<2>{1, 2}).degenerate);
}

TEST(Tally, QuotientsAreNotedAsIfTheyWereDivided) {
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    Tally quotients, figures;
    for (std::uint32_t k = 0; k < 200; ++k) {
      // Few different values, so that quotients tie, exactly and up to rounding.
      const double denominator = 1 + static_cast<double>(random.bits() % 7) / 3;
      const double figure = (static_cast<double>(random.bits() % 9) - (trial % 2 == 0 ? 8.0 : 4.0)) / 3;
      const double numerator = figure * denominator;
      quotients.legal_quotient(numerator, denominator, k);
      figures.legal(numerator / denominator, k);
      if (trial % 5 == 4 && k == 100) {
        quotients.violation(1, -1, k);
        figures.violation(1, -1, k);
      }
    }
    EXPECT_EQ(quotients.tested, figures.tested);
    EXPECT_EQ(quotients.worst.figure, figures.worst.figure);
    EXPECT_EQ(quotients.worst.ids, figures.worst.ids);
    EXPECT_EQ(quotients.worst.kind, figures.worst.kind);
  }
}

TEST(BoxTree, FindsEveryItemInABall) {
  Random random(10);
  for (const std::size_t n : {0U, 1U, 2U, 8U, 9U, 100U, 1000U}) {
    std::vector<Vec<2>> points(n);
    for (Vec<2>& p : points) p = sample_point<2>(random, n % 2);
    const BoxTree<2> tree(
        n, [&](std::size_t i) { return Box<2>(points[i], points[i]); }, [](std::size_t i) { return 1.0 + i; });
    const Vec<2> x = {0.5, 0.5};
    std::size_t n_found = 0, n_expected = 0;
    double largest = 0;
    tree.visit(
        [&](const Box<2>& box, double weight) {
          largest = std::max(largest, weight);
          return box.distance_sq(x) <= 0.09;
        },
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) n_found += distance_sq(points[tree.order()[i]], x) <= 0.09;
        });
    for (const Vec<2>& p : points) n_expected += distance_sq(p, x) <= 0.09;
    EXPECT_EQ(n_found, n_expected);
    EXPECT_EQ(largest, static_cast<double>(n));
  }
}

}  // namespace
}  // namespace voropack::judge
