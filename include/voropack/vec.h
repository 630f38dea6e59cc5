// Points and vectors of R^D, and axis-aligned boxes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace voropack {

/// A point or vector of R^D in domain units. A plain aggregate: `Vec<2> p = {x, y};`
template <int D>
struct Vec {
  std::array<double, D> coord{};

  constexpr Vec() = default;
  template <class... T>
  requires(sizeof...(T) == D) constexpr Vec(T... c) : coord{static_cast<double>(c)...} {}

  constexpr double& operator[](int axis) { return coord[static_cast<std::size_t>(axis)]; }
  constexpr double operator[](int axis) const { return coord[static_cast<std::size_t>(axis)]; }

  constexpr Vec& operator+=(const Vec& b) {
    for (int k = 0; k < D; ++k) (*this)[k] += b[k];
    return *this;
  }
  constexpr Vec& operator-=(const Vec& b) {
    for (int k = 0; k < D; ++k) (*this)[k] -= b[k];
    return *this;
  }
  constexpr Vec& operator*=(double s) {
    for (int k = 0; k < D; ++k) (*this)[k] *= s;
    return *this;
  }
  friend constexpr Vec operator+(Vec a, const Vec& b) { return a += b; }
  friend constexpr Vec operator-(Vec a, const Vec& b) { return a -= b; }
  friend constexpr Vec operator*(Vec a, double s) { return a *= s; }
  friend constexpr Vec operator*(double s, Vec a) { return a *= s; }
  friend constexpr Vec operator/(Vec a, double s) { return a *= 1.0 / s; }
  friend constexpr Vec operator-(Vec a) { return a *= -1.0; }
  friend constexpr bool operator==(const Vec&, const Vec&) = default;
  friend constexpr auto operator<=>(const Vec& a, const Vec& b) { return a.coord <=> b.coord; }
};

template <int D>
constexpr double dot(const Vec<D>& a, const Vec<D>& b) {
  double s = 0;
  for (int k = 0; k < D; ++k) s += a[k] * b[k];
  return s;
}

template <int D>
constexpr double norm_sq(const Vec<D>& a) {
  return dot(a, a);
}

template <int D>
double norm(const Vec<D>& a) {
  return std::sqrt(norm_sq(a));
}

template <int D>
constexpr double distance_sq(const Vec<D>& a, const Vec<D>& b) {
  return norm_sq(a - b);
}

template <int D>
double distance(const Vec<D>& a, const Vec<D>& b) {
  return std::sqrt(distance_sq(a, b));
}

/// The z component of a x b.
constexpr double cross(const Vec<2>& a, const Vec<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

constexpr Vec<3> cross(const Vec<3>& a, const Vec<3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <int D>
bool is_finite(const Vec<D>& a) {
  for (int k = 0; k < D; ++k)
    if (!std::isfinite(a[k])) return false;
  return true;
}

/// An axis-aligned box; empty (lo > hi) until something is added.
template <int D>
struct Box {
  Vec<D> lo, hi;

  Box() {
    for (int k = 0; k < D; ++k) {
      lo[k] = std::numeric_limits<double>::infinity();
      hi[k] = -std::numeric_limits<double>::infinity();
    }
  }
  Box(const Vec<D>& l, const Vec<D>& h) : lo(l), hi(h) {}

  [[nodiscard]] bool empty() const { return lo[0] > hi[0]; }
  void add(const Vec<D>& p) {
    for (int k = 0; k < D; ++k) {
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
  }
  void add(const Box& b) {
    for (int k = 0; k < D; ++k) {
      lo[k] = std::min(lo[k], b.lo[k]);
      hi[k] = std::max(hi[k], b.hi[k]);
    }
  }
  void inflate(double by) {
    for (int k = 0; k < D; ++k) {
      lo[k] -= by;
      hi[k] += by;
    }
  }
  [[nodiscard]] Vec<D> center() const { return 0.5 * (lo + hi); }
  [[nodiscard]] double diagonal() const { return empty() ? 0.0 : norm(hi - lo); }
  [[nodiscard]] bool contains(const Vec<D>& p) const {
    for (int k = 0; k < D; ++k)
      if (p[k] < lo[k] || p[k] > hi[k]) return false;
    return true;
  }
  [[nodiscard]] bool overlaps(const Box& b) const {
    for (int k = 0; k < D; ++k)
      if (b.hi[k] < lo[k] || b.lo[k] > hi[k]) return false;
    return true;
  }
  /// Squared distance from p to the box, 0 inside.
  [[nodiscard]] double distance_sq(const Vec<D>& p) const {
    double s = 0;
    for (int k = 0; k < D; ++k) {
      const double d = std::max({lo[k] - p[k], 0.0, p[k] - hi[k]});
      s += d * d;
    }
    return s;
  }
};

}  // namespace voropack
