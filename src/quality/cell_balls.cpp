#include "quality/cell_balls.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace voropack {

namespace {

constexpr double kTolerance = 1e-9;  // Relative to the ball; far below what a quality figure can tell apart.
constexpr int kMaxSteps = 200;       // A dozen suffice; rounding could make the methods cycle.

/// The points on the sphere of the current ball.
template <int D>
struct Support {
  std::array<Vec<D>, D + 1> point;
  std::size_t n = 0;
};

/// The vectors from a point p to the points of a support, and twice their products.
template <int D>
struct Spokes {
  std::array<std::array<double, D>, D + 1> coord;          ///< Not Vec, which would be set to zero first.
  std::array<std::array<double, D + 1>, D + 1> twice_dot;  ///< [i][j] for i <= j.
  std::array<double, D + 1> length_sq;

  Spokes(const Support<D>& support, const Vec<D>& p) {
    for (std::size_t i = 0; i < support.n; ++i) coord[i] = (support.point[i] - p).coord;
    for (std::size_t i = 0; i < support.n; ++i) {
      length_sq[i] = norm_sq(v(i));
      for (std::size_t j = i; j < support.n; ++j) twice_dot[i][j] = 2 * dot(v(i), v(j));
    }
  }

  [[nodiscard]] Vec<D> v(std::size_t k) const {
    Vec<D> spoke;
    spoke.coord = coord[k];
    return spoke;
  }
};

/// Some points of a support, in ascending order.
template <int D>
struct Subset {
  std::array<std::uint8_t, D> member{};
  std::uint8_t n = 0;
  std::uint8_t mask = 0;
};

/// The smallest ball around p and the N points of `subset` if it has all of them on its sphere and needs them. False
/// otherwise. The ball's center is relative to p.
template <std::size_t N, int D>
bool sphere_through(const Spokes<D>& spokes, const Subset<D>& subset, Ball<D>& ball) {
  // center - p = sum_k t_k v_k with v_k = q_k - p and 2 v_i.(center - p) = |v_i|^2. The matrix is a Gram matrix:
  // elimination keeps it symmetric and needs no pivoting, and a small pivot means dependence.
  std::array<std::array<double, N + 1>, N> row;  // The upper triangle and the right-hand side.
  std::array<double, N> inverse_pivot;
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = i; j < N; ++j) row[i][j] = spokes.twice_dot[subset.member[i]][subset.member[j]];
    row[i][N] = spokes.length_sq[subset.member[i]];
  }
  for (std::size_t k = 0; k < N; ++k) {
    if (!(row[k][k] > 1e-12 * spokes.length_sq[subset.member[k]])) return false;
    inverse_pivot[k] = 1 / row[k][k];
    for (std::size_t i = k + 1; i < N; ++i) {
      const double factor = row[k][i] * inverse_pivot[k];
      for (std::size_t j = i; j <= N; ++j) row[i][j] -= factor * row[k][j];
    }
  }
  Vec<D> offset;
  double weight_of_p = 1;
  for (std::size_t k = N; k-- > 0;) {
    double t = row[k][N];
    for (std::size_t j = k + 1; j < N; ++j) t -= row[k][j] * row[j][N];
    t *= inverse_pivot[k];
    if (t < 0) return false;
    row[k][N] = t;
    weight_of_p -= t;
    offset += t * spokes.v(subset.member[k]);
  }
  // A center out of the convex hull of the points is that of a ball around fewer of them.
  if (weight_of_p < 0) return false;
  ball = {offset, norm(offset)};
  return true;
}

template <int D>
bool smallest_sphere(const Spokes<D>& spokes, const Subset<D>& subset, Ball<D>& ball) {
  if constexpr (D == 3)
    if (subset.n == 3) return sphere_through<3>(spokes, subset, ball);
  return subset.n == 2 ? sphere_through<2>(spokes, subset, ball) : sphere_through<1>(spokes, subset, ball);
}

/// The subsets of {0, ..., D} with 1 to D elements in descending order of their size: the support mostly grows or
/// changes by one point, so that one of the first will do.
template <int D>
constexpr auto subsets_by_size() {
  std::array<Subset<D>, (1U << (D + 1U)) - 2> subsets{};
  std::size_t n = 0;
  for (int size = D; size >= 1; --size) {
    for (unsigned mask = 1; mask < 1U << (D + 1U); ++mask) {
      if (std::popcount(mask) != size) continue;
      Subset<D>& subset = subsets[n++];
      subset.mask = static_cast<std::uint8_t>(mask);
      for (std::uint8_t k = 0; k <= D; ++k)
        if ((mask >> k & 1U) != 0) subset.member[subset.n++] = k;
    }
  }
  return subsets;
}

