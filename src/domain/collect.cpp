// From a DomainInput to distinct points, parent edges and facets with planes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "domain/complex.h"
#include "geom/tolerance.h"

namespace voropack::domain_impl {

namespace {

template <int D>
void check_points(const DomainInput<D>& input, FaultList<D>& faults) {
  const Names<D> names(input);
  const auto check = [&](const Vec<D>& x, const std::string& name) {
    if (!is_finite(x)) {
      faults.add("not_finite", fmt::format("{} has a coordinate that is not a finite number: {}", name, place_text(x)),
                 "give finite coordinates", x);
      return;
    }
    for (int k = 0; k < D; ++k)
      if (std::abs(x[k]) > kMaxCoordinate) {
        faults.add("too_large", fmt::format("{} lies at {}, beyond {:g}", name, place_text(x), kMaxCoordinate),
                   "scale the domain down", x);
        return;
      }
  };
  for (std::size_t i = 0; i < input.points.size(); ++i) check(input.points[i], names.point(i));
  for (std::size_t i = 0; i < input.hole_seeds.size(); ++i)
    check(input.hole_seeds[i], fmt::format("hole seed {}", names.number(i)));
  for (std::size_t i = 0; i < input.region_seeds.size(); ++i) {
    const auto& seed = input.region_seeds[i];
    check(seed.position, fmt::format("region seed {}", names.number(i)));
    if (seed.max_measure && !std::isfinite(*seed.max_measure))
      faults.add("not_finite",
                 fmt::format("the largest measure of region seed {} is not a finite number", names.number(i)),
                 "give a finite number or none", seed.position);
  }
  for (std::size_t i = 0; i < input.facets.size(); ++i)
    for (const Vec<D>& x : input.facets[i].holes) check(x, "a hole seed of " + names.facet(i));
}

template <int D>
void check_indices(const DomainInput<D>& input, FaultList<D>& faults) {
  const Names<D> names(input);
  const std::size_t n = input.points.size();
  const auto check = [&](std::uint32_t p, const std::string& name, const std::optional<std::uint64_t>& line) {
    if (p < n || faults.full()) return;
    const std::string range = n == 0
                                  ? "there are no points"
                                  : fmt::format("points are numbered {} to {}", names.number(0), names.number(n - 1));
    faults.add("index_out_of_range", fmt::format("{} names point {}, but {}", name, names.number(p), range),
               "correct the index, or the number that the first point has", {}, line);
  };
  for (std::size_t i = 0; i < input.segments.size(); ++i)
    for (const std::uint32_t p : input.segments[i].points)
      check(p, fmt::format("segment {}", names.number(i)), input.segments[i].line);
  for (std::size_t i = 0; i < input.facets.size(); ++i)
    for (const auto& polygon : input.facets[i].polygons)
      for (const std::uint32_t p : polygon) check(p, fmt::format("facet {}", names.number(i)), input.facets[i].line);
  if (D == 2 && !input.facets.empty())
    faults.add("facet_in_2d", "a two-dimensional domain has facets",
               "give its boundary as segments, or give points three coordinates");
  if (!input.point_markers.empty() && input.point_markers.size() != n)
    faults.add("index_out_of_range",
               fmt::format("there are {} point markers for {} points", input.point_markers.size(), n),
               "give one marker for each point, or none at all");
}

/// Finds a point among those added that is within `tolerance`, by hashing cells much wider than that.
template <int D>
class PointGrid {
 public:
  explicit PointGrid(double tolerance) : tolerance_(tolerance), cell_(16 * tolerance) {}

  /// The first of `points` within tolerance of x, or kNone.
  [[nodiscard]] Index find(const std::vector<Vec<D>>& points, const Vec<D>& x) const {
    Index best = kNone;
    for (unsigned corner = 0; corner < (1U << D); ++corner) {
      std::array<std::int64_t, D> cell;
      bool repeated = false;
      for (int k = 0; k < D; ++k) {
        const auto lo = cell_of(x[k] - tolerance_), hi = cell_of(x[k] + tolerance_);
        const bool upper = ((corner >> static_cast<unsigned>(k)) & 1U) != 0;
        repeated = repeated || (upper && lo == hi);
        cell[static_cast<std::size_t>(k)] = upper ? hi : lo;
      }
      if (repeated) continue;
      const auto range = cells_.equal_range(key(cell));
      for (auto it = range.first; it != range.second; ++it)
        if (it->second < best && distance(points[it->second], x) <= tolerance_) best = it->second;
    }
    return best;
  }
  void add(const Vec<D>& x, Index i) {
    std::array<std::int64_t, D> cell;
    for (int k = 0; k < D; ++k) cell[static_cast<std::size_t>(k)] = cell_of(x[k]);
    cells_.emplace(key(cell), i);
  }

