// build_domain: the steps in order, and the arrays of the result.
#include "voropack/domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "domain/angles.h"
#include "domain/complex.h"
#include "domain/merge.h"
#include "domain/plane.h"
#include "domain/regions.h"
#include "domain/volumes.h"

namespace voropack {

namespace domain_impl {

namespace {

/// Numbers for elements without a marker: 1, 2, ... by the input element that they come from, without those given.
class MarkerNumbers {
 public:
  void reserve(const std::optional<int>& given) {
    if (given) given_.push_back(*given);
  }
  void close() { std::sort(given_.begin(), given_.end()); }
  int number(const std::optional<int>& given, Index element) {
    if (given) return *given;
    const auto it = of_element_.find(element);
    if (it != of_element_.end()) return it->second;
    do ++last_;
    while (std::binary_search(given_.begin(), given_.end(), last_));
    return of_element_[element] = last_;
  }

 private:
  std::vector<int> given_;
  std::unordered_map<Index, int> of_element_;
  int last_ = 0;
};

/// Points that are kept, renumbered, with their markers.
template <int D>
std::vector<PointId> add_points(const Complex<D>& complex, const std::vector<char>& kept, Domain<D>& domain) {
  std::vector<std::optional<int>> markers(complex.points.size());
  const auto& given = complex.input->point_markers;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const Index p = complex.input_to_point[i];
    if (p != kNone && !markers[p]) markers[p] = given[i];
  }
  std::vector<PointId> new_id(complex.points.size());
  for (std::size_t p = 0; p < complex.points.size(); ++p) {
    if (!kept.empty() && kept[p] == 0) continue;
    new_id[p] = domain.points.push_back(complex.points[p]);
    domain.point_marker.push_back(markers[p].value_or(0));
    domain.box.add(complex.points[p]);
  }
  return new_id;
}

template <int D>
void add_segments(const Complex<D>& complex, const std::vector<SegmentChain>& chains,
                  const std::vector<PointId>& new_id, Domain<D>& domain, PolytopeNames& names) {
  MarkerNumbers numbers;
  for (const SegmentChain& chain : chains) numbers.reserve(complex.segments[chain.first].marker);
  numbers.close();
  for (const SegmentChain& chain : chains) {
    const WorkSegment& segment = complex.segments[chain.first];
    domain.segments.push_back({new_id[chain.ends[0]], new_id[chain.ends[1]]});
    domain.segment_marker.push_back(numbers.number(segment.marker, segment.parent));
    names.segment.push_back(complex.parent_name(segment.parent));
    names.segment_line.push_back(complex.parent_line(segment.parent));
  }
}

template <int D>
void add_regions(const RegionTable& table, Domain<D>& domain) {
  domain.region_id = table.id;
  domain.region_measure = table.measure;
  domain.region_max_simplex = table.max_simplex;
}

/// Regions of points and segments that are on no wall.
template <int D>
void add_inner_polytopes(const Complex<D>& complex, const Volumes<D>& volumes, const RegionTable& regions,
                         const std::vector<char>& on_wall, const std::vector<PointId>& new_id, Domain<D>& domain,
                         FaultList<D>& faults) {
  const Names<D> names(*complex.input);
  domain.point_region.resize(domain.points.size(), RegionId::none());
  for (std::size_t p = 0; p < complex.points.size(); ++p)
    if (on_wall[p] == 0 && !new_id[p].is_none())
      domain.point_region[new_id[p]] =
          region_of(complex, volumes, regions, complex.points[p], names.point(complex.point_input[p]), faults);
}

std::vector<Fin> fins_of(const Complex<2>& complex) {
  std::vector<Fin> fins;
  for (Index s = 0; s < complex.segments.size(); ++s) {
    const auto [a, b] = complex.segments[s].ends;
    fins.push_back({.ridge = a, .wall = s, .ccw_side = 0, .apex = b});
    fins.push_back({.ridge = b, .wall = s, .ccw_side = 1, .apex = a});
  }
  std::vector<std::array<Index, 2>> ridges;
  for (Index p = 0; p < complex.points.size(); ++p) ridges.push_back({p, p});
  sort_fins(complex.points, ridges, fins);
  return fins;
}

std::vector<Fin> fins_of(const Complex<3>& complex) {
  std::vector<Fin> fins;
  for (Index t = 0; t < complex.triangles.size(); ++t) {
    const auto& corners = complex.triangles[t];
    const Index piece = complex.triangle_piece[t];
    const WorkFacet& facet = complex.facets[complex.pieces[piece].facet];
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = corners[i], b = corners[(i + 1) % 3];
      const Index s = complex.find_segment(a, b);
      if (s == kNone) continue;
      // The triangle itself may be too thin to tell a direction; the facet's extreme points are far from the segment.
      const Vec<3> edge = complex.points[b] - complex.points[a];
      const Vec<3> inward = cross(facet.frame.normal, edge / norm(edge));
      Index apex = corners[(i + 2) % 3];
      double farthest = 0;
      for (const Index p : facet.extremes)
        if (const double d = dot(inward, complex.points[p] - complex.points[a]); std::abs(d) > std::abs(farthest)) {
          farthest = d;
          apex = p;
        }
      fins.push_back({.ridge = s,
                      .wall = piece,
                      .ccw_side = static_cast<std::uint8_t>(complex.segments[s].ends[0] == a ? 0 : 1),
                      .apex = apex,
                      .opposite = farthest < 0});
    }
  }
  std::vector<std::array<Index, 2>> ridges;
  for (const WorkSegment& s : complex.segments) ridges.push_back(s.ends);
  sort_fins(complex.points, ridges, fins);
  return fins;
}

/// The facet in its frame as a triangulation of its points that are kept.
void triangulate_facet(const Complex<3>& complex, const MergedFacets& merged, Index g,
                       const std::vector<std::pair<Index, int>>& chains,
                       const std::vector<std::vector<Index>>& group_points, const std::vector<PointId>& new_id,
                       Domain<3>& domain) {
  const FacetGroup& group = merged.groups[g];
  std::vector<Index> points;
  for (const Index p : group_points[g])
    if (merged.point_kept[p] != 0) points.push_back(p);
  const auto local = [&](Index p) {
    return static_cast<Index>(std::lower_bound(points.begin(), points.end(), p) - points.begin());
  };
  PlanarProblem problem;
  problem.even_odd = true;
  for (const Index p : points) problem.points.push_back(group.frame.to_plane(complex.points[p]));
  std::vector<SegmentId> segments;
  for (const auto& [c, count] : chains) {
    const SegmentChain& chain = merged.chains[c];
    problem.edges.push_back({{local(chain.ends[0]), local(chain.ends[1])}, count == 1 ? 1U : 0U, count > 1});
    segments.push_back(SegmentId(c));
  }
  const PlanarTriangulation plane = triangulate_plane(problem);
  if (!plane.conflicts.empty() || plane.triangles.empty())
    throw InternalError(
        Fault{.id = "domain.facet_triangulation",
              .message = fmt::format("the facet from input facet {} cannot be triangulated",
                                     complex.facets[group.first_facet].input + complex.input->first_index),
              .fix = "report this with the input file"});
  std::vector<std::array<PointId, 3>> triangles;
  for (const auto& [a, b, c] : plane.triangles)
    triangles.push_back({new_id[points[a]], new_id[points[b]], new_id[points[c]]});
  std::vector<PointId> closure;
  for (const Index p : points) closure.push_back(new_id[p]);
  std::sort(closure.begin(), closure.end());
  std::sort(segments.begin(), segments.end());
  domain.facet_frame.push_back(group.frame);
  domain.facet_points.push_row(closure);
  domain.facet_segments.push_row(segments);
  domain.facet_triangles.push_row(triangles);
}

void add_facets(const Complex<3>& complex, const MergedFacets& merged, const std::vector<Fin>& fins,
                const std::vector<std::array<RegionId, 2>>& side_region, const std::vector<PointId>& new_id,
                Domain<3>& domain, PolytopeNames& names) {
  const std::size_t n = merged.groups.size();
  std::vector<std::vector<Index>> group_points(n);
  for (std::size_t t = 0; t < complex.triangles.size(); ++t) {
    auto& points = group_points[merged.piece_group[complex.triangle_piece[t]]];
    points.insert(points.end(), complex.triangles[t].begin(), complex.triangles[t].end());
  }
  for (auto& points : group_points) {
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
  }
  std::vector<Index> chain_of_segment(complex.segments.size(), kNone);
  for (Index c = 0; c < merged.chains.size(); ++c) chain_of_segment[merged.chains[c].first] = c;
  std::vector<std::vector<std::pair<Index, int>>> group_chains(n);
  for (const Fin& fin : fins) {
    const Index c = chain_of_segment[fin.ridge];
    if (c == kNone) continue;
    auto& chains = group_chains[merged.piece_group[fin.wall]];
    const auto it = std::find_if(chains.rbegin(), chains.rend(), [&](const auto& x) { return x.first == c; });
    if (it == chains.rend())
      chains.emplace_back(c, 1);
    else
      ++it->second;
  }
  MarkerNumbers numbers;
  for (const FacetGroup& group : merged.groups) numbers.reserve(group.marker);
  numbers.close();
  for (Index g = 0; g < n; ++g) {
    const FacetGroup& group = merged.groups[g];
    triangulate_facet(complex, merged, g, group_chains[g], group_points, new_id, domain);
    const Index first = complex.facets[group.first_facet].input;
    domain.facet_marker.push_back(numbers.number(group.marker, first));
    const Index piece = group.pieces.front();
    auto regions = side_region[piece];
    if (dot(group.frame.normal, complex.facets[complex.pieces[piece].facet].frame.normal) < 0)
      std::swap(regions[0], regions[1]);
    domain.wall_regions.push_back(regions);
    names.facet.push_back(Names<3>(*complex.input).facet(first));
    names.facet_line.push_back(complex.input->facets[first].line);
  }
}

Domain<2> assemble(Complex<2>& complex, const DomainOptions&, FaultList<2>& faults, PolytopeNames& names) {
  Walls<2> walls{complex.points, {}, {}, complex.segments.size()};
  std::vector<char> on_wall(complex.points.size(), 0);
  std::vector<SegmentChain> chains;
  for (Index s = 0; s < complex.segments.size(); ++s) {
    walls.simplices.push_back(complex.segments[s].ends);
    walls.simplex_wall.push_back(s);
    chains.push_back({complex.segments[s].ends, s});
    for (const Index p : complex.segments[s].ends) on_wall[p] = 1;
  }
  const std::vector<Fin> fins = fins_of(complex);
  const Volumes<2> volumes(walls, fins);
  const RegionTable regions = assign_regions(complex, volumes, faults);
  const Names<2> input_names(*complex.input);
  check_walls(complex, walls, fins, volumes, regions,
              {[&](Index w) { return complex.parent_name(complex.segments[w].parent); },
               [&](Index p) { return input_names.point(complex.point_input[p]); }},
              faults);

  Domain<2> domain;
  const std::vector<PointId> new_id = add_points(complex, {}, domain);
  add_segments(complex, chains, new_id, domain, names);
  add_regions(regions, domain);
  for (Index s = 0; s < complex.segments.size(); ++s)
    domain.wall_regions.push_back({regions.at(volumes.at(s, 0)), regions.at(volumes.at(s, 1))});
  add_inner_polytopes(complex, volumes, regions, on_wall, new_id, domain, faults);
  domain.segment_region.resize(domain.segments.size(), RegionId::none());
  return domain;
}

Domain<3> assemble(Complex<3>& complex, const DomainOptions& options, FaultList<3>& faults, PolytopeNames& names) {
  cut_facets(complex, faults);
  faults.throw_if_any();
  const Walls<3> walls{complex.points, complex.triangles, complex.triangle_piece, complex.pieces.size()};
  const std::vector<Fin> fins = fins_of(complex);
  const Volumes<3> volumes(walls, fins);
  const RegionTable regions = assign_regions(complex, volumes, faults);
  const Names<3> input_names(*complex.input);
  check_walls(complex, walls, fins, volumes, regions,
              {[&](Index w) { return input_names.facet(complex.facets[complex.pieces[w].facet].input); },
               [&](Index s) { return complex.parent_name(complex.segments[s].parent); }},
              faults);
  faults.throw_if_any();

  std::vector<std::array<RegionId, 2>> side_region;
  for (Index w = 0; w < complex.pieces.size(); ++w)
    side_region.push_back({regions.at(volumes.at(w, 0)), regions.at(volumes.at(w, 1))});
  const MergedFacets merged = merge_facets(complex, fins, side_region, options.merge_coplanar);

  Domain<3> domain;
  const std::vector<PointId> new_id = add_points(complex, merged.point_kept, domain);
  add_segments(complex, merged.chains, new_id, domain, names);
  add_regions(regions, domain);
  add_facets(complex, merged, fins, side_region, new_id, domain, names);
  std::vector<char> on_wall(complex.points.size(), 0), segment_on_wall(complex.segments.size(), 0);
  for (const auto& triangle : complex.triangles)
    for (const Index p : triangle) on_wall[p] = 1;
  for (const Fin& fin : fins) segment_on_wall[fin.ridge] = 1;
  add_inner_polytopes(complex, volumes, regions, on_wall, new_id, domain, faults);
  for (Index c = 0; c < merged.chains.size(); ++c) {
    const SegmentChain& chain = merged.chains[c];
    const Vec<3> middle = 0.5 * (complex.points[chain.ends[0]] + complex.points[chain.ends[1]]);
    domain.segment_region.push_back(segment_on_wall[chain.first] != 0
                                        ? RegionId::none()
                                        : region_of(complex, volumes, regions, middle, names.segment[c], faults));
  }
  return domain;
}

}  // namespace

}  // namespace domain_impl

