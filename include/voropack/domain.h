// Stage 1: the domain as a piecewise linear system (Definition 3.2 of [Miller1996]), built from what a file or a caller
// gives.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voropack/index.h"
#include "voropack/observer.h"
#include "voropack/vec.h"

namespace voropack {

/// Names any polytope of a Domain: its dimension (0 .. D) and its index among those of that dimension.
/// Ordered by dimension, then index, which is the order of algorithm PACKING.
struct PolytopeId {
  std::uint32_t dimension : 2 = 0;
  std::uint32_t index : 30 = 0;

  PolytopeId() = default;
  PolytopeId(int dim, std::size_t i)
      : dimension(static_cast<std::uint32_t>(dim) & 3U), index(static_cast<std::uint32_t>(i) & 0x3fffffffU) {}
  explicit PolytopeId(PointId p) : PolytopeId(0, p.value()) {}
  explicit PolytopeId(SegmentId s) : PolytopeId(1, s.value()) {}
  explicit PolytopeId(FacetId f) : PolytopeId(2, f.value()) {}
  friend bool operator==(const PolytopeId&, const PolytopeId&) = default;
  friend auto operator<=>(const PolytopeId& a, const PolytopeId& b) {
    return ((std::uint32_t{a.dimension} << 30U) | a.index) <=> ((std::uint32_t{b.dimension} << 30U) | b.index);
  }
};

/// What a file or a caller gives: a piecewise linear complex, not yet validated. `build_domain` makes a Domain of it.
template <int D>
struct DomainInput {
  struct Segment {
    std::array<std::uint32_t, 2> points;  ///< Indices into `points`.
    std::optional<int> marker;
    std::optional<std::uint64_t> line;  ///< 1-based line of `file` that it came from.
  };
  /// A planar region of R^3: one or more polygons and seeds of its holes. Two-point polygons are segments, one-point
  /// polygons points inside the facet, as in TetGen's .poly.
  struct Facet {
    std::vector<std::vector<std::uint32_t>> polygons;
    std::vector<Vec<D>> holes;
    std::optional<int> marker;
    std::optional<std::uint64_t> line;
  };
  struct RegionSeed {
    Vec<D> position;
    std::optional<int> id;              ///< The region's id; the next unused one if absent.
    std::optional<double> max_measure;  ///< Largest wanted simplex area (2D) or volume (3D).
  };

  std::vector<Vec<D>> points;
  std::vector<std::optional<int>> point_markers;  ///< Empty, or as long as `points`.
  std::vector<Segment> segments;
  std::vector<Facet> facets;  ///< Empty in 2D.
  std::vector<RegionSeed> region_seeds;
  std::vector<Vec<D>> hole_seeds;
  /// A bare surface (OFF, STL, OBJ, PLY): unreferenced points and collinear boundary points are dropped. In a piecewise
  /// linear complex (.poly, .smesh) every point stays, because its author listed it on purpose.
  bool is_surface = false;
  std::uint32_t first_index = 0;  ///< The number that the file gives its first point: used in messages only.
  std::string file;               ///< Where it came from: used in messages only. Empty if built in code.
};

/// An orthonormal frame of a facet's plane. For a plane normal to a coordinate axis, u and v are coordinate axes, so
/// that lifted points lie in the plane exactly.
struct PlaneFrame {
  Vec<3> origin, u, v, normal;  ///< normal = u x v.
  [[nodiscard]] Vec<2> to_plane(const Vec<3>& x) const { return {dot(x - origin, u), dot(x - origin, v)}; }
  [[nodiscard]] Vec<3> from_plane(const Vec<2>& x) const { return origin + x[0] * u + x[1] * v; }
  /// Signed distance from the plane, positive on the side of `normal`.
  [[nodiscard]] double height(const Vec<3>& x) const { return dot(x - origin, normal); }
};

/// What was done so that facets whose points were rounded are planar.
struct PlaneMerge {
  double distance = 0;              ///< How far points were allowed to move, in units of the domain.
  double angle_deg = 0;             ///< How far from parallel facets were merged.
  std::size_t n_moved = 0;          ///< Points that were moved.
  double largest_displacement = 0;  ///< The largest distance that one was moved.
};

/// The piecewise linear system: polytopes of dimension 0 to D, closed under boundary and intersection.
///
/// A *wall* is a (D-1)-polytope: a segment in 2D, a facet in 3D. Its side 0 is where its normal points (in 2D: to the
/// left of the direction from the segment's first to its second point), its side 1 is the other one.
///
/// Invariants, guaranteed by `build_domain`:
///  1. Points are distinct; no point lies inside a segment; two segments meet only in a common end point.
///  2. A point or segment that lies in a facet is listed in facet_points or facet_segments; otherwise it meets the
///  facet only in
///     listed points. Two facets meet only in points and segments that both list.
///  3. Every facet is planar up to rounding; its boundary is a union of its segments.
///  4. Every wall has a region on at least one of its sides; no polytope lies outside every region's closure.
template <int D>
struct Domain {
  IdVector<PointId, Vec<D>> points;
  IdVector<PointId, int> point_marker;  ///< 0 where none was given.
  IdVector<SegmentId, std::array<PointId, 2>> segments;
  IdVector<SegmentId, int> segment_marker;  ///< Given, or 1, 2, ... in the order of the first input element.

