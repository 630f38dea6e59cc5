#include "geom/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace voropack {
namespace {

/// Calls visit with every tuple of K + 1 exponents of the given sum.
template <int K>
void for_each_monomial(int degree, const std::function<void(const std::array<int, K + 1>&)>& visit) {
  std::array<int, K + 1> power{};
  const std::function<void(std::size_t, int)> fill = [&](std::size_t i, int rest) {
    if (i == K) {
      power[i] = rest;
      visit(power);
      return;
    }
    for (power[i] = 0; power[i] <= rest; ++power[i]) fill(i + 1, rest - power[i]);
  };
  fill(0, degree);
}

/// The mean of a monomial of barycentric coordinates over the simplex: K! a! b! ... / (K + a + b + ...)!
template <int K>
double exact_mean(const std::array<int, K + 1>& power) {
  double value = std::tgamma(K + 1.0);
  int degree = 0;
  for (const int a : power) {
    value *= std::tgamma(a + 1.0);
    degree += a;
  }
  return value / std::tgamma(K + degree + 1.0);
}

template <int K>
double quadrature_mean(const auto& rule, const std::array<int, K + 1>& power) {
  double sum = 0;
  for (const auto& point : rule) {
    double term = point.weight;
    for (std::size_t i = 0; i <= K; ++i) term *= std::pow(point.barycentric[i], power[i]);
    sum += term;
  }
  return sum;
}

template <int K>
double largest_error(const auto& rule, int degree) {
  double largest = 0;
  for_each_monomial<K>(degree, [&](const std::array<int, K + 1>& power) {
    largest = std::max(largest, std::abs(quadrature_mean<K>(rule, power) - exact_mean<K>(power)));
  });
  return largest;
}

template <int K>
void expect_exact(const auto& rule, int to_degree) {
  for (int degree = 0; degree <= to_degree; ++degree)
    EXPECT_LT(largest_error<K>(rule, degree), 1e-15) << "degree " << degree;
  EXPECT_GT(largest_error<K>(rule, to_degree + 1), 1e-8);
  for (const auto& point : rule) {
    EXPECT_GT(point.weight, 0);
    double sum = 0;
    for (const double x : point.barycentric) {
      EXPECT_GT(x, 0);
      sum += x;
    }
    EXPECT_NEAR(sum, 1, 3e-16);
  }
}

template <int K>
void expect_exact_to_their_degree() {
  expect_exact<K>(kQuadrature<K>, kQuadratureDegree);
  expect_exact<K>(kFineQuadrature<K>, kFineQuadratureDegree);
}

TEST(Quadrature, OfSegmentsIsExactToItsDegreeAndInside) { expect_exact_to_their_degree<1>(); }
TEST(Quadrature, OfTrianglesIsExactToItsDegreeAndInside) { expect_exact_to_their_degree<2>(); }
TEST(Quadrature, OfTetrahedraIsExactToItsDegreeAndInside) { expect_exact_to_their_degree<3>(); }

TEST(Quadrature, PlacesPointsOfATriangleInSpace) {
  const std::array<Vec<3>, 3> corners = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  for (const auto& point : kQuadrature<2>)
    EXPECT_EQ(point.at(corners), Vec<3>(point.barycentric[0], point.barycentric[1], point.barycentric[2]));
}

}  // namespace
}  // namespace voropack
