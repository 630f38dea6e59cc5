#include "geom/wall_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// A ray that passes this near to the border of a wall, in barycentric coordinates, decides nothing.
constexpr double kBorderMargin = 1e-9;

template <int K>
Box<K> box_of(const std::array<Vec<K>, K>& simplex) {
  Box<K> box;
  for (const Vec<K>& p : simplex) box.add(p);
  return box;
}

/// A unit vector in a direction that no model prefers.
template <int K>
Vec<K> generic_direction(int attempt) {
  Random random(hash_words(0x77a11, K, attempt));
  Vec<K> d;
  do {
    for (int k = 0; k < K; ++k) d[k] = 2 * random.unit() - 1;
  } while (norm_sq(d) > 1 || norm_sq(d) < 0.1);
  return d / norm(d);
}

/// Largest t for which the ray may still be in the box, or a negative number if it misses the box.
template <int K>
bool ray_meets(const Box<K>& box, const Vec<K>& x, const Vec<K>& inverse, double t_max) {
  double t0 = 0, t1 = t_max;
  for (int k = 0; k < K; ++k) {
    double a = (box.lo[k] - x[k]) * inverse[k], b = (box.hi[k] - x[k]) * inverse[k];
    if (a > b) std::swap(a, b);
    t0 = std::max(t0, a);
    t1 = std::min(t1, b);
  }
  return t0 <= t1 * (1 + 1e-12) + std::numeric_limits<double>::min();
}

double distance_sq_to(const std::array<Vec<2>, 2>& s, const Vec<2>& x) {
  const Vec<2> d = s[1] - s[0];
  const double t = std::clamp(dot(x - s[0], d) / norm_sq(d), 0.0, 1.0);
  return distance_sq(x, s[0] + t * d);
}

