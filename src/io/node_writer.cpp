// Meshes as .node, .ele, .face (3D) and .edge, as TetGen and Triangle write them, counted from 1.
#include <memory>

#include "base/number_text.h"
#include "io/atomic_file.h"
#include "io/writers.h"

namespace voropack::io {

namespace {

/// Both Triangle and TetGen count from 1 unless told otherwise, and both read either.
constexpr std::uint64_t kFirst = 1;
/// Text is handed on in pieces of about this size.
constexpr std::size_t kPieceBytes = std::size_t{1} << 18U;

/// A text file of rows of numbers.
class Table {
 public:
  explicit Table(const std::filesystem::path& path) : file_(path) {}

  template <class Number>
  Table& operator<<(Number value) {
    if (!at_line_start_) text_ += ' ';
    at_line_start_ = false;
    append_number(text_, value);
    return *this;
  }
  Table& operator<<(VertexId v) { return *this << v.value() + kFirst; }
  void end_row() {
    text_ += '\n';
    at_line_start_ = true;
    if (text_.size() >= kPieceBytes) flush();
  }
  void finish() {
    flush();
    file_.finish();
  }
  void rename() { file_.rename(); }

 private:
  void flush() {
    file_.write(text_);
    text_.clear();
  }
  AtomicFile file_;
  std::string text_;
  bool at_line_start_ = true;
};

/// Further attributes have no names, only places: those before them must be there.
void check_arrays(const std::vector<NamedArray>& arrays, std::size_t n, bool has_first,
                  const std::filesystem::path& path) {
  const auto refuse = [&](const NamedArray& array, const char* what, const char* fix) {
    throw OptionError(Fault{
        .id = "io.bad_array", .message = "the array '" + array.name + "' " + what, .fix = fix, .file = path.string()});
  };
  for (const NamedArray& array : arrays) {
    if (array.values.size() != n) refuse(array, "has another length than the mesh", "give one value for each element");
    if (!has_first) refuse(array, "would take the place of the spacing, which is not known", "end the name with .vtu");
  }
}

template <int D>
void write_points(const Mesh<D>& mesh, const std::vector<NamedArray>& arrays, Table& table) {
  const bool has_spacing = !mesh.vertex_spacing.empty();
  const bool has_marker = !mesh.vertex_marker.empty();
  table << mesh.points.size() << D << arrays.size() + (has_spacing ? 1 : 0) << static_cast<int>(has_marker);
  table.end_row();
  for (const VertexId v : ids(mesh.points)) {
    table << v;
    for (const double x : mesh.points[v].coord) table << x;
    if (has_spacing) table << mesh.vertex_spacing[v];
    for (const NamedArray& array : arrays) table << array.values[v.value()];
    if (has_marker) table << mesh.vertex_marker[v];
    table.end_row();
  }
}

template <int D>
void write_simplices(const Mesh<D>& mesh, const std::vector<NamedArray>& arrays, Table& table) {
  table << mesh.simplex_vertices.size() << D + 1 << arrays.size() + 1;
  table.end_row();
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    table << s.value() + kFirst;
    for (const VertexId v : mesh.simplex_vertices[s]) table << v;
    table << mesh.simplex_region[s];
    for (const NamedArray& array : arrays) table << array.values[s.value()];
    table.end_row();
  }
}

template <class I, std::size_t K>
void write_listing(const IdVector<I, std::array<VertexId, K>>& vertices, const IdVector<I, int>& markers,
                   Table& table) {
  table << vertices.size() << 1;
  table.end_row();
  for (const I i : ids(vertices)) {
    table << i.value() + kFirst;
    for (const VertexId v : vertices[i]) table << v;
    table << markers[i];
    table.end_row();
  }
}

}  // namespace

template <int D>
void write_node_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays) {
  check_arrays(arrays.vertex, mesh.points.size(), !mesh.vertex_spacing.empty(), path);
  check_arrays(arrays.simplex, mesh.simplex_vertices.size(), true, path);
  std::vector<std::unique_ptr<Table>> tables;
  // Empty lists are written too, so that no list of an earlier mesh stays beside this one.
  const auto new_table = [&](const char* extension) -> Table& {
    std::filesystem::path name = path;
    tables.push_back(std::make_unique<Table>(name.replace_extension(extension)));
    return *tables.back();
  };
  write_points(mesh, arrays.vertex, new_table(".node"));
  write_simplices(mesh, arrays.simplex, new_table(".ele"));
  if constexpr (D == 2) {
    write_listing(mesh.boundary_vertices, mesh.boundary_marker, new_table(".edge"));
  } else {
    write_listing(mesh.boundary_vertices, mesh.boundary_marker, new_table(".face"));
    write_listing(mesh.segment_edges, mesh.segment_edge_marker, new_table(".edge"));
  }
  for (const auto& table : tables) table->finish();
  for (const auto& table : tables) table->rename();
}

template void write_node_mesh<2>(const Mesh<2>&, const std::filesystem::path&, const MeshArrays&);
template void write_node_mesh<3>(const Mesh<3>&, const std::filesystem::path&, const MeshArrays&);

}  // namespace voropack::io
