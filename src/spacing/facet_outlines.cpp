#include "spacing/facet_outlines.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "geom/tolerance.h"

namespace voropack {

namespace {

/// The segment meets the box (Liang and Barsky 1984).
bool meets(const std::array<Vec<2>, 2>& edge, const Box<2>& box) {
  double begin = 0;
  double end = 1;
  for (int k = 0; k < 2; ++k) {
    const double p = edge[0][k];
    const double d = edge[1][k] - p;
    if (d == 0) {
      if (p < box.lo[k] || p > box.hi[k]) return false;
      continue;
    }
    const double t0 = (box.lo[k] - p) / d;
    const double t1 = (box.hi[k] - p) / d;
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return begin <= end;
}

}  // namespace

FacetOutlines::FacetOutlines(const Domain<3>& domain, const PolytopeSet<3>& polytopes)
    : domain_(&domain), polytopes_(&polytopes), tolerance_(absolute_tolerance(domain.box, kFlatTolerance)) {
  for (FacetId f : ids(domain.facet_frame)) {
    const PlaneFrame& frame = domain.facet_frame[f];
    const auto points = domain.facet_points[f];
    is_flat_.push_back(std::all_of(points.begin(), points.end(),
                                   [&](PointId p) { return std::abs(frame.height(domain.points[p])) <= tolerance_; }));
    // An edge between two triangles has them on different sides and appears in both directions.
    std::map<std::pair<PointId, PointId>, int> count;
    for (const auto& t : domain.facet_triangles[f])
      for (std::size_t i = 0; i < 3; ++i) ++count[std::minmax(t[i], t[(i + 1) % 3])];
    std::vector<Edge> edges;
    for (const auto& [ends, n] : count)
      if (n == 1)
        edges.push_back({frame.to_plane(domain.points[ends.first]), frame.to_plane(domain.points[ends.second])});
    boundary_.push_row(edges);
  }
}

bool FacetOutlines::projects_inside(const Box<3>& box, FacetId facet) const {
  if (is_flat_[facet.value()] == 0) return false;
  const PlaneFrame& frame = domain_->facet_frame[facet];
  const Vec<3> center = box.center();
  const Vec<3> foot = center - frame.height(center) * frame.normal;
  if (polytopes_->distance_to(polytopes_->of_facet(facet), foot) > tolerance_) return false;
  // No boundary edge through the rectangle around the projected box: it lies on one side, with its center inside.
  Box<2> projection;
  for (unsigned i = 0; i < 8; ++i)
    projection.add(frame.to_plane({(i & 1U) != 0 ? box.hi[0] : box.lo[0], (i & 2U) != 0 ? box.hi[1] : box.lo[1],
                                   (i & 4U) != 0 ? box.hi[2] : box.lo[2]}));
  projection.inflate(-tolerance_);
  const auto edges = boundary_[facet];
  return std::none_of(edges.begin(), edges.end(), [&](const Edge& edge) { return meets(edge, projection); });
}

}  // namespace voropack
