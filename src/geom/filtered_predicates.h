// The predicates of predicates.h behind floating-point filters that are inlined into the loops of a triangulation.
//
// Both determinants are evaluated as by Shewchuk [Adaptive Precision Floating-Point Arithmetic and Fast Robust
// Geometric Predicates, 1997], whose theorems bound the error by (a few units of rounding) times the permanent, the
// determinant with all signs positive. Where |differences of coordinates| <= X <= Y <= Z, axis by axis, the permanents
// are at most
//   orientation  2D: 2 XY          3D: 6 XYZ
//   in_circumball 2D: 12 XY Y^2    3D: 72 XYZ Z^2
// and the bounds below follow. Three filters are tried in turn:
//   1. static: X = Y = Z = the extent of all points, computed once;
//   2. of the call: X, Y, Z from the arguments, so that small simplices of a graded mesh pass;
//   3. exact evaluation, exact_predicates.h.
// Shewchuk's theorems hold without overflow and underflow. A filter answers only where X, Y, Z lie in a range in which
// the error by underflow is far below the slack of the constants, and nothing overflows.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geom/exact_predicates.h"
#include "voropack/vec.h"

namespace voropack {

template <int K>
class FilteredPredicates;

namespace filter {

inline constexpr double kRoundoff = 0x1.0p-53;
/// 1 + this covers the rounding of the bound itself and of the second-order terms of the theorems.
inline constexpr double kSlack = 1.0 + 0x1.0p-40;
inline constexpr double kOrientation2 = kSlack * 3 * kRoundoff * 2;
inline constexpr double kOrientation3 = kSlack * 7 * kRoundoff * 6;
inline constexpr double kInCircle = kSlack * 10 * kRoundoff * 12;
inline constexpr double kInSphere = kSlack * 16 * kRoundoff * 72;
/// Products of five lengths in this range neither overflow nor come near to the denormal numbers.
inline constexpr double kSmallest = 1e-58;
inline constexpr double kLargest = 1e58;

inline bool in_range(double smallest, double largest) { return smallest > kSmallest && largest < kLargest; }

constexpr double max_abs(double a, double b, double c) {
  return std::max(std::abs(a), std::max(std::abs(b), std::abs(c)));
}

constexpr int sign(double x) { return x > 0 ? 1 : -1; }

}  // namespace filter

template <>
class FilteredPredicates<2> {
 public:
  /// All points of later calls lie in `box`.
  void set_box(const Box<2>& box) {
    const double extent = std::max(box.hi[0] - box.lo[0], box.hi[1] - box.lo[1]);
    const bool fits = filter::in_range(extent, extent);
    orientation_bound_ = fits ? filter::kOrientation2 * extent * extent : kNever;
    in_ball_bound_ = fits ? filter::kInCircle * extent * extent * extent * extent : kNever;
  }

  [[nodiscard]] int orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) const {
    const double acx = a[0] - c[0], bcx = b[0] - c[0];
    const double acy = a[1] - c[1], bcy = b[1] - c[1];
    const double det = acx * bcy - acy * bcx;
    if (std::abs(det) > orientation_bound_) [[likely]]
      return filter::sign(det);
    const double x = std::max(std::abs(acx), std::abs(bcx)), y = std::max(std::abs(acy), std::abs(bcy));
    if (x == 0 || y == 0) return 0;  // On a line parallel to an axis.
    if (filter::in_range(std::min(x, y), std::max(x, y)) && std::abs(det) > filter::kOrientation2 * x * y)
      return filter::sign(det);
    return orientation_exact(a, b, c);
  }

