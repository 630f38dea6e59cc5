// Stage 6: Mesh<D>, ControlVolumes<D> -> QualityReport: the figures that a user judges a mesh by.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// Counts over equal bins of [lo, hi]; values outside go to the end bins.
struct Histogram {
  double lo = 0, hi = 1;
  std::vector<std::uint64_t> bins;
};

/// Figures of a mesh and its cells. Angles in degrees, lengths in domain units, the rest without unit.
struct QualityReport {
  struct Spread {
    double min = 0, mean = 0, p99 = 0, max = 0;
    Histogram histogram;
  };
  std::uint64_t n_vertices = 0, n_simplices = 0, n_boundary_simplices = 0, n_cells = 0, n_dual_faces = 0;
  struct Region {
    int id = 0;
    std::uint64_t n_simplices = 0;
    double volume = 0;
  };
  std::vector<Region> regions;         ///< Ascending by id.
  Spread radius_edge;                  ///< Circumradius over shortest edge, per simplex.
  Spread edge_length;                  ///< Per edge that has a dual face of positive area.
  Spread angle_deg;                    ///< Angles of triangles (2D) or of faces (3D); mean and p99 to 0.01 degrees.
  std::optional<Spread> dihedral_deg;  ///< 3D.
  double volume_sum = 0;               ///< Sum of cell volumes.
  double domain_volume = 0;            ///< Sum of simplex volumes.
  double min_cell_volume = 0;
  double min_face_area = 0;
  std::uint64_t n_negative_faces = 0;
  std::uint64_t n_zero_faces = 0;  ///< As ControlVolumes::n_zero_areas; the next two likewise.
  double zeroed_area = 0;
  double zeroed_area_bound = 0;
  /// R/r of Theorem 2.4, per cell: smallest enclosing over largest inscribed ball; an upper bound where the region is
  /// not convex at the site (docs/theory/quality.md).
  Spread cell_aspect;
};

/// The same for any number of threads. O(n). Throws Cancelled if the observer asks to stop.
template <int D>
QualityReport measure_quality(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                              Observer& observer = silent_observer());

/// The largest ratios over the simplices of a mesh. Slivers have a small radius_edge and a large radius_ratio.
struct ShapeRatios {
  double radius_edge = 0;   ///< Circumradius over shortest edge.
  double radius_ratio = 0;  ///< Circumradius over inradius; infinite if a simplex is flat or negatively oriented.
};
template <int D>
ShapeRatios max_shape_ratios(const Mesh<D>& mesh);

/// The smallest dihedral angle of a tetrahedron, in degrees. Accurate however small.
double min_dihedral_deg(const Mesh<3>& mesh, SimplexId s);

}  // namespace voropack
