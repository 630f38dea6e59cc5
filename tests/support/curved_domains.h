// Surfaces that are flat triangles only because they had to be: bodies of revolution and spheroids. No angle of theirs
// is sharp, but triangles that are nearly equilateral have protecting balls that hardly miss each other's centers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "voropack/domain.h"

namespace voropack::domains {

/// Rings of 16 points around the z axis at the (z, radius) of a profile, closed by a point at each end, as triangles of
/// one marker.
inline void add_body_of_revolution(DomainInput<3>& input, const std::vector<std::array<double, 2>>& profile,
                                   double z_begin, double z_end, int marker) {
  constexpr std::size_t kAround = 16;
  const auto add = [&](const Vec<3>& x) {
    input.points.push_back(x);
    return static_cast<std::uint32_t>(input.points.size() - 1);
  };
  const std::uint32_t begin = add({0, 0, z_begin});
  std::vector<std::vector<std::uint32_t>> rings;
  for (const auto& [z, r] : profile) {
    const double shift = rings.size() % 2 == 0 ? 0 : 0.5;
    rings.emplace_back();
    for (std::size_t k = 0; k < kAround; ++k) {
      const double angle = 2 * std::numbers::pi * (static_cast<double>(k) + shift) / kAround;
      rings.back().push_back(add({r * std::cos(angle), r * std::sin(angle), z}));
    }
  }
  const std::uint32_t end = add({0, 0, z_end});
  const auto facet = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    input.facets.push_back({{{a, b, c}}, {}, marker, std::nullopt});
  };
  for (std::size_t k = 0; k < kAround; ++k) {
    const std::size_t next = (k + 1) % kAround;
    facet(begin, rings.front()[next], rings.front()[k]);
    facet(end, rings.back()[k], rings.back()[next]);
    for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
      const auto &low = rings[i], &high = rings[i + 1];
      if (i % 2 == 0) {
        facet(low[k], low[next], high[k]);
        facet(low[next], high[next], high[k]);
      } else {
        facet(low[k], high[next], high[k]);
        facet(low[k], low[next], high[next]);
      }
    }
  }
}

/// Two balls of radius 1/2 with a rod between them.
inline DomainInput<3> dumbbell() {
  DomainInput<3> input;
  std::vector<std::array<double, 2>> profile;
  for (int i = 1; i < 24; ++i) {
    const double z = -1.5 + 0.125 * i;
    profile.push_back({z, std::max(0.2, std::sqrt(std::max(0.0, 0.25 - (std::abs(z) - 1) * (std::abs(z) - 1))))});
  }
  add_body_of_revolution(input, profile, -1.5, 1.5, 1);
  return input;
}

/// The icosahedron with its 20 triangles cut into four so many times, on the unit sphere stretched along x.
inline DomainInput<3> spheroid(int n_cuts, double stretch) {
  using Triangle = std::array<std::uint32_t, 3>;
  const double t = std::numbers::phi;
  std::vector<Vec<3>> points = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                                {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  std::vector<Triangle> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vec<3>& x : points) x = x / norm(x);
  for (int i = 0; i < n_cuts; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]) / norm(points[a] + points[b]));
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {Triangle{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  DomainInput<3> input;
  for (const Vec<3>& x : points) input.points.push_back({stretch * x[0], x[1], x[2]});
  for (const auto& [a, b, c] : triangles) input.facets.push_back({{{a, b, c}}, {}, 1, std::nullopt});
  return input;
}

}  // namespace voropack::domains