/// The smallest ball around `support` and p, a point outside of the smallest ball around `support`; the support becomes
/// what determines it. False if rounding hides it.
template <int D>
bool enlarge(Support<D>& support, const Vec<D>& p, Ball<D>& ball) {
  static constexpr auto kSubsets = subsets_by_size<D>();
  const Spokes<D> spokes(support, p);
  // A full support most often loses the point nearest to p; its complement comes first.
  std::size_t first = 0;
  if (support.n == D + 1)
    first = D - static_cast<std::size_t>(std::min_element(spokes.length_sq.begin(), spokes.length_sq.end()) -
                                         spokes.length_sq.begin());
  for (std::size_t at = 0; at < kSubsets.size(); ++at) {
    const Subset<D>& subset = kSubsets[at == 0 ? first : at <= first ? at - 1 : at];
    if (subset.mask >> support.n != 0 || !smallest_sphere(spokes, subset, ball)) continue;
    // The smallest ball around some of the points that encloses them all is the smallest around all.
    const double reach_sq = ball.radius * ball.radius * (1 + kTolerance);
    bool fits = true;
    for (std::size_t k = 0; k < support.n && fits; ++k)
      fits = (subset.mask >> k & 1U) != 0 || distance_sq(spokes.v(k), ball.center) <= reach_sq;
    if (!fits) continue;
    for (std::size_t k = 0; k < subset.n; ++k) support.point[k] = support.point[subset.member[k]];
    support.point[subset.n] = p;
    support.n = subset.n + std::size_t{1};
    ball.center += p;
    return true;
  }
  return false;
}

/// |x - p|^2 of points p, and the farthest point.
template <int D>
typename PointRows<D>::Place farthest(const PointRows<D>& points, const Vec<D>& x) {
  return points.largest([&](const auto&... coord) {
    int axis = 0;
    Lanes sum = 0.0;
    ((sum = sum + square(coord - Lanes(x[axis++]))), ...);
    return sum;
  });
}

/// How far x is out of {x : normal.x <= offset}, and the half-space that it is farthest out of.
template <int D>
typename HalfSpaceRows<D>::Place most_violated(const HalfSpaceRows<D>& half_spaces, const Vec<D>& x) {
  return half_spaces.largest([&](const auto&... column) {
    const std::array<Lanes, D + 1> row = {column...};
    Lanes sum = -row[D];
    for (int axis = 0; axis < D; ++axis) sum = sum + row[static_cast<std::size_t>(axis)] * Lanes(x[axis]);
    return sum;
  });
}

/// D + 1 active constraints normal.x + r <= offset of a linear program, and the inverse of their matrix: the unknowns
/// (x, r) are inverse times offset.
template <int D>
class Basis {
 public:
  /// The sides of a regular simplex with an inscribed ball of radius `radius` around the origin.
  explicit Basis(double radius) {
    std::array<Vec<D>, D + 1> normal;  // They sum to zero, and their dyads to (D + 1) / D times the identity.
    if constexpr (D == 3) {
      const double t = 1 / std::sqrt(3.0);
      normal = {Vec<3>{t, t, t}, Vec<3>{t, -t, -t}, Vec<3>{-t, t, -t}, Vec<3>{-t, -t, t}};
    } else {
      const double t = std::sqrt(0.75);
      normal = {Vec<2>{1, 0}, Vec<2>{-0.5, t}, Vec<2>{-0.5, -t}};
    }
    for (std::size_t k = 0; k <= D; ++k) {
      for (std::size_t i = 0; i < D; ++i) set(inverse_[i], k, normal[k].coord[i] * D / (D + 1));
      set(inverse_[D], k, 1.0 / (D + 1));
      set(offset_, k, radius);
    }
  }

  [[nodiscard]] Ball<D> ball() const {
    Ball<D> ball;
    for (std::size_t i = 0; i < D; ++i) ball.center.coord[i] = dot(inverse_[i], offset_);
    ball.radius = dot(inverse_[D], offset_);
    return ball;
  }

