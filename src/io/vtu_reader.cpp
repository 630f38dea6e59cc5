// Meshes from .vtu files: our own, and those of other programs with triangles or tetrahedra.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/names.h"
#include "base/number_text.h"
#include "io/mesh_assembly.h"
#include "io/readers.h"
#include "io/vtu_data.h"
#include "io/xml.h"

namespace voropack::io {

namespace {

enum VtkCellType : std::int64_t { kVertex = 1, kLine = 3, kTriangle = 5, kTetrahedron = 10 };

constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 48U;
constexpr std::uint64_t kMaxComponents = 1000;

class VtuReader {
 public:
  explicit VtuReader(const Source& source)
      : source_(source), document_(parse_xml(source, "AppendedData")), data_(source, document_) {
    const XmlElement& root = document_.elements.front();
    if (root.tag != "VTKFile" || XmlDocument::attribute(root, "type") != "UnstructuredGrid")
      fail("io.bad_header", "this is not a VTK file with an UnstructuredGrid",
           "write the mesh as an unstructured grid (.vtu)");
    grid_ = &required_child(root, "UnstructuredGrid");
    piece_ = &required_child(*grid_, "Piece");
    if (std::count_if(grid_->children.begin(), grid_->children.end(),
                      [&](std::uint32_t c) { return document_.elements[c].tag == "Piece"; }) > 1)
      fail("io.unsupported", "the file has more than one Piece", "merge the pieces, for instance in ParaView");
    n_points_ = read_count("NumberOfPoints");
    n_cells_ = read_count("NumberOfCells");
  }

  AnyMesh read(FaultySimplices faulty, Observer& observer) {
    const std::vector<double> coordinates = read_points();
    read_cells();
    const auto has = [&](std::int64_t type) { return std::find(types_.begin(), types_.end(), type) != types_.end(); };
    if (has(kTetrahedron)) return read_mesh_of_dimension<3>(coordinates, faulty, observer);
    if (!has(kTriangle))
      fail("io.unsupported", "the file has neither triangles nor tetrahedra", "give a mesh of simplices");
    for (std::uint64_t p = 0; p < n_points_; ++p)
      if (coordinates[3 * p + 2] != 0)
        fail("io.not_planar",
             fmt::format("the mesh has triangles only, but point {} (counted from 0) has z = {}", p,
                         coordinates[3 * p + 2]),
             "set z to 0 for a mesh of the plane, or give a mesh of tetrahedra");
    return read_mesh_of_dimension<2>(coordinates, faulty, observer);
  }

  std::vector<double> read_point_array(const std::string& name) const {
    const XmlElement* array = find_array(*piece_, "PointData", name);
    if (array == nullptr) {
      std::vector<std::string> names, quoted;
      if (const XmlElement* section = document_.child(*piece_, "PointData"))
        for (const std::uint32_t c : section->children) {
          names.emplace_back(XmlDocument::attribute(document_.elements[c], "Name").value_or(""));
          quoted.push_back(quote(names.back()));
        }
      const std::string near = nearest_name(name, names);
      fail("io.no_such_array",
           fmt::format("the points have no array {}; they have {}", quote(name),
                       names.empty() ? "none at all" : join_names(quoted)),
           near.empty() ? "name one that is there" : fmt::format("did you mean {}?", quote(near)));
    }
    std::uint64_t n_components = 1;
    const auto text = XmlDocument::attribute(*array, "NumberOfComponents");
    if (text && (!parse_integer(*text, n_components) || n_components == 0 || n_components > kMaxComponents))
      data_.fail(*array, "io.bad_count", "its NumberOfComponents is not a number of components",
                 "correct the attribute");
    return data_.read<double>(*array, n_components * n_points_);
  }

 private:
  [[noreturn]] void fail(std::string id, std::string message, std::string fix) const {
    io::fail(source_.file, std::move(id), std::move(message), std::move(fix));
  }

  const XmlElement& required_child(const XmlElement& parent, std::string_view tag) const {
    const XmlElement* child = document_.child(parent, tag);
    if (child == nullptr)
      io::fail(source_.file, "io.bad_xml", fmt::format("the element {} lacks its {}", quote(parent.tag), tag),
               "check that the file is complete", parent.line);
    return *child;
  }

