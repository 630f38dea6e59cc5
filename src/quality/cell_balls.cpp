#include "quality/cell_balls.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace voropack {

namespace {

constexpr double kTolerance = 1e-9;  // Relative to the ball; far below what a quality figure can tell apart.
constexpr int kMaxSteps = 200;       // A dozen suffice; rounding could make the methods cycle.

/// Rows of numbers, column by column, so that loops over the rows take several at a time.
template <std::size_t kColumns>
class Columns {
 public:
  /// `row(k)` is an array of kColumns numbers. The first row is repeated to fill up the last group.
  template <class Row>
  Columns(std::size_t n, const Row& row) : n_((n + kGroup - 1) / kGroup * kGroup) {
    if (n_ > kInline) heap_.resize(n_ * (kColumns + 1));
    double* const first = n_ > kInline ? heap_.data() : inline_.data();
    for (std::size_t c = 0; c < kColumns; ++c) column_[c] = first + c * n_;
    result_ = first + kColumns * n_;
    for (std::size_t k = 0; k < n_; ++k) {
      const auto& values = row(k < n ? k : 0);
      for (std::size_t c = 0; c < kColumns; ++c) column_[c][k] = values[c];
    }
  }
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

  /// The largest of fn(column 0, column 1, ...) over all rows; -infinity if none is a number.
  template <class Fn>
  double largest(const Fn& fn) {
    for (std::size_t k = 0; k < n_; ++k) result_[k] = [&]<std::size_t... C>(std::index_sequence<C...>) {
        return fn(column_[C][k]...);
      }
    (std::make_index_sequence<kColumns>{});
    std::array<double, kGroup> best;
    best.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < n_; k += kGroup)
      for (std::size_t lane = 0; lane < kGroup; ++lane) best[lane] = std::max(best[lane], result_[k + lane]);
    return *std::max_element(best.begin(), best.end());
  }

  /// The first row at which the last call of `largest` found `value`; 0 if there is none.
  [[nodiscard]] std::size_t row_of(double value) const {
    const double* const place = std::find(result_, result_ + n_, value);
    return place == result_ + n_ ? 0 : static_cast<std::size_t>(place - result_);
  }

 private:
  static constexpr std::size_t kGroup = 4;
  static constexpr std::size_t kInline = 64;  // Rows; more than most cells have corners or neighbors.

  std::size_t n_;
  std::array<double*, kColumns> column_;
  double* result_;
  std::array<double, kInline*(kColumns + 1)> inline_;
  std::vector<double> heap_;
};

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
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = i; j < N; ++j) row[i][j] = spokes.twice_dot[subset.member[i]][subset.member[j]];
    row[i][N] = spokes.length_sq[subset.member[i]];
  }
  for (std::size_t k = 0; k < N; ++k) {
    if (!(row[k][k] > 1e-12 * spokes.length_sq[subset.member[k]])) return false;
    for (std::size_t i = k + 1; i < N; ++i) {
      const double factor = row[k][i] / row[k][k];
      for (std::size_t j = i; j <= N; ++j) row[i][j] -= factor * row[k][j];
    }
  }
  Vec<D> offset;
  double weight_of_p = 1;
  for (std::size_t k = N; k-- > 0;) {
    double t = row[k][N];
    for (std::size_t j = k + 1; j < N; ++j) t -= row[k][j] * row[j][N];
    t /= row[k][k];
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

/// |x - p|^2 of the point p with the given coordinates.
constexpr double length_sq(const Vec<2>& x, double p0, double p1) { return distance_sq(Vec<2>{p0, p1}, x); }
constexpr double length_sq(const Vec<3>& x, double p0, double p1, double p2) {
  return distance_sq(Vec<3>{p0, p1, p2}, x);
}

/// How far x is out of {x : normal.x <= offset}.
double excess_of(const Vec<2>& x, double n0, double n1, double offset) { return n0 * x[0] + n1 * x[1] - offset; }
double excess_of(const Vec<3>& x, double n0, double n1, double n2, double offset) {
  return n0 * x[0] + n1 * x[1] + n2 * x[2] - offset;
}

/// D + 1 active constraints normal.x + r <= offset of a linear program, as columns of the inverse of their matrix: the
/// unknowns (x, r) are sum_k offset[k] column[k].
template <int D>
struct Basis {
  using Column = std::array<double, D + 1>;
  std::array<Column, D + 1> column;
  std::array<double, D + 1> offset;

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
      for (std::size_t i = 0; i < D; ++i) column[k][i] = normal[k].coord[i] * D / (D + 1);
      column[k][D] = 1.0 / (D + 1);
      offset[k] = radius;
    }
  }

  [[nodiscard]] Ball<D> ball() const {
    Ball<D> ball;
    for (std::size_t k = 0; k <= D; ++k) {
      for (std::size_t i = 0; i < D; ++i) ball.center.coord[i] += offset[k] * column[k][i];
      ball.radius += offset[k] * column[k][D];
    }
    return ball;
  }

  /// Takes in a violated constraint for the one whose multiplier vanishes first. False if rounding hides which.
  bool exchange(const HalfSpace<D>& entering) {
    // The entering row is sum_k weights[k] times active row k; the multipliers of the objective r are column[k][D].
    std::array<double, D + 1> weights;
    for (std::size_t k = 0; k <= D; ++k) {
      weights[k] = column[k][D];
      for (std::size_t i = 0; i < D; ++i) weights[k] += column[k][i] * entering.normal.coord[i];
    }
    std::size_t leaving = D + 1;
    double ratio = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k <= D; ++k) {
      if (!(weights[k] > 1e-12) || !(column[k][D] / weights[k] < ratio)) continue;
      ratio = column[k][D] / weights[k];
      leaving = k;
    }
    if (leaving > D) return false;
    const double scale = 1 / weights[leaving];
    for (double& x : column[leaving]) x *= scale;
    for (std::size_t k = 0; k <= D; ++k) {
      if (k == leaving) continue;
      for (std::size_t i = 0; i <= D; ++i) column[k][i] -= weights[k] * column[leaving][i];
    }
    offset[leaving] = entering.offset;
    return true;
  }
};

}  // namespace

