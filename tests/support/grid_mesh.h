// Meshes of the unit cube of any size, and box-shaped cells, for tests of output and speed.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>

#include "mesh/faces.h"
#include "voropack/dual.h"
#include "voropack/mesh.h"

namespace voropack::test {

/// The unit square or cube as a grid of n^D boxes, each cut into D! simplices (Kuhn). Region 1 for x < 1/2, else 2;
/// hull faces have marker 3, the interface marker 4; the spacing is 1/(2n).
template <int D>
Mesh<D> grid_mesh(std::size_t n) {
  Mesh<D> mesh;
  const std::size_t side = n + 1;
  const std::size_t n_points = D == 2 ? side * side : side * side * side;
  for (std::size_t p = 0; p < n_points; ++p) {
    const std::array<std::size_t, 3> at = {p % side, p / side % side, p / side / side};
    Vec<D> x;
    for (int k = 0; k < D; ++k) x[k] = static_cast<double>(at[static_cast<std::size_t>(k)]) / static_cast<double>(n);
    mesh.points.push_back(x);
    mesh.vertex_spacing.push_back(0.5 / static_cast<double>(n));
    mesh.vertex_marker.push_back(0);
    mesh.vertex_carrier_dimension.push_back(D);
  }
  const std::array<std::size_t, 3> stride = {1, side, side * side};
  for (std::size_t p = 0; p < n_points; ++p) {
    const std::array<std::size_t, 3> at = {p % side, p / side % side, p / side / side};
    if (std::any_of(at.begin(), at.begin() + D, [&](std::size_t i) { return i == n; })) continue;
    std::array<std::size_t, D> axes;
    std::iota(axes.begin(), axes.end(), std::size_t{0});
    do {
      std::array<VertexId, D + 1> corners;
      std::size_t v = p;
      corners[0] = VertexId(v);
      for (std::size_t k = 0; k < D; ++k) corners[k + 1] = VertexId(v += stride[axes[k]]);
      // The path along a permuted order of the axes is positive if the permutation is even.
      bool odd = false;
      for (std::size_t i = 0; i < D; ++i)
        for (std::size_t j = i + 1; j < D; ++j) odd ^= axes[i] > axes[j];
      if (odd) std::swap(corners[D - 1], corners[D]);
      mesh.simplex_vertices.push_back(corners);
      mesh.simplex_region.push_back(2 * at[0] < n ? 1 : 2);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  build_neighbors(mesh);
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const SimplexId neighbor = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      const bool interface =
          !neighbor.is_none() && s < neighbor && mesh.simplex_region[s] != mesh.simplex_region[neighbor];
      if (!neighbor.is_none() && !interface) continue;
      mesh.boundary_vertices.push_back(boundary_face<D>(mesh.simplex_vertices[s], i));
      mesh.boundary_marker.push_back(interface ? 4 : 3);
    }
  if constexpr (D == 3)
    for (std::size_t i = 0; i < n; ++i) {
      mesh.segment_edges.push_back({VertexId(i), VertexId(i + 1)});
      mesh.segment_edge_marker.push_back(5);
    }
  return mesh;
}

template <int D>
struct BoxCells {
  CellShapes<D> shapes;
  ControlVolumes<D> volumes;
};

/// n^D boxes as the cells of a control-volume mesh, with volumes of the unit square or cube.
template <int D>
BoxCells<D> box_cells(std::size_t n) {
  BoxCells<D> cells;
  cells.shapes.points = grid_mesh<D>(n).points.raw();
  const std::size_t side = n + 1, depth = D == 2 ? 1 : n;
  for (std::size_t z = 0; z < depth; ++z)
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) {
        const auto corner = [&](std::size_t i, std::size_t j, std::size_t k) {
          return static_cast<std::uint32_t>(x + i + side * (y + j) + side * side * (z + k));
        };
        if constexpr (D == 2) {
          cells.shapes.cell_faces.push_row(
              std::array{corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 1, 0)});
        } else {
          const std::array<std::array<std::uint32_t, 4>, 6> faces = {
              {{corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)},
               {corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)},
               {corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)},
               {corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)},
               {corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)},
               {corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)}}};
          std::array<std::uint32_t, 6> row;
          for (std::size_t f = 0; f < 6; ++f) {
            row[f] = static_cast<std::uint32_t>(cells.shapes.face_points.size());
            cells.shapes.face_points.push_row(faces[f]);
          }
          cells.shapes.cell_faces.push_row(row);
        }
        const std::size_t c = cells.volumes.sites.size();
        Vec<D> center;
        const std::array<std::size_t, 3> at = {x, y, z};
        for (int k = 0; k < D; ++k)
          center[k] = (static_cast<double>(at[static_cast<std::size_t>(k)]) + 0.5) / static_cast<double>(n);
        cells.volumes.sites.push_back(center);
        cells.volumes.cell_vertex.push_back(VertexId(c));
        cells.volumes.cell_region.push_back(x < n / 2 ? 1 : 2);
        cells.volumes.cell_volume.push_back(std::pow(static_cast<double>(n), -D));
      }
  return cells;
}

}  // namespace voropack::test
