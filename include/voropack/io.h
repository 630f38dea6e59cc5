// Stages 0 and 9: files -> DomainInput or Mesh, and results -> files. Formats are described in docs/formats.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "voropack/domain.h"
#include "voropack/dual.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// A domain of either dimension, as the file says.
using AnyDomainInput = std::variant<DomainInput<2>, DomainInput<3>>;
/// A mesh of either dimension, as the file says.
using AnyMesh = std::variant<Mesh<2>, Mesh<3>>;

/// Reads a domain by extension: .poly (Triangle or TetGen, told apart by the dimension in its header), .smesh, .node
/// (points only: their convex hull is not taken; they are isolated points), .off, .stl (text or binary), .obj, .ply
/// (text or binary).
///
/// Counts are checked against the file's size before memory is reserved. Cost: O(n) for n bytes, the file is held in
/// memory. Throws: InputError io.cannot_open, io.truncated, io.bad_number, io.bad_count, io.bad_index, io.not_finite,
///         io.unknown_format, ... each with file and line (or byte, for binary) and how to mend it; the whole list is
///         in docs/formats.md. LimitError limit.ids, limit.memory. Cancelled.
AnyDomainInput read_domain(const std::filesystem::path& path, Observer& observer = silent_observer());

/// What to do with simplices that are flat, there twice, or overlap others. Accepted, they are for `retriangulate`,
/// which needs vertices, boundary and regions only: flat ones and duplicates are left out, and leave gaps behind; of
/// others that lie on the same side of a common face, each becomes the neighbor of the other. The observer is told
/// their numbers, and that of simplices of another orientation than most.
enum class FaultySimplices : std::uint8_t { kRefuse, kAccept };

/// Reads a mesh by extension: .node (with .ele and, where present, .face, .edge) or .vtu. Orientation is made positive;
/// neighbors are built; hull faces and interfaces that no file lists are added with marker 0; listed faces and edges
/// that no simplex has are kept, for `certify` to name; simplices without region get region 1. Throws as read_domain,
/// and InputError mesh.flat_simplex, mesh.nonmanifold, mesh.overlapping_simplices, io.duplicate_face,
/// io.duplicate_edge.
/// With FaultySimplices::kAccept, of these only mesh.nonmanifold, io.duplicate_face and io.duplicate_edge.
AnyMesh read_mesh(const std::filesystem::path& path, Observer& observer = silent_observer(),
                  FaultySimplices faulty = FaultySimplices::kRefuse);

/// The values of one array of point data in a .vtu file of any program, in the order of its points; of vectors, one
/// tuple after the other. The grid's cells are not looked at.
///
/// Throws as read_mesh, and InputError io.no_such_array, which lists the arrays that are there.
std::vector<double> read_point_array(const std::filesystem::path& path, const std::string& name,
                                     Observer& observer = silent_observer());

/// A number for each vertex, simplex or cell, to be written beside what a file holds anyway.
struct NamedArray {
  std::string name;  ///< Printable, without <>&"', and not the name of an array that is there anyway.
  std::span<const double> values;
};
struct MeshArrays {
  std::vector<NamedArray> vertex;   ///< Each with n_vertices values.
  std::vector<NamedArray> simplex;  ///< Each with n_simplices values.
};

/// Writes a mesh by extension: .node (with .ele and .face, .edge), where `arrays` become further attributes without
/// names, or .vtu. Each file is written beside its place and renamed, so that an interrupted or failed run leaves
/// nothing half-written. Missing parent folders are made. Throws: InputError io.cannot_write (disk full, no
/// permission), OptionError io.unknown_format, io.bad_array (length, name, or attributes of .node without the spacing
/// before them).
template <int D>
void write_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays = {});

/// Writes control volumes as .vtu polyhedra (VTK type 42) or polygons (type 7) with cell arrays `site`, `volume`,
/// `region`, and further ones of n_cells values each. Throws as write_mesh.
template <int D>
void write_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes, const std::filesystem::path& path,
                 std::span<const NamedArray> arrays = {});

/// Writes a 2D mesh with its Voronoi cells as SVG.
void write_svg(const Mesh<2>& mesh, const CellShapes<2>& shapes, const ControlVolumes<2>& volumes,
               const std::filesystem::path& path);

/// Writes a 2D mesh with the P1 function of an array of n_vertices values as filled contours between round numbers, and
/// a scale of their colours, as SVG. Throws: as write_mesh.
void write_svg(const Mesh<2>& mesh, const NamedArray& colors, const std::filesystem::path& path);

/// Writes a sparse matrix given by rows in the Matrix Market exchange format, counted from 1 there: `offsets` of n_rows
/// + 1 rows into `columns` and `values`. Throws: InputError io.cannot_write.
void write_matrix_market(std::span<const std::uint64_t> offsets, std::span<const std::uint32_t> columns,
                         std::span<const double> values, std::size_t n_columns, const std::filesystem::path& path);

/// Writes text whole or not at all: beside its place, then renamed.
void write_text(const std::string& text, const std::filesystem::path& path);

}  // namespace voropack
