// One facet of a three-dimensional domain as a packing problem of the plane.
#pragma once

#include <vector>

#include "packing/book.h"
#include "packing/tied_polygons.h"
#include "spheres/pack_interior.h"
#include "voropack/domain.h"
#include "voropack/packing.h"

namespace voropack {

/// What is packed on a facet: new centers in space and Delaunay triangles.
struct PackedFacet {
  std::vector<Vec<3>> centers;
  std::vector<double> radii;
  /// Corners: below boundary.size() an entry of `boundary`, else a new center. Positively oriented in the facet's
  /// frame.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<TiedPolygon> tied;      ///< Of these corners and triangles.
  std::vector<SphereId> boundary;     ///< The spheres on the facet's points and segments.
  std::vector<SpacingCap<3>> faults;  ///< Where f must shrink, because a subsegment is not Delaunay in the facet.
};

/// What is packed of a facet before its interior.
struct FacetStart {
  std::vector<SphereId> spheres;              ///< Kept ones, those of corners and books, in the facet's interior.
  std::vector<std::array<SphereId, 3>> fans;  ///< Triangles around corners: their circles must stay empty.
  ReservedArea reserved;                      ///< Where only these may be.
};

/// `spheres_of_segment[s]`: the spheres along segment s, both ends included, in order.
PackedFacet pack_facet(const Domain<3>& domain, const Incidence<3>& incidence, FacetId facet, const Packing<3>& packing,
                       const Csr<SegmentId, SphereId>& spheres_of_segment, const FacetStart& start,
                       const Spacing<3>& spacing, const PackingOptions& options, const Observer& observer);

}  // namespace voropack
