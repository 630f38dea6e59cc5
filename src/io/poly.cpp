// Piecewise linear complexes: .poly of Triangle (2D) and of TetGen (3D), and .smesh of TetGen.
#include <fmt/format.h>

#include "io/node.h"
#include "io/readers.h"

namespace voropack::io {

namespace {

enum class Kind { kPoly, kSmesh };

std::optional<int> marker_or_none(int marker) { return marker != 0 ? std::optional(marker) : std::nullopt; }

template <int D>
Vec<D> read_position(TextScanner& scanner) {
  Vec<D> position;
  position[0] = scanner.number("x coordinate");
  position[1] = scanner.number("y coordinate");
  if constexpr (D == 3) position[2] = scanner.number("z coordinate");
  return position;
}

/// Reads the parts of a .poly or .smesh file that follow its points, in the order of the file.
template <int D>
class ComplexReader {
 public:
  ComplexReader(TextScanner& scanner, NodeList<D> nodes) : scanner_(scanner) {
    first_ = nodes.first_index;
    input_.points = std::move(nodes.points);
    input_.point_markers.reserve(nodes.markers.size());
    for (const int marker : nodes.markers) input_.point_markers.push_back(marker_or_none(marker));
    input_.first_index = first_;
    input_.file = scanner.file();
  }

  /// `<segments> <markers>`, then `<number> <a> <b> [marker]`.
  void read_segments() {
    const Header header = read_header("segment", "header of the segments");
    input_.segments.reserve(scanner_.capacity(header.n, 6));
    for (std::uint64_t i = 0; i < header.n; ++i) {
      scanner_.next_line("segment", i + first_);
      scanner_.integer("number of the segment");
      typename DomainInput<D>::Segment segment{};
      segment.line = scanner_.line();
      for (std::uint32_t& point : segment.points) point = read_index();
      if (header.has_markers) segment.marker = marker_or_none(scanner_.small_integer("marker"));
      scanner_.end_of_line();
      input_.segments.push_back(segment);
    }
  }

  /// .poly: `<polygons> [holes] [marker]`, then the polygons and holes of the facet, each on its own lines.
  /// .smesh: one polygon for each facet, `<corners> <a> <b> ... [marker]`.
  void read_facets(Kind kind) {
    const Header header = read_header("facet", "header of the facets");
    input_.facets.reserve(scanner_.capacity(header.n, 4));
    for (std::uint64_t i = 0; i < header.n; ++i) {
      const std::uint64_t number = i + first_;
      scanner_.next_line("facet", number);
      Facet facet;
      facet.line = scanner_.line();
      FacetParts parts;
      if (kind == Kind::kPoly)
        parts = read_parts();
      else
        facet.polygons.push_back(read_polygon());
      if (header.has_markers && !scanner_.at_end_of_line())
        facet.marker = marker_or_none(scanner_.small_integer("marker"));
      scanner_.end_of_line();
      if (kind == Kind::kPoly) read_polygons_and_holes(facet, number, parts);
      input_.facets.push_back(std::move(facet));
    }
  }

  /// `<holes>`, then `<number> <position>`. May be left out at the end of the file.
  void read_holes() {
    const std::uint64_t n = read_optional_count("header of the holes", "number of holes");
    input_.hole_seeds.reserve(scanner_.capacity(n, 2 * (D + 1)));
    for (std::uint64_t i = 0; i < n; ++i) {
      scanner_.next_line("hole", i + first_);
      scanner_.integer("number of the hole");
      input_.hole_seeds.push_back(read_position<D>(scanner_));
      scanner_.end_of_line();
    }
  }

  /// `<regions>`, then `<number> <position> <attribute> [largest area or volume]`. May be left out.
  void read_regions() {
    const std::uint64_t n = read_optional_count("header of the regions", "number of regions");
    input_.region_seeds.reserve(scanner_.capacity(n, 2 * (D + 2)));
    for (std::uint64_t i = 0; i < n; ++i) {
      scanner_.next_line("region", i + first_);
      scanner_.integer("number of the region");
      typename DomainInput<D>::RegionSeed seed{read_position<D>(scanner_), {}, {}};
      seed.id = read_region_id(scanner_, "attribute");
      if (!scanner_.at_end_of_line()) {
        const double largest = scanner_.number(D == 2 ? "largest area" : "largest volume");
        if (largest > 0) seed.max_measure = largest;
      }
      scanner_.end_of_line();
      input_.region_seeds.push_back(seed);
    }
    scanner_.end_of_file("region");
  }

  DomainInput<D> take() { return std::move(input_); }

 private:
  using Facet = typename DomainInput<D>::Facet;
  struct Header {
    std::uint64_t n = 0;
    bool has_markers = false;
  };
  struct FacetParts {
    std::uint64_t n_polygons = 0, n_holes = 0;
  };

