#include "packing/tied_polygons.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/disjoint_sets.h"
#include "geom/circumcenter.h"
#include "geom/kernel.h"
#include "geom/predicates.h"
#include "voropack/packing.h"

namespace voropack {

namespace {

/// Points this near to a circle, relative to its radius, are taken to be on it: far more than rounding, far less than
/// the random moves of new centers.
constexpr double kOnCircle = 1e-9;

using Triangle = std::array<std::uint32_t, 3>;

/// Whether the corner of t that is not on its edge to s lies on the circle of s.
bool are_tied(std::span<const Vec<2>> points, const Triangle& s, const Triangle& t) {
  const Vec<2> c = fast_circumcenter(std::array{points[s[0]], points[s[1]], points[s[2]]});
  const double radius = distance(c, points[s[0]]);
  return std::ranges::all_of(
      t, [&](std::uint32_t v) { return std::abs(distance(c, points[v]) - radius) <= kOnCircle * radius; });
}

bool are_coplanar(std::span<const Vec<3>> points, const std::vector<std::uint32_t>& corners, const Triangle& base) {
  return std::ranges::all_of(corners, [&](std::uint32_t v) {
    return orientation(points[base[0]], points[base[1]], points[base[2]], points[v]) == 0;
  });
}

/// The triangles of the polygon in a Delaunay triangulation in space: of its corners and two points above and below
/// it, outside its ball.
std::vector<Triangle> triangles_in_space(std::span<const Vec<3>> points, const std::vector<std::uint32_t>& corners,
                                         const Triangle& base) {
  const Vec<3>&a = points[base[0]], &b = points[base[1]], &c = points[base[2]];
  const Vec<3> center = triangle_circumcenter(a, b, c), normal = cross(b - a, c - a);
  const Vec<3> up = (2 * distance(center, a) / norm(normal)) * normal;
  std::vector<Vec<3>> all = {center + up, center - up};
  for (const std::uint32_t v : corners) all.push_back(points[v]);
  DelaunayKernel<3> kernel;
  kernel.insert(all);
  std::set<Triangle> found;
  for (std::uint32_t slot = 0; slot < kernel.n_slots(); ++slot) {
    if (!kernel.is_finite(slot)) continue;
    std::vector<std::uint32_t> here;
    for (const std::uint32_t v : kernel.corners(slot))
      if (v >= 2) here.push_back(corners[v - 2]);
    std::sort(here.begin(), here.end());
    if (here.size() == 3) found.insert({here[0], here[1], here[2]});
  }
  return {found.begin(), found.end()};
}

}  // namespace

std::vector<TiedPolygon> settle_tied_polygons(std::span<const Vec<2>> in_plane, std::span<const Vec<3>> in_space,
                                              std::span<const Triangle> neighbors, std::span<Triangle> triangles) {
  const auto n = static_cast<std::uint32_t>(triangles.size());
  DisjointSets sets(n);
  for (std::uint32_t t = 0; t < n; ++t)
    for (const std::uint32_t s : neighbors[t])
      if (s < t && are_tied(in_plane, triangles[s], triangles[t])) sets.join(s, t);
  std::map<std::uint32_t, TiedPolygon> polygons;
  for (std::uint32_t t = 0; t < n; ++t) polygons[sets.find(t)].triangles.push_back(t);
  std::vector<TiedPolygon> result;
  for (auto& [root, polygon] : polygons) {
    if (polygon.triangles.size() == 1) continue;
    for (const std::uint32_t t : polygon.triangles)
      polygon.points.insert(polygon.points.end(), triangles[t].begin(), triangles[t].end());
    std::sort(polygon.points.begin(), polygon.points.end());
    polygon.points.erase(std::unique(polygon.points.begin(), polygon.points.end()), polygon.points.end());
    const Triangle base = triangles[root];
    if (!are_coplanar(in_space, polygon.points, base)) continue;
    const std::vector<Triangle> settled = triangles_in_space(in_space, polygon.points, base);
    if (settled.size() != polygon.triangles.size()) continue;
    for (std::size_t i = 0; i < settled.size(); ++i) {
      Triangle t = settled[i];
      if (orientation(in_plane[t[0]], in_plane[t[1]], in_plane[t[2]]) < 0) std::swap(t[1], t[2]);
      triangles[polygon.triangles[i]] = t;
    }
    result.push_back(std::move(polygon));
  }
  return result;
}

std::vector<std::array<std::uint32_t, 3>> settle_polygon(std::span<const Vec<3>> corners) {
  std::vector<std::uint32_t> all(corners.size());
  std::iota(all.begin(), all.end(), 0U);
  return triangles_in_space(corners, all, {0, 1, 2});
}

}  // namespace voropack
