// Families of domains with small angles: wedges, pyramids, books, fans, slits, needles and heaps of simplices that
// share vertices, edges and facets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.h"
#include "geom/distance.h"
#include "support/cases.h"
#include "support/plc_files.h"
#include "voropack/delaunay.h"

namespace voropack::test::sharp {

using domains::add_box;
using domains::add_facet;
using domains::add_loop;
using domains::add_point;
using domains::add_segment;
using domains::Polygon;

inline double radians(double degrees) { return degrees * std::numbers::pi / 180; }

template <int D>
Case<D> make_case(std::string name, DomainInput<D> input, double measure) {
  return {std::move(name), std::move(input), measure, {}, 0};
}

/// A prism over an isosceles triangle: two unit squares that meet at the angle.
inline Case<3> wedge(double degrees) {
  const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
  DomainInput<3> input;
  domains::add_prism(input, {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{c, s}}, 0, 1);
  return make_case("wedge " + std::to_string(degrees), input, s / 2);
}

/// Two quadrilaterals of different shapes that meet at the angle: nothing is symmetric.
inline Case<3> skew_wedge(double degrees) {
  const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
  DomainInput<3> input;
  input.points = {Vec<3>{0, 0, 0},
                  Vec<3>{0, 1, 0},
                  Vec<3>{1, 0, 0},
                  Vec<3>{1.2, 1.3, 0},
                  Vec<3>{.8 * c, -.2, .8 * s},
                  Vec<3>{.7 * c, 1.1, .7 * s}};
  for (const Polygon& p : {Polygon{0, 1, 3, 2}, Polygon{0, 4, 5, 1}, Polygon{0, 2, 4}, Polygon{1, 5, 3},
                           Polygon{2, 5, 4}, Polygon{2, 3, 5}})
    add_facet(input, p);
  return make_case("skew wedge " + std::to_string(degrees), input, enclosed_volume(input));
}

/// A regular pyramid of height 1 with this angle between opposite lines on its cone.
inline Case<3> pyramid(std::uint32_t n_sides, double tip_degrees) {
  const double r = std::tan(radians(tip_degrees) / 2);
  DomainInput<3> input;
  Polygon base;
  for (std::uint32_t i = 0; i < n_sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / n_sides;
    input.points.push_back({r * std::cos(angle), r * std::sin(angle), 0});
    base.push_back(n_sides - 1 - i);
  }
  input.points.push_back({0, 0, 1});
  add_facet(input, base);
  for (std::uint32_t i = 0; i < n_sides; ++i) add_facet(input, {i, (i + 1) % n_sides, n_sides});
  return make_case("pyramid " + std::to_string(n_sides) + " " + std::to_string(tip_degrees), input,
                   enclosed_volume(input));
}

/// Pages around a vertical spine, all of them inside a cube of edge 3.
inline Case<3> book(const std::vector<double>& angles_deg, const std::string& name) {
  DomainInput<3> input;
  add_box<3>(input, {-1.5, -1.5, -1}, {1.5, 1.5, 2});
  const auto a = add_point<3>(input, {0, 0, 0}), b = add_point<3>(input, {0, 0, 1});
  for (const double degrees : angles_deg) {
    const double x = 0.5 * std::cos(radians(degrees)), y = 0.5 * std::sin(radians(degrees));
    const auto c = add_point<3>(input, {x, y, 0.9}), d = add_point<3>(input, {x, y, 0.1});
    add_facet(input, {a, b, c, d});
  }
  return make_case("book " + name, input, 27);
}

inline Case<3> equal_book(int n_pages) {
  std::vector<double> angles;
  for (int i = 0; i < n_pages; ++i) angles.push_back(360.0 * i / n_pages);
  return book(angles, std::to_string(n_pages) + " equal");
}

/// Pages at random angles at least `least` degrees apart.
inline Case<3> random_book(int n_pages, double least, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> gaps;
  double sum = 0;
  for (int i = 0; i < n_pages; ++i) sum += gaps.emplace_back(random.unit());
  std::vector<double> angles = {0};
  for (int i = 0; i + 1 < n_pages; ++i)
    angles.push_back(angles.back() + least + gaps[static_cast<std::size_t>(i)] / sum * (360 - n_pages * least));
  return book(angles, std::to_string(n_pages) + " random " + std::to_string(seed));
}

/// A crack that rises from the bottom of a cube at the angle and ends inside.
inline Case<3> leaning_crack(double degrees) {
  DomainInput<3> input = domains::unit_cube();
  const double x = 0.3 + 0.4 * std::cos(radians(degrees)), z = 0.4 * std::sin(radians(degrees));
  const auto first = add_point<3>(input, {0.3, 0.3, 0});
  add_point<3>(input, {0.3, 0.7, 0});
  add_point<3>(input, {x, 0.7, z});
  add_point<3>(input, {x, 0.3, z});
  add_facet(input, {first, first + 1, first + 2, first + 3});
  return make_case("leaning crack " + std::to_string(degrees), input, 1);
}

/// A flat tetrahedron over a thin triangle.
inline Case<3> needle(double thickness) {
  DomainInput<3> input;
  input.points = {Vec<3>{0, 0, 0}, Vec<3>{1, 0, 0}, Vec<3>{.5, thickness, 0}, Vec<3>{.5, .3 * thickness, .5}};
  for (const Polygon& p : {Polygon{0, 2, 1}, Polygon{0, 1, 3}, Polygon{1, 2, 3}, Polygon{2, 0, 3}}) add_facet(input, p);
  return make_case("needle " + std::to_string(thickness), input, thickness * .5 / 6);
}

/// Segments of different lengths from one point inside a square of edge 3.
inline Case<2> fan(int n_segments, double degrees, std::uint64_t seed = 1) {
  Random random(seed);
  DomainInput<2> input;
  add_box<2>(input, {-1, -1}, {2, 2});
  const auto tip = add_point<2>(input, {0, 0});
  for (int i = 0; i < n_segments; ++i) {
    const double angle = radians(degrees) * i, length = 1 + 0.3 * random.unit();
    add_segment(input, tip, add_point<2>(input, {length * std::cos(angle), length * std::sin(angle)}));
  }
  return make_case("fan " + std::to_string(n_segments) + " " + std::to_string(degrees), input, 9);
}

/// A triangle with this angle at one corner and another below it.
inline Case<2> sliver(double degrees) {
  DomainInput<2> input;
  const double height = std::tan(radians(degrees));
  add_loop(input, {Vec<2>{0, 0}, Vec<2>{1.3, 0}, Vec<2>{1, height}});
  return make_case("sliver " + std::to_string(degrees), input, 1.3 * height / 2);
}

/// A segment that leaves the side of a square at the angle and ends inside.
inline Case<2> leaning_slit(double degrees) {
  DomainInput<2> input = domains::unit_square();
  const auto foot = add_point<2>(input, {0.2, 0});
  add_segment(input, foot,
              add_point<2>(input, {0.2 + 0.6 * std::cos(radians(degrees)), 0.6 * std::sin(radians(degrees))}));
  return make_case("leaning slit " + std::to_string(degrees), input, 1);
}

/// Some simplices of the Delaunay triangulation of random points, each with all of its faces: they share vertices,
/// edges and facets at random. What they enclose is filled.
template <int D>
Case<D> heap(std::size_t n_points, double share, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec<D>> points(n_points);
  for (Vec<D>& x : points)
    for (int k = 0; k < D; ++k) x[k] = random.unit();
  const Triangulation<D> all = delaunay_triangulation(points);
  const std::size_t n = all.simplices.size();
  std::vector<bool> taken(n), outside(n);
  for (std::size_t s = 0; s < n; ++s) taken[s] = random.unit() < share;
  if (std::ranges::count(taken, true) == 0) taken[0] = true;
  // From the hull through what is not taken.
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t s = 0; s < n; ++s)
      if (!taken[s] && !outside[s])
        for (const std::uint32_t t : all.neighbors[s])
          if (t == Triangulation<D>::kNoNeighbor || outside[t]) grows = outside[s] = true;
  }
  DomainInput<D> input;
  std::vector<std::uint32_t> index(n_points, ~0U);
  const auto point = [&](std::uint32_t v) {
    if (index[v] == ~0U) index[v] = add_point(input, points[v]);
    return index[v];
  };
  double measure = 0;
  for (std::size_t s = 0; s < n; ++s) {
    if (outside[s]) continue;
    const auto& corners = all.simplices[s];
    std::array<Vec<D>, D> sides;
    for (std::size_t k = 0; k < D; ++k) sides[k] = points[corners[k + 1]] - points[corners[0]];
    if constexpr (D == 2)
      measure += std::abs(sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0]) / 2;
    else
      measure += std::abs(dot(cross(sides[0], sides[1]), sides[2])) / 6;
    for (std::size_t k = 0; k <= D; ++k) {
      const std::uint32_t t = all.neighbors[s][k];
      if (t != Triangulation<D>::kNoNeighbor && !outside[t] && t < s) continue;  // Added from the other side.
      std::vector<std::uint32_t> face;
      for (std::size_t j = 0; j <= D; ++j)
        if (j != k) face.push_back(point(corners[j]));
      if constexpr (D == 2)
        add_segment(input, face[0], face[1]);
      else
        add_facet(input, face);
    }
  }
  return make_case("heap " + std::to_string(n_points) + " " + std::to_string(seed), input, measure);
}

