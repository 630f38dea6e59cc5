#include "quality/cell_balls.h"

#include <Eigen/Dense>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace voropack {

namespace {

constexpr double kTolerance = 1e-9;  // Relative to the ball; far below what a quality figure can tell apart.
constexpr int kMaxSteps = 200;       // A dozen suffice; rounding could make the methods cycle.

/// The points on the sphere of the current ball.
template <int D>
struct Support {
  std::array<Vec<D>, D + 1> point;
  int n = 0;
};

/// The smallest ball around p and `subset` if it has all of them on its sphere and needs them. False otherwise.
template <int D>
bool sphere_through(const Vec<D>& p, const Support<D>& subset, Ball<D>& ball) {
  // center - p = sum_k t_k v_k with v_k = q_k - p and 2 v_i.(center - p) = |v_i|^2.
  std::array<Vec<D>, D> v;
  std::array<std::array<double, D + 1>, D> row{};
  const auto n = static_cast<std::size_t>(subset.n);
  for (std::size_t i = 0; i < n; ++i) v[i] = subset.point[i] - p;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) row[i][j] = 2 * dot(v[i], v[j]);
    row[i][n] = norm_sq(v[i]);
  }
  // The matrix is a Gram matrix: elimination needs no pivoting, and a small pivot means dependence.
  for (std::size_t k = 0; k < n; ++k) {
    if (!(row[k][k] > 1e-12 * norm_sq(v[k]))) return false;
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = row[i][k] / row[k][k];
      for (std::size_t j = k; j <= n; ++j) row[i][j] -= factor * row[k][j];
    }
  }
  Vec<D> offset;
  double weight_of_p = 1;
  for (std::size_t k = n; k-- > 0;) {
    double t = row[k][n];
    for (std::size_t j = k + 1; j < n; ++j) t -= row[k][j] * row[j][n];
    t /= row[k][k];
    if (t < 0) return false;
    row[k][n] = t;
    weight_of_p -= t;
    offset += t * v[k];
  }
  // A center out of the convex hull of the points is that of a ball around fewer of them.
  if (weight_of_p < 0) return false;
  ball = {p + offset, norm(offset)};
  return true;
}

/// The subsets of {0, ..., D} with 1 to D elements in descending order of their size: the support mostly grows or
/// changes by one point, so that one of the first will do.
template <int D>
constexpr auto subsets_by_size() {
  std::array<unsigned, (1U << (D + 1U)) - 2> masks{};
  std::size_t n = 0;
  for (int size = D; size >= 1; --size)
    for (unsigned mask = 1; mask < 1U << (D + 1U); ++mask)
      if (std::popcount(mask) == size) masks[n++] = mask;
  return masks;
}

/// The smallest ball around `support` and p, a point outside of the smallest ball around `support`; the support becomes
/// what determines it. False if rounding hides it.
template <int D>
bool enlarge(Support<D>& support, const Vec<D>& p, Ball<D>& ball) {
  static constexpr auto kSubsets = subsets_by_size<D>();
  for (const unsigned mask : kSubsets) {
    Support<D> subset;
    bool fits = mask < 1U << static_cast<unsigned>(support.n);
    for (std::size_t k = 0; k <= D && fits; ++k)
      if ((mask >> k & 1U) != 0) subset.point[static_cast<std::size_t>(subset.n++)] = support.point[k];
    if (!fits || !sphere_through(p, subset, ball)) continue;
    // The smallest ball around some of the points that encloses them all is the smallest around all.
    const double reach_sq = ball.radius * ball.radius * (1 + kTolerance);
    for (std::size_t k = 0; k < static_cast<std::size_t>(support.n) && fits; ++k)
      fits = (mask >> k & 1U) != 0 || distance_sq(support.point[k], ball.center) <= reach_sq;
    if (!fits) continue;
    subset.point[static_cast<std::size_t>(subset.n++)] = p;
    support = subset;
    return true;
  }
  return false;
}

}  // namespace

