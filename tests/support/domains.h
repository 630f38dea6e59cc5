// Small piecewise linear complexes for tests. Every function returns fresh DomainInput that `build_domain` accepts with
// the default options; the comment gives what comes out of it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include "base/random.h"
#include "voropack/domain.h"

namespace voropack::domains {

using Corner = std::uint32_t;
using Polygon = std::vector<Corner>;

/// Appends a segment between points that are already there.
template <int D>
void add_segment(DomainInput<D>& input, std::size_t a, std::size_t b, std::optional<int> marker = {}) {
  input.segments.push_back({{static_cast<Corner>(a), static_cast<Corner>(b)}, marker, {}});
}

/// Appends a facet of one polygon between points that are already there.
inline void add_facet(DomainInput<3>& input, Polygon polygon, std::optional<int> marker = {}) {
  input.facets.push_back({{std::move(polygon)}, {}, marker, {}});
}

/// Appends a point; returns its index.
template <int D>
Corner add_point(DomainInput<D>& input, const Vec<D>& x) {
  input.points.push_back(x);
  return static_cast<Corner>(input.points.size() - 1);
}

/// Appends a closed polygon: its points and segments.
inline void add_loop(DomainInput<2>& input, const std::vector<Vec<2>>& loop) {
  const std::size_t first = input.points.size();
  for (const Vec<2>& x : loop) input.points.push_back(x);
  for (std::size_t i = 0; i < loop.size(); ++i) add_segment(input, first + i, first + (i + 1) % loop.size());
}

/// Appends a prism over a polygon (counterclockwise seen from above): bottom, top, sides.
inline void add_prism(DomainInput<3>& input, const std::vector<Vec<2>>& base, double z0, double z1) {
  const auto first = static_cast<Corner>(input.points.size());
  const auto n = static_cast<Corner>(base.size());
  for (const double z : {z0, z1})
    for (const Vec<2>& x : base) input.points.push_back({x[0], x[1], z});
  Polygon bottom, top;
  for (Corner i = 0; i < n; ++i) {
    bottom.push_back(first + n - 1 - i);
    top.push_back(first + n + i);
  }
  add_facet(input, bottom);
  add_facet(input, top);
  for (Corner i = 0; i < n; ++i) {
    const Corner j = (i + 1) % n;
    add_facet(input, {first + i, first + j, first + n + j, first + n + i});
  }
}

inline std::vector<Vec<2>> rectangle(const Vec<2>& lo, const Vec<2>& hi) {
  return {Vec<2>{lo[0], lo[1]}, Vec<2>{hi[0], lo[1]}, Vec<2>{hi[0], hi[1]}, Vec<2>{lo[0], hi[1]}};
}

/// Appends an axis-aligned box: 4 points and segments, or 8 points and 6 facets (bottom, top, front, right, back,
/// left).
template <int D>
void add_box(DomainInput<D>& input, const Vec<D>& lo, const Vec<D>& hi) {
  if constexpr (D == 2)
    add_loop(input, rectangle(lo, hi));
  else
    add_prism(input, rectangle({lo[0], lo[1]}, {hi[0], hi[1]}), lo[2], hi[2]);
}

template <int D>
Vec<D> all(double c) {
  Vec<D> x;
  for (int k = 0; k < D; ++k) x[k] = c;
  return x;
}

/// An axis-aligned box. One region.
template <int D>
DomainInput<D> box(const Vec<D>& lo, const Vec<D>& hi) {
  DomainInput<D> input;
  add_box<D>(input, lo, hi);
  return input;
}

/// [0, 1]^D: 4 points, 4 segments; 8 points, 12 segments, 6 facets. Measure 1.
template <int D>
DomainInput<D> unit_box() {
  return box<D>(all<D>(0), all<D>(1));
}
inline DomainInput<2> unit_square() { return unit_box<2>(); }
inline DomainInput<3> unit_cube() { return unit_box<3>(); }

/// [0, 3]^D without the cavity [1, 2]^D, which a hole seed empties. Measure 8 or 26.
template <int D>
DomainInput<D> box_with_hole() {
  DomainInput<D> input = box<D>(all<D>(0), all<D>(3));
  add_box<D>(input, all<D>(1), all<D>(2));
  input.hole_seeds.push_back(all<D>(1.5));
  return input;
}

/// [0, 3]^3 with a square hole from bottom to top: two facets with a hole each. Measure 24.
inline DomainInput<3> box_with_through_hole() {
  DomainInput<3> input = box<3>(all<3>(0), all<3>(3));
  const auto first = static_cast<Corner>(input.points.size());
  for (const double z : {0.0, 3.0})
    for (const Vec<2>& x : rectangle({1, 1}, {2, 2})) input.points.push_back({x[0], x[1], z});
  for (Corner side = 0; side < 2; ++side) {
    const Corner p = first + 4 * side;
    input.facets[side].polygons.push_back({p, p + 1, p + 2, p + 3});
    input.facets[side].holes.push_back({1.5, 1.5, side == 0 ? 0.0 : 3.0});
  }
  for (Corner i = 0; i < 4; ++i) {
    const Corner j = (i + 1) % 4;
    add_facet(input, {first + i, first + j, first + 4 + j, first + 4 + i});
  }
  return input;
}

/// [0, 2]^2 without (1, 2]^2, in 3D times [0, 1]. Measure 3. Non-convex facets.
template <int D>
DomainInput<D> l_shape() {
  const std::vector<Vec<2>> base = {Vec<2>{0, 0}, Vec<2>{2, 0}, Vec<2>{2, 1}, Vec<2>{1, 1}, Vec<2>{1, 2}, Vec<2>{0, 2}};
  DomainInput<D> input;
  if constexpr (D == 2)
    add_loop(input, base);
  else
    add_prism(input, base, 0, 1);
  return input;
}

/// [0, 2] x [0, 1]^(D-1), cut at x = 1 by a wall whose edges lie on the outer walls. Region 7 left, 9 right, measure 1
/// each. In 3D the four cut facets become eight (11 facets with the wall).
template <int D>
DomainInput<D> two_material_box() {
  Vec<D> hi = all<D>(1);
  hi[0] = 2;
  DomainInput<D> input = box<D>(all<D>(0), hi);
  const auto first = static_cast<Corner>(input.points.size());
  if constexpr (D == 2) {
    input.points.push_back({1, 0});
    input.points.push_back({1, 1});
    add_segment(input, first, first + 1);
  } else {
    for (const Vec<2>& x : rectangle({0, 0}, {1, 1})) input.points.push_back({1, x[0], x[1]});
    add_facet(input, {first, first + 1, first + 2, first + 3});
  }
  Vec<D> seed = all<D>(0.5);
  input.region_seeds.push_back({seed, 7, {}});
  seed[0] = 1.5;
  input.region_seeds.push_back({seed, 9, {}});
  return input;
}

/// [0, 1]^D with a wall inside that touches nothing: a segment, or a rectangle, both of whose sides face the region.
template <int D>
DomainInput<D> box_with_internal_wall() {
  DomainInput<D> input = unit_box<D>();
  const auto first = static_cast<Corner>(input.points.size());
  if constexpr (D == 2) {
    input.points.push_back({0.5, 0.3});
    input.points.push_back({0.5, 0.7});
    add_segment(input, first, first + 1);
  } else {
    for (const Vec<2>& x : rectangle({0.3, 0.3}, {0.7, 0.7})) input.points.push_back({0.5, x[0], x[1]});
    add_facet(input, {first, first + 1, first + 2, first + 3});
  }
  return input;
}

/// [0, 1]^D with a segment from the middle of the wall x = 0 to the center.
template <int D>
DomainInput<D> box_with_dangling_segment() {
  DomainInput<D> input = unit_box<D>();
  Vec<D> foot = all<D>(0.5);
  foot[0] = 0;
  const Corner a = add_point(input, foot);
  const Corner b = add_point(input, all<D>(0.5));
  add_segment(input, a, b);
  return input;
}

/// [0, 1]^D with a point at its center.
template <int D>
DomainInput<D> box_with_isolated_point() {
  DomainInput<D> input = unit_box<D>();
  input.points.push_back(all<D>(0.5));
  return input;
}

/// [0, 1]^3 with a segment and a point inside its top facet, listed as polygons of that facet.
inline DomainInput<3> box_with_marked_facet() {
  DomainInput<3> input = unit_cube();
  const Corner a = add_point<3>(input, {0.3, 0.3, 1});
  const Corner b = add_point<3>(input, {0.7, 0.3, 1});
  const Corner c = add_point<3>(input, {0.5, 0.7, 1});
  input.facets[1].polygons.push_back({a, b});
  input.facets[1].polygons.push_back({c});
  return input;
}

/// A regular tetrahedron with edges of length 1, or an equilateral triangle: every plane angle is 60 degrees, every
/// dihedral angle 70.5. In 3D the edges meet the opposite facets at 54.7 degrees: accepted only with min_angle_deg
/// below that.
template <int D>
DomainInput<D> regular_simplex() {
  DomainInput<D> input;
  const double h = std::sqrt(3.0) / 2;
  if constexpr (D == 2) {
    add_loop(input, {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{0.5, h}});
  } else {
    input.points = {Vec<3>{0, 0, 0}, Vec<3>{1, 0, 0}, Vec<3>{0.5, h, 0}, Vec<3>{0.5, h / 3, std::sqrt(2.0 / 3.0)}};
    for (const Polygon& p : {Polygon{0, 2, 1}, Polygon{0, 1, 3}, Polygon{1, 2, 3}, Polygon{2, 0, 3}})
      add_facet(input, p);
  }
  return input;
}

/// [0, 1]^3 as a bare surface of 12 n^2 triangles.
inline DomainInput<3> tessellated_cube(int n) {
  DomainInput<3> input;
  input.is_surface = true;
  const auto corner = [&](int axis, int side, int i, int j) {
    Vec<3> x;
    x[axis] = side;
    x[(axis + 1) % 3] = static_cast<double>(i) / n;
    x[(axis + 2) % 3] = static_cast<double>(j) / n;
    return add_point(input, x);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const std::array<Corner, 4> c = {corner(axis, side, i, j), corner(axis, side, i + 1, j),
                                           corner(axis, side, i + 1, j + 1), corner(axis, side, i, j + 1)};
          for (Polygon t : {Polygon{c[0], c[1], c[2]}, Polygon{c[0], c[2], c[3]}}) {
            if (side == 0) std::swap(t[1], t[2]);
            add_facet(input, t);
          }
        }
  return input;
}

/// A rotation of R^D by a seeded generic angle (2D) or quaternion (3D), as rows.
template <int D>
std::array<Vec<D>, D> generic_rotation(std::uint64_t seed) {
  Random random(seed);
  if constexpr (D == 2) {
    const double angle = 0.1 + random.unit();
    return {Vec<2>{std::cos(angle), -std::sin(angle)}, Vec<2>{std::sin(angle), std::cos(angle)}};
  } else {
    std::array<double, 4> q;
    double length_sq = 0;
    for (double& c : q) {
      c = 0.2 + random.unit();
      length_sq += c * c;
    }
    for (double& c : q) c /= std::sqrt(length_sq);
    const auto [w, x, y, z] = q;
    return {Vec<3>{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
            Vec<3>{2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
            Vec<3>{2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  }
}

/// `input` with `fn` applied to every position.
template <int D, class Fn>
DomainInput<D> mapped(DomainInput<D> input, Fn&& fn) {
  for (Vec<D>& x : input.points) x = fn(x);
  for (auto& facet : input.facets)
    for (Vec<D>& x : facet.holes) x = fn(x);
  for (auto& seed : input.region_seeds) seed.position = fn(seed.position);
  for (Vec<D>& x : input.hole_seeds) x = fn(x);
  return input;
}

/// `input` rotated generically, scaled and shifted.
template <int D>
DomainInput<D> tilted(const DomainInput<D>& input, std::uint64_t seed = 1, double scale = 1, double shift = 0) {
  const std::array<Vec<D>, D> rows = generic_rotation<D>(seed);
  return mapped(input, [&](const Vec<D>& x) {
    Vec<D> y;
    for (int k = 0; k < D; ++k) y[k] = shift + scale * dot(rows[static_cast<std::size_t>(k)], x);
    return y;
  });
}

/// The unit box, rotated generically: no wall is normal to an axis.
template <int D>
DomainInput<D> tilted_box() {
  return tilted(unit_box<D>());
}

}  // namespace voropack::domains
