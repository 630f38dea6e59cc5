// The working form of a domain while `build_domain` completes it: plain arrays that each step extends.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "domain/faults.h"
#include "voropack/domain.h"

namespace voropack::domain_impl {

using Index = std::uint32_t;
inline constexpr Index kNone = std::numeric_limits<Index>::max();

/// A segment or facet edge as the input gives it, before points split it.
struct ParentEdge {
  std::array<Index, 2> ends;
  std::optional<int> marker;
  bool listed = false;    ///< The input names it as a segment, not only as an edge of a facet: it is never dropped.
  Index segment = kNone;  ///< The input segment, or
  Index facet = kNone;    ///< the first input facet with this edge.
};

/// A piece of parent edges with no point inside.
struct WorkSegment {
  std::array<Index, 2> ends;
  Index parent = kNone;  ///< The first parent edge that covers it. It has that one's direction.
  std::optional<int> marker;
  bool listed = false;
};

/// An input facet, or a triangle of one that was split, in terms of points and parent edges.
struct WorkFacet {
  Index input = kNone;
  std::optional<int> marker;
  std::vector<std::vector<Index>> polygons;       ///< With three corners or more.
  std::vector<std::array<Index, 2>> inner_edges;  ///< Its polygons with two.
  double area = 0;                                ///< Of its largest polygon.
  std::optional<Index> sheet;                     ///< Facets of the same sheet have the same plane.
  std::vector<Index> outline;                     ///< Parent edges of its polygons, as often as they occur.
  std::vector<Index> inner;                       ///< Parent edges that it lists as segments inside.
  std::vector<Index> points;                      ///< All that it names, sorted.
  std::vector<Vec<3>> holes;
  PlaneFrame frame;
  std::vector<Index> extremes;  ///< Some of its points, among them one that is nearly farthest from any line.
};

/// A part of one facet that no segment cuts: the atoms of which the facets of the result are made.
struct Piece {
  Index facet = kNone;
  double area = 0;
};

template <int D>
struct Complex {
  const DomainInput<D>* input = nullptr;
  Box<D> box;
  double tolerance = 0;  ///< A point this near to something lies on it.
  std::vector<std::string> warnings;
  std::optional<PlaneMerge> merge;  ///< What moving points to common planes did.

  std::vector<Vec<D>> points;         ///< Farther than `tolerance` from each other.
  std::vector<Index> point_input;     ///< The first input point there.
  std::vector<Index> input_to_point;  ///< kNone for those that were dropped.
  std::vector<char> point_listed;     ///< Named as a point inside a facet, or by nothing: it is never dropped.

  std::vector<ParentEdge> parents;  ///< In the order of the input: its segments, then edges of its facets.
  std::vector<WorkSegment> segments;
  std::vector<std::vector<Index>> parent_segments;  ///< For each parent edge, the segments that it consists of.
  std::unordered_map<std::uint64_t, Index> segment_of_ends;

  std::vector<WorkFacet> facets;
  std::vector<Piece> pieces;
  std::vector<std::array<Index, 3>> triangles;  ///< Positively oriented in the frame of their facet.
  std::vector<Index> triangle_piece;

  static std::uint64_t key(Index a, Index b) {
    return a < b ? (std::uint64_t{a} << 32U) | b : (std::uint64_t{b} << 32U) | a;
  }
  /// The segment with these ends, or kNone.
  [[nodiscard]] Index find_segment(Index a, Index b) const {
    const auto it = segment_of_ends.find(key(a, b));
    return it == segment_of_ends.end() ? kNone : it->second;
  }
  /// What the user knows a parent edge by, and its line.
  [[nodiscard]] std::string parent_name(Index parent) const;
  [[nodiscard]] std::optional<std::uint64_t> parent_line(Index parent) const;
};

/// Checks that numbers are usable, merges equal points and drops unreferenced ones of a surface.
template <int D>
Complex<D> collect_points(const DomainInput<D>& input, FaultList<D>& faults);

/// Makes parent edges and facets with their planes; finds elements without extent and facets that are not planar.
template <int D>
void collect_elements(Complex<D>& complex, const DomainOptions& options, FaultList<D>& faults);

/// Finds the planes of facets and moves points onto the planes that facets share. A facet whose points cannot be moved
/// so is replaced by triangles. Finds facets without area and facets that are not planar within the merge distance.
void find_planes(Complex<3>& complex, const DomainOptions& options, FaultList<3>& faults);

/// Splits parent edges at the points on them and finds segments that cross.
template <int D>
void split_segments(Complex<D>& complex, FaultList<D>& faults);

/// Cuts each facet along all segments in it into pieces and triangulates them; finds facets that are pierced or
/// overlap.
void cut_facets(Complex<3>& complex, FaultList<3>& faults);

}  // namespace voropack::domain_impl
