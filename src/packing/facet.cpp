#include "packing/facet.h"

#include <algorithm>

#include "base/random.h"
#include "geom/circumcenter.h"
#include "packing/boundary.h"

namespace voropack {

namespace {

/// New centers on a facet move at random by this much, relative to f: on a tilted plane, four points that are
/// cocircular by symmetry would span a flat simplex once their coordinates are rounded.
constexpr double kFacetJitter = 1e-5;

/// The spacing function in the facet's plane.
LocalSpacing<2> spacing_in_plane(const Spacing<3>& spacing, const PlaneFrame& frame) {
  return {[&spacing, frame](const Vec<2>& x) { return spacing(frame.from_plane(x)); },
          [&spacing, frame](const Box<2>& box) {
            Box<3> space;
            for (const double x : {box.lo[0], box.hi[0]})
              for (const double y : {box.lo[1], box.hi[1]}) space.add(frame.from_plane({x, y}));
            return spacing.constant_on(space);
          },
          spacing.lipschitz()};
}

/// The regions beside segment s in the plane of the facet, which is region 0: on the left in its frame, then on the
/// right.
std::array<int, 2> sides_of_segment(const Incidence<3>& incidence, FacetId facet, SegmentId s) {
  std::array<int, 2> sides = {Walls<2>::kOutside, Walls<2>::kOutside};
  for (const Page& page : incidence.pages_of(s))
    if (page.facet == facet) sides[static_cast<std::size_t>(page.side)] = 0;
  return sides;
}

}  // namespace

PackedFacet pack_facet(const Domain<3>& domain, const Incidence<3>& incidence, FacetId facet, const Packing<3>& packing,
                       const Csr<SegmentId, SphereId>& spheres_of_segment, const FacetStart& start,
                       const Spacing<3>& spacing, const PackingOptions& options, const Observer& observer) {
  const PlaneFrame& frame = domain.facet_frame[facet];
  PackedFacet result;
  PackingProblem<2> problem;
  for (const PointId p : domain.facet_points[facet]) {
    result.boundary.push_back(SphereId(p.value()));
    problem.bounds.add(frame.to_plane(domain.points[p]));
  }
  for (const SegmentId s : domain.facet_segments[facet])
    for (const SphereId sphere : spheres_of_segment[s]) result.boundary.push_back(sphere);
  result.boundary.insert(result.boundary.end(), start.spheres.begin(), start.spheres.end());
  std::sort(result.boundary.begin(), result.boundary.end());
  result.boundary.erase(std::unique(result.boundary.begin(), result.boundary.end()), result.boundary.end());
  const auto local = [&](SphereId s) {
    return static_cast<std::uint32_t>(std::lower_bound(result.boundary.begin(), result.boundary.end(), s) -
                                      result.boundary.begin());
  };
  for (const SphereId s : result.boundary)
    problem.fixed.push_back({frame.to_plane(packing.center[s]), packing.radius[s]});

  const auto forbid = [&](const Vec<2>& center, double radius) {
    problem.balls.push_back(grown_by_blur(Ball<2>{center, radius}, domain.box));
  };
  Walls<2> walls;
  for (const SegmentId s : domain.facet_segments[facet]) {
    const std::array<int, 2> sides = sides_of_segment(incidence, facet, s);
    walls.simplices.push_back(
        {frame.to_plane(domain.points[domain.segments[s][0]]), frame.to_plane(domain.points[domain.segments[s][1]])});
    walls.regions.push_back(sides);
    const auto chain = spheres_of_segment[s];
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      const std::array<std::uint32_t, 2> ends = {local(chain[k]), local(chain[k + 1])};
      const Vec<2> a = problem.fixed[ends[0]].center, b = problem.fixed[ends[1]].center;
      problem.faces.push_back({ends, sides});
      forbid(0.5 * (a + b), 0.5 * distance(a, b));
    }
  }
  const WallLocator<2> locator(std::move(walls));
  problem.walls = &locator;
  problem.far = &locator;
  for (const auto& fan : start.fans) {
    std::array<Vec<2>, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = problem.fixed[local(fan[i])].center;
    const Vec<2> c = fast_circumcenter(corners);
    forbid(c, distance(c, corners[0]));
  }
  if (!start.reserved.empty()) problem.reserved = &start.reserved;
  problem.spacing = spacing_in_plane(spacing, frame);
  problem.form = options.form;
  problem.interior = options.interior;
  problem.epsilon = options.epsilon;
  problem.jitter = kFacetJitter;
  problem.seed = hash_words(options.seed, 2, facet.value());

  PackedInterior<2> packed = pack_interior(problem, true, observer);
  for (const std::uint32_t i : packed.broken_faces) {
    const Ball<2>& ball = problem.balls[i];
    result.faults.push_back(
        repair_cap(frame.from_plane(ball.center), ball.radius, spacing, PolytopeId(facet), PolytopeId(facet)));
  }
  for (const Ball<2>& s : packed.spheres) {
    result.centers.push_back(frame.from_plane(s.center));
    result.radii.push_back(s.radius);
  }
  result.triangles = std::move(packed.triangulation.simplices);
  std::vector<Vec<2>> in_plane;
  std::vector<Vec<3>> in_space;
  for (const Ball<2>& s : problem.fixed) in_plane.push_back(s.center);
  for (const Ball<2>& s : packed.spheres) in_plane.push_back(s.center);
  for (const SphereId s : result.boundary) in_space.push_back(packing.center[s]);
  in_space.insert(in_space.end(), result.centers.begin(), result.centers.end());
  result.tied = settle_tied_polygons(in_plane, in_space, packed.triangulation.neighbors, result.triangles);
  return result;
}

}  // namespace voropack