  std::uint64_t read_count(std::string_view name) const {
    std::uint64_t count = 0;
    if (!parse_integer(XmlDocument::attribute(*piece_, name).value_or(""), count) || count > kMaxCount)
      io::fail(source_.file, "io.bad_count", fmt::format("the attribute {} of Piece is not a number of things", name),
               "correct the attribute", piece_->line);
    check_id_range(source_.file, "element", count);
    return count;
  }

  /// The array of that name in a section of `parent`, or nullptr.
  const XmlElement* find_array(const XmlElement& parent, std::string_view section, std::string_view name) const {
    const XmlElement* element = document_.child(parent, section);
    if (element == nullptr) return nullptr;
    for (const std::uint32_t c : element->children)
      if (XmlDocument::attribute(document_.elements[c], "Name") == name) return &document_.elements[c];
    return nullptr;
  }

  std::vector<double> read_points() const {
    const XmlElement& array = required_child(required_child(*piece_, "Points"), "DataArray");
    const std::vector<double> coordinates = data_.read<double>(array, 3 * n_points_);
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      if (!std::isfinite(coordinates[i]))
        data_.fail(array, "io.not_finite",
                   fmt::format("a coordinate of point {} (counted from 0) is not finite", i / 3),
                   "correct or remove the point");
    return coordinates;
  }

  const XmlElement& required_cell_array(std::string_view name) const {
    const XmlElement* array = find_array(*piece_, "Cells", name);
    if (array == nullptr)
      fail("io.bad_xml", fmt::format("the cells lack their array {}", name), "check that the file is complete");
    return *array;
  }

  void read_cells() {
    types_ = data_.read<std::int64_t>(required_cell_array("types"), n_cells_);
    const XmlElement& offsets_array = required_cell_array("offsets");
    offsets_ = data_.read<std::int64_t>(offsets_array, n_cells_);
    std::int64_t previous = 0;
    for (std::uint64_t c = 0; c < n_cells_; ++c) {
      const std::int64_t n_corners = corner_count(types_[c]);
      if (n_corners == 0)
        fail("io.unsupported",
             fmt::format("cell {} (counted from 0) has the VTK type {}; only triangles (5), tetrahedra (10), lines (3) "
                         "and vertices (1) "
                         "are known",
                         c, types_[c]),
             "split the cells into simplices, for instance with ParaView's filter Tetrahedralize");
      if (offsets_[c] - previous != n_corners)
        data_.fail(offsets_array, "io.bad_count",
                   fmt::format("cell {} (counted from 0) of type {} has {} corners instead of {}", c, types_[c],
                               offsets_[c] - previous, n_corners),
                   "correct the offsets");
      previous = offsets_[c];
    }
    const XmlElement& array = required_cell_array("connectivity");
    connectivity_ = data_.read<std::int64_t>(array, static_cast<std::uint64_t>(previous));
    check_vertices(array, connectivity_);
  }

  static std::int64_t corner_count(std::int64_t type) {
    return type == kVertex ? 1 : type == kLine ? 2 : type == kTriangle ? 3 : type == kTetrahedron ? 4 : 0;
  }

  void check_vertices(const XmlElement& array, const std::vector<std::int64_t>& vertices) const {
    for (const std::int64_t v : vertices)
      if (v < 0 || static_cast<std::uint64_t>(v) >= n_points_)
        data_.fail(array, "io.bad_index",
                   fmt::format("point {} (counted from 0) is not one of the {} points", v, n_points_),
                   "correct the index");
  }

  /// Whole numbers of 32 bits; empty if there is no such array.
  std::vector<int> read_labels(const XmlElement& parent, std::string_view section, std::string_view name,
                               std::uint64_t n) const {
    const XmlElement* array = find_array(parent, section, name);
    if (array == nullptr) return {};
    std::vector<int> labels;
    for (const std::int64_t value : data_.read<std::int64_t>(*array, n)) {
      if (!std::in_range<int>(value))
        data_.fail(*array, "io.bad_number", fmt::format("{} does not fit into 32 bits", value), "use smaller numbers");
      labels.push_back(static_cast<int>(value));
    }
    return labels;
  }

