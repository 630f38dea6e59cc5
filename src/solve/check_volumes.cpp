#include "solve/check_volumes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "solve/cell_index.h"
#include "voropack/error.h"

namespace voropack {

namespace {

[[noreturn]] void fail(std::string message) {
  throw InputError(Fault{.id = "solve.bad_volumes",
                         .message = std::move(message),
                         .fix = "see the descriptions of ControlVolumes and BoundaryAreas"});
}

void check_lengths(std::string_view what, std::initializer_list<std::size_t> lengths) {
  for (const std::size_t n : lengths)
    if (n != *lengths.begin())
      fail(fmt::format("the arrays of {} have the lengths {} and {}", what, *lengths.begin(), n));
}

template <int D>
void check_cells(const ControlVolumes<D>& volumes) {
  const std::size_t n = volumes.cell_vertex.size();
  const std::size_t bad = first_bad(n, [&](std::size_t i) {
    const CellId c(i);
    if (volumes.cell_vertex[c].value() >= volumes.sites.size()) return false;
    if (!(volumes.cell_volume[c] > 0 && std::isfinite(volumes.cell_volume[c]))) return false;
    if (i == 0) return volumes.cell_vertex[c] == VertexId(0);
    // Sorted by vertex, then region, and no vertex is missing.
    const CellId before(i - 1);
    const std::uint32_t step = volumes.cell_vertex[c].value() - volumes.cell_vertex[before].value();
    return step == 1 || (step == 0 && volumes.cell_region[before] < volumes.cell_region[c]);
  });
  if (bad != n)
    fail(fmt::format(
        "cell {} (counted from 0) is not sorted by vertex and region, leaves out a vertex, or has no positive volume",
        bad));
  if (n == 0 || volumes.cell_vertex.back().value() + 1 != volumes.sites.size()) fail("the last vertex has no cell");
}

/// An edge as one number that sorts as (i, j).
std::uint64_t edge_key(const std::array<VertexId, 2>& edge) {
  return std::uint64_t{edge[0].value()} << 32U | edge[1].value();
}

template <int D>
void check_faces(const ControlVolumes<D>& volumes, const CellIndex& index) {
  const std::size_t n = volumes.face_vertices.size(), n_vertices = volumes.sites.size();
  const std::size_t bad = first_bad(n, [&](std::size_t k) {
    const DualFaceId f(k);
    const auto [i, j] = volumes.face_vertices[f];
    if (!(i < j && j.value() < n_vertices)) return false;
    if (k > 0 && edge_key(volumes.face_vertices[f]) < edge_key(volumes.face_vertices[DualFaceId(k - 1)])) return false;
    const double length = volumes.face_edge_length[f];
    return std::isfinite(volumes.face_area[f]) && std::isfinite(length) && length > 0 &&
           index.contains(i, volumes.face_region[f]) && index.contains(j, volumes.face_region[f]);
  });
  if (bad != n)
    fail(
        fmt::format("dual face {} (counted from 0) is not sorted by its vertices, has no finite area or positive edge "
                    "length, or lies "
                    "in a region where its vertices have no cells",
                    bad));
}

template <int D>
void check_patches(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellIndex& index) {
  const std::size_t n = boundary.patch_vertex.size(), n_vertices = volumes.sites.size();
  const std::size_t bad = first_bad(n, [&](std::size_t k) {
    const PatchId p(k);
    const VertexId v = boundary.patch_vertex[p];
    if (v.value() >= n_vertices) return false;
    const auto key = [&](PatchId q) {
      return std::tuple(boundary.patch_vertex[q], boundary.patch_marker[q], boundary.patch_region[q]);
    };
    if (k > 0 && !(key(PatchId(k - 1)) < key(p))) return false;
    return std::isfinite(boundary.patch_area[p]) && is_finite(boundary.patch_centroid[p]) &&
           index.contains(v, boundary.patch_region[p]);
  });
  if (bad != n)
    fail(
        fmt::format("boundary patch {} (counted from 0) is not sorted by vertex, marker and region, is not finite, or "
                    "lies in a region "
                    "where its vertex "
                    "has no cell",
                    bad));
}

}  // namespace

template <int D>
void check_volumes(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary) {
  check_lengths("cells", {volumes.cell_vertex.size(), volumes.cell_region.size(), volumes.cell_volume.size()});
  check_lengths("dual faces", {volumes.face_vertices.size(), volumes.face_region.size(), volumes.face_area.size(),
                               volumes.face_edge_length.size()});
  check_lengths("boundary patches",
                {boundary.patch_vertex.size(), boundary.patch_marker.size(), boundary.patch_region.size(),
                 boundary.patch_area.size(), boundary.patch_centroid.size()});
  check_cells(volumes);
  const CellIndex index(volumes);
  check_faces(volumes, index);
  check_patches(volumes, boundary, index);
}

template void check_volumes(const ControlVolumes<2>&, const BoundaryAreas<2>&);
template void check_volumes(const ControlVolumes<3>&, const BoundaryAreas<3>&);

}  // namespace voropack
