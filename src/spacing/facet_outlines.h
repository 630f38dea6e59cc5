// Where the distance to a facet is the distance to its plane.
#pragma once

#include <array>
#include <vector>

#include "spacing/polytope_set.h"
#include "voropack/domain.h"

namespace voropack {

/// The boundary of each facet in its plane, with edges inside the facet left out.
class FacetOutlines {
 public:
  FacetOutlines(const Domain<3>& domain, const PolytopeSet<3>& polytopes);

  /// True only if every point of the box projects into the facet (up to rounding), so that its distance is |height|.
  [[nodiscard]] bool projects_inside(const Box<3>& box, FacetId facet) const;

 private:
  using Edge = std::array<Vec<2>, 2>;
  const Domain<3>* domain_;
  const PolytopeSet<3>* polytopes_;
  double tolerance_;
  std::vector<char> is_flat_;    // [n_facets] all points lie in the frame's plane up to rounding.
  Csr<FacetId, Edge> boundary_;  // In the frame's coordinates.
};

}  // namespace voropack
