// Joins coplanar pieces to facets and drops what thereby is no longer a polytope.
#pragma once

#include <array>
#include <vector>

#include "domain/complex.h"
#include "domain/volumes.h"

namespace voropack::domain_impl {

/// Pieces that make one facet of the result.
struct FacetGroup {
  std::vector<Index> pieces;
  PlaneFrame frame;
  std::optional<int> marker;
  Index first_facet = kNone;  ///< The first input facet in it.
};

/// One or more segments in line that make one segment of the result.
struct SegmentChain {
  std::array<Index, 2> ends;
  Index first = kNone;  ///< The first of its segments.
};

struct MergedFacets {
  std::vector<FacetGroup> groups;  ///< In the order of the input.
  std::vector<Index> piece_group;
  std::vector<SegmentChain> chains;  ///< In the order of the input.
  std::vector<char> point_kept;
};

/// `side_region[piece]` are the regions on both sides; `fins` are sorted by segment.
MergedFacets merge_facets(const Complex<3>& complex, const std::vector<Fin>& fins,
                          const std::vector<std::array<RegionId, 2>>& side_region, bool merge_coplanar);

}  // namespace voropack::domain_impl
