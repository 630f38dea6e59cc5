#include "geom/polytope_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voropack {

namespace {

/// Where the projection of x on the line ab lies, as parameter in [0, 1]; 0 for a segment of no length.
template <int D>
double clamped_parameter(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b) {
  const Vec<D> ab = b - a;
  const double length_sq = norm_sq(ab);
  if (length_sq == 0) return 0;
  return std::clamp(dot(x - a, ab) / length_sq, 0.0, 1.0);
}

template <int D>
double distance_to_boundary(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b, const Vec<D>& c) {
  return std::min({distance_to_segment(x, a, b), distance_to_segment(x, b, c), distance_to_segment(x, c, a)});
}

/// The distance between the lines ab and cd if their common perpendicular meets both segments inside, else infinity.
/// In the plane: 0 if they cross.
template <int D>
double distance_inside(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  const Vec<D> u = b - a;
  const Vec<D> v = d - c;
  const Vec<D> w = c - a;
  if constexpr (D == 2) {
    const double den = cross(u, v);
    if (den == 0) return kNowhere;
    const double s = cross(w, v) / den;
    const double t = cross(w, u) / den;
    return s > 0 && s < 1 && t > 0 && t < 1 ? 0.0 : kNowhere;
  } else {
    const Vec<3> n = cross(u, v);
    const double n_sq = norm_sq(n);
    const double s = dot(cross(w, v), n);
    if (!(s > 0 && s < n_sq)) return kNowhere;
    const double t = dot(cross(w, u), n);
    return t > 0 && t < n_sq ? std::abs(dot(w, n)) / std::sqrt(n_sq) : kNowhere;
  }
}

}  // namespace

template <int D>
double distance_to_segment(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b) {
  const double t = clamped_parameter(x, a, b);
  // From the nearer end, so that the result is accurate near both.
  return t <= 0.5 ? norm((x - a) - t * (b - a)) : norm((x - b) + (1 - t) * (b - a));
}

template <int D>
double distance_to_triangle(const Vec<D>& x, const Vec<D>& a, const Vec<D>& b, const Vec<D>& c) {
  if constexpr (D == 2) {
    const double ab = cross(b - a, x - a);
    const double bc = cross(c - b, x - b);
    const double ca = cross(a - c, x - c);
    if ((ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0)) return 0;
  } else {
    // x projects into the triangle iff it lies on the inner side of the three planes through an edge and the normal.
    const Vec<3> normal = cross(b - a, c - a);
    const Vec<3> xa = x - a;
    const Vec<3> xb = x - b;
    if (dot(cross(b - a, xa), normal) >= 0 && dot(cross(c - b, xb), normal) >= 0 &&
        dot(cross(a - c, x - c), normal) >= 0) {
      const double area_sq = norm_sq(normal);
      if (area_sq > 0) return std::abs(dot(xa, normal)) / std::sqrt(area_sq);
    }
  }
  return distance_to_boundary(x, a, b, c);
}

template <int D>
double segment_distance(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, const Vec<D>& d) {
  const double ends = std::min({distance_to_segment(a, c, d), distance_to_segment(b, c, d),
                                distance_to_segment(c, a, b), distance_to_segment(d, a, b)});
  return std::min(ends, distance_inside(a, b, c, d));
}

template <int D>
double distance_to_simplex(const Vec<D>& x, const SmallSimplex<D>& s) {
  switch (s.dimension) {
    case 0:
      return distance(x, s.corner[0]);
    case 1:
      return distance_to_segment(x, s.corner[0], s.corner[1]);
    default:
      return distance_to_triangle(x, s.corner[0], s.corner[1], s.corner[2]);
  }
}

template <int D>
double distance_between_disjoint(const SmallSimplex<D>& s, const SmallSimplex<D>& t) {
  const auto n_s = static_cast<std::size_t>(s.dimension) + 1;
  const auto n_t = static_cast<std::size_t>(t.dimension) + 1;
  double best = distance_to_simplex(s.corner[0], t);
  for (std::size_t i = 1; i < n_s; ++i) best = std::min(best, distance_to_simplex(s.corner[i], t));
  for (std::size_t j = 0; j < n_t; ++j) best = std::min(best, distance_to_simplex(t.corner[j], s));
  if (D == 2 || n_s == 1 || n_t == 1) return best;  // In the plane an end or corner is nearest.
  const std::size_t edges_s = n_s == 2 ? 1 : 3;
  const std::size_t edges_t = n_t == 2 ? 1 : 3;
  for (std::size_t i = 0; i < edges_s; ++i)
    for (std::size_t j = 0; j < edges_t; ++j)
      best =
          std::min(best, segment_distance(s.corner[i], s.corner[(i + 1) % n_s], t.corner[j], t.corner[(j + 1) % n_t]));
  return best;
}

#define VOROPACK_INSTANTIATE(D)                                                                        \
  template double distance_to_segment<D>(const Vec<D>&, const Vec<D>&, const Vec<D>&);                 \
  template double distance_to_triangle<D>(const Vec<D>&, const Vec<D>&, const Vec<D>&, const Vec<D>&); \
  template double segment_distance<D>(const Vec<D>&, const Vec<D>&, const Vec<D>&, const Vec<D>&);     \
  template double distance_to_simplex<D>(const Vec<D>&, const SmallSimplex<D>&);                       \
  template double distance_between_disjoint<D>(const SmallSimplex<D>&, const SmallSimplex<D>&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
