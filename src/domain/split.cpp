// Splits segments at the points on them and finds those that cross.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "domain/complex.h"
#include "geom/aabb_tree.h"
#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "geom/predicates.h"

namespace voropack::domain_impl {

namespace {

/// Whether a box may hold a point within `reach` of the segment ab; true for each box around such a point.
template <int D>
auto near_segment(const Vec<D>& a, const Vec<D>& b, double reach) {
  Box<D> around;
  around.add(a);
  around.add(b);
  around.inflate(reach);
  return [a, b, reach, around](const Box<D>& box) {
    return box.overlaps(around) && distance_to_segment(box.center(), a, b) <= 0.5 * box.diagonal() + reach;
  };
}

template <int D>
Box<D> box_of(const Vec<D>& a, const Vec<D>& b) {
  Box<D> box;
  box.add(a);
  box.add(b);
  return box;
}

/// Corners of the polyline from a to b through all points within tolerance of it.
template <int D>
class Splitter {
 public:
  explicit Splitter(const Complex<D>& complex) : complex_(&complex) {
    std::vector<Box<D>> boxes;
    boxes.reserve(complex.points.size());
    for (const Vec<D>& x : complex.points) boxes.push_back(Box<D>(x, x));
    tree_ = AabbTree<D>(std::move(boxes));
  }

  [[nodiscard]] std::vector<Index> split(Index a, Index b) const {
    std::vector<Index> chain = {a, b};
    // A piece may come near to a point that the whole did not reach, since each corner may be off by the tolerance.
    for (bool changed = true; changed;) {
      changed = false;
      std::vector<Index> finer = {a};
      for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
        const std::vector<Index> inside = points_inside(chain[i], chain[i + 1], chain);
        changed = changed || !inside.empty();
        finer.insert(finer.end(), inside.begin(), inside.end());
        finer.push_back(chain[i + 1]);
      }
      chain = std::move(finer);
    }
    return chain;
  }

 private:
  [[nodiscard]] std::vector<Index> points_inside(Index a, Index b, const std::vector<Index>& chain) const {
    const auto& points = complex_->points;
    const Vec<D>&xa = points[a], &xb = points[b];
    std::vector<std::pair<double, Index>> found;
    tree_.visit(near_segment(xa, xb, complex_->tolerance), [&](Index p) {
      if (distance_to_segment(points[p], xa, xb) > complex_->tolerance) return;
      if (p == a || p == b || (chain.size() > 2 && std::find(chain.begin(), chain.end(), p) != chain.end())) return;
      found.emplace_back(nearest_parameter(points[p], xa, xb), p);
    });
    std::sort(found.begin(), found.end());
    std::vector<Index> inside;
    for (const auto& [t, p] : found) inside.push_back(p);
    return inside;
  }

  const Complex<D>* complex_;
  AabbTree<D> tree_;
};

template <int D>
void add_segments(Complex<D>& complex) {
  const Splitter<D> splitter(complex);
  complex.parent_segments.resize(complex.parents.size());
  for (Index parent = 0; parent < complex.parents.size(); ++parent) {
    const ParentEdge& edge = complex.parents[parent];
    const std::vector<Index> chain = splitter.split(edge.ends[0], edge.ends[1]);
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      const auto [it, added] = complex.segment_of_ends.try_emplace(Complex<D>::key(chain[i], chain[i + 1]),
                                                                   static_cast<Index>(complex.segments.size()));
      if (added) complex.segments.push_back({{chain[i], chain[i + 1]}, parent, edge.marker, edge.listed});
      WorkSegment& segment = complex.segments[it->second];
      segment.listed = segment.listed || edge.listed;
      if (!segment.marker) segment.marker = edge.marker;
      complex.parent_segments[parent].push_back(it->second);
    }
  }
}

bool cross_exactly(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d) {
  return orientation(a, b, c) * orientation(a, b, d) <= 0 && orientation(c, d, a) * orientation(c, d, b) <= 0;
}

template <int D>
void find_crossings(const Complex<D>& complex, FaultList<D>& faults) {
  const auto& points = complex.points;
  std::vector<Box<D>> boxes;
  for (const WorkSegment& s : complex.segments) boxes.push_back(box_of(points[s.ends[0]], points[s.ends[1]]));
  const AabbTree<D> tree(std::move(boxes));
  std::set<std::pair<Index, Index>> reported;
  for (Index i = 0; i < complex.segments.size() && !faults.full(); ++i) {
    const auto [a, b] = complex.segments[i].ends;
    tree.visit(near_segment(points[a], points[b], complex.tolerance), [&](Index j) {
      const auto [c, d] = complex.segments[j].ends;
      if (j <= i || a == c || a == d || b == c || b == d) return;
      const SegmentPair<D> nearest = nearest_points(points[a], points[b], points[c], points[d]);
      bool meet = nearest.length() <= complex.tolerance;
      if constexpr (D == 2) meet = meet || cross_exactly(points[a], points[b], points[c], points[d]);
      if (!meet) return;
      const auto [first, second] = std::minmax(complex.segments[i].parent, complex.segments[j].parent);
      if (!reported.emplace(first, second).second) return;
      faults.add("self_intersection",
                 fmt::format("{} and {} cross at {}", complex.parent_name(first), complex.parent_name(second),
                             place_text(nearest.on_first)),
                 "add a point there and split both, or move one of them", nearest.on_first,
                 complex.parent_line(second));
    });
  }
}

}  // namespace

template <int D>
void split_segments(Complex<D>& complex, FaultList<D>& faults) {
  add_segments(complex);
  find_crossings(complex, faults);
}

template void split_segments(Complex<2>&, FaultList<2>&);
template void split_segments(Complex<3>&, FaultList<3>&);

}  // namespace voropack::domain_impl
