// The boundary and the interfaces of a mesh in space as triangles, curves and points, of which a coarser surface takes
// some vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "voropack/index.h"
#include "voropack/mesh.h"

namespace voropack {

/// Stands for what is no region.
inline constexpr int kNoRegion = -1;

/// Regions are indices into `region_id`; side 0 is where the normal (b-a) x (c-a) points.
struct SurfaceTriangle {
  std::array<std::uint32_t, 3> corners;
  std::array<int, 2> regions;
  int marker = 0;
  std::uint32_t patch = 0;  ///< Triangles of one patch may be replaced by others of it.
};

/// Two vertices, ascending: the same from whichever side an edge is seen.
using EdgeEnds = std::array<std::uint32_t, 2>;

inline EdgeEnds ends_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// An edge where patches end or meet, where the surface has a crease, or that is on no triangle.
struct CurveEdge {
  EdgeEnds ends;
  int marker = 0;
  std::uint32_t curve = 0;  ///< Edges of one curve may be joined.
};

struct SurfaceComplex {
  std::vector<VertexId> vertex;  ///< [n] in the mesh; ascending. Triangles and edges name places in here.
  std::vector<Vec<3>> points;    ///< [n]
  std::vector<SurfaceTriangle> triangles;
  std::vector<CurveEdge> edges;
  std::vector<int> region_id;                ///< Ascending, as users see them.
  std::vector<double> region_volume;         ///< By region.
  std::vector<double> region_boundary_area;  ///< By region.
};

/// What makes patches and curves.
struct SurfaceWish {
  double feature_angle_deg = 180;  ///< Edges where the surface turns by more are on curves.
  bool merge_markers = false;      ///< Faces of different markers may be joined: what is connected gets the same one.
};

/// Boundary faces with the same regions on their sides, and the same marker, are a patch; regions[0] > regions[1], or
/// both are the same. Curves are edges with another number of triangles than two, those between patches, creases, and
/// edges in flat places that the mesh lists as parts of segments. Vertices that are points of their own are included.
/// O(n).
SurfaceComplex find_surface(const Mesh<3>& mesh, const SurfaceWish& wish);

}  // namespace voropack
