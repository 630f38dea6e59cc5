#include "geom/circumcenter.h"

#include <cmath>
#include <limits>

#include "geom/number_vec.h"

namespace voropack {

namespace {

constexpr double kUnit = 0x1.0p-53;
constexpr double kDeterminantError = 1e-13;  // Relative.
constexpr double kOffsetError = 1e-13;       // Relative to the edges at corner 0.

/// The offset is numerator / (2 volume).
template <class S, std::size_t D>
struct Center {
  NumberVec<S, D> numerator;
  S volume;
};

/// Cramer's rule for 2 v.x = |v|^2, v = b, c, d.
template <class S>
Center<S, 3> center(const std::array<Vec<3>, 4>& p) {
  const auto b = difference<S>(p[1], p[0]), c = difference<S>(p[2], p[0]), d = difference<S>(p[3], p[0]);
  const auto cd = cross<S>(c, d), db = cross<S>(d, b), bc = cross<S>(b, c);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c), dd = dot<S>(d, d);
  const auto axis = [&](std::size_t k) { return bb * cd[k] + cc * db[k] + dd * bc[k]; };
  return {{axis(0), axis(1), axis(2)}, dot<S>(d, bc)};
}

template <class S>
Center<S, 2> center(const std::array<Vec<2>, 3>& p) {
  const auto b = difference<S>(p[1], p[0]), c = difference<S>(p[2], p[0]);
  const S bb = dot<S>(b, b), cc = dot<S>(c, c);
  return {{bb * c[1] - cc * b[1], cc * b[0] - bb * c[0]}, cross<S>(b, c)};
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
struct CenterBound {
  double numerator, volume, edge;
};

CenterBound error_bound(const std::array<Vec<3>, 4>& p) {
  const double b = distance_sq(p[1], p[0]), c = distance_sq(p[2], p[0]), d = distance_sq(p[3], p[0]);
  const double volume = std::sqrt(b * c * d), edge = std::sqrt(b + c + d);
  return {24 * volume * edge, 12 * volume, edge};
}

CenterBound error_bound(const std::array<Vec<2>, 3>& p) {
  const double b = distance_sq(p[1], p[0]), c = distance_sq(p[2], p[0]);
  const double volume = std::sqrt(b * c), edge = std::sqrt(b + c);
  return {12 * volume * edge, 6 * volume, edge};
}

template <class S, int D>
bool certified(const std::array<Vec<D>, D + 1>& p, double unit, Vec<D>& offset) {
  const auto exact = center<S>(p);
  const CenterBound bound = error_bound(p);
  const double volume = to_double(exact.volume), volume_error = unit * bound.volume;
  if (!(std::abs(volume) > 8 * volume_error)) return false;
  for (int k = 0; k < D; ++k) offset[k] = to_double(exact.numerator[static_cast<std::size_t>(k)]) / (2 * volume);
  const double relative = volume_error / std::abs(volume);
  const double error = 2 * (unit * bound.numerator / (2 * std::abs(volume)) + norm(offset) * relative);
  return error <= kOffsetError * bound.edge;
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
  if (std::abs(fast) > kUnit / kDeterminantError * error_bound(simplex).volume) return fast;
  const double scale = unit_scale(simplex, simplex[0]);
  std::array<Vec<D>, D + 1> unit = simplex;
  for (Vec<D>& p : unit) p *= scale;
  const double volume_scale = D == 3 ? scale * scale * scale : scale * scale;
  return to_double(determinant<Expansion>(unit).approximate()) / volume_scale;
}

template Vec<2> circumcenter_offset<2>(const std::array<Vec<2>, 3>&);
template Vec<3> circumcenter_offset<3>(const std::array<Vec<3>, 4>&);
template double simplex_determinant<2>(const std::array<Vec<2>, 3>&);
template double simplex_determinant<3>(const std::array<Vec<3>, 4>&);
template Vec<2> circumcenter<2>(const std::array<Vec<2>, 3>&);
template Vec<3> circumcenter<3>(const std::array<Vec<3>, 4>&);

}  // namespace voropack
