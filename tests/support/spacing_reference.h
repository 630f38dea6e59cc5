// lfs and f by their definitions, over all pairs, with distances written another way than in the library.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "voropack/domain.h"

namespace voropack::reference {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <int D>
double point_segment(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b) {
  const double t = dot(x - a, b - a) / dot(b - a, b - a);
  return t <= 0 ? distance(x, a) : t >= 1 ? distance(x, b) : distance(x, a + t * (b - a));
}

/// Barycentric coordinates of the projection from the normal equations.
inline double point_triangle(const Vec<3>& x, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const Vec<3> u = b - a;
  const Vec<3> v = c - a;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), xu = dot(x - a, u), xv = dot(x - a, v);
  const double det = uu * vv - uv * uv;
  const double s = (vv * xu - uv * xv) / det;
  const double t = (uu * xv - uv * xu) / det;
  if (s >= 0 && t >= 0 && s + t <= 1) return distance(x, a + s * u + t * v);
  return std::min({point_segment(x, a, b), point_segment(x, b, c), point_segment(x, c, a)});
}

/// Minimizes the quadratic in both parameters over the unit square: inside, or on one of its four sides.
template <int D>
double segment_segment(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d) {
  const Vec<D> u = b - a, v = d - c, w = a - c;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  double best =
      std::min({point_segment(a, c, d), point_segment(b, c, d), point_segment(c, a, b), point_segment(d, a, b)});
  const double det = uu * vv - uv * uv;
  if (det > 1e-14 * uu * vv) {
    const double s = (uv * vw - vv * uw) / det;
    const double t = (uu * vw - uv * uw) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = std::min(best, distance(a + s * u, c + t * v));
  }
  return best;
}

/// A polytope as a list of corner lists (one, or a facet's triangles) and the points of its closure.
template <int D>
struct Polytope {
  std::vector<std::vector<Vec<D>>> pieces;
  std::vector<PointId> closure;
};

template <int D>
std::vector<Polytope<D>> polytopes(const Domain<D>& domain) {
  std::vector<Polytope<D>> result;
  const auto& x = domain.points;
  for (PointId p : ids(x)) result.push_back({{{x[p]}}, {p}});
  for (SegmentId s : ids(domain.segments)) {
    const auto [a, b] = domain.segments[s];
    result.push_back({{{x[a], x[b]}}, {std::min(a, b), std::max(a, b)}});
  }
  for (FacetId f : ids(domain.facet_frame)) {
    Polytope<D> polytope;
    for (const auto& t : domain.facet_triangles[f]) polytope.pieces.push_back({x[t[0]], x[t[1]], x[t[2]]});
    polytope.closure.assign(domain.facet_points[f].begin(), domain.facet_points[f].end());
    result.push_back(polytope);
  }
  return result;
}

template <int D>
double distance_to(const Vec<D>& x, const std::vector<Vec<D>>& piece) {
  if (piece.size() == 1) return distance(x, piece[0]);
  if (piece.size() == 2) return point_segment(x, piece[0], piece[1]);
  if constexpr (D == 3) return point_triangle(x, piece[0], piece[1], piece[2]);
  return kInfinity;
}

template <int D>
double distance_to(const Vec<D>& x, const Polytope<D>& p) {
  double best = kInfinity;
  for (const auto& piece : p.pieces) best = std::min(best, distance_to(x, piece));
  return best;
}

template <int D>
double distance_between(const Polytope<D>& p, const Polytope<D>& q) {
  double best = kInfinity;
  for (const auto& s : p.pieces) {
    for (const auto& t : q.pieces) {
      for (const auto& x : s) best = std::min(best, distance_to(x, t));
      for (const auto& x : t) best = std::min(best, distance_to(x, s));
      for (std::size_t i = 0; i + 1 < s.size(); ++i)
        for (std::size_t k = i + 1; k < s.size(); ++k)
          for (std::size_t j = 0; j + 1 < t.size(); ++j)
            for (std::size_t l = j + 1; l < t.size(); ++l)
              best = std::min(best, segment_segment(s[i], s[k], t[j], t[l]));
    }
  }
  return best;
}

/// Every disjoint pair with its distance.
template <int D>
class AllPairs {
 public:
  explicit AllPairs(const Domain<D>& domain) : polytopes_(polytopes(domain)) {
    for (std::size_t i = 0; i < polytopes_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        std::vector<PointId> shared;
        std::set_intersection(polytopes_[i].closure.begin(), polytopes_[i].closure.end(), polytopes_[j].closure.begin(),
                              polytopes_[j].closure.end(), std::back_inserter(shared));
        if (shared.empty()) pairs_.push_back({i, j, distance_between(polytopes_[i], polytopes_[j])});
      }
    }
  }

  double lfs(const Vec<D>& x) const { return smallest(x, 1, 0); }
  /// The geometric part of f for feature factor a and gradation b.
  double f(const Vec<D>& x, double a, double b) const { return b >= a ? a * lfs(x) : smallest(x, b, 0.5 * (a - b)); }

 private:
  struct Pair {
    std::size_t p, q;
    double gap;
  };
  double smallest(const Vec<D>& x, double slope, double gap) const {
    std::vector<double> d;
    for (const auto& p : polytopes_) d.push_back(distance_to(x, p));
    double best = kInfinity;
    for (const Pair& pair : pairs_) best = std::min(best, slope * std::max(d[pair.p], d[pair.q]) + gap * pair.gap);
    return best;
  }

  std::vector<Polytope<D>> polytopes_;
  std::vector<Pair> pairs_;
};

}  // namespace voropack::reference
