// Sets of points that are easy, degenerate or uneven, for tests of triangulations.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/random.h"
#include "voropack/vec.h"

namespace voropack::test {

/// In the box between (lo, lo, ...) and (hi, hi, ...).
template <int K>
Vec<K> random_point(Random& random, double lo = 0, double hi = 1) {
  Vec<K> p;
  for (int k = 0; k < K; ++k) p[k] = lo + (hi - lo) * random.unit();
  return p;
}

template <int K>
std::vector<Vec<K>> random_points(std::size_t n, std::uint64_t seed = 1) {
  Random random(seed);
  std::vector<Vec<K>> points(n);
  for (Vec<K>& p : points) p = random_point<K>(random);
  return points;
}

/// Clusters whose sizes differ by many orders.
template <int K>
std::vector<Vec<K>> clustered_points(std::size_t n) {
  Random random(2);
  std::vector<Vec<K>> points(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double size = std::pow(10.0, -static_cast<double>(i % 9));
    Random center(i % 9 + 100);
    points[i] = random_point<K>(center) + size * random_point<K>(random);
  }
  return points;
}

template <int K>
std::vector<Vec<K>> sphere_points(std::size_t n) {
  Random random(3);
  std::vector<Vec<K>> points;
  while (points.size() < n) {
    Vec<K> p = 2.0 * random_point<K>(random);
    for (int k = 0; k < K; ++k) p[k] -= 1;
    if (norm(p) > 0.1) points.push_back(p / norm(p));
  }
  return points;
}

/// Points i * step with n per axis, the first axis fastest.
template <int K>
std::vector<Vec<K>> grid_points(int n, double step, double offset = 0) {
  std::vector<Vec<K>> points;
  for (int k = 0; k < (K == 3 ? n : 1); ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        Vec<K> p;
        p[0] = offset + step * i;
        p[1] = offset + step * j;
        if constexpr (K == 3) p[2] = offset + step * k;
        points.push_back(p);
      }
  return points;
}

/// Grid points and cell centers: body-centered cubic in 3D.
template <int K>
std::vector<Vec<K>> centered_points(int n, double step) {
  std::vector<Vec<K>> points = grid_points<K>(n, step);
  const std::vector<Vec<K>> centers = grid_points<K>(n - 1, step, 0.5 * step);
  points.insert(points.end(), centers.begin(), centers.end());
  return points;
}

/// A square's or cube's boundary with a grid on it, and random points inside.
template <int K>
std::vector<Vec<K>> box_points(int n, std::size_t n_inside) {
  std::vector<Vec<K>> points;
  for (const Vec<K>& p : grid_points<K>(n + 1, 1.0 / n)) {
    bool on_boundary = false;
    for (int k = 0; k < K; ++k) on_boundary = on_boundary || p[k] == 0 || p[k] == 1.0 / n * n;
    if (on_boundary) points.push_back(p);
  }
  for (const Vec<K>& p : random_points<K>(n_inside, 4)) points.push_back(p);
  return points;
}

/// All integer points of norm sqrt(50) (2D) or 9 (3D), exactly cospherical, and the center.
template <int K>
std::vector<Vec<K>> cospherical_points() {
  std::vector<Vec<K>> points = {Vec<K>{}};
  for (const Vec<K>& p : grid_points<K>(21, 1.0, -10.0))
    if (norm_sq(p) == (K == 2 ? 50 : 81)) points.push_back(p);
  return points;
}

template <int K>
std::vector<Vec<K>> moved(std::vector<Vec<K>> points, double scale, double offset) {
  for (Vec<K>& p : points) {
    p *= scale;
    for (int k = 0; k < K; ++k) p[k] += offset;
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

template <int K>
void shuffle(std::vector<Vec<K>>& points, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random.bits() % i]);
}

/// Points in a few planes across the first axis.
template <int K>
std::vector<Vec<K>> plane_points(std::size_t n, int n_planes) {
  std::vector<Vec<K>> points = random_points<K>(n, 6);
  for (Vec<K>& p : points) p[0] = std::floor(n_planes * p[0]);
  return points;
}

}  // namespace voropack::test