  [[nodiscard, gnu::always_inline]] int in_circumball(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c,
                                                      const Vec<2>& e) const {
    const double aex = a[0] - e[0], bex = b[0] - e[0], cex = c[0] - e[0];
    const double aey = a[1] - e[1], bey = b[1] - e[1], cey = c[1] - e[1];
    const double alift = aex * aex + aey * aey;
    const double blift = bex * bex + bey * bey;
    const double clift = cex * cex + cey * cey;
    const double det =
        alift * (bex * cey - cex * bey) + blift * (cex * aey - aex * cey) + clift * (aex * bey - bex * aey);
    if (std::abs(det) > in_ball_bound_) [[likely]]
      return filter::sign(det);
    double x = filter::max_abs(aex, bex, cex), y = filter::max_abs(aey, bey, cey);
    if (x > y) std::swap(x, y);
    if (filter::in_range(x, y) && std::abs(det) > filter::kInCircle * x * y * (y * y)) return filter::sign(det);
    return in_circumball_exact(a, b, c, e);
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double orientation_bound_ = kNever;
  double in_ball_bound_ = kNever;
};

template <>
class FilteredPredicates<3> {
 public:
  /// All points of later calls lie in `box`.
  void set_box(const Box<3>& box) {
    const double extent = std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
    const bool fits = filter::in_range(extent, extent);
    orientation_bound_ = fits ? filter::kOrientation3 * extent * extent * extent : kNever;
    in_ball_bound_ = fits ? filter::kInSphere * extent * extent * extent * (extent * extent) : kNever;
  }

  [[nodiscard]] int orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) const {
    const double adx = a[0] - d[0], bdx = b[0] - d[0], cdx = c[0] - d[0];
    const double ady = a[1] - d[1], bdy = b[1] - d[1], cdy = c[1] - d[1];
    const double adz = a[2] - d[2], bdz = b[2] - d[2], cdz = c[2] - d[2];
    // Shewchuk's determinant has the opposite sign.
    const double det = adz * (cdx * bdy - bdx * cdy) + bdz * (adx * cdy - cdx * ady) + cdz * (bdx * ady - adx * bdy);
    if (std::abs(det) > orientation_bound_) [[likely]]
      return filter::sign(det);
    const double x = filter::max_abs(adx, bdx, cdx);
    const double y = filter::max_abs(ady, bdy, cdy);
    const double z = filter::max_abs(adz, bdz, cdz);
    if (x == 0 || y == 0 || z == 0) return 0;  // In a plane parallel to two axes.
    if (filter::in_range(std::min({x, y, z}), std::max({x, y, z})) && std::abs(det) > filter::kOrientation3 * x * y * z)
      return filter::sign(det);
    return orientation_exact(a, b, c, d);
  }

  [[nodiscard, gnu::always_inline]] int in_circumball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c,
                                                      const Vec<3>& d, const Vec<3>& e) const {
    const double aex = a[0] - e[0], bex = b[0] - e[0], cex = c[0] - e[0], dex = d[0] - e[0];
    const double aey = a[1] - e[1], bey = b[1] - e[1], cey = c[1] - e[1], dey = d[1] - e[1];
    const double aez = a[2] - e[2], bez = b[2] - e[2], cez = c[2] - e[2], dez = d[2] - e[2];
    const double ab = aex * bey - bex * aey, bc = bex * cey - cex * bey;
    const double cd = cex * dey - dex * cey, da = dex * aey - aex * dey;
    const double ac = aex * cey - cex * aey, bd = bex * dey - dex * bey;
    const double abc = aez * bc - bez * ac + cez * ab;
    const double bcd = bez * cd - cez * bd + dez * bc;
    const double cda = cez * da + dez * ac + aez * cd;
    const double dab = dez * ab + aez * bd + bez * da;
    const double alift = aex * aex + aey * aey + aez * aez;
    const double blift = bex * bex + bey * bey + bez * bez;
    const double clift = cex * cex + cey * cey + cez * cez;
    const double dlift = dex * dex + dey * dey + dez * dez;
    // Shewchuk's determinant has the opposite sign.
    const double det = (clift * dab - dlift * abc) + (alift * bcd - blift * cda);
    if (std::abs(det) > in_ball_bound_) [[likely]]
      return filter::sign(det);
    const double x = std::max(filter::max_abs(aex, bex, cex), std::abs(dex));
    const double y = std::max(filter::max_abs(aey, bey, cey), std::abs(dey));
    const double z = std::max(filter::max_abs(aez, bez, cez), std::abs(dez));
    const double largest = std::max({x, y, z});
    if (filter::in_range(std::min({x, y, z}), largest) &&
        std::abs(det) > filter::kInSphere * x * y * z * (largest * largest))
      return filter::sign(det);
    return in_circumball_exact(a, b, c, d, e);
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double orientation_bound_ = kNever;
  double in_ball_bound_ = kNever;
};

}  // namespace voropack
