#include "geom/circumcenter.h"

#include <cmath>
#include <limits>

#include "geom/number_vec.h"

namespace voropack {

namespace {

constexpr double kUnit = 0x1.0p-53;
constexpr double kDeterminantError = 1e-13;  // Relative.
constexpr double kOffsetError = 1e-13;       // Relative to the edges at corner 0.

/// The offset is numerator / (2 volume); edge_sq are the squared lengths of the edges at corner 0.
template <class S, std::size_t D>
struct Center {
  NumberVec<S, D> numerator;
  S volume;
  NumberVec<S, D> edge_sq;
};

/// Cramer's rule for 2 v.x = |v|^2, v = b, c, d.
template <class S, class Point>
Center<S, 3> center(const std::array<Point, 4>& p) {
  const auto b = difference<S>(p[1], p[0]), c = difference<S>(p[2], p[0]), d = difference<S>(p[3], p[0]);
  const auto cd = cross<S>(c, d), db = cross<S>(d, b), bc = cross<S>(b, c);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c), dd = dot<S>(d, d);
  const auto axis = [&](std::size_t k) { return bb * cd[k] + cc * db[k] + dd * bc[k]; };
  return {{axis(0), axis(1), axis(2)}, dot<S>(d, bc), {bb, cc, dd}};
}

template <class S, class Point>
Center<S, 2> center(const std::array<Point, 3>& p) {
  const auto b = difference<S>(p[1], p[0]), c = difference<S>(p[2], p[0]);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c);
  return {{bb * c[1] - cc * b[1], cc * b[0] - bb * c[0]}, cross<S>(b, c), {bb, cc}};
}

template <class S>
S determinant(const std::array<Vec<3>, 4>& p) {
  const auto b = difference<S>(p[1], p[0]), c = difference<S>(p[2], p[0]), d = difference<S>(p[3], p[0]);
  return dot<S>(d, cross<S>(b, c));
}

template <class S>
S determinant(const std::array<Vec<2>, 3>& p) {
  return cross<S>(difference<S>(p[1], p[0]), difference<S>(p[2], p[0]));
}

/// Bounds of the errors of numerator and volume in units of the arithmetic, and the length of the edges at corner 0.
template <class S>
struct CenterBound {
  S numerator, volume, edge;
};

template <class S>
CenterBound<S> error_bound(const NumberVec<S, 3>& edge_sq) {
  using std::sqrt;
  const S volume = sqrt(edge_sq[0] * edge_sq[1] * edge_sq[2]), edge = sqrt(edge_sq[0] + edge_sq[1] + edge_sq[2]);
  return {S(24) * volume * edge, S(12) * volume, edge};
}

template <class S>
CenterBound<S> error_bound(const NumberVec<S, 2>& edge_sq) {
  using std::sqrt;
  const S volume = sqrt(edge_sq[0] * edge_sq[1]), edge = sqrt(edge_sq[0] + edge_sq[1]);
  return {S(12) * volume * edge, S(6) * volume, edge};
}

/// Whether an offset in arithmetic of the given unit is as accurate as promised; S is double, or Lanes for two of them.
template <class S, std::size_t D>
auto is_accurate(const NumberVec<S, D>& offset, const S& volume, const CenterBound<S>& bound, const S& unit) {
  using std::abs, std::sqrt;
  const S volume_error = unit * bound.volume;
  const S relative = volume_error / abs(volume);
  const S length = sqrt(dot<S>(offset, offset));
  const S error = S(2) * (unit * bound.numerator / (S(2) * abs(volume)) + length * relative);
  return (abs(volume) > S(8) * volume_error) & (error < S(kOffsetError) * bound.edge);
}

template <class S, int D>
bool certified(const std::array<Vec<D>, D + 1>& p, double unit, Vec<D>& offset) {
  const auto exact = center<S>(p);
  NumberVec<double, D> edge_sq;
  for (std::size_t k = 0; k < D; ++k) edge_sq[k] = to_double(exact.edge_sq[k]);
  const double volume = to_double(exact.volume);
  for (std::size_t k = 0; k < D; ++k) offset.coord[k] = to_double(exact.numerator[k]) / (2 * volume);
  return is_accurate<double>(offset.coord, volume, error_bound<double>(edge_sq), unit);
}

