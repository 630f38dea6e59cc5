#include "coarsening/edge_balls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geom/circumcenter.h"
#include "geom/distance.h"
#include "geom/tolerance.h"

namespace voropack {

namespace {

/// Balls are lifted by this much more than they have to be, and by no more than this part of their radius.
constexpr double kLift = 1.1;
constexpr double kMaxLift = 0.5;

/// In the plane that bisects ab, with its middle m as origin: the circumcenter of abp lies at -x along the direction to
/// p, that of abq at y along the direction to q, and `turn` is the angle between the planes. The dual face of ab is
/// bounded by the normals in these two points and by a convex chain of circumcenters; its signed area is at least
/// that of the polygon m, -x, P, Q, y, where P and Q lie `lift` above -x and y. The normals meet where abpq has its
/// circumcenter. If the lift is to be more, the ball there is to be empty, so that abpq is a simplex, and alone at ab.
/// Nothing if the area is negative then.
std::optional<std::array<double, 2>> lifts(double x, double y, double turn) {
  const double c = std::cos(turn), s = std::sin(turn), gain = (y - x) * (1 + c);
  const std::array<double, 2> meet = {(y - x * c) / s, (y * c - x) / s};
  const double root = gain * gain - 4 * s * s * x * y;
  if (gain > 0 && root >= 0) {
    const double lift = kLift * 2 * x * y * s / (gain + std::sqrt(root));
    const std::array<double, 2> both = {std::max(lift, kLift * x * std::tan(turn)), lift};
    if (both[0] < meet[0] && both[1] < meet[1]) return both;
  }
  if (!(c * (x * x + y * y) > 2 * x * y) || !(meet[1] >= 0)) return std::nullopt;
  return meet;
}

}  // namespace

std::optional<EdgeBalls> edge_balls(const Vec<3>& a, const Vec<3>& b, const Vec<3>& p, const Vec<3>& q,
                                    const std::array<bool, 2>& has_region) {
  const Vec<3> normal = cross(b - a, p - a);
  const double height = dot(normal, q - a) / norm(normal);
  if (std::abs(height) <= kCoplanarAngle * distance(q, a)) return EdgeBalls{};
  const Vec<3> middle = 0.5 * (a + b);
  EdgeBalls found;
  found.balls[found.n++] = {middle, 0.5 * distance(a, b)};
  const bool is_obtuse_at_p = dot(a - p, b - p) < 0;
  if ((!is_obtuse_at_p && dot(a - q, b - q) >= 0) || !has_region[height > 0 ? 0 : 1]) return found;
  // Towards the region.
  const Vec<3> over_p = (height > 0 ? 1 : -1) / norm(normal) * normal;
  Vec<3> over_q = cross(b - a, q - a);
  over_q = (dot(over_q, p - a) > 0 ? 1 : -1) / norm(over_q) * over_q;
  const double turn = angle_between(over_p, over_q);
  if (!(turn < 0.5 * std::numbers::pi)) return std::nullopt;
  const Vec<3> of_p = triangle_circumcenter(a, b, p), of_q = triangle_circumcenter(a, b, q);
  const double x = distance(of_p, middle), y = distance(of_q, middle);
  const auto lift = is_obtuse_at_p ? lifts(x, y, turn) : lifts(y, x, turn);
  if (!lift) return std::nullopt;
  const double lift_p = (*lift)[is_obtuse_at_p ? 0 : 1], lift_q = (*lift)[is_obtuse_at_p ? 1 : 0];
  const double radius_p = distance(of_p, a), radius_q = distance(of_q, a);
  if (lift_p > kMaxLift * radius_p || lift_q > kMaxLift * radius_q) return std::nullopt;
  found.balls[found.n++] = {of_p + lift_p * over_p, std::hypot(radius_p, lift_p)};
  found.balls[found.n++] = {of_q + lift_q * over_q, std::hypot(radius_q, lift_q)};
  return found;
}

std::array<bool, 2> regions_beside(const SurfaceTriangle& t, std::uint32_t a, std::uint32_t b) {
  const auto at = static_cast<std::size_t>(std::ranges::find(t.corners, a) - t.corners.begin());
  const std::size_t along = t.corners[(at + 1) % 3] == b ? 0 : 1;
  return {t.regions[along] != kNoRegion, t.regions[1 - along] != kNoRegion};
}

}  // namespace voropack