  template <int D>
  void read_vertex_data(Mesh<D>& mesh) const {
    if (const XmlElement* array = find_array(*piece_, "PointData", "spacing")) {
      mesh.vertex_spacing = IdVector<VertexId, double>(data_.read<double>(*array, n_points_));
      for (const double f : mesh.vertex_spacing)
        if (!std::isfinite(f))
          data_.fail(*array, "io.not_finite", "a spacing is not finite", "correct the value, or leave out the array");
    }
    mesh.vertex_marker = IdVector<VertexId, int>(read_labels(*piece_, "PointData", "marker", n_points_));
    for (const int dimension : read_labels(*piece_, "PointData", "carrier_dimension", n_points_)) {
      if (dimension < 0 || dimension > D)
        fail("io.bad_number", fmt::format("a carrier_dimension is {}", dimension),
             fmt::format("use numbers from 0 to {}, or leave out the array", D));
      mesh.vertex_carrier_dimension.push_back(static_cast<std::uint8_t>(dimension));
    }
  }

  /// The cells with K corners as vertex sets with the labels of their cells.
  template <std::size_t K>
  Listing<K> cells_of_size(const std::vector<int>& labels) const {
    Listing<K> listing;
    listing.file = source_.file;
    for (std::uint64_t c = 0; c < n_cells_; ++c) {
      if (corner_count(types_[c]) != static_cast<std::int64_t>(K)) continue;
      std::array<VertexId, K> corners;
      for (std::size_t k = 0; k < K; ++k)
        corners[k] = VertexId(static_cast<std::size_t>(connectivity_[static_cast<std::size_t>(offsets_[c]) - K + k]));
      listing.vertices.push_back(corners);
      if (!labels.empty()) listing.markers.push_back(labels[c]);
    }
    return listing;
  }

  /// Vertex sets from our own field arrays; else the cells with K corners.
  template <std::size_t K>
  Listing<K> read_listing(std::string_view name, std::string_view marker_name,
                          const std::vector<int>& cell_markers) const {
    const XmlElement* array = find_array(*grid_, "FieldData", name);
    if (array == nullptr) return cells_of_size<K>(cell_markers);
    std::uint64_t n = 0;
    if (!parse_integer(XmlDocument::attribute(*array, "NumberOfTuples").value_or(""), n) || n > kMaxCount)
      data_.fail(*array, "io.bad_count", "its NumberOfTuples is not a number of things", "correct the attribute");
    const std::vector<std::int64_t> vertices = data_.read<std::int64_t>(*array, K * n);
    check_vertices(*array, vertices);
    Listing<K> listing;
    listing.file = source_.file;
    listing.vertices.resize(n);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      listing.vertices[i / K][i % K] = VertexId(static_cast<std::size_t>(vertices[i]));
    listing.markers = read_labels(*grid_, "FieldData", marker_name, n);
    return listing;
  }

  template <int D>
  Mesh<D> read_mesh_of_dimension(const std::vector<double>& coordinates, FaultySimplices faulty,
                                 Observer& observer) const {
    Mesh<D> mesh;
    mesh.points.resize(n_points_);
    for (std::size_t p = 0; p < n_points_; ++p)
      for (int k = 0; k < D; ++k) mesh.points[VertexId(p)][k] = coordinates[3 * p + static_cast<std::size_t>(k)];
    read_vertex_data(mesh);
    const std::vector<int> regions = read_labels(*piece_, "CellData", "region", n_cells_);
    const std::vector<int> markers = read_labels(*piece_, "CellData", "marker", n_cells_);
    Listing<2> segments;
    if constexpr (D == 3) segments = read_listing<2>("segment_edges", "segment_edge_marker", markers);
    assemble_mesh<D>(mesh, cells_of_size<D + 1>(regions),
                     read_listing<D>("boundary_vertices", "boundary_marker", markers), segments, faulty, observer);
    return mesh;
  }

  const Source& source_;
  XmlDocument document_;
  VtuData data_;
  const XmlElement* grid_ = nullptr;
  const XmlElement* piece_ = nullptr;
  std::uint64_t n_points_ = 0, n_cells_ = 0;
  std::vector<std::int64_t> types_, offsets_, connectivity_;
};

}  // namespace

AnyMesh parse_vtu(const Source& source, Observer& observer, FaultySimplices faulty) {
  observer.check_cancelled();
  return VtuReader(source).read(faulty, observer);
}

std::vector<double> parse_vtu_point_array(const Source& source, const std::string& name, Observer& observer) {
  observer.check_cancelled();
  return VtuReader(source).read_point_array(name);
}

}  // namespace voropack::io
