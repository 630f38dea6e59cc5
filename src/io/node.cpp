#include "io/node.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "io/readers.h"

namespace voropack::io {

namespace {

constexpr std::array<std::string_view, 3> kCoordinateNames = {"x coordinate", "y coordinate", "z coordinate"};

template <int D>
DomainInput<D> node_domain(TextScanner& scanner, const NodeHeader& header) {
  NodeList<D> nodes = read_node_list<D>(scanner, header);
  scanner.end_of_file("point");
  DomainInput<D> input;
  input.points = std::move(nodes.points);
  for (const int marker : nodes.markers)
    input.point_markers.push_back(marker != 0 ? std::optional(marker) : std::nullopt);
  input.first_index = nodes.first_index;
  input.file = scanner.file();
  return input;
}

}  // namespace

bool read_marker_flag(TextScanner& scanner) {
  const std::int64_t flag = scanner.integer("number of markers");
  if (flag != 0 && flag != 1)
    scanner.fail("io.bad_count", fmt::format("{}: the number of markers is {}", scanner.element(), flag),
                 "write 1 if each line ends with a marker and 0 if not");
  return flag == 1;
}

int read_region_id(TextScanner& scanner, std::string_view what) {
  const double id = scanner.number(what);
  if (id != std::floor(id) || std::abs(id) > std::numeric_limits<int>::max())
    scanner.fail("io.bad_region",
                 fmt::format("{}: the {} {} is not a whole number of 32 bits", scanner.element(), what, id),
                 "use a whole number such as 1: it becomes the region's id");
  return static_cast<int>(id);
}

NodeHeader read_node_header(TextScanner& scanner) {
  scanner.next_line("header of the points");
  NodeHeader header;
  header.n_points = scanner.count("number of points");
  if (!scanner.at_end_of_line()) {
    const std::int64_t dimension = scanner.integer("dimension");
    if (dimension != 2 && dimension != 3)
      scanner.fail("io.bad_dimension", fmt::format("the header of the points announces dimension {}", dimension),
                   "only dimensions 2 and 3 are supported; the header is <points> <dimension> <attributes> <markers>");
    header.dimension = static_cast<int>(dimension);
  }
  if (!scanner.at_end_of_line()) header.n_attributes = scanner.count("number of attributes");
  if (!scanner.at_end_of_line()) header.has_markers = read_marker_flag(scanner);
  scanner.end_of_line();
  return header;
}

int required_dimension(const NodeHeader& header, const TextScanner& scanner) {
  if (!header.dimension)
    scanner.fail("io.bad_dimension", "the header of the points does not say their dimension",
                 "write the header as <points> <dimension> <attributes> <markers>");
  return *header.dimension;
}

template <int D>
NodeList<D> read_node_list(TextScanner& scanner, const NodeHeader& header) {
  const std::uint64_t columns = 1 + D + header.n_attributes;
  const std::uint64_t capacity = scanner.capacity(header.n_points, 2 * columns);
  NodeList<D> nodes;
  nodes.points.reserve(capacity);
  if (header.n_attributes > 0) nodes.first_attribute.reserve(capacity);
  if (header.has_markers) nodes.markers.reserve(capacity);

  for (std::uint64_t i = 0; i < header.n_points; ++i) {
    scanner.next_line("point", i + nodes.first_index);
    const std::int64_t number = scanner.integer("number of the point");
    if (i == 0 && number == 1) nodes.first_index = 1;
    if (number != static_cast<std::int64_t>(i) + nodes.first_index)
      scanner.fail("io.bad_index",
                   i == 0 ? fmt::format("the first point has the number {}", number)
                          : fmt::format("point {} is followed by point {}", i - 1 + nodes.first_index, number),
                   "number the points from 0 or from 1 on without a gap");
    Vec<D> point;
    for (int k = 0; k < D; ++k) point[k] = scanner.number(kCoordinateNames[static_cast<std::size_t>(k)]);
    nodes.points.push_back(point);
    for (std::uint64_t a = 0; a < header.n_attributes; ++a) {
      const double attribute = scanner.number("attribute");
      if (a == 0) nodes.first_attribute.push_back(attribute);
    }
    if (header.has_markers) nodes.markers.push_back(scanner.small_integer("marker"));
    scanner.end_of_line();
  }
  return nodes;
}

AnyDomainInput parse_node_domain(const Source& source, Observer& observer) {
  TextScanner scanner(source, '#', observer);
  const NodeHeader header = read_node_header(scanner);
  if (required_dimension(header, scanner) == 2) return node_domain<2>(scanner, header);
  return node_domain<3>(scanner, header);
}

template NodeList<2> read_node_list<2>(TextScanner&, const NodeHeader&);
template NodeList<3> read_node_list<3>(TextScanner&, const NodeHeader&);

}  // namespace voropack::io