// Adds the farthest point to the support until none is outside: the radius grows with each step [Gaertner1999].
template <int D>
Ball<D> smallest_enclosing_ball(std::span<const Vec<D>> points) {
  double farthest_sq = 0;
  const auto farthest = [&](const Vec<D>& from) -> const Vec<D>& {
    std::size_t best = 0;
    farthest_sq = -1;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double length_sq = distance_sq(points[k], from);
      if (length_sq > farthest_sq) {
        farthest_sq = length_sq;
        best = k;
      }
    }
    return points[best];
  };
  Support<D> support;
  support.point[0] = farthest(points[0]);
  support.n = 1;
  Ball<D> ball{support.point[0], 0};
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vec<D>& p = farthest(ball.center);
    const double outside = std::sqrt(farthest_sq);
    Ball<D> larger;
    if (outside <= ball.radius * (1 + kTolerance)) return ball;
    if (!enlarge(support, p, larger) || !(larger.radius > ball.radius)) return {ball.center, outside};
    ball = larger;
  }
  farthest(ball.center);
  return {ball.center, std::sqrt(farthest_sq)};
}

// max r subject to normal.x + r <= offset, a linear program of D + 1 unknowns, by the dual simplex method: the D + 1
// active constraints determine (x, r); the most violated constraint replaces one of them, until none is violated.
// Constraints of a large simplex around the origin start it.
template <int D>
Ball<D> largest_inscribed_ball(std::span<const HalfSpace<D>> half_spaces, double size) {
  using Matrix = Eigen::Matrix<double, D + 1, D + 1>;
  using Column = Eigen::Matrix<double, D + 1, 1>;
  const auto row_of = [](const HalfSpace<D>& h) {
    Column c;
    for (int k = 0; k < D; ++k) c[k] = h.normal[k];
    c[D] = 1;
    return c;
  };
  // A regular simplex: its normals sum to zero.
  Matrix active;
  Column offset = Column::Constant(1e3 * size);
  if constexpr (D == 3) {
    const double t = 1 / std::sqrt(3.0);
    active << t, t, t, 1, t, -t, -t, 1, -t, t, -t, 1, -t, -t, t, 1;
  } else {
    const double t = std::sqrt(0.75);
    active << 1, 0, 1, -0.5, t, 1, -0.5, -t, 1;
  }
  Matrix inverse = active.inverse();
  Column x = inverse * offset;
  Ball<D> ball;
  for (int step = 0;; ++step) {
    double least = std::numeric_limits<double>::infinity();
    const HalfSpace<D>* entering = nullptr;
    for (int k = 0; k < D; ++k) ball.center[k] = x[k];
    for (const HalfSpace<D>& h : half_spaces) {
      const double slack = h.offset - dot(h.normal, ball.center);
      if (slack < least) {
        least = slack;
        entering = &h;
      }
    }
    ball.radius = least;
    if (entering == nullptr || least >= x[D] - kTolerance * size || step == kMaxSteps) return ball;
    // row = weights^T active; the multipliers of the objective (0, ..., 0, 1) are the last row of the inverse.
    const Column row = row_of(*entering);
    const Column weights = inverse.transpose() * row;
    int leaving = -1;
    double ratio = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= D; ++k) {
      if (weights[k] > 1e-12 && inverse(D, k) / weights[k] < ratio) {
        ratio = inverse(D, k) / weights[k];
        leaving = k;
      }
    }
    if (leaving < 0) return ball;
    active.row(leaving) = row.transpose();
    offset[leaving] = entering->offset;
    inverse = active.inverse();
    x = inverse * offset;
  }
}

template Ball<2> smallest_enclosing_ball(std::span<const Vec<2>>);
template Ball<3> smallest_enclosing_ball(std::span<const Vec<3>>);
template Ball<2> largest_inscribed_ball(std::span<const HalfSpace<2>>, double);
template Ball<3> largest_inscribed_ball(std::span<const HalfSpace<3>>, double);

}  // namespace voropack