/// Squared distance to a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
double distance_sq_to(const std::array<Vec<3>, 3>& s, const Vec<3>& x) {
  const auto [a, b, c] = s;
  const Vec<3> ab = b - a, ac = c - a, ap = x - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return norm_sq(ap);
  const Vec<3> bp = x - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return norm_sq(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return distance_sq(x, a + (d1 / (d1 - d3)) * ab);
  const Vec<3> cp = x - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return norm_sq(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return distance_sq(x, a + (d2 / (d2 - d6)) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return distance_sq(x, b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b));
  const Vec<3> n = cross(ab, ac);
  const double h = dot(n, ap);
  return h * h / norm_sq(n);
}

/// True if the box lies strictly on one side of the plane (line) of the wall.
template <int K>
bool plane_misses(const std::array<Vec<K>, K>& s, const Box<K>& box) {
  Vec<K> n;
  if constexpr (K == 2) {
    const Vec<2> d = s[1] - s[0];
    n = {-d[1], d[0]};
  } else {
    n = cross(s[1] - s[0], s[2] - s[0]);
  }
  double reach = 0;
  for (int k = 0; k < K; ++k) reach += std::abs(n[k]) * 0.5 * (box.hi[k] - box.lo[k]);
  return std::abs(dot(n, box.center() - s[0])) > reach * (1 + 1e-9);
}

}  // namespace

template <int K>
WallLocator<K>::WallLocator(Walls<K> walls) : walls_(std::move(walls)) {
  std::vector<Box<K>> boxes;
  boxes.reserve(walls_.simplices.size());
  for (const auto& simplex : walls_.simplices) boxes.push_back(box_of<K>(simplex));
  tree_ = BoxTree<K>(boxes);
}

template <int K>
typename WallLocator<K>::Ray WallLocator<K>::hit(std::uint32_t wall, const Vec<K>& x, const Vec<K>& direction,
                                                 double& t, int& side) const {
  const auto& s = walls_.simplices[wall];
  double denominator, u, v = 0;
  if constexpr (K == 2) {
    // x + t d = a + u e
    const Vec<2> e = s[1] - s[0], w = s[0] - x;
    denominator = cross(direction, e);
    if (std::abs(denominator) < kBorderMargin * norm(e))
      return std::abs(cross(direction, w)) < kBorderMargin * (norm(w) + norm(e)) ? Ray::kUnclear : Ray::kMiss;
    t = cross(w, e) / denominator;
    u = cross(w, direction) / denominator;
    side = denominator > 0 ? 0 : 1;  // x - a = u e - t d, so cross(e, x - a) = t cross(d, e).
  } else {
    // Moeller and Trumbore: x + t d = a + u e1 + v e2
    const Vec<3> e1 = s[1] - s[0], e2 = s[2] - s[0], p = cross(direction, e2), w = x - s[0], q = cross(w, e1);
    denominator = dot(e1, p);
    const double scale = norm(cross(e1, e2));
    if (std::abs(denominator) < kBorderMargin * scale)
      return std::abs(dot(w, cross(e1, e2))) < kBorderMargin * scale * (norm(w) + norm(e1) + norm(e2)) ? Ray::kUnclear
                                                                                                       : Ray::kMiss;
    t = dot(e2, q) / denominator;
    u = dot(w, p) / denominator;
    v = dot(direction, q) / denominator;
    side = denominator > 0 ? 0 : 1;  // denominator = -d . normal: coming against the normal meets side 0.
  }
  const double inside = std::min({u, v, 1 - u - v});
  const double worst = K == 2 ? std::min(u, 1 - u) : inside;
  if (t < 0 || worst < -kBorderMargin) return Ray::kMiss;
  if (worst < kBorderMargin) return Ray::kUnclear;
  return Ray::kHit;
}

template <int K>
typename WallLocator<K>::Ray WallLocator<K>::cast(const Vec<K>& x, const Vec<K>& direction, int& region) const {
  Vec<K> inverse;
  for (int k = 0; k < K; ++k) inverse[k] = 1 / direction[k];
  double best = std::numeric_limits<double>::infinity(), unclear = best;
  region = Walls<K>::kOutside;
  tree_.for_each([&](const Box<K>& box) { return ray_meets(box, x, inverse, best); },
                 [&](std::uint32_t wall) {
                   double t = 0;
                   int side = 0;
                   const Ray result = hit(wall, x, direction, t, side);
                   if (result == Ray::kUnclear) unclear = std::min(unclear, t);
                   if (result == Ray::kHit && t < best) {
                     best = t;
                     region = walls_.regions[wall][static_cast<std::size_t>(side)];
                   }
                 });
  // What lies behind the nearest clear hit does not matter.
  return unclear <= best * (1 + kBorderMargin) && unclear < std::numeric_limits<double>::infinity() ? Ray::kUnclear
                                                                                                    : Ray::kHit;
}

template <int K>
int WallLocator<K>::region(const Vec<K>& x) const {
  constexpr int kMaxAttempts = 64;
  int region = Walls<K>::kOutside;
  if (empty() || !tree_.nodes()[0].box.contains(x)) return region;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt)
    if (cast(x, generic_direction<K>(attempt), region) == Ray::kHit) return region;
  return Walls<K>::kOutside;
}

template <int K>
bool WallLocator<K>::touches(const Box<K>& box) const {
  bool found = false;
  tree_.for_each([&](const Box<K>& b) { return !found && b.overlaps(box); },
                 [&](std::uint32_t wall) {
                   const auto& s = walls_.simplices[wall];
                   found = found || (box_of<K>(s).overlaps(box) && !plane_misses<K>(s, box));
                 });
  return found;
}

template <int K>
bool WallLocator<K>::is_near(const Vec<K>& x, double distance) const {
  const double limit = distance * distance;
  bool found = false;
  tree_.for_each([&](const Box<K>& b) { return !found && b.distance_sq(x) < limit; },
                 [&](std::uint32_t wall) { found = found || distance_sq_to(walls_.simplices[wall], x) < limit; });
  return found;
}

template class WallLocator<2>;
template class WallLocator<3>;

}  // namespace voropack
