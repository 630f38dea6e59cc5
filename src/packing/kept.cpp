#include "packing/kept.h"

#include <algorithm>
#include <optional>

#include "geom/polytope_distance.h"
#include "geom/tolerance.h"

namespace voropack {

namespace {

/// The traces in each facet.
template <int D>
std::vector<std::vector<SegmentId>> traces_of_facets(const Domain<D>& domain, const Incidence<D>& incidence) {
  std::vector<std::vector<SegmentId>> traces(domain.facet_frame.size());
  if (incidence.has_traces())
    for (const SegmentId s : ids(domain.segments))
      if (const PolytopeId given = incidence.given(PolytopeId(s)); given != PolytopeId(s))
        traces[given.index].push_back(s);
  return traces;
}

}  // namespace

template <int D>
KeptCenters<D>::KeptCenters(const Domain<D>& domain, const Incidence<D>& incidence, const KeptVertices<D>& vertices)
    : n_(vertices.position.size()), all_stay_(vertices.all_stay) {
  if (empty()) return;
  const std::vector<std::vector<SegmentId>> traces = traces_of_facets(domain, incidence);
  const double tolerance = absolute_tolerance(domain.box, kOnTolerance);
  std::vector<std::vector<OnSegment>> on_segment(domain.segments.size());
  std::vector<std::vector<Vec<D>>> on_facet(domain.facet_frame.size());
  const auto add_to_segment = [&](SegmentId s, const Vec<D>& x) {
    const Vec<D> a = domain.points[domain.segments[s][0]], b = domain.points[domain.segments[s][1]];
    on_segment[s.value()].push_back({dot(x - a, b - a) / distance(a, b), x});
  };
  for (std::size_t i = 0; i < n_; ++i) {
    const Vec<D>& x = vertices.position[i];
    const PolytopeId carrier = vertices.carrier[i];
    if (carrier.dimension == D) {
      inside_.push_back({x, RegionId(carrier.index)});
    } else if (carrier.dimension == 1) {
      add_to_segment(SegmentId(carrier.index), x);
    } else if (carrier.dimension == 2) {
      const auto& lines = traces[carrier.index];
      const auto trace = std::ranges::find_if(lines, [&](SegmentId s) {
        const auto [a, b] = domain.segments[s];
        return distance_to_segment(x, domain.points[a], domain.points[b]) <= tolerance;
      });
      if (trace != lines.end())
        add_to_segment(*trace, x);
      else
        on_facet[carrier.index].push_back(x);
    }
  }
  for (auto& row : on_segment) {
    std::ranges::sort(row, {}, &OnSegment::position);
    on_segment_.push_row(row);
  }
  for (const auto& row : on_facet) on_facet_.push_row(row);
}

template <int D>
double KeptCenters<D>::nearest(const Domain<D>& domain, const Incidence<D>& incidence, PointId p) const {
  double least = std::numeric_limits<double>::infinity();
  const Vec<D>& x = domain.points[p];
  for (const SegmentId s : incidence.segments_at(p))
    for (const OnSegment& k : on_segment(s)) least = std::min(least, distance(x, k.center));
  for (const FacetId f : incidence.facets_at(p))
    for (const Vec<D>& y : on_facet(f)) least = std::min(least, distance(x, y));
  return least;
}

template class KeptCenters<2>;
template class KeptCenters<3>;

}  // namespace voropack
