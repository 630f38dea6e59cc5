// Which vertices lie on two polytopes that meet at a small angle. The polytopes are found in the mesh itself: facets
// are boundary simplices joined across edges that are no part of a segment, segments are straight chains of edges.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "certificate/topology.h"
#include "voropack/mesh.h"

namespace voropack::judge {

/// Polytopes that meet below this angle (radians), neither in the other, form a sharp feature.
inline constexpr double kSharpAngle = 1.0471975511965976;  // 60 degrees.

template <int D>
class SharpFeatures {
 public:
  SharpFeatures(const Mesh<D>& mesh, const Topology<D>& topology);

  [[nodiscard]] bool empty() const { return angles_.empty(); }
  /// The smallest angle below kSharpAngle between a polytope that holds u and one that holds v; nothing if there is
  /// none. Both are taken closed: a vertex on a segment lies on the facets around it.
  [[nodiscard]] std::optional<double> angle(std::uint32_t u, std::uint32_t v) const;
  /// The same for the polytopes that carry u and v in their relative interior.
  [[nodiscard]] std::optional<double> carrier_angle(std::uint32_t u, std::uint32_t v) const;

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  struct Builder;

  [[nodiscard]] std::optional<double> between(std::uint32_t p, std::uint32_t q) const {
    const auto it = angles_.find(std::minmax(p, q));
    return it == angles_.end() ? std::nullopt : std::optional(it->second);
  }
  [[nodiscard]] std::span<const std::uint32_t> polytopes_of(std::uint32_t v) const {
    return {closures_.data() + first_[v], closures_.data() + first_[v + 1]};
  }

  std::map<Pair, double> angles_;        ///< Of pairs of polytopes that meet below kSharpAngle.
  std::vector<std::uint32_t> first_;     ///< [n_vertices + 1] into closures_
  std::vector<std::uint32_t> closures_;  ///< By vertex: the polytopes that hold it and have a sharp partner.
  std::vector<std::uint32_t> carrier_;   ///< [n_vertices] kNone at corners and inside.
};

}  // namespace voropack::judge
