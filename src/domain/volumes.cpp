#include "domain/volumes.h"

#include <algorithm>
#include <cmath>

#include "base/disjoint_sets.h"
#include "base/random.h"
#include "geom/distance.h"
#include "geom/predicates.h"
#include "geom/tolerance.h"

namespace voropack::domain_impl {

namespace {

constexpr std::uint64_t kMaxAttempts = 64;  // Directions that are tried before the best of them is taken.
constexpr double kReach = 3;                // A ray of so many diameters leaves the domain.

/// A sum with Neumaier's compensation.
class Sum {
 public:
  void add(long double x) {
    const long double t = total_ + x;
    rest_ += std::abs(total_) >= std::abs(x) ? (total_ - t) + x : (x - t) + total_;
    total_ = t;
  }
  [[nodiscard]] long double value() const { return total_ + rest_; }

 private:
  long double total_ = 0, rest_ = 0;
};

/// Compares directions of fins around one ridge, by exact predicates.
template <int D>
class AroundRidge {
 public:
  AroundRidge(const std::vector<Vec<D>>& points, const std::array<std::uint32_t, 2>& ridge)
      : points_(points), ridge_(ridge) {}

  /// Sign of the sine of the angle from f to g.
  [[nodiscard]] int turn(const Fin& f, const Fin& g) const {
    if constexpr (D == 2)
      return orientation(points_[ridge_[0]], points_[f.apex], points_[g.apex]);
    else
      return orientation(points_[ridge_[0]], points_[ridge_[1]], points_[f.apex], points_[g.apex]) *
             (f.opposite == g.opposite ? 1 : -1);
  }
  [[nodiscard]] Vec<D> toward(const Fin& f) const {
    Vec<D> d = points_[f.apex] - points_[ridge_[0]];
    if constexpr (D == 3) {
      const Vec<3> e = points_[ridge_[1]] - points_[ridge_[0]];
      d = (f.opposite ? -1.0 : 1.0) * (d - (dot(d, e) / norm_sq(e)) * e);
    }
    return d;
  }
  /// 0 for the direction of `start` and up to half a turn from it, 1 for the rest.
  [[nodiscard]] int half(const Fin& start, const Fin& f) const {
    const int t = turn(start, f);
    if (t != 0) return t > 0 ? 0 : 1;
    return dot(toward(start), toward(f)) >= 0 ? 0 : 1;
  }

 private:
  const std::vector<Vec<D>>& points_;
  const std::array<std::uint32_t, 2>& ridge_;
};

}  // namespace

template <int D>
void sort_fins(const std::vector<Vec<D>>& points, const std::vector<std::array<std::uint32_t, 2>>& ridges,
               std::vector<Fin>& fins) {
  std::stable_sort(fins.begin(), fins.end(), [](const Fin& f, const Fin& g) { return f.ridge < g.ridge; });
  for (auto begin = fins.begin(); begin != fins.end();) {
    auto end = begin;
    while (end != fins.end() && end->ridge == begin->ridge) ++end;
    const AroundRidge<D> around(points, ridges[begin->ridge]);
    const Fin start = *begin;
    std::stable_sort(begin, end, [&](const Fin& f, const Fin& g) {
      const int hf = around.half(start, f), hg = around.half(start, g);
      return hf != hg ? hf < hg : around.turn(f, g) > 0;
    });
    begin = end;
  }
}

template void sort_fins(const std::vector<Vec<2>>&, const std::vector<std::array<std::uint32_t, 2>>&,
                        std::vector<Fin>&);
template void sort_fins(const std::vector<Vec<3>>&, const std::vector<std::array<std::uint32_t, 2>>&,
                        std::vector<Fin>&);

template <int D>
Volumes<D>::Volumes(const Walls<D>& walls, const std::vector<Fin>& fins) : walls_(walls) {
  std::vector<Box<D>> boxes(walls.simplices.size());
  for (std::size_t s = 0; s < boxes.size(); ++s) {
    for (const std::uint32_t p : walls.simplices[s]) boxes[s].add(walls.points[p]);
    box_.add(boxes[s]);
  }
  tree_ = AabbTree<D>(std::move(boxes));
  const std::vector<std::uint32_t> side_shell = join_at_ridges(fins);
  std::size_t n_shells = 0;
  for (const std::uint32_t s : side_shell) n_shells = std::max<std::size_t>(n_shells, s + 1);
  join_nested(side_shell, n_shells);
}

template <int D>
std::vector<std::uint32_t> Volumes<D>::join_at_ridges(const std::vector<Fin>& fins) const {
  DisjointSets sides(2 * walls_.n_walls);
  for (std::size_t begin = 0; begin < fins.size();) {
    std::size_t end = begin;
    while (end < fins.size() && fins[end].ridge == fins[begin].ridge) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      const Fin &fin = fins[i], &next = fins[i + 1 < end ? i + 1 : begin];
      sides.join(2 * fin.wall + fin.ccw_side, 2 * next.wall + (1U - next.ccw_side));
    }
    begin = end;
  }
  std::vector<std::uint32_t> number(2 * walls_.n_walls, kOutside), side_shell(2 * walls_.n_walls);
  std::uint32_t n_shells = 0;
  for (std::uint32_t i = 0; i < side_shell.size(); ++i) {
    const std::uint32_t root = sides.find(i);
    if (number[root] == kOutside) number[root] = n_shells++;
    side_shell[i] = number[root];
  }
  return side_shell;
}