  /// Takes in a violated constraint for the one whose multiplier vanishes first. False if rounding hides which.
  bool exchange(const std::array<double, D + 1>& entering) {
    // The entering row is sum_k weights[k] times active row k; the multipliers of the objective r are inverse_[D].
    Row weights = inverse_[D], ratio;
    for (std::size_t pair = 0; pair < kPairs; ++pair) {
      for (std::size_t i = 0; i < D; ++i) weights[pair] = weights[pair] + inverse_[i][pair] * Lanes(entering[i]);
      ratio[pair] = select(weights[pair] > Lanes(kLeastWeight), inverse_[D][pair] / weights[pair], kNever);
    }
    std::size_t leaving = 0;
    for (std::size_t k = 1; k <= D; ++k) leaving = at(ratio, k) < at(ratio, leaving) ? k : leaving;
    if (!(at(ratio, leaving) < kNever)) return false;
    const double scale = 1 / at(weights, leaving);
    for (Row& row : inverse_) {
      const double value = scale * at(row, leaving);
      for (std::size_t pair = 0; pair < kPairs; ++pair) row[pair] = row[pair] - weights[pair] * Lanes(value);
      set(row, leaving, value);
    }
    set(offset_, leaving, entering[D]);
    return true;
  }

 private:
  static constexpr double kLeastWeight = 1e-12;
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kPairs = (D + Lanes::kSize) / Lanes::kSize;
  /// One number for each active constraint, and zeros.
  using Row = std::array<Lanes, kPairs>;

  static double at(const Row& row, std::size_t k) { return row[k / Lanes::kSize][k % Lanes::kSize]; }
  static void set(Row& row, std::size_t k, double x) { row[k / Lanes::kSize].set(k % Lanes::kSize, x); }
  static double dot(const Row& a, const Row& b) {
    Lanes sum = 0.0;
    for (std::size_t pair = 0; pair < kPairs; ++pair) sum = sum + a[pair] * b[pair];
    return sum[0] + sum[1];
  }

  std::array<Row, D + 1> inverse_{};
  Row offset_{};
};

}  // namespace

// Adds the farthest point to the support until none is outside: the radius grows with each step [Gaertner1999].
template <int D>
Ball<D> smallest_enclosing_ball(const PointRows<D>& points) {
  const auto point = [&](std::size_t row) {
    Vec<D> p;
    p.coord = points[row];
    return p;
  };
  // Two points that are as far from each other as is easily found.
  Support<D> support;
  support.point[0] = point(farthest<D>(points, point(0)).row);
  support.point[1] = point(farthest<D>(points, support.point[0]).row);
  support.n = support.point[0] == support.point[1] ? 1 : 2;
  Ball<D> ball{0.5 * (support.point[0] + support.point[1]), 0.5 * distance(support.point[0], support.point[1])};
  double outside = 0;
  for (int step = 0; step <= kMaxSteps; ++step) {
    const auto [outside_sq, row] = farthest<D>(points, ball.center);
    outside = std::sqrt(outside_sq);
    if (outside <= ball.radius * (1 + kTolerance)) return ball;
    Ball<D> larger;
    if (!enlarge(support, point(row), larger) || !(larger.radius > ball.radius)) break;
    ball = larger;
  }
  return {ball.center, outside};
}

// max r subject to normal.x + r <= offset, a linear program of D + 1 unknowns, by the dual simplex method: the D + 1
// active constraints determine (x, r); the most violated constraint replaces one of them, until none is violated.
// Constraints of a large simplex around the origin start it.
template <int D>
Ball<D> largest_inscribed_ball(const HalfSpaceRows<D>& half_spaces, double size) {
  Basis<D> basis(1e3 * size);
  for (int step = 0;; ++step) {
    Ball<D> ball = basis.ball();
    const auto [excess, row] = most_violated<D>(half_spaces, ball.center);
    const bool optimal = !(-excess < ball.radius - kTolerance * size);
    ball.radius = -excess;
    if (optimal || step == kMaxSteps || !basis.exchange(half_spaces[row])) return ball;
  }
}

template Ball<2> smallest_enclosing_ball<2>(const PointRows<2>&);
template Ball<3> smallest_enclosing_ball<3>(const PointRows<3>&);
template Ball<2> largest_inscribed_ball<2>(const HalfSpaceRows<2>&, double);
template Ball<3> largest_inscribed_ball<3>(const HalfSpaceRows<3>&, double);

}  // namespace voropack