  // Facets: empty in 2D.
  IdVector<FacetId, PlaneFrame> facet_frame;
  IdVector<FacetId, int> facet_marker;     ///< Given, or 1, 2, ... in the order of the first input element.
  Csr<FacetId, SegmentId> facet_segments;  ///< Every segment in the closure: boundary and inside. Sorted.
  Csr<FacetId, PointId> facet_points;      ///< Every point of the closure. Sorted.
  /// A constrained triangulation of each facet with its facet_points as vertices, positively oriented in its frame.
  Csr<FacetId, std::array<PointId, 3>> facet_triangles;

  // Regions.
  std::vector<std::array<RegionId, 2>> wall_regions;  ///< [n_walls] on side 0 and side 1; none() outside and in holes.
  IdVector<RegionId, int> region_id;                  ///< The id that users see, in files and options.
  IdVector<RegionId, double> region_measure;          ///< Area (2D) or volume (3D), by the divergence theorem.
  IdVector<RegionId, std::optional<double>> region_max_simplex;  ///< Largest wanted simplex area or volume.
  /// Points and segments (in 3D also dangling ones) that lie inside a region, on no wall: the region that holds them.
  IdVector<PointId, RegionId> point_region;      ///< none() for a point on a wall.
  IdVector<SegmentId, RegionId> segment_region;  ///< none() for a segment on a wall; in 2D always none().

  Box<D> box;
  std::optional<PlaneMerge> merge;    ///< Absent if no point was moved.
  std::vector<std::string> warnings;  ///< What was merged, moved, split or dropped.
  std::string file;                   ///< Where it came from, for messages. May be empty.

  [[nodiscard]] std::size_t n_walls() const { return wall_regions.size(); }
  [[nodiscard]] int wall_marker(std::size_t wall) const {
    if constexpr (D == 2)
      return segment_marker[SegmentId(wall)];
    else
      return facet_marker[FacetId(wall)];
  }
  /// Length by which sizes and tolerances are scaled: the diagonal of `box`.
  [[nodiscard]] double diameter() const { return box.diagonal(); }
};

struct DomainOptions {
  /// Smallest angle between two polytopes, neither in the other, that is accepted. Degrees.
  double min_angle_deg = 0.0;
  /// Join coplanar facets of the same marker that meet at an edge with no third facet.
  bool merge_coplanar = true;
  /// Facets are coplanar if all their points are this near to one plane, and a facet is planar if all its points are.
  /// Points are moved onto these planes by no more than this. A length, in units of the domain. Rounding of doubles is
  /// tolerated on top. If absent: 1e-5 times the diagonal of the bounding box, or two units of the last digit of the
  /// largest coordinate if that is more and the coordinates show that they were rounded, to nine decimal digits or
  /// fewer or to single precision; at most 1e-3 times the diagonal. docs/theory/domain.md has the measurements.
  std::optional<double> merge_distance = std::nullopt;
  /// Facets are coplanar only if their planes are this near to parallel. Degrees. Facets thinner than four times the
  /// merge distance are exempt: noise turns their planes anywhere.
  double merge_angle_deg = 0.1;
};

/// Validates and completes `input` to a piecewise linear system.
///
/// Points within `kOnTolerance` of each other are merged, points on segments split them, points and segments on facets
/// become part of them (both within the same tolerance, see src/geom/tolerance.h). Points of nearly coplanar facets are
/// moved into common planes, and coplanar facets are joined. Volumes
/// are found from the facets' sides; those with a hole seed become holes; those with a region seed take its id; others
/// are numbered with unused ids from 1 on. A facet whose parts border different regions is cut into one facet for each;
/// they keep its marker. Method: docs/theory/domain.md.
/// Cost: O(n log n) for n elements that meet few others, and a ray for each thing inside a region.
/// Throws: InputError with up to 20 faults: domain.not_finite, domain.too_large, domain.too_small, domain.too_far,
///         domain.index_out_of_range, domain.facet_in_2d, domain.empty, domain.zero_size_segment,
///         domain.zero_size_facet, domain.nonplanar_facet, domain.self_intersection, domain.open_boundary,
///         domain.outside, domain.seed_outside, domain.seed_on_wall, domain.seed_conflict, domain.small_angle (naming
///         the pair, the angle and the place).
///         OptionError domain.bad_option. Cancelled if the observer asks to stop.
template <int D>
Domain<D> build_domain(const DomainInput<D>& input, const DomainOptions& options = {},
                       Observer& observer = silent_observer());

/// The first broken invariant in words, or an empty string. O(n^2). For tests.
template <int D>
std::string find_domain_fault(const Domain<D>& domain);

}  // namespace voropack