namespace {

/// Twice (2D) or six times (3D) the signed measure between a simplex and the origin, positive for side 0: there the
/// normal points into the volume.
long double cone_measure(const std::array<Vec<2>, 2>& x) {
  return static_cast<long double>(x[0][0]) * x[1][1] - static_cast<long double>(x[0][1]) * x[1][0];
}
long double cone_measure(const std::array<Vec<3>, 3>& x) {
  long double det = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    det += x[0][k] * (static_cast<long double>(x[1][i]) * x[2][j] - static_cast<long double>(x[1][j]) * x[2][i]);
  }
  return -det;
}
double size_of(const std::array<Vec<2>, 2>& x) { return norm(x[1] - x[0]); }
double size_of(const std::array<Vec<3>, 3>& x) { return norm(cross(x[1] - x[0], x[2] - x[0])); }

}  // namespace

template <int D>
auto Volumes<D>::measure_shells(const std::vector<std::uint32_t>& side_shell, std::size_t n_shells) const
    -> std::vector<Shell> {
  std::vector<Sum> sums(n_shells);
  std::vector<Shell> shells(n_shells);
  const Vec<D> center = box_.center();
  for (std::uint32_t s = 0; s < walls_.simplices.size(); ++s) {
    std::array<Vec<D>, D> x;
    for (std::size_t i = 0; i < D; ++i) x[i] = walls_.points[walls_.simplices[s][i]] - center;
    const long double measure = cone_measure(x) / (D == 2 ? 2 : 6);
    const double size = size_of(x);
    const std::size_t wall = walls_.simplex_wall[s];
    for (std::size_t side = 0; side < 2; ++side) {
      const std::uint32_t shell = side_shell[2 * wall + side];
      if (shells[shell].largest == kOutside || size > shells[shell].largest_size) {
        shells[shell].largest_size = size;
        shells[shell].largest = s;
      }
      if (side_shell[2 * wall] == side_shell[2 * wall + 1]) continue;  // Cancels.
      sums[shell].add(side == 0 ? measure : -measure);
    }
  }
  for (std::size_t i = 0; i < n_shells; ++i) shells[i].measure = sums[i].value();
  return shells;
}

template <int D>
auto Volumes<D>::line_through(std::uint32_t simplex, std::uint64_t salt) const -> std::vector<Crossing> {
  std::vector<Crossing> best;
  double best_gap = -1;
  for (std::uint64_t attempt = 0; attempt < kMaxAttempts && best_gap < kRayGap; ++attempt) {
    Random random(hash_words(salt, attempt));
    Vec<D> start;
    double total = 0;
    for (const std::uint32_t p : walls_.simplices[simplex]) {
      const double weight = 0.2 + random.unit();
      start += weight * walls_.points[p];
      total += weight;
    }
    start = start / total;
    const Vec<D> reach = kReach * box_.diagonal() * direction(salt, attempt);
    auto hits = crossings(start - reach, start + reach);
    if (!hits || hits->empty()) continue;
    double gap = 1;
    for (std::size_t i = 0; i + 1 < hits->size(); ++i) gap = std::min(gap, (*hits)[i + 1].at - (*hits)[i].at);
    if (gap <= best_gap) continue;
    best_gap = gap;
    best = std::move(*hits);
  }
  return best;
}

// The boundary of a volume is one shell around it, whose measure is positive, and one shell around each thing in it. A
// line through such a thing goes on in the volume until it leaves it for good through the outer shell; whatever it
// meets between belongs to other things in the same volume. So it is enough to join, along one line through each shell
// that is not an outer one, the sides that face each other.
template <int D>
void Volumes<D>::join_nested(const std::vector<std::uint32_t>& side_shell, std::size_t n_shells) {
  const std::vector<Shell> shells = measure_shells(side_shell, n_shells);
  DisjointSets joined(n_shells + 1);
  const auto outside = static_cast<std::uint32_t>(n_shells);
  const auto shell_at = [&](const Crossing& crossing, bool far) {
    return side_shell[2 * crossing.wall + static_cast<std::size_t>(far ? crossing.far_side : 1 - crossing.far_side)];
  };
  for (std::uint32_t shell = 0; shell < n_shells; ++shell) {
    if (shells[shell].measure > 0) continue;
    std::uint32_t before = outside;
    for (const Crossing& crossing : line_through(shells[shell].largest, shell + 1)) {
      joined.join(before, shell_at(crossing, false));
      before = shell_at(crossing, true);
    }
    joined.join(before, outside);
  }

  std::vector<std::uint32_t> volume_of_root(n_shells + 1, kOutside);
  std::vector<Sum> sums;
  side_volume_.assign(side_shell.size(), kOutside);
  std::vector<char> added(n_shells, 0);
  for (std::size_t i = 0; i < side_shell.size(); ++i) {
    const std::uint32_t shell = side_shell[i], root = joined.find(shell);
    if (root == joined.find(outside)) continue;
    if (volume_of_root[root] == kOutside) {
      volume_of_root[root] = static_cast<std::uint32_t>(sums.size());
      sums.emplace_back();
    }
    side_volume_[i] = volume_of_root[root];
    if (added[shell] == 0) sums[volume_of_root[root]].add(shells[shell].measure);
    added[shell] = 1;
  }
  for (const Sum& sum : sums) measure_.push_back(sum.value());
}

