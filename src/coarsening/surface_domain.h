// A simplified surface as a domain, each triangle a facet, and what it leaves of a region.
#pragma once

#include <vector>

#include "coarsening/simplify_surface.h"
#include "geom/wall_locator.h"
#include "spheres/sphere_set.h"
#include "voropack/domain.h"
#include "voropack/packing.h"

namespace voropack {

/// The points are the vertices of `surface`, the facets its triangles, the segments its curve edges and then all others
/// of its edges, in this order.
Domain<3> domain_of_surface(const SurfaceComplex& fine, const LevelSurface& surface);

/// A packing of nothing but the surface's vertices, with radii 0: its triangles and curve edges are protected.
Packing<3> packing_of_surface(const SurfaceComplex& fine, const LevelSurface& surface);

/// The balls of the edges inside of patches (edge_balls.h).
std::vector<Ball<3>> edge_balls_of_surface(const SurfaceComplex& fine, const LevelSurface& surface);

/// The triangles with the regions beside them.
Walls<3> walls_of_surface(const SurfaceComplex& fine, const LevelSurface& surface);

}  // namespace voropack
