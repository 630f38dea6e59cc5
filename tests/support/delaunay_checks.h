// The laws of a Delaunay kernel, in their slow and obvious form.
#pragma once

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "geom/delaunay_kernel.h"
#include "geom/predicates.h"
#include "voropack/vec.h"

namespace voropack::test {

template <int K>
int orientation_of(const std::vector<Vec<K>>& p, const std::array<std::uint32_t, K + 1>& c) {
  if constexpr (K == 2) return orientation(p[c[0]], p[c[1]], p[c[2]]);
  if constexpr (K == 3) return orientation(p[c[0]], p[c[1]], p[c[2]], p[c[3]]);
}

template <int K>
int side_of_ball(const std::vector<Vec<K>>& p, const std::array<std::uint32_t, K + 1>& c, const Vec<K>& q) {
  if constexpr (K == 2) return in_circumball(p[c[0]], p[c[1]], p[c[2]], q);
  if constexpr (K == 3) return in_circumball(p[c[0]], p[c[1]], p[c[2]], p[c[3]], q);
}

/// Finite simplices, each with ascending corners, in ascending order.
template <int K, class Kernel>
std::vector<std::array<std::uint32_t, K + 1>> sorted_simplices(const Kernel& kernel) {
  std::vector<std::array<std::uint32_t, K + 1>> all;
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s) {
    if (!kernel.is_finite(s)) continue;
    all.push_back(kernel.corners(s));
    std::sort(all.back().begin(), all.back().end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// The first broken law of the data structure in words, or an empty string: corners distinct, neighbors mutual across
/// the same face, simplices positively oriented, the boundary of the whole a sphere, slot_of_vertex right.
template <int K, class Kernel>
std::string find_structure_fault(const Kernel& kernel, const std::vector<Vec<K>>& points) {
  constexpr std::size_t kCorners = K + 1;
  if (kernel.n_vertices() != points.size()) return "wrong number of vertices";
  std::size_t n_alive = 0, n_infinite = 0;
  std::set<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s) {
    if (!kernel.is_alive(s)) {
      if (kernel.is_finite(s)) return "an empty slot is finite";
      continue;
    }
    ++n_alive;
    const auto c = kernel.corners(s);
    const auto n = kernel.neighbors(s);
    auto sorted = c;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return "corners are not distinct";
    const bool finite = std::find(c.begin(), c.end(), kInfiniteVertex) == c.end();
    if (finite != kernel.is_finite(s)) return "is_finite is wrong";
    n_infinite += finite ? 0 : 1;
    if (finite && sorted.back() >= points.size()) return "a corner is no vertex";
    if (finite && orientation_of<K>(points, c) <= 0) return "a simplex is not positively oriented";
    for (std::size_t i = 0; i < kCorners; ++i)
      for (std::size_t j = 0; j < i; ++j) edges.insert({std::min(c[i], c[j]), std::max(c[i], c[j])});
    for (std::size_t i = 0; i < kCorners; ++i) {
      if (n[i] >= kernel.n_slots() || !kernel.is_alive(n[i])) return "a neighbor is not alive";
      const auto back = kernel.neighbors(n[i]);
      const auto other = kernel.corners(n[i]);
      bool mutual = false;
      for (std::size_t j = 0; j < kCorners; ++j) {
        if (back[j] != s) continue;
        auto mine = c, theirs = other;
        mine[i] = theirs[j] = 0xffffffffU;
        std::sort(mine.begin(), mine.end());
        std::sort(theirs.begin(), theirs.end());
        mutual = mutual || mine == theirs;
      }
      if (!mutual) return "a neighbor does not share the face opposite to the corner";
    }
    // A face at infinity sees its finite neighbor on the negative side.
    if (!finite) {
      const std::size_t at = static_cast<std::size_t>(std::find(c.begin(), c.end(), kInfiniteVertex) - c.begin());
      auto inward = c;
      for (const std::uint32_t v : kernel.corners(n[at]))
        if (std::find(c.begin(), c.end(), v) == c.end()) inward[at] = v;
      if (orientation_of<K>(points, inward) >= 0) return "a face at infinity is not positively oriented";
    }
  }
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    const std::uint32_t s = kernel.slot_of_vertex(v);
    if (s >= kernel.n_slots() || !kernel.is_alive(s)) return "slot_of_vertex is empty";
    const auto c = kernel.corners(s);
    if (std::find(c.begin(), c.end(), v) == c.end()) return "slot_of_vertex does not have the vertex";
  }
  // Euler's relation of the sphere of dimension K: V - E + F - T = 0 with F = 2T, or V - E + T = 2.
  const std::size_t n_all_vertices = points.size() + 1;
  const bool euler = K == 3 ? n_all_vertices + n_alive == edges.size() : n_all_vertices + n_alive == edges.size() + 2;
  if (!euler) return "Euler's relation does not hold";
  if (n_infinite == 0) return "there is no hull";
  return {};
}

/// True if no point lies strictly inside the circumball of a finite simplex. O(n^2).
template <int K, class Kernel>
bool has_empty_balls(const Kernel& kernel, const std::vector<Vec<K>>& points) {
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s) {
    if (!kernel.is_finite(s)) continue;
    for (const Vec<K>& q : points)
      if (side_of_ball<K>(points, kernel.corners(s), q) > 0) return false;
  }
  return true;
}

}  // namespace voropack::test
