// Packs the interior of one polytope, in one of the three forms of [Miller1996].
#pragma once

#include <cstdint>
#include <vector>

#include "spheres/packing_problem.h"

namespace voropack {

template <int K>
struct PackedInterior {
  std::vector<Ball<K>> spheres;  ///< The new ones. In the triangulation they follow the problem's fixed ones.
  std::vector<int> regions;      ///< [spheres.size()] the region that holds each.
  /// The Delaunay triangulation of fixed and new spheres inside the regions. Empty unless asked for or Voronoi-maximal.
  Triangulation<K> triangulation;
  double triangulation_s = 0;  ///< Wall time of triangulating and labelling, in seconds.
  std::vector<std::uint32_t>
      broken_faces;  ///< Indices of protected faces that the triangulation lacks; then nothing else is valid.
};

/// `want_triangulation`: also for the forms that do not need it.
template <int K>
PackedInterior<K> pack_interior(const PackingProblem<K>& problem, bool want_triangulation, const Observer& observer);

/// Positions along a segment of the given length that pack it maximally, ends excluded; `spacing` is in arc length from
/// the first end. The gaps are equal in the measure ds / f, hence as small as a packing allows, and so are the
/// protecting balls.
std::vector<double> equidistribute(double length, const LocalSpacing<1>& spacing);

}  // namespace voropack