template <int D>
Vec<D> exact_offset(const std::array<Vec<D>, D + 1>& p) {
  Vec<D> offset;
  const auto exact = center<Expansion>(p);
  const Dd twice = exact.volume.approximate() * Dd(2.0);
  for (int k = 0; k < D; ++k) {
    offset[k] = sign(twice) == 0 ? std::numeric_limits<double>::quiet_NaN()
                                 : to_double(exact.numerator[static_cast<std::size_t>(k)].approximate() / twice);
  }
  return offset;
}

}  // namespace

template <int D>
Vec<D> circumcenter_offset(const std::array<Vec<D>, D + 1>& simplex) {
  Vec<D> offset;
  if (certified<double, D>(simplex, kUnit, offset)) return offset;
  const double scale = unit_scale(simplex, simplex[0]);
  std::array<Vec<D>, D + 1> unit = simplex;
  for (Vec<D>& p : unit) p *= scale;
  if (!certified<Dd, D>(unit, kDdUnit, offset)) offset = exact_offset<D>(unit);
  return offset / scale;
}

template <int D>
Vec<D> circumcenter(const std::array<Vec<D>, D + 1>& simplex) {
  return simplex[0] + circumcenter_offset<D>(simplex);
}

template <int D>
double simplex_determinant(const std::array<Vec<D>, D + 1>& simplex) {
  const double fast = determinant<double>(simplex);
  NumberVec<double, D> edge_sq;
  for (std::size_t k = 0; k < D; ++k) edge_sq[k] = distance_sq(simplex[k + 1], simplex[0]);
  if (std::abs(fast) > kUnit / kDeterminantError * error_bound<double>(edge_sq).volume) return fast;
  const double scale = unit_scale(simplex, simplex[0]);
  std::array<Vec<D>, D + 1> unit = simplex;
  for (Vec<D>& p : unit) p *= scale;
  const double volume_scale = D == 3 ? scale * scale * scale : scale * scale;
  return to_double(determinant<Expansion>(unit).approximate()) / volume_scale;
}

template <int D>
CircumcenterPair<D> circumcenter_pair(const SimplexPair<D>& simplices) {
  const Center<Lanes, D> fast = center<Lanes>(simplices);
  const CenterBound<Lanes> bound = error_bound<Lanes>(fast.edge_sq);
  CircumcenterPair<D> pair;
  pair.determinant = fast.volume;
  for (std::size_t k = 0; k < D; ++k) pair.offset[k] = fast.numerator[k] / (Lanes(2) * fast.volume);
  const Lanes::Mask accurate = is_accurate<Lanes>(pair.offset, fast.volume, bound, Lanes(kUnit)) &
                               (abs(fast.volume) > Lanes(kUnit / kDeterminantError) * bound.volume);
  for (std::size_t lane = 0; lane < Lanes::kSize && !accurate.all(); ++lane) {
    std::array<Vec<D>, D + 1> simplex;
    for (std::size_t i = 0; i <= D; ++i)
      for (std::size_t k = 0; k < D; ++k) simplex[i].coord[k] = simplices[i][k][lane];
    const Vec<D> offset = circumcenter_offset<D>(simplex);
    for (std::size_t k = 0; k < D; ++k) pair.offset[k].set(lane, offset.coord[k]);
    pair.determinant.set(lane, simplex_determinant<D>(simplex));
  }
  return pair;
}

template Vec<2> circumcenter_offset<2>(const std::array<Vec<2>, 3>&);
template Vec<3> circumcenter_offset<3>(const std::array<Vec<3>, 4>&);
template double simplex_determinant<2>(const std::array<Vec<2>, 3>&);
template double simplex_determinant<3>(const std::array<Vec<3>, 4>&);
template CircumcenterPair<2> circumcenter_pair<2>(const SimplexPair<2>&);
template CircumcenterPair<3> circumcenter_pair<3>(const SimplexPair<3>&);
template Vec<2> circumcenter<2>(const std::array<Vec<2>, 3>&);
template Vec<3> circumcenter<3>(const std::array<Vec<3>, 4>&);

}  // namespace voropack