template <int D>
Vec<D> Volumes<D>::direction(std::uint64_t salt, std::uint64_t attempt) const {
  Random random(hash_words(salt, attempt, 0x726179));
  Vec<D> d;
  for (double length = 0; !(length > 0.1 && length < 1);) {
    for (int k = 0; k < D; ++k) d[k] = 2 * random.unit() - 1;
    length = norm(d);
  }
  return d / norm(d);
}

template <int D>
auto Volumes<D>::crossings(const Vec<D>& p, const Vec<D>& q) const -> std::optional<std::vector<Crossing>> {
  std::vector<Crossing> found;
  bool degenerate = false;
  // The ray against slabs, widened so that rounding loses nothing.
  const double margin = absolute_tolerance(box_, kRayGap);
  const auto meets = [&](const Box<D>& box) {
    double lo = 0, hi = 1;
    for (int k = 0; k < D; ++k) {
      const double d = q[k] - p[k];
      if (d == 0) {
        if (p[k] < box.lo[k] - margin || p[k] > box.hi[k] + margin) return false;
        continue;
      }
      const double t0 = (box.lo[k] - margin - p[k]) / d, t1 = (box.hi[k] + margin - p[k]) / d;
      lo = std::max(lo, std::min(t0, t1));
      hi = std::min(hi, std::max(t0, t1));
    }
    return lo <= hi;
  };
  tree_.visit(meets, [&](std::uint32_t s) {
    std::array<Vec<D>, D> x;
    for (std::size_t i = 0; i < D; ++i) x[i] = walls_.points[walls_.simplices[s][i]];
    int at_p = 0, at_q = 0;
    double hp = 0, hq = 0;
    if constexpr (D == 2) {
      const int a = orientation(p, q, x[0]), b = orientation(p, q, x[1]);
      if (a * b > 0) return;
      at_p = orientation(x[0], x[1], p);
      at_q = orientation(x[0], x[1], q);
      if (at_p * at_q > 0) return;
      if (a == 0 || b == 0 || at_p == 0 || at_q == 0) degenerate = true;
      hp = cross(x[1] - x[0], p - x[0]);
      hq = cross(x[1] - x[0], q - x[0]);
    } else {
      const int a = orientation(p, q, x[0], x[1]), b = orientation(p, q, x[1], x[2]), c = orientation(p, q, x[2], x[0]);
      if (std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0) return;
      at_p = orientation(x[0], x[1], x[2], p);
      at_q = orientation(x[0], x[1], x[2], q);
      if (at_p * at_q > 0) return;
      if (a == 0 || b == 0 || c == 0 || at_p == 0 || at_q == 0) degenerate = true;
      const Vec<3> n = cross(x[1] - x[0], x[2] - x[0]);
      hp = dot(n, p - x[0]);
      hq = dot(n, q - x[0]);
    }
    const double at = hp != hq ? std::clamp(hp / (hp - hq), 0.0, 1.0) : 0.5;
    found.push_back({at, walls_.simplex_wall[s], at_q > 0 ? 0 : 1});
  });
  if (degenerate) return std::nullopt;
  std::sort(found.begin(), found.end(),
            [](const Crossing& f, const Crossing& g) { return f.at != g.at ? f.at < g.at : f.wall < g.wall; });
  return found;
}

template <int D>
std::optional<std::uint32_t> Volumes<D>::locate(const Vec<D>& x) const {
  if (!box_.contains(x)) return kOutside;
  for (std::uint64_t attempt = 0; attempt < kMaxAttempts; ++attempt) {
    const Vec<D> end = x + kReach * box_.diagonal() * direction(0, attempt);
    const auto hits = crossings(x, end);
    if (!hits) continue;
    if (hits->empty()) return kOutside;
    const bool clear = hits->size() < 2 || (*hits)[1].at - (*hits)[0].at > kRayGap;
    if (!clear && attempt + 1 < kMaxAttempts) continue;
    const Crossing& first = hits->front();
    return at(first.wall, 1 - first.far_side);
  }
  return std::nullopt;
}

template class Volumes<2>;
template class Volumes<3>;

}  // namespace voropack::domain_impl
