// The types that cross stages: the simplicial mesh and its Voronoi control volumes.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "voropack/index.h"
#include "voropack/vec.h"

namespace voropack {

/// A simplicial mesh as parallel arrays. Immutable once built.
///
/// Invariants, checked by `find_mesh_fault`:
///  1. Simplices are positively oriented; corners are valid and distinct; no simplex occurs twice.
///  2. simplex_neighbors is mutual; entry i shares the face opposite to corner i, or is none() on the hull of the mesh.
///  3. boundary_vertices lists every face that has a simplex on one side only or different regions on its sides, and
///  the
///     subdivision of internal facets.
template <int D>
struct Mesh {
  IdVector<VertexId, Vec<D>> points;                                  ///< [n_vertices] position, in domain units.
  IdVector<SimplexId, std::array<VertexId, D + 1>> simplex_vertices;  ///< [n_simplices] positive orientation.
  IdVector<SimplexId, std::array<SimplexId, D + 1>>
      simplex_neighbors;                    ///< [n_simplices] entry i is opposite to corner i.
  IdVector<SimplexId, int> simplex_region;  ///< [n_simplices] the region's id as users see it.

  IdVector<BoundaryId, std::array<VertexId, D>>
      boundary_vertices;                                    ///< [n_boundary] subfacets (3D) or subsegments (2D).
  IdVector<BoundaryId, int> boundary_marker;                ///< [n_boundary] marker of the facet or segment; 0 unknown.
  IdVector<EdgeId, std::array<VertexId, 2>> segment_edges;  ///< 3D: the edges that segments consist of. Empty in 2D.
  IdVector<EdgeId, int> segment_edge_marker;                ///< [n_segment_edges]

  // Absent (empty) where a file does not say.
  IdVector<VertexId, double> vertex_spacing;  ///< [n_vertices] f at the vertex, length.
  IdVector<VertexId, int> vertex_marker;      ///< [n_vertices] marker of the carrying polytope; 0 inside.
  IdVector<VertexId, std::uint8_t> vertex_carrier_dimension;  ///< [n_vertices] 0 point, 1 segment, 2, 3.

  friend bool operator==(const Mesh&, const Mesh&) = default;
};

/// The first broken invariant in words, or an empty string. O(n log n).
template <int D>
std::string find_mesh_fault(const Mesh<D>& mesh);

/// Fills simplex_neighbors from simplex_vertices, which must be positively oriented. The same result for any number of
/// threads. Throws InputError mesh.nonmanifold if three simplices share a face, mesh.overlapping_simplices if two lie
/// on the same side of one.
template <int D>
void build_neighbors(Mesh<D>& mesh);

/// Voronoi control volumes, region by region. A solver needs nothing else; simplices are not mentioned.
///
/// A *cell* is the part of one vertex's Voronoi cell that lies in one region; a *dual face* is the part of the Voronoi
/// face of an edge that lies in one region. Inside a region there is one of each per vertex and edge; on an interface
/// one per adjacent region.
template <int D>
struct ControlVolumes {
  IdVector<VertexId, Vec<D>> sites;        ///< [n_vertices]
  IdVector<CellId, VertexId> cell_vertex;  ///< [n_cells] sorted by vertex, then region.
  IdVector<CellId, int> cell_region;       ///< [n_cells] the region's id as users see it.
  IdVector<CellId, double> cell_volume;    ///< [n_cells] |V_i| in that region: length^D, > 0.

  IdVector<DualFaceId, std::array<VertexId, 2>> face_vertices;  ///< [n_faces] the edge (i, j), i < j; sorted.
  IdVector<DualFaceId, int> face_region;                        ///< [n_faces]
  IdVector<DualFaceId, double> face_area;                       ///< [n_faces] |A_ij| in that region: length^(D-1), > 0.
  IdVector<DualFaceId, double> face_edge_length;                ///< [n_faces] h_ij.

  // How the numbers were obtained, for the report.
  std::uint64_t n_zero_areas = 0;  ///< Dual faces without area, up to certified errors, and therefore not listed.
  double zeroed_area = 0;          ///< Sum of the magnitudes that rounding gave these areas.
  double zeroed_area_bound = 0;    ///< Sum of the certified errors within which they are zero: not less.
  std::uint64_t n_exact_evaluations = 0;  ///< Dual edges that needed more than double precision.
};

}  // namespace voropack
