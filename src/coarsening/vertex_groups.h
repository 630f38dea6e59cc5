// Vertices along a space-filling curve, a few at a time, and which of them have become impossible on a level.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/lanes.h"
#include "spheres/sphere_set.h"
#include "voropack/index.h"
#include "voropack/vec.h"

namespace voropack {

/// N numbers that are compared at once.
template <std::size_t N>
using LaneArray = std::array<Lanes, N / Lanes::kSize>;

/// Groups of vertices that are near to each other, the leaves of a tree of boxes.
template <int D>
struct VertexGroups {
  static constexpr std::size_t kSize = 16;  ///< Vertices of a group; the last one may have fewer.
  static constexpr std::size_t kChildren = 8;

  VertexGroups() = default;
  /// `along_curve`: each vertex is near to the one before. O(n), in parallel.
  VertexGroups(std::vector<VertexId> along_curve, const IdVector<VertexId, Vec<D>>& points);

  [[nodiscard]] std::size_t size() const { return balls.size(); }
  /// Of group g.
  [[nodiscard]] std::span<const VertexId> members(std::size_t g) const {
    return std::span(vertices).subspan(g * kSize, std::min(kSize, vertices.size() - g * kSize));
  }

  std::vector<VertexId> vertices;  ///< All, along the curve: group g has those from g kSize on.
  std::vector<std::array<LaneArray<kSize>, static_cast<std::size_t>(D)>> coordinates;  ///< By group, then axis.
  std::vector<Ball<D>> balls;                                                          ///< By group: around them.
  std::vector<Box<D>> boxes;  ///< Of the groups; then of so many of these each, and so on up to that of all.
};

/// Which vertices of `groups` can still join a level. Spheres and balls come one after the other, and each takes out
/// all vertices that it is in the way of: what is left needs no search.
template <int D>
class Vacancies {
 public:
  /// `f`: the radii that vertices would have. O(n), in parallel.
  Vacancies(const VertexGroups<D>& groups, const IdVector<VertexId, double>& f);

  /// Whether nothing is in the way of the vertex with this number along the curve.
  [[nodiscard]] bool contain(std::uint32_t number) const { return (gone_[number / kSize] >> number % kSize & 1U) == 0; }
  /// The f-sphere of that vertex.
  [[nodiscard]] Ball<D> sphere(std::uint32_t number) const;
  /// Takes out what overlaps an f-sphere.
  void take_sphere(const Ball<D>& sphere);
  /// Takes out what lies in a protecting ball or too near to it.
  void take_ball(const Ball<D>& ball);

 private:
  using Groups = VertexGroups<D>;
  static constexpr std::size_t kSize = Groups::kSize, kChildren = Groups::kChildren, kAxes = D;

  /// The boxes of the children, groups or nodes of the layer below, as large as the f-spheres in them together: only
  /// spheres that meet one can be in the way there. An absent child has an empty box.
  struct Node {
    std::array<LaneArray<kChildren>, kAxes> lo, hi;
  };

  template <class Test>
  void take(const Ball<D>& ball, const Test& test) {
    if (!layers_.empty()) take_below(layers_.size() - 1, 0, ball, test);
  }
  template <class Test>
  void take_below(std::size_t layer, std::size_t node, const Ball<D>& ball, const Test& test);

  const Groups& groups_;
  std::vector<LaneArray<kSize>> radii_;  ///< By group.
  std::vector<Node> nodes_;              ///< Layer by layer; those above groups first, the root last.
  std::vector<std::size_t> layers_;      ///< Where each layer begins among the nodes.
  std::vector<std::uint16_t> gone_;      ///< By group, a bit for each vertex that cannot join.
  std::vector<std::uint8_t> is_empty_;   ///< By node, a bit for each child with no vertices left.
};

}  // namespace voropack
