// Where two polytopes are nearest to each other, or meet.
#pragma once

#include "packing/incidence.h"

namespace voropack {

/// The point of a polytope of dimension < D that is nearest to x.
template <int D>
Vec<D> nearest_point_of(const Domain<D>& domain, PolytopeId p, const Vec<D>& x);

/// Two points, one on each of two polytopes, that are nearest to each other.
template <int D>
struct Gap {
  Vec<D> middle;  ///< Between the two.
  double size;    ///< Their distance. Length.
};

/// The nearest points of p and q, which do not meet. Where there are many, as between parallel facets, those that one
/// comes to from `near` by projecting it to p, to q and so on.
template <int D>
Gap<D> nearest_gap(const Domain<D>& domain, PolytopeId p, PolytopeId q, const Vec<D>& near);

/// Of the points and segments that two polytopes have in common, which must be some, the point nearest to x.
template <int D>
Vec<D> nearest_common_point(const Domain<D>& domain, const Incidence<D>& incidence, PolytopeId p, PolytopeId q,
                            const Vec<D>& x);

}  // namespace voropack