namespace heaps {

using Tetrahedron = std::array<std::uint32_t, 4>;

inline std::array<Vec<3>, 4> corners_of(const std::vector<Vec<3>>& points, const Tetrahedron& t) {
  return {points[t[0]], points[t[1]], points[t[2]], points[t[3]]};
}

inline double volume_of(const std::array<Vec<3>, 4>& x) {
  return std::abs(dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0])) / 6;
}

/// True if a plane separates the interiors: one along a face of either, or along an edge of both.
inline bool are_apart(const std::array<Vec<3>, 4>& a, const std::array<Vec<3>, 4>& b) {
  const auto separates = [&](const Vec<3>& normal) {
    if (norm(normal) < 1e-12) return false;
    double lo_a = 1e300, hi_a = -1e300, lo_b = 1e300, hi_b = -1e300;
    for (std::size_t i = 0; i < 4; ++i) {
      const double on_a = dot(a[i], normal) / norm(normal), on_b = dot(b[i], normal) / norm(normal);
      lo_a = std::min(lo_a, on_a), hi_a = std::max(hi_a, on_a);
      lo_b = std::min(lo_b, on_b), hi_b = std::max(hi_b, on_b);
    }
    return hi_a <= lo_b + 1e-9 || hi_b <= lo_a + 1e-9;
  };
  for (const auto* t : {&a, &b})
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec<3>&x = (*t)[k], &y = (*t)[(k + 1) % 4], &z = (*t)[(k + 2) % 4];
      if (separates(cross(y - x, z - x))) return true;
    }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = 0; l < k; ++l)
          if (separates(cross(a[i] - a[j], b[k] - b[l]))) return true;
  return false;
}

}  // namespace heaps

