// The boundary of a mesh in the plane as chains of edges, of which a coarser boundary takes some vertices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voropack/index.h"
#include "voropack/mesh.h"

namespace voropack {

/// Stands for what is no region.
inline constexpr int kOutside = -1;

/// A path of boundary edges with the same regions on its sides and the same marker, and no branch in between.
struct VertexChain {
  std::vector<std::uint32_t> vertices;  ///< In order. The first and last one of an open chain are anchors.
  bool is_closed = false;               ///< The last vertex is joined to the first one; there is no anchor.
  std::array<int, 2> regions{};         ///< To the left and to the right: indices into `region_id`, or kOutside.
  int marker = 0;

  /// The fewest vertices that enclose something, if the chain encloses something.
  [[nodiscard]] std::size_t min_vertices() const { return is_closed ? 3 : vertices.front() == vertices.back() ? 4 : 2; }
};

/// A place on a chain.
struct ChainPlace {
  std::uint32_t chain = 0, position = 0;
};

/// What coarsening beyond the boundary needs to know of the finest mesh.
struct ChainedMesh {
  std::vector<Vec<2>> points;
  std::vector<VertexChain> chains;
  Csr<VertexId, ChainPlace>
      places;  ///< Where a vertex is on the boundary: nowhere, once, or as often as chains end there.
  std::vector<int> vertex_region;       ///< Of a vertex that is not on the boundary: index into `region_id`.
  std::vector<std::uint8_t> is_anchor;  ///< Kept on every level: ends of chains, corners and points of their own.
  std::vector<int> region_id;           ///< Ascending, as users see them.
  std::vector<double> region_area;

  [[nodiscard]] bool on_boundary(std::uint32_t v) const { return !places[VertexId(v)].empty(); }
};

/// Every boundary edge is in one chain. Vertices where two edges turn by more than `feature_angle_deg` are anchors.
/// Throws InputError coarsen.not_an_edge if one is no edge of the mesh.
ChainedMesh find_chains(const Mesh<2>& mesh, double feature_angle_deg = 180);

/// How far a vertex is, at most, from the edge that stands for its part of the chain: `from` and `to` are positions,
/// the latter beyond the former, round the end of a closed chain.
double chain_deviation(const ChainedMesh& mesh, const VertexChain& chain, std::size_t from, std::size_t to);
/// The signed area between that edge and its part of the chain.
double chain_area(const ChainedMesh& mesh, const VertexChain& chain, std::size_t from, std::size_t to);

}  // namespace voropack
