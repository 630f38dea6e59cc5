// Meshes and control volumes as .vtu.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "io/vtu_writer.h"
#include "io/writers.h"
#include "voropack/io.h"

namespace voropack::io {

namespace {

enum VtkCellType : std::uint8_t { kTriangle = 5, kPolygon = 7, kTetrahedron = 10, kPolyhedron = 42 };

/// value(i) for each i in [0, n).
template <class T, class Value>
VtuArray make_array(std::string name, std::uint64_t n, int n_components, Value value) {
  return {std::move(name), n, n_components, VtuArray::Fill<T>([value](std::uint64_t begin, std::span<T> out) {
            for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<T>(value(begin + i));
          })};
}

/// Indices below `limit`: in 32 bits where they fit.
template <class Value>
VtuArray make_index_array(std::string name, std::uint64_t n, int n_components, std::uint64_t limit, Value value) {
  if (limit <= std::numeric_limits<std::int32_t>::max())
    return make_array<std::int32_t>(std::move(name), n, n_components, value);
  return make_array<std::int64_t>(std::move(name), n, n_components, value);
}

/// Points have 3 coordinates in VTK; in 2D z is 0.
template <int D, class Points>
VtuArray make_points(const Points& points) {
  return make_array<double>("Points", 3 * std::uint64_t{points.size()}, 3, [&points](std::uint64_t i) {
    const auto k = static_cast<int>(i % 3);
    return k < D ? points.data()[i / 3][k] : 0.0;
  });
}

template <class I, std::size_t K>
VtuArray make_vertex_sets(std::string name, const IdVector<I, std::array<VertexId, K>>& sets, std::size_t n_vertices) {
  return make_index_array(std::move(name), K * std::uint64_t{sets.size()}, static_cast<int>(K), n_vertices,
                          [&sets](std::uint64_t i) { return sets.data()[i / K][i % K].value(); });
}

template <class T, class I, class V>
VtuArray make_copy(std::string name, const IdVector<I, V>& values) {
  return make_array<T>(std::move(name), values.size(), 1, [&values](std::uint64_t i) { return values.data()[i]; });
}

/// Rows of varying length, concatenated. `row(r, out)` appends row r; `ends[r]` is where it ends.
template <class Row>
VtuArray make_row_array(std::string name, const std::vector<std::uint64_t>& ends, std::uint64_t limit, Row row) {
  const auto fill = [&ends, row](std::uint64_t begin, auto out) {
    std::vector<std::uint64_t> values;
    auto r = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), begin) - ends.begin());
    std::uint64_t skip = begin - (r == 0 ? 0 : ends[r - 1]);
    for (std::size_t done = 0; done < out.size(); ++r, skip = 0) {
      values.clear();
      row(r, values);
      for (std::size_t k = skip; k < values.size() && done < out.size(); ++k)
        out[done++] = static_cast<typename decltype(out)::value_type>(values[k]);
    }
  };
  const std::uint64_t n = ends.empty() ? 0 : ends.back();
  if (limit <= std::numeric_limits<std::int32_t>::max())
    return {std::move(name), n, 1, VtuArray::Fill<std::int32_t>(fill)};
  return {std::move(name), n, 1, VtuArray::Fill<std::int64_t>(fill)};
}

template <class Row>
std::vector<std::uint64_t> row_ends(std::size_t n, const Row& row) {
  std::vector<std::uint64_t> ends(n);
  parallel_for(n, [&](std::size_t r) {
    std::vector<std::uint64_t> values;
    row(r, values);
    ends[r] = values.size();
  });
  for (std::size_t r = 1; r < n; ++r) ends[r] += ends[r - 1];
  return ends;
}

VtuArray make_offsets(std::string name, const std::vector<std::uint64_t>& ends) {
  return make_index_array(std::move(name), ends.size(), 1, ends.empty() ? 0 : ends.back(),
                          [&ends](std::uint64_t i) { return ends[i]; });
}

bool is_fit_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c >= ' ' && c != 0x7f && std::string_view("<>&\"'").find(static_cast<char>(c)) == std::string_view::npos;
  });
}

/// Appends further arrays of `n` values each to those that the file holds anyway.
void add_arrays(std::vector<VtuArray>& section, std::span<const NamedArray> arrays, std::uint64_t n) {
  const auto fail = [](const NamedArray& array, const std::string& message, const std::string& fix) {
    throw OptionError(
        Fault{.id = "io.bad_array", .message = fmt::format("the array '{}' {}", array.name, message), .fix = fix});
  };
  for (const NamedArray& array : arrays) {
    if (array.values.size() != n)
      fail(array, fmt::format("has {} values for {} elements", array.values.size(), n), "give each element a value");
    if (!is_fit_name(array.name)) fail(array, "has a name that XML cannot hold", "use letters and digits");
    if (std::any_of(section.begin(), section.end(), [&](const VtuArray& other) { return other.name == array.name; }))
      fail(array, "is there already", "give it another name");
    section.push_back(
        make_array<double>(array.name, n, 1, [values = array.values](std::uint64_t i) { return values[i]; }));
  }
}

VtuArray make_types(std::uint64_t n, VtkCellType type) {
  return make_array<std::uint8_t>("types", n, 1, [type](std::uint64_t) { return type; });
}

}  // namespace

