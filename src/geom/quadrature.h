// Quadrature on simplices: points with positive weights inside the simplex. A rule of degree 5 with few points for what
// a method integrates, and one of degree 7 for what judges it.
#pragma once

#include <array>
#include <cstddef>

#include "voropack/vec.h"

namespace voropack {

/// A point of a quadrature rule on a K-simplex. The weights of a rule add up to 1: the integral is the simplex's
/// measure times the weighted sum.
template <int K>
struct QuadraturePoint {
  std::array<double, K + 1> barycentric;
  double weight;

  /// The point in a simplex with the given corners, in a space of any dimension.
  template <int D>
  [[nodiscard]] Vec<D> at(const std::array<Vec<D>, K + 1>& corners) const {
    Vec<D> x;
    for (std::size_t i = 0; i <= K; ++i) x += barycentric[i] * corners[i];
    return x;
  }
};

/// The degree of the polynomials that `kQuadrature` integrates exactly.
inline constexpr int kQuadratureDegree = 5;

namespace quadrature_detail {

/// Gauss's three points, at 1/2 and 1/2 -+ sqrt(3/20).
constexpr std::array<QuadraturePoint<1>, 3> make_segment_rule() {
  constexpr double kOffset = 0.38729833462074168852;
  return {
      {{{0.5, 0.5}, 4.0 / 9}, {{0.5 - kOffset, 0.5 + kOffset}, 5.0 / 18}, {{0.5 + kOffset, 0.5 - kOffset}, 5.0 / 18}}};
}

/// Radon's seven points (1948): the barycenter and two orbits, with barycentric coordinate (6 -+ sqrt(15)) / 21
/// twice.
constexpr std::array<QuadraturePoint<2>, 7> make_triangle_rule() {
  std::array<QuadraturePoint<2>, 7> rule{};
  rule[0] = {{1.0 / 3, 1.0 / 3, 1.0 / 3}, 9.0 / 40};
  constexpr std::array<double, 2> kSmall = {0.10128650732345633880, 0.47014206410511508977};
  constexpr std::array<double, 2> kWeight = {0.12593918054482715260, 0.13239415278850618074};
  for (std::size_t orbit = 0; orbit < 2; ++orbit)
    for (std::size_t i = 0; i < 3; ++i) {
      QuadraturePoint<2>& point = rule[1 + 3 * orbit + i];
      point.barycentric.fill(kSmall[orbit]);
      point.barycentric[i] = 1 - 2 * kSmall[orbit];
      point.weight = kWeight[orbit];
    }
  return rule;
}

/// The fourteen points of Walkington (2000): two orbits near corners and faces, one of six points between edges.
constexpr std::array<QuadraturePoint<3>, 14> make_tetrahedron_rule() {
  std::array<QuadraturePoint<3>, 14> rule{};
  constexpr std::array<double, 2> kSmall = {0.31088591926330060980, 0.092735250310891226402};
  constexpr std::array<double, 2> kWeight = {0.11268792571801585080, 0.073493043116361949544};
  for (std::size_t orbit = 0; orbit < 2; ++orbit)
    for (std::size_t i = 0; i < 4; ++i) {
      QuadraturePoint<3>& point = rule[4 * orbit + i];
      point.barycentric.fill(kSmall[orbit]);
      point.barycentric[i] = 1 - 3 * kSmall[orbit];
      point.weight = kWeight[orbit];
    }
  constexpr double kPair = 0.045503704125649649492;
  std::size_t next = 8;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      QuadraturePoint<3>& point = rule[next++];
      point.barycentric.fill(0.5 - kPair);
      point.barycentric[i] = point.barycentric[j] = kPair;
      point.weight = 0.042546020777081466438;
    }
  return rule;
}

/// The four points of Gauss and Jacobi on [0, 1] for the weight (1 - t)^a, a = 0, 1, 2; weights divided by their sum.
struct GaussJacobi {
  std::array<double, 4> point, weight;
};
inline constexpr std::array<GaussJacobi, 3> kGaussJacobi = {{
    {{0.06943184420297371239, 0.33000947820757186760, 0.66999052179242813240, 0.93056815579702628761},
     {0.17392742256872692869, 0.32607257743127307131, 0.32607257743127307131, 0.17392742256872692869}},
    {{0.05710419611451768219, 0.27684301363812382768, 0.58359043236891682006, 0.86024013565621944785},
     {0.27101382686297623242, 0.40692913602054272158, 0.25969509521646488165, 0.06236194190001616435}},
    {{0.04850054944699732930, 0.23860073755186230506, 0.51704729510436750234, 0.79585141789677286330},
     {0.33266524683383395105, 0.43037636939764262714, 0.20590166151876922595, 0.03105672224975419585}},
}};

/// Stroud's conical product of 4^K points: each coordinate is a share of what the ones before leave.
template <int K>
constexpr auto make_conical_rule() {
  constexpr std::size_t kSize = K == 1 ? 4 : K == 2 ? 16 : 64;
  std::array<QuadraturePoint<K>, kSize> rule{};
  for (std::size_t p = 0; p < kSize; ++p) {
    double rest = 1, weight = 1;
    std::size_t digits = p;
    for (std::size_t k = 0; k < K; ++k, digits /= 4) {
      const GaussJacobi& line = kGaussJacobi[K - 1 - k];
      rule[p].barycentric[k] = rest * line.point[digits % 4];
      rest *= 1 - line.point[digits % 4];
      weight *= line.weight[digits % 4];
    }
    rule[p].barycentric[K] = rest;
    rule[p].weight = weight;
  }
  return rule;
}

}  // namespace quadrature_detail

/// The rule of degree kQuadratureDegree on a K-simplex.
template <int K>
inline constexpr std::array<QuadraturePoint<K>, 0> kQuadrature = {};
template <>
inline constexpr std::array<QuadraturePoint<1>, 3> kQuadrature<1> = quadrature_detail::make_segment_rule();
template <>
inline constexpr std::array<QuadraturePoint<2>, 7> kQuadrature<2> = quadrature_detail::make_triangle_rule();
template <>
inline constexpr std::array<QuadraturePoint<3>, 14> kQuadrature<3> = quadrature_detail::make_tetrahedron_rule();

/// The degree of the polynomials that `kFineQuadrature` integrates exactly, with 4^K points.
inline constexpr int kFineQuadratureDegree = 7;
template <int K>
inline constexpr auto kFineQuadrature = quadrature_detail::make_conical_rule<K>();

}  // namespace voropack