/// The smallest angle between a segment and a segment or triangle, not around it, with a common point. Degrees. Of a
/// domain of triangles.
inline double least_angle_deg(const DomainInput<3>& input) {
  const auto& x = input.points;
  double least = std::numbers::pi;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const auto& f : input.facets)
    for (const auto& p : f.polygons) triangles.push_back({p[0], p[1], p[2]});
  for (const auto& s : triangles)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 1; k < 3; ++k) {
        const std::uint32_t tip = s[i], end = s[(i + k) % 3];
        for (const auto& t : triangles)
          for (std::size_t j = 0; j < 3; ++j) {
            const std::uint32_t a = t[(j + 1) % 3], b = t[(j + 2) % 3];
            if (t[j] != tip) continue;
            const Vec<3> along = x[end] - x[tip];
            for (const std::uint32_t c : {a, b})
              if (c != end) least = std::min(least, angle_between(along, x[c] - x[tip]));
            if (a != end && b != end) least = std::min(least, angle_to_cone(along, x[a] - x[tip], x[b] - x[tip]));
          }
      }
  return least * 180 / std::numbers::pi;
}

/// Random tetrahedra in the unit cube, each of which has one or two corners in common with an earlier one. Nothing
/// meets below the least angle, as `least_angle_deg` measures it.
inline Case<3> tetrahedra(std::size_t n_tetrahedra, double least_deg, std::uint64_t seed) {
  constexpr double kLeastVolume = 0.02 / 6;
  Random random(seed);
  DomainInput<3> input;
  std::vector<heaps::Tetrahedron> taken;
  double measure = 0;
  while (taken.size() < n_tetrahedra) {
    DomainInput<3> next = input;
    heaps::Tetrahedron t{};
    std::size_t n_shared = 0;
    if (!taken.empty()) {
      heaps::Tetrahedron from = taken[random.bits() % taken.size()];
      for (std::size_t i = 4; i > 1; --i) std::swap(from[i - 1], from[random.bits() % i]);
      n_shared = 1 + random.bits() % 2;
      t = from;
    }
    for (std::size_t i = n_shared; i < 4; ++i) {
      Vec<3> x;
      for (int k = 0; k < 3; ++k) x[k] = random.unit();
      t[i] = add_point(next, x);
    }
    const auto x = heaps::corners_of(next.points, t);
    if (heaps::volume_of(x) < kLeastVolume) continue;
    if (!std::ranges::all_of(taken,
                             [&](const auto& u) { return heaps::are_apart(x, heaps::corners_of(next.points, u)); }))
      continue;
    for (std::size_t k = 0; k < 4; ++k) add_facet(next, {t[k], t[(k + 1) % 4], t[(k + 2) % 4]});
    if (least_angle_deg(next) < least_deg) continue;
    input = std::move(next);
    taken.push_back(t);
    measure += heaps::volume_of(x);
  }
  return make_case("tetrahedra " + std::to_string(n_tetrahedra) + " " + std::to_string(seed), input, measure);
}

/// The same domain with points, segments and facets in another order.
template <int D>
Case<D> renumbered(Case<D> c, std::uint64_t seed) {
  Random random(seed);
  const auto shuffle = [&](auto& list) {
    for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
  };
  std::vector<std::uint32_t> order(c.input.points.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  shuffle(order);
  std::vector<Vec<D>> points(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) points[order[i]] = c.input.points[i];
  c.input.points = std::move(points);
  for (auto& s : c.input.segments)
    for (std::uint32_t& p : s.points) p = order[p];
  for (auto& f : c.input.facets)
    for (auto& polygon : f.polygons)
      for (std::uint32_t& p : polygon) p = order[p];
  shuffle(c.input.segments);
  shuffle(c.input.facets);
  c.name += " renumbered";
  return c;
}

/// Rotated, scaled by `scale` and shifted by `shift` times the scale along every axis.
template <int D>
Case<D> moved(Case<D> c, std::uint64_t seed, double scale, double shift) {
  c.input = domains::tilted(c.input, seed, scale, shift * scale);
  c.measure *= std::pow(scale, D);
  c.name += " moved " + std::to_string(seed) + ", scale " + std::to_string(scale) + ", shift " + std::to_string(shift);
  return c;
}

}  // namespace voropack::test::sharp
