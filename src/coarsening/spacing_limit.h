// What the domain allows f to be at the vertices of the finest mesh, evaluated only where a level gets near to it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "coarsening/fine_mesh.h"
#include "voropack/spacing.h"

namespace voropack {

/// A spacing function at the vertices of a mesh. One value per group of vertices bounds it from below, since it is
/// Lipschitz; far from the boundary no level asks for more.
template <int D>
class SpacingLimit {
 public:
  SpacingLimit(const FineMesh<D>& fine, Spacing<D> spacing)
      : fine_(fine),
        spacing_(std::move(spacing)),
        at_least_(fine.mesh.points.size(), 0.0),
        is_known_(at_least_.size(), 0) {
    constexpr double kSlack = 1e-9;  // For rounding.
    parallel_for(fine.groups.size(), [&](std::size_t g) {
      const auto& [center, radius] = fine.groups.balls[g];
      const double bound = (1 - kSlack) * spacing_(center) - spacing_.lipschitz() * radius;
      for (const VertexId v : fine.groups.members(g)) at_least_[v] = bound;
    });
  }

  /// The least of `f` and the spacing function at v. Threads may ask at a time, but for different vertices.
  double operator()(VertexId v, double f) {
    if (f <= at_least_[v]) return f;
    if (std::exchange(is_known_[v.value()], 1) == 0) at_least_[v] = spacing_(fine_.mesh.points[v]);
    return std::min(f, at_least_[v]);
  }

 private:
  const FineMesh<D>& fine_;
  Spacing<D> spacing_;
  IdVector<VertexId, double> at_least_;  ///< Its value, or a lower bound.
  std::vector<std::uint8_t> is_known_;   ///< Whether it is the value.
};

}  // namespace voropack
