// Which polytopes the vertices of a packing are due to.
#pragma once

#include <vector>

#include "voropack/packing.h"

namespace voropack {

/// A point on a polytope of a dimension that stands for a number of vertices.
template <int D>
struct CountedPoint {
  Vec<D> position;
  int dimension = 0;
  double count = 1;
};

/// What the vertices at `points` are due to, beside wishes: at most kMaxFeatures features, the costliest first, which
/// make up kCoverage of all that pairs of polytopes and caps account for. Of many points, 3000 stand for all.
template <int D>
std::vector<CostlyFeature<D>> attribute(const Domain<D>& domain, const Spacing<D>& spacing,
                                        std::vector<CountedPoint<D>> points);

inline constexpr std::size_t kMaxFeatures = 10;
inline constexpr double kCoverage = 0.8;

/// The points by which `estimate_sphere_count` counts. Counts may be negative: facets keep clear of their segments.
template <int D>
std::vector<CountedPoint<D>> estimated_points(const Domain<D>& domain, const Spacing<D>& spacing,
                                              const PackingOptions& options);

}  // namespace voropack
