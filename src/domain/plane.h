// Planes of facets, and constrained triangulations in them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voropack/domain.h"

namespace voropack::domain_impl {

/// The vector area of a closed polygon (Newell): its length is the area, its direction the normal about which the
/// polygon turns counterclockwise.
Vec<3> area_vector(const std::vector<Vec<3>>& points, const std::vector<std::uint32_t>& polygon);

/// A frame of the plane through `center` normal to `normal`. If all `positions` agree exactly in one coordinate, the
/// plane is normal to that axis, through the first of them exactly.
PlaneFrame plane_frame(const Vec<3>& normal, const Vec<3>& center, const std::vector<Vec<3>>& positions);

struct PlanarEdge {
  std::array<std::uint32_t, 2> ends;
  std::uint32_t n_outline = 0;  ///< How often it occurs in the outline, or
  bool inner = false;           ///< a segment inside, which is also the end of a hole.
};

/// Points of a plane with edges that meet in common ends only.
struct PlanarProblem {
  std::vector<Vec<2>> points;
  std::vector<PlanarEdge> edges;
  std::vector<Vec<2>> holes;
  /// True: inside is what one has to cross the outline an odd number of times to reach. False: inside is what the
  /// outline keeps from infinity and from the hole seeds.
  bool even_odd = false;
};

/// Triangles of the inside, positively oriented. Two are in the same piece if one can walk between them across no edge.
struct PlanarTriangulation {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> triangle_piece;
  std::uint32_t n_pieces = 0;
  /// Two numbers of edges that cross, or an edge and a point on it: then there are no triangles.
  struct Conflict {
    std::uint32_t edge = 0, point = 0;
  };
  std::vector<Conflict> conflicts;
};

/// Triangulates exactly the given points: a constrained Delaunay triangulation by exact predicates. O(n log n) for
/// points in a random or spatial order.
PlanarTriangulation triangulate_plane(const PlanarProblem& problem);

}  // namespace voropack::domain_impl
