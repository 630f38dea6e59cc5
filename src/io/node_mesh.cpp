// Meshes of Triangle and TetGen: .node and .ele, with .face (3D) and .edge.
#include <fmt/format.h>

#include "io/mesh_assembly.h"
#include "io/node.h"
#include "io/readers.h"

namespace voropack::io {

namespace {

/// The number that begins the line; the first one decides from where the elements are counted.
void read_element_number(TextScanner& scanner, std::uint64_t i, std::uint64_t& first) {
  const std::int64_t number = scanner.integer("number of the element");
  if (i == 0 && number >= 0) first = static_cast<std::uint64_t>(number);
}

/// .ele: `<simplices> <nodes each> <attributes>`, then `<number> <corners> [more nodes] [attributes]`.
template <int D>
Listing<D + 1> read_simplices(const Source& source, std::uint32_t first_vertex, std::uint64_t n_vertices,
                              Observer& observer, bool& is_quadratic) {
  constexpr std::string_view kKind = D == 2 ? "triangle" : "tetrahedron";
  constexpr std::int64_t kQuadraticNodes = D == 2 ? 6 : 10;
  TextScanner scanner(source, '#', observer);
  scanner.next_line("header of the simplices");
  const std::uint64_t n = scanner.count("number of simplices");
  const std::int64_t n_nodes = scanner.at_end_of_line() ? D + 1 : scanner.integer("number of nodes each");
  if (n_nodes != D + 1 && n_nodes != kQuadraticNodes)
    scanner.fail("io.bad_count",
                 fmt::format("the header announces simplices with {} nodes; {} or {} are known for points of dimension "
                             "{}",
                             n_nodes, D + 1, kQuadraticNodes, D),
                 "correct the header, or give the .node file that belongs to this .ele file");
  is_quadratic = n_nodes == kQuadraticNodes;
  const std::uint64_t n_attributes = scanner.at_end_of_line() ? 0 : scanner.count("number of attributes");
  scanner.end_of_line();

  Listing<D + 1> simplices;
  simplices.file = source.file;
  simplices.first_vertex = first_vertex;
  const std::uint64_t capacity = scanner.capacity(n, 2 * (D + 2));
  simplices.vertices.reserve(capacity);
  simplices.lines.reserve(capacity);
  if (n_attributes > 0) simplices.markers.reserve(capacity);
  for (std::uint64_t i = 0; i < n; ++i) {
    scanner.next_line(kKind, i + simplices.first_number);
    read_element_number(scanner, i, simplices.first_number);
    std::array<VertexId, D + 1> corners;
    for (VertexId& v : corners) v = VertexId(scanner.index("vertex", first_vertex, n_vertices));
    for (std::int64_t k = D + 1; k < n_nodes; ++k) scanner.index("vertex", first_vertex, n_vertices);
    if (n_attributes > 0) simplices.markers.push_back(read_region_id(scanner, "region"));
    for (std::uint64_t a = 1; a < n_attributes; ++a) scanner.number("attribute");
    scanner.end_of_line();
    simplices.vertices.push_back(corners);
    simplices.lines.push_back(scanner.line());
  }
  scanner.end_of_file("simplex");
  return simplices;
}

/// .face (K = 3) and .edge (K = 2): `<elements> <markers>`, then `<number> <corners> [marker]`. TetGen -o2 adds K nodes
/// of a triangle or 1 of an edge before the marker, -nn adds 2 or 1 adjacent tetrahedra behind it.
template <std::size_t K>
Listing<K> read_listing(TextScanner& scanner, std::uint32_t first_vertex, std::uint64_t n_vertices, bool is_quadratic,
                        std::size_t max_adjacent) {
  constexpr std::string_view kKind = K == 2 ? "edge" : "face";
  scanner.next_line("header");
  const std::uint64_t n = scanner.count(K == 2 ? "number of edges" : "number of faces");
  const bool has_markers = !scanner.at_end_of_line() && read_marker_flag(scanner);
  scanner.end_of_line();

  Listing<K> listing;
  listing.file = scanner.file();
  listing.first_vertex = first_vertex;
  const std::uint64_t capacity = scanner.capacity(n, 2 * (K + 1));
  listing.vertices.reserve(capacity);
  listing.lines.reserve(capacity);
  if (has_markers) listing.markers.reserve(capacity);
  for (std::uint64_t i = 0; i < n; ++i) {
    scanner.next_line(kKind, i + listing.first_number);
    read_element_number(scanner, i, listing.first_number);
    std::array<VertexId, K> corners;
    for (VertexId& v : corners) v = VertexId(scanner.index("vertex", first_vertex, n_vertices));
    if (is_quadratic)
      for (std::size_t k = 0; k < (K == 2 ? 1 : 3); ++k) scanner.index("vertex", first_vertex, n_vertices);
    if (has_markers) listing.markers.push_back(scanner.small_integer("marker"));
    for (std::size_t k = 0; k < max_adjacent && !scanner.at_end_of_line(); ++k) scanner.integer("adjacent tetrahedron");
    scanner.end_of_line();
    listing.vertices.push_back(corners);
    listing.lines.push_back(scanner.line());
  }
  return listing;
}

template <std::size_t K>
Listing<K> read_listing(const Source& source, std::uint32_t first_vertex, std::uint64_t n_vertices, bool is_quadratic,
                        std::size_t max_adjacent, Observer& observer) {
  TextScanner scanner(source, '#', observer);
  Listing<K> listing = read_listing<K>(scanner, first_vertex, n_vertices, is_quadratic, max_adjacent);
  scanner.end_of_file(K == 2 ? "edge" : "face");
  return listing;
}

/// The segments of a .poly whose points are in the .node file beside it, as Triangle writes it with a mesh. One that
/// lists points of its own is a domain, and says nothing about the vertices of the mesh.
Listing<2> read_segments_of_poly(const Source& source, std::uint32_t first_vertex, std::uint64_t n_vertices,
                                 Observer& observer) {
  TextScanner scanner(source, '#', observer);
  const NodeHeader header = read_node_header(scanner);
  if (header.n_points > 0 || header.dimension.value_or(2) != 2) return {};
  return read_listing<2>(scanner, first_vertex, n_vertices, false, 0);
}

template <int D>
Mesh<D> read_mesh_of_dimension(TextScanner& node_scanner, const NodeHeader& header, const NodeMeshSources& sources,
                               Observer& observer, FaultySimplices faulty) {
  NodeList<D> nodes = read_node_list<D>(node_scanner, header);
  node_scanner.end_of_file("point");
  const std::uint32_t first = nodes.first_index;
  const std::uint64_t n = nodes.points.size();
  Mesh<D> mesh;
  mesh.points = IdVector<VertexId, Vec<D>>(std::move(nodes.points));
  mesh.vertex_spacing = IdVector<VertexId, double>(std::move(nodes.first_attribute));
  mesh.vertex_marker = IdVector<VertexId, int>(std::move(nodes.markers));

  bool is_quadratic = false;
  Listing<D + 1> simplices = read_simplices<D>(sources.ele, first, n, observer, is_quadratic);
  Listing<D> boundary;
  Listing<2> segments;
  if constexpr (D == 2) {
    // Triangle lists no nodes in the middle of edges.
    if (sources.edge)
      boundary = read_listing<2>(*sources.edge, first, n, false, 0, observer);
    else if (sources.poly)
      boundary = read_segments_of_poly(*sources.poly, first, n, observer);
  } else {
    if (sources.face) boundary = read_listing<3>(*sources.face, first, n, is_quadratic, 2, observer);
    if (sources.edge) segments = read_listing<2>(*sources.edge, first, n, is_quadratic, 1, observer);
  }
  assemble_mesh<D>(mesh, std::move(simplices), boundary, segments, faulty, observer);
  return mesh;
}

}  // namespace

AnyMesh parse_node_mesh(const NodeMeshSources& sources, Observer& observer, FaultySimplices faulty) {
  TextScanner scanner(sources.node, '#', observer);
  const NodeHeader header = read_node_header(scanner);
  if (required_dimension(header, scanner) == 2)
    return read_mesh_of_dimension<2>(scanner, header, sources, observer, faulty);
  return read_mesh_of_dimension<3>(scanner, header, sources, observer, faulty);
}

}  // namespace voropack::io
