// Which polytopes of a domain meet, where, and at what angle.
#pragma once

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <vector>

#include "voropack/domain.h"

namespace voropack {

/// The side of a segment on which a facet lies: a facet that a segment cuts into has two pages there.
struct Page {
  FacetId facet;
  int side = 0;  ///< 0: to the left of the segment's direction in the facet's frame. 1: to the right.
  friend auto operator<=>(const Page&, const Page&) = default;
};

/// The part of a facet near one of its points between two directions, counterclockwise in the facet's frame.
struct Sector {
  double begin = 0, end = 0;  ///< Angles in the facet's frame, begin < end <= begin + 2 pi.
  SegmentId first, second;    ///< The segments along the two directions; none() if the facet has none there.
};

/// Polytopes that meet at less than this angle (radians), neither in the other, form a sharp feature.
inline constexpr double kSharpAngle = std::numbers::pi / 3;

template <int D>
class Incidence {
 public:
  /// `trace_facets`: by trace the facet it is in. The domain's last segments and last points belong to traces, in this
  /// order (see traces.h).
  explicit Incidence(const Domain<D>& domain, std::vector<FacetId> trace_facets = {});

  [[nodiscard]] std::span<const SegmentId> segments_at(PointId p) const { return point_segments_[p]; }
  [[nodiscard]] std::span<const FacetId> facets_at(PointId p) const { return point_facets_[p]; }
  [[nodiscard]] std::span<const Page> pages_of(SegmentId s) const { return segment_pages_[s]; }

  /// The polytope of the domain that was given: the facet if `p` is a trace or its end.
  [[nodiscard]] PolytopeId given(PolytopeId p) const;
  [[nodiscard]] bool has_traces() const { return !trace_facets_.empty(); }

  /// The points in the closures of both polytopes, ascending.
  [[nodiscard]] std::vector<PointId> common_points(PolytopeId a, PolytopeId b) const;
  /// The segments of both facets.
  [[nodiscard]] std::vector<SegmentId> common_segments(FacetId f, FacetId g) const;
  /// True if `lower` is in the closure of `upper`.
  [[nodiscard]] bool contains(PolytopeId upper, PolytopeId lower) const;

  /// The segments and facets whose closure holds the polytope, itself included if it is one.
  [[nodiscard]] std::vector<PolytopeId> holders(PolytopeId p) const;

  /// Unit vector from p along its segment s.
  [[nodiscard]] Vec<D> direction(SegmentId s, PointId p) const;
  /// The sectors of a facet at one of its points.
  [[nodiscard]] std::vector<Sector> sectors(FacetId f, PointId p) const;
  /// Unit vector from segment s into the page, at a right angle to s.
  [[nodiscard]] Vec<D> inward(const Page& page, SegmentId s) const;

  /// The smallest angle in radians between two polytopes of dimension 1 or 2 where they meet; nothing if they do not
  /// meet or one is in the other. Two facets with common segments are measured there only.
  [[nodiscard]] std::optional<double> meeting_angle(PolytopeId a, PolytopeId b) const;
  /// True if both are segments or facets and meet below kSharpAngle: what is on them may be nearer to each other than
  /// f-spheres allow. A trace counts as its facet.
  [[nodiscard]] bool form_sharp_feature(PolytopeId a, PolytopeId b) const;
  /// True if it forms one with a segment or facet whose closure holds p.
  [[nodiscard]] bool is_sharp_at(PolytopeId a, PointId p) const {
    const std::vector<PolytopeId> around = holders(PolytopeId(p));
    return std::any_of(around.begin(), around.end(), [&](PolytopeId b) { return form_sharp_feature(a, b); });
  }

 private:
  [[nodiscard]] std::span<const PointId> points_of(PolytopeId p) const;
  [[nodiscard]] double angle_at(PointId p, PolytopeId a, PolytopeId b) const;

  const Domain<D>* domain_;
  std::vector<FacetId> trace_facets_;
  Csr<PointId, SegmentId> point_segments_;
  Csr<PointId, FacetId> point_facets_;
  Csr<SegmentId, Page> segment_pages_;
};

}  // namespace voropack