 private:
  [[nodiscard]] std::int64_t cell_of(double c) const {
    return cell_ > 0 ? static_cast<std::int64_t>(std::floor(c / cell_)) : 0;
  }
  static std::uint64_t key(const std::array<std::int64_t, D>& cell) {
    std::uint64_t h = 0;
    for (const std::int64_t c : cell) h = hash_words(h, static_cast<std::uint64_t>(c));
    return h;
  }

  double tolerance_, cell_;
  std::unordered_multimap<std::uint64_t, Index> cells_;
};

template <int D>
std::vector<char> referenced_points(const DomainInput<D>& input) {
  std::vector<char> referenced(input.points.size(), 0);
  for (const auto& segment : input.segments)
    for (const std::uint32_t p : segment.points) referenced[p] = 1;
  for (const auto& facet : input.facets)
    for (const auto& polygon : facet.polygons)
      for (const std::uint32_t p : polygon) referenced[p] = 1;
  return referenced;
}

}  // namespace

template <int D>
Complex<D> collect_points(const DomainInput<D>& input, FaultList<D>& faults) {
  Complex<D> complex;
  complex.input = &input;
  check_points(input, faults);
  check_indices(input, faults);
  if (D == 2 ? input.segments.empty() : input.facets.empty())
    faults.add("empty", fmt::format("the domain has no {}", D == 2 ? "segments" : "facets"),
               "give the boundary of at least one region");
  faults.throw_if_any();

  const std::vector<char> referenced = referenced_points(input);
  for (std::size_t i = 0; i < input.points.size(); ++i)
    if (referenced[i] != 0 || !input.is_surface) complex.box.add(input.points[i]);
  if (complex.box.diagonal() < kMinDiameter) {
    faults.add("too_small", fmt::format("all points lie within {:g} of {}", kMinDiameter, place_text(complex.box.lo)),
               "give points that differ, or scale the domain up", complex.box.lo);
    faults.throw_if_any();
  }
  complex.tolerance = absolute_tolerance(complex.box, kOnTolerance);
  if (complex.tolerance > kMaxBlur * complex.box.diagonal()) {
    faults.add("too_far",
               fmt::format("the domain is {:.3g} across and lies near {}, where double precision tells apart no points "
                           "nearer than {:.2g} safely",
                           complex.box.diagonal(), place_text(complex.box.lo), complex.tolerance),
               "move the domain towards the origin", complex.box.lo);
    faults.throw_if_any();
  }

  const Names<D> names(input);
  PointGrid<D> grid(complex.tolerance);
  std::size_t n_dropped = 0, n_merged = 0;
  std::string first_dropped, first_merged;
  complex.input_to_point.assign(input.points.size(), kNone);
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (referenced[i] == 0 && input.is_surface) {
      if (n_dropped++ == 0) first_dropped = names.point(i);
      continue;
    }
    Index p = grid.find(complex.points, input.points[i]);
    if (p == kNone) {
      p = static_cast<Index>(complex.points.size());
      complex.points.push_back(input.points[i]);
      complex.point_input.push_back(static_cast<Index>(i));
      complex.point_listed.push_back(0);
      grid.add(input.points[i], p);
    } else if (n_merged++ == 0) {
      first_merged = fmt::format("point {} into point {}", names.number(i), names.number(complex.point_input[p]));
    }
    if (referenced[i] == 0) complex.point_listed[p] = 1;
    complex.input_to_point[i] = p;
  }
  if (n_dropped > 0)
    complex.warnings.push_back(
        fmt::format("dropped {} points that nothing refers to, the first is {}", n_dropped, first_dropped));
  if (n_merged > 0)
    complex.warnings.push_back(fmt::format("merged {} duplicate points, the first is {}", n_merged, first_merged));
  return complex;
}

namespace {

/// Adds parent edges, each pair of ends once.
template <int D>
class ParentEdges {
 public:
  explicit ParentEdges(Complex<D>& complex) : complex_(&complex) {}
  Index add(const ParentEdge& edge) {
    const auto [it, added] =
        of_ends_.try_emplace(Complex<D>::key(edge.ends[0], edge.ends[1]), static_cast<Index>(complex_->parents.size()));
    if (added) {
      complex_->parents.push_back(edge);
    } else {
      ParentEdge& old = complex_->parents[it->second];
      old.listed = old.listed || edge.listed;
      if (!old.marker) old.marker = edge.marker;
    }
    return it->second;
  }

