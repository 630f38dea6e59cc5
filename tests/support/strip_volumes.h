// Control volumes that are worked out by hand: no mesh, as another program would give them.
#pragma once

#include "voropack/boundary_areas.h"
#include "voropack/mesh.h"

namespace voropack::test {

struct Strip {
  ControlVolumes<2> volumes;
  BoundaryAreas<2> boundary;
};

/// The sites 0, 1, ..., n - 1 on the x axis as vertices of a strip of unit width: each cell reaches halfway to its
/// neighbors. Vertex `interface` (none: 0) lies between region 1, left of it, and region 2. The left end has marker 1,
/// the right end marker 2.
inline Strip strip(std::size_t n, std::size_t interface = 0) {
  Strip out;
  const auto add_cell = [&](std::size_t v, int region, double volume) {
    out.volumes.cell_vertex.push_back(VertexId(v));
    out.volumes.cell_region.push_back(region);
    out.volumes.cell_volume.push_back(volume);
  };
  const auto region_right_of = [&](std::size_t v) { return interface > 0 && v >= interface ? 2 : 1; };
  for (std::size_t v = 0; v < n; ++v) {
    out.volumes.sites.push_back(Vec<2>{static_cast<double>(v), 0.0});
    if (v > 0) add_cell(v, region_right_of(v - 1), 0.5);
    if (v == 0 || v == interface)
      add_cell(v, region_right_of(v), 0.5);
    else if (v + 1 < n)
      out.volumes.cell_volume.back() += 0.5;
    if (v + 1 == n) continue;
    out.volumes.face_vertices.push_back({VertexId(v), VertexId(v + 1)});
    out.volumes.face_region.push_back(region_right_of(v));
    out.volumes.face_area.push_back(1);
    out.volumes.face_edge_length.push_back(1);
  }
  for (const std::size_t v : {std::size_t{0}, n - 1}) {
    out.boundary.patch_vertex.push_back(VertexId(v));
    out.boundary.patch_marker.push_back(v == 0 ? 1 : 2);
    out.boundary.patch_region.push_back(v == 0 ? 1 : region_right_of(v - 1));
    out.boundary.patch_area.push_back(1);
    out.boundary.patch_centroid.push_back(out.volumes.sites[VertexId(v)]);
  }
  return out;
}

}  // namespace voropack::test