template <int D>
Domain<D> build_domain(const DomainInput<D>& input, const DomainOptions& options, Observer& observer) {
  using namespace domain_impl;
  if (!(options.min_angle_deg >= 0 && options.min_angle_deg <= 180))
    throw OptionError(Fault{.id = "domain.bad_option",
                            .message = fmt::format("min_angle_deg is {}", options.min_angle_deg),
                            .fix = "give an angle between 0 and 180 degrees; 0 accepts all"});
  if (options.merge_distance && !(*options.merge_distance >= 0 && std::isfinite(*options.merge_distance)))
    throw OptionError(Fault{.id = "domain.bad_option",
                            .message = fmt::format("merge_distance is {}", *options.merge_distance),
                            .fix = "give a length that is not negative"});
  if (!(options.merge_angle_deg >= 0 && options.merge_angle_deg < 90))
    throw OptionError(Fault{.id = "domain.bad_option",
                            .message = fmt::format("merge_angle_deg is {}", options.merge_angle_deg),
                            .fix = "give an angle of at least 0 and less than 90 degrees"});
  observer.begin_stage("domain");
  FaultList<D> faults(input);
  Complex<D> complex = collect_points(input, faults);
  collect_elements(complex, options, faults);
  faults.throw_if_any();
  observer.check_cancelled();
  split_segments(complex, faults);
  faults.throw_if_any();
  observer.check_cancelled();
  PolytopeNames names;
  Domain<D> domain = assemble(complex, options, faults, names);
  faults.throw_if_any();
  observer.check_cancelled();
  check_angles(domain, names, options.min_angle_deg, faults);
  faults.throw_if_any();
  domain.file = input.file;
  domain.merge = complex.merge;
  domain.warnings = complex.warnings;
  for (const std::string& warning : domain.warnings) observer.log(LogLevel::kWarning, warning);
  return domain;
}

template Domain<2> build_domain(const DomainInput<2>&, const DomainOptions&, Observer&);
template Domain<3> build_domain(const DomainInput<3>&, const DomainOptions&, Observer&);

}  // namespace voropack