 private:
  Complex<D>* complex_;
  std::unordered_map<std::uint64_t, Index> of_ends_;
};

/// The polygon in terms of points, without repeated neighbors.
std::vector<Index> corners_of(const std::vector<std::uint32_t>& polygon, const std::vector<Index>& input_to_point) {
  std::vector<Index> corners;
  for (const std::uint32_t p : polygon)
    if (corners.empty() || corners.back() != input_to_point[p]) corners.push_back(input_to_point[p]);
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  return corners;
}

void collect_facets(Complex<3>& complex, FaultList<3>& faults) {
  for (Index f = 0; f < complex.input->facets.size(); ++f) {
    const auto& given = complex.input->facets[f];
    WorkFacet facet;
    facet.input = f;
    facet.marker = given.marker;
    facet.holes = given.holes;
    for (const auto& polygon : given.polygons) {
      std::vector<Index> corners = corners_of(polygon, complex.input_to_point);
      facet.points.insert(facet.points.end(), corners.begin(), corners.end());
      const bool wanted_area = polygon.size() > 2;
      if (corners.size() == 1 && !wanted_area) complex.point_listed[corners[0]] = 1;
      if (corners.size() == 2 && !wanted_area) facet.inner_edges.push_back({corners[0], corners[1]});
      if (wanted_area && corners.size() < 3)
        faults.add(
            "zero_size_facet",
            fmt::format("a polygon of {} has fewer than three different corners", Names<3>(*complex.input).facet(f)),
            "remove the polygon, or correct its corners", complex.points[corners.front()], given.line);
      if (corners.size() >= 3) facet.polygons.push_back(std::move(corners));
    }
    std::sort(facet.points.begin(), facet.points.end());
    facet.points.erase(std::unique(facet.points.begin(), facet.points.end()), facet.points.end());
    complex.facets.push_back(std::move(facet));
  }
}

void collect_facet_edges(Complex<3>& complex, ParentEdges<3>& parents) {
  for (WorkFacet& facet : complex.facets) {
    for (const auto& ends : facet.inner_edges) facet.inner.push_back(parents.add({ends, {}, true, kNone, facet.input}));
    for (const auto& corners : facet.polygons)
      for (std::size_t i = 0; i < corners.size(); ++i)
        facet.outline.push_back(
            parents.add({{corners[i], corners[(i + 1) % corners.size()]}, {}, false, kNone, facet.input}));
  }
}

}  // namespace

template <int D>
void collect_elements(Complex<D>& complex, const DomainOptions& options, FaultList<D>& faults) {
  const Names<D> names(*complex.input);
  ParentEdges<D> parents(complex);
  for (Index s = 0; s < complex.input->segments.size(); ++s) {
    const auto& given = complex.input->segments[s];
    const std::array<Index, 2> ends = {complex.input_to_point[given.points[0]],
                                       complex.input_to_point[given.points[1]]};
    if (ends[0] == ends[1])
      faults.add("zero_size_segment",
                 fmt::format("{} has no length (within the tolerance of {:.3g}) at {}", names.segment(s),
                             complex.tolerance, place_text(complex.points[ends[0]])),
                 "remove it, or correct its ends", complex.points[ends[0]], given.line);
    else
      parents.add({ends, given.marker, true, s, kNone});
  }
  if constexpr (D == 3) {
    collect_facets(complex, faults);
    find_planes(complex, options, faults);
    collect_facet_edges(complex, parents);
  }
}

template <int D>
std::string Complex<D>::parent_name(Index parent) const {
  const Names<D> names(*input);
  const ParentEdge& edge = parents[parent];
  if (edge.segment != kNone) return names.segment(edge.segment);
  return fmt::format("the edge between points {} and {} of {}", names.number(point_input[edge.ends[0]]),
                     names.number(point_input[edge.ends[1]]), names.facet(edge.facet));
}

template <int D>
std::optional<std::uint64_t> Complex<D>::parent_line(Index parent) const {
  const ParentEdge& edge = parents[parent];
  return edge.segment != kNone ? input->segments[edge.segment].line : input->facets[edge.facet].line;
}

template struct Complex<2>;
template struct Complex<3>;
template Complex<2> collect_points(const DomainInput<2>&, FaultList<2>&);
template Complex<3> collect_points(const DomainInput<3>&, FaultList<3>&);
template void collect_elements(Complex<2>&, const DomainOptions&, FaultList<2>&);
template void collect_elements(Complex<3>&, const DomainOptions&, FaultList<3>&);

}  // namespace voropack::domain_impl
