// Points that touch a facet which does not name them.
#pragma once

#include "domain/sheets.h"
#include "geom/aabb_tree.h"

namespace voropack::domain_impl {

/// Finds the points that lie on sheets without being named by their facets, so that they move along with them.
class Attacher {
 public:
  explicit Attacher(const Complex<3>& complex);

  /// Adds to sheet.points those within `reach` of its plane and, in the plane, of its facets.
  void attach(Sheet& sheet, double reach) const;

 private:
  const Complex<3>& complex_;
  AabbTree<3> tree_;
};

}  // namespace voropack::domain_impl