template <int D>
void write_vtu_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays) {
  constexpr std::uint64_t kCorners = D + 1;
  const std::uint64_t n_vertices = mesh.points.size(), n_simplices = mesh.simplex_vertices.size();
  VtuGrid grid;
  grid.n_points = n_vertices;
  grid.n_cells = n_simplices;
  grid.points = make_points<D>(mesh.points);
  if (!mesh.vertex_spacing.empty()) grid.point_data.push_back(make_copy<double>("spacing", mesh.vertex_spacing));
  if (!mesh.vertex_marker.empty()) grid.point_data.push_back(make_copy<std::int32_t>("marker", mesh.vertex_marker));
  if (!mesh.vertex_carrier_dimension.empty())
    grid.point_data.push_back(make_copy<std::uint8_t>("carrier_dimension", mesh.vertex_carrier_dimension));
  add_arrays(grid.point_data, arrays.vertex, n_vertices);
  grid.cell_data.push_back(make_copy<std::int32_t>("region", mesh.simplex_region));
  add_arrays(grid.cell_data, arrays.simplex, n_simplices);
  grid.cells.push_back(make_vertex_sets("connectivity", mesh.simplex_vertices, n_vertices));
  grid.cells.back().n_components = 1;
  grid.cells.push_back(make_index_array("offsets", n_simplices, 1, n_simplices * kCorners,
                                        [](std::uint64_t i) { return (i + 1) * kCorners; }));
  grid.cells.push_back(make_types(n_simplices, D == 2 ? kTriangle : kTetrahedron));
  // Not as cells, so that whoever sums over the cells sees simplices only.
  if (!mesh.boundary_vertices.empty()) {
    grid.field_data.push_back(make_vertex_sets("boundary_vertices", mesh.boundary_vertices, n_vertices));
    grid.field_data.push_back(make_copy<std::int32_t>("boundary_marker", mesh.boundary_marker));
  }
  if (!mesh.segment_edges.empty()) {
    grid.field_data.push_back(make_vertex_sets("segment_edges", mesh.segment_edges, n_vertices));
    grid.field_data.push_back(make_copy<std::int32_t>("segment_edge_marker", mesh.segment_edge_marker));
  }
  write_vtu(grid, path);
}

template void write_vtu_mesh<2>(const Mesh<2>&, const std::filesystem::path&, const MeshArrays&);
template void write_vtu_mesh<3>(const Mesh<3>&, const std::filesystem::path&, const MeshArrays&);

}  // namespace voropack::io

namespace voropack {

template <int D>
void write_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes, const std::filesystem::path& path,
                 std::span<const NamedArray> arrays) {
  using namespace io;
  const std::uint64_t n_points = shapes.points.size(), n_cells = shapes.cell_faces.size();
  // The corner points of a cell: of a polyhedron ascending and each once, of a polygon in order.
  const auto corners = [&shapes](std::size_t c, std::vector<std::uint64_t>& out) {
    for (const std::uint32_t face_or_point : shapes.cell_faces[CellId(c)]) {
      if constexpr (D == 2)
        out.push_back(face_or_point);
      else
        for (const std::uint32_t point : shapes.face_points[DualFaceId(face_or_point)]) out.push_back(point);
    }
    if constexpr (D == 3) {
      std::sort(out.begin(), out.end());
      out.erase(std::unique(out.begin(), out.end()), out.end());
    }
  };
  // A face between two cells is listed as seen from outside of the first; VTK wants it so for each.
  std::vector<CellId> first_cell(shapes.face_points.size());
  if constexpr (D == 3)
    for (const CellId c : ids<CellId>(n_cells))
      for (const std::uint32_t face : shapes.cell_faces[c])
        if (first_cell[face].is_none()) first_cell[face] = c;
  // VTK's face stream of a polyhedron: number of faces, then for each its number of points and its points.
  const auto face_stream = [&shapes, &first_cell](std::size_t c, std::vector<std::uint64_t>& out) {
    const auto faces = shapes.cell_faces[CellId(c)];
    out.push_back(faces.size());
    for (const std::uint32_t face : faces) {
      const auto points = shapes.face_points[DualFaceId(face)];
      out.push_back(points.size());
      if (first_cell[face] == CellId(c))
        out.insert(out.end(), points.begin(), points.end());
      else
        out.insert(out.end(), points.rbegin(), points.rend());
    }
  };

  const std::vector<std::uint64_t> corner_ends = row_ends(n_cells, corners);
  std::vector<std::uint64_t> stream_ends;
  VtuGrid grid;
  grid.n_points = n_points;
  grid.n_cells = n_cells;
  grid.points = make_points<D>(shapes.points);
  grid.cells.push_back(make_row_array("connectivity", corner_ends, n_points, corners));
  grid.cells.push_back(make_offsets("offsets", corner_ends));
  grid.cells.push_back(make_types(n_cells, D == 2 ? kPolygon : kPolyhedron));
  if constexpr (D == 3) {
    stream_ends = row_ends(n_cells, face_stream);
    grid.cells.push_back(make_row_array("faces", stream_ends, n_points, face_stream));
    grid.cells.push_back(make_offsets("faceoffsets", stream_ends));
  }
  grid.cell_data.push_back(make_index_array("site", n_cells, 1, volumes.sites.size(), [&volumes](std::uint64_t i) {
    return volumes.cell_vertex.data()[i].value();
  }));
  grid.cell_data.push_back(make_copy<double>("volume", volumes.cell_volume));
  grid.cell_data.push_back(make_copy<std::int32_t>("region", volumes.cell_region));
  add_arrays(grid.cell_data, arrays, n_cells);
  write_vtu(grid, path);
}

template void write_cells<2>(const CellShapes<2>&, const ControlVolumes<2>&, const std::filesystem::path&,
                             std::span<const NamedArray>);
template void write_cells<3>(const CellShapes<3>&, const ControlVolumes<3>&, const std::filesystem::path&,
                             std::span<const NamedArray>);

}  // namespace voropack