  Header read_header(std::string_view kind, std::string_view name) {
    scanner_.next_line(name);
    Header header;
    header.n = scanner_.count(fmt::format("number of {}s", kind));
    if (!scanner_.at_end_of_line()) header.has_markers = read_marker_flag(scanner_);
    scanner_.end_of_line();
    return header;
  }

  FacetParts read_parts() {
    FacetParts parts;
    parts.n_polygons = scanner_.count("number of polygons");
    if (!scanner_.at_end_of_line()) parts.n_holes = scanner_.count("number of holes");
    return parts;
  }

  void read_polygons_and_holes(Facet& facet, std::uint64_t number, const FacetParts& parts) {
    if (parts.n_polygons == 0)
      scanner_.fail("io.bad_count", fmt::format("facet {} has no polygons", number), "remove the facet");
    facet.polygons.reserve(scanner_.capacity(parts.n_polygons, 4));
    for (std::uint64_t p = 0; p < parts.n_polygons; ++p) {
      scanner_.next_line("polygon of facet", number);
      facet.polygons.push_back(read_polygon());
      scanner_.end_of_line();
    }
    facet.holes.reserve(scanner_.capacity(parts.n_holes, 8));
    for (std::uint64_t h = 0; h < parts.n_holes; ++h) {
      scanner_.next_line("hole of facet", number);
      scanner_.integer("number of the hole");
      facet.holes.push_back(read_position<D>(scanner_));
      scanner_.end_of_line();
    }
  }

  std::uint64_t read_optional_count(std::string_view element, std::string_view what) {
    if (!TextScanner(scanner_).next_line()) return 0;
    scanner_.next_line(element);
    const std::uint64_t n = scanner_.count(what);
    scanner_.end_of_line();
    return n;
  }

  std::uint32_t read_index() { return scanner_.index("point", first_, input_.points.size()); }

  /// `<corners> <a> <b> ...`, which may go on on the following lines.
  std::vector<std::uint32_t> read_polygon() {
    const std::uint64_t n = scanner_.count("number of corners");
    if (n == 0) scanner_.fail("io.bad_count", scanner_.element() + " has no corners", "remove it");
    std::vector<std::uint32_t> corners;
    corners.reserve(scanner_.capacity(n, 2));
    for (std::uint64_t k = 0; k < n; ++k) {
      if (scanner_.at_end_of_line() && !scanner_.next_line())
        scanner_.fail("io.truncated",
                      fmt::format("the file ends at {}, after {} of its {} corners", scanner_.element(), k, n),
                      "check that the file is complete");
      corners.push_back(read_index());
    }
    return corners;
  }

  TextScanner& scanner_;
  std::uint32_t first_ = 0;
  DomainInput<D> input_;
};

template <int D>
DomainInput<D> read_complex(TextScanner& scanner, NodeList<D> nodes, Kind kind) {
  ComplexReader<D> reader(scanner, std::move(nodes));
  if constexpr (D == 2)
    reader.read_segments();
  else
    reader.read_facets(kind);
  reader.read_holes();
  reader.read_regions();
  return reader.take();
}

AnyDomainInput parse_complex(const Source& source, const NodeFileOpener& open_node, Kind kind, Observer& observer) {
  TextScanner scanner(source, '#', observer);
  const NodeHeader header = read_node_header(scanner);

  const auto read_nodes_and_rest = [&](TextScanner& node_scanner, const NodeHeader& node_header) -> AnyDomainInput {
    const int dimension = required_dimension(node_header, node_scanner);
    if (dimension == 2 && kind == Kind::kSmesh)
      node_scanner.fail("io.bad_dimension", "a .smesh file describes facets in space, but its points have dimension 2",
                        "rename the file to .poly if it is a complex of Triangle");
    if (dimension == 2) return read_complex<2>(scanner, read_node_list<2>(node_scanner, node_header), kind);
    return read_complex<3>(scanner, read_node_list<3>(node_scanner, node_header), kind);
  };
  if (header.n_points > 0) return read_nodes_and_rest(scanner, header);

  const FileContent node_file = open_node();
  TextScanner node_scanner(node_file.source(), '#', observer);
  const NodeHeader node_header = read_node_header(node_scanner);
  if (header.dimension && node_header.dimension && *header.dimension != *node_header.dimension)
    scanner.fail("io.bad_dimension",
                 fmt::format("the header announces dimension {}, but the points in {} have dimension {}",
                             *header.dimension, node_file.file, *node_header.dimension),
                 "correct the header, or put the right .node file beside this one");
  return read_nodes_and_rest(node_scanner, node_header);
}

}  // namespace

AnyDomainInput parse_poly(const Source& source, const NodeFileOpener& open_node, Observer& observer) {
  return parse_complex(source, open_node, Kind::kPoly, observer);
}

AnyDomainInput parse_smesh(const Source& source, const NodeFileOpener& open_node, Observer& observer) {
  return parse_complex(source, open_node, Kind::kSmesh, observer);
}

}  // namespace voropack::io
