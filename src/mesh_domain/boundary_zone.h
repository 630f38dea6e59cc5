// Where a mesh is at its boundary, found in one pass over its simplices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "mesh/vertex_set_table.h"
#include "voropack/mesh.h"

namespace voropack {

/// visit(i, out) may append to `out`, for i < n; returns all that was appended, in the order of i. In parallel.
template <class T, class Visit>
std::vector<T> collect_in_order(std::size_t n, Visit&& visit) {
  constexpr std::size_t kBlock = 16384;
  std::vector<std::vector<T>> parts((n + kBlock - 1) / kBlock);
  parallel_for(
      parts.size(),
      [&](std::size_t block) {
        for (std::size_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) visit(i, parts[block]);
      },
      1);
  std::vector<T> all;
  for (const std::vector<T>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

template <int D>
struct BoundaryZone {
  explicit BoundaryZone(const Mesh<D>& mesh) : faces(mesh.boundary_vertices.size()), is_on(mesh.points.size(), 0) {
    for (const BoundaryId f : ids(mesh.boundary_vertices)) {
      for (const VertexId v : mesh.boundary_vertices[f]) is_on[v.value()] = 1;
      faces.insert(mesh.boundary_vertices[f], f.value());
    }
    simplices = collect_in_order<SimplexId>(mesh.simplex_vertices.size(), [&](std::size_t i, auto& out) {
      int n_on = 0;
      for (const VertexId v : mesh.simplex_vertices[SimplexId(i)]) n_on += is_on[v.value()];
      if (n_on >= D) out.push_back(SimplexId(i));
    });
  }

  /// collect_in_order over `simplices`: visit(simplex, out).
  template <class T, class Visit>
  [[nodiscard]] std::vector<T> collect(Visit&& visit) const {
    return collect_in_order<T>(simplices.size(), [&](std::size_t i, std::vector<T>& out) { visit(simplices[i], out); });
  }

  VertexSetTable<D> faces;           ///< BoundaryIds.
  std::vector<std::uint8_t> is_on;   ///< By vertex: whether it is a corner of a boundary face.
  std::vector<SimplexId> simplices;  ///< Ascending; those with D or more such corners: all at boundary faces, and some.
};

}  // namespace voropack