// Adds the farthest point to the support until none is outside: the radius grows with each step [Gaertner1999].
template <int D>
Ball<D> smallest_enclosing_ball(std::span<const Vec<D>> points) {
  Columns<D> columns(
      points.size(), [&](std::size_t k) -> const auto& { return points[k].coord; });
  const auto largest_length_sq = [&](const Vec<D>& from) {
    return columns.largest([&](auto... coord) { return length_sq(from, coord...); });
  };
  const auto farthest = [&](double largest) -> const Vec<D>& { return points[columns.row_of(largest)]; };
  Support<D> support;
  support.point[0] = farthest(largest_length_sq(points[0]));
  support.n = 1;
  Ball<D> ball{support.point[0], 0};
  double outside = 0;
  for (int step = 0; step <= kMaxSteps; ++step) {
    const double outside_sq = largest_length_sq(ball.center);
    outside = std::sqrt(outside_sq);
    if (outside <= ball.radius * (1 + kTolerance)) return ball;
    Ball<D> larger;
    if (!enlarge(support, farthest(outside_sq), larger) || !(larger.radius > ball.radius)) break;
    ball = larger;
  }
  return {ball.center, outside};
}

// max r subject to normal.x + r <= offset, a linear program of D + 1 unknowns, by the dual simplex method: the D + 1
// active constraints determine (x, r); the most violated constraint replaces one of them, until none is violated.
// Constraints of a large simplex around the origin start it.
template <int D>
Ball<D> largest_inscribed_ball(std::span<const HalfSpace<D>> half_spaces, double size) {
  Columns<D + 1> columns(half_spaces.size(), [&](std::size_t k) {
    std::array<double, D + 1> row;
    std::copy_n(half_spaces[k].normal.coord.begin(), D, row.begin());
    row[D] = half_spaces[k].offset;
    return row;
  });
  Basis<D> basis(1e3 * size);
  for (int step = 0;; ++step) {
    Ball<D> ball = basis.ball();
    const double excess = columns.largest([&](auto... row) { return excess_of(ball.center, row...); });
    const bool optimal = !(-excess < ball.radius - kTolerance * size);
    ball.radius = -excess;
    if (optimal || step == kMaxSteps || !basis.exchange(half_spaces[columns.row_of(excess)])) return ball;
  }
}

template Ball<2> smallest_enclosing_ball(std::span<const Vec<2>>);
template Ball<3> smallest_enclosing_ball(std::span<const Vec<3>>);
template Ball<2> largest_inscribed_ball(std::span<const HalfSpace<2>>, double);
template Ball<3> largest_inscribed_ball(std::span<const HalfSpace<3>>, double);

}  // namespace voropack
