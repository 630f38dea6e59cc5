#include "coarsening/surface_domain.h"

#include <algorithm>
#include <map>

#include "coarsening/edge_balls.h"
#include "geom/circumcenter.h"

namespace voropack {

namespace {

/// By place in the complex: the index among the vertices of the surface.
std::vector<std::uint32_t> point_indices(const SurfaceComplex& fine, const LevelSurface& surface) {
  std::vector<std::uint32_t> index(fine.points.size(), 0);
  for (std::uint32_t p = 0; p < surface.vertices.size(); ++p) index[surface.vertices[p]] = p;
  return index;
}

PlaneFrame frame_of(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  PlaneFrame frame;
  const Vec<3> normal = cross(b - a, c - a);
  frame.origin = a;
  frame.u = (b - a) / distance(a, b);
  frame.normal = normal / norm(normal);
  frame.v = cross(frame.normal, frame.u);
  return frame;
}

}  // namespace

Domain<3> domain_of_surface(const SurfaceComplex& fine, const LevelSurface& surface) {
  Domain<3> domain;
  const std::vector<std::uint32_t> index = point_indices(fine, surface);
  for (const std::uint32_t v : surface.vertices) {
    domain.points.push_back(fine.points[v]);
    domain.box.add(fine.points[v]);
  }
  domain.point_marker.resize(domain.points.size(), 0);
  domain.point_region.resize(domain.points.size());
  std::map<EdgeEnds, SegmentId> segment_of;
  const auto segment = [&](std::uint32_t a, std::uint32_t b, int marker) {
    const auto [it, is_new] = segment_of.try_emplace(ends_of(a, b), SegmentId(domain.segments.size()));
    if (is_new) {
      domain.segments.push_back({PointId(std::size_t{a}), PointId(std::size_t{b})});
      domain.segment_marker.push_back(marker);
    }
    return it->second;
  };
  for (const CurveEdge& e : surface.edges) segment(index[e.ends[0]], index[e.ends[1]], e.marker);
  for (const SurfaceTriangle& t : surface.triangles) {
    std::array<PointId, 3> corners;
    std::array<SegmentId, 3> sides;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = PointId(std::size_t{index[t.corners[i]]});
      sides[i] = segment(index[t.corners[i]], index[t.corners[(i + 1) % 3]], 0);
    }
    domain.facet_frame.push_back(
        frame_of(domain.points[corners[0]], domain.points[corners[1]], domain.points[corners[2]]));
    domain.facet_marker.push_back(t.marker);
    domain.facet_triangles.push_row(std::array<std::array<PointId, 3>, 1>{corners});
    std::sort(corners.begin(), corners.end());
    std::sort(sides.begin(), sides.end());
    domain.facet_points.push_row(corners);
    domain.facet_segments.push_row(sides);
    std::array<RegionId, 2> regions;
    for (std::size_t k = 0; k < 2; ++k)
      if (t.regions[k] != kNoRegion) regions[k] = RegionId(static_cast<std::size_t>(t.regions[k]));
    domain.wall_regions.push_back(regions);
  }
  domain.segment_region.resize(domain.segments.size());
  for (std::size_t r = 0; r < fine.region_id.size(); ++r) {
    domain.region_id.push_back(fine.region_id[r]);
    domain.region_measure.push_back(fine.region_volume[r]);
    domain.region_max_simplex.push_back(std::nullopt);
  }
  return domain;
}

Packing<3> packing_of_surface(const SurfaceComplex& fine, const LevelSurface& surface) {
  Packing<3> packing;
  const std::vector<std::uint32_t> index = point_indices(fine, surface);
  const auto sphere = [&](std::uint32_t v) { return SphereId(std::size_t{index[v]}); };
  for (std::size_t p = 0; p < surface.vertices.size(); ++p) {
    packing.center.push_back(fine.points[surface.vertices[p]]);
    packing.radius.push_back(0);
    packing.carrier.push_back(PolytopeId(0, p));
  }
  for (std::size_t e = 0; e < surface.edges.size(); ++e) {
    const auto& [a, b] = surface.edges[e].ends;
    packing.subsegments.push_back({{sphere(a), sphere(b)}, PolytopeId(1, e)});
  }
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const auto& [a, b, c] = surface.triangles[f].corners;
    packing.subfacets.push_back({{sphere(a), sphere(b), sphere(c)}, PolytopeId(2, f)});
  }
  return packing;
}

std::vector<Ball<3>> edge_balls_of_surface(const SurfaceComplex& fine, const LevelSurface& surface) {
  std::map<EdgeEnds, std::vector<std::uint32_t>> beside;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& c = surface.triangles[t].corners;
      beside[ends_of(c[i], c[(i + 1) % 3])].push_back(t);
    }
  for (const CurveEdge& e : surface.edges) beside.erase(e.ends);
  std::vector<Ball<3>> balls;
  for (const auto& [ends, triangles] : beside) {
    if (triangles.size() != 2) continue;
    const SurfaceTriangle &t = surface.triangles[triangles[0]], &s = surface.triangles[triangles[1]];
    const auto [a, b] = ends;
    const auto found = edge_balls(fine.points[a], fine.points[b], fine.points[third_corner(t, a, b)],
                                  fine.points[third_corner(s, a, b)], regions_beside(t, a, b));
    if (found) balls.insert(balls.end(), found->balls.begin(), found->balls.begin() + static_cast<long>(found->n));
  }
  return balls;
}

Walls<3> walls_of_surface(const SurfaceComplex& fine, const LevelSurface& surface) {
  Walls<3> walls;
  for (const SurfaceTriangle& t : surface.triangles) {
    walls.simplices.push_back({fine.points[t.corners[0]], fine.points[t.corners[1]], fine.points[t.corners[2]]});
    walls.regions.push_back(t.regions);
  }
  return walls;
}

}  // namespace voropack
