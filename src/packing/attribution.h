// Which polytopes the vertices of a packing are due to.
#pragma once

#include <optional>
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

/// How many vertices a packing will have, and where.
template <int D>
struct CountEstimate {
  std::vector<CountedPoint<D>> points;  ///< Counts may be negative: facets keep clear of their segments.
  std::optional<double> plateau;        ///< Of the values that f has on parts of regions that of most vertices.
  [[nodiscard]] double count() const;
};

template <int D>
CountEstimate<D> estimate_count(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options);

}  // namespace voropack
