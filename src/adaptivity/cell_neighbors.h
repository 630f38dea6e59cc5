// Which cells of a region share a dual face.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "base/parallel.h"
#include "solve/cell_index.h"
#include "voropack/mesh.h"

namespace voropack {

/// [n_faces] the cells on the two sides of each dual face, in the order of its vertices.
using FaceSides = IdVector<DualFaceId, std::array<CellId, 2>>;

template <int D>
FaceSides cells_of_faces(const ControlVolumes<D>& volumes) {
  const CellIndex cell(volumes);
  FaceSides sides(volumes.face_area.size());
  parallel_for(sides.size(), [&](std::size_t i) {
    const DualFaceId f(i);
    for (std::size_t k = 0; k < 2; ++k) sides[f][k] = cell(volumes.face_vertices[f][k], volumes.face_region[f]);
  });
  return sides;
}

/// [n_cells] the dual faces of each cell, ascending.
inline Csr<CellId, DualFaceId> faces_of_cells(const FaceSides& sides, std::size_t n_cells) {
  Csr<CellId, DualFaceId> result;
  result.offsets.assign(n_cells + 1, 0);
  for (const auto& pair : sides)
    for (const CellId c : pair) ++result.offsets[c.value() + std::size_t{1}];
  for (std::size_t c = 0; c < n_cells; ++c) result.offsets[c + 1] += result.offsets[c];
  result.values.resize(result.offsets.back());
  std::vector<std::uint64_t> next(result.offsets.begin(), result.offsets.end() - 1);
  for (const DualFaceId f : ids(sides))
    for (const CellId c : sides[f]) result.values[next[c.value()]++] = f;
  return result;
}

/// [n_cells] the neighbors of each cell in its region, ascending.
inline Csr<CellId, CellId> cell_neighbors(const FaceSides& sides, std::size_t n_cells) {
  const Csr<CellId, DualFaceId> faces = faces_of_cells(sides, n_cells);
  Csr<CellId, CellId> result;
  result.offsets = faces.offsets;
  result.values.resize(faces.values.size());
  parallel_for(n_cells, [&](std::size_t i) {
    const CellId c(i);
    const auto row = result[c];
    std::ranges::transform(faces[c], row.begin(),
                           [&](DualFaceId f) { return sides[f][0] == c ? sides[f][1] : sides[f][0]; });
    std::ranges::sort(row);
  });
  return result;
}

}  // namespace voropack
