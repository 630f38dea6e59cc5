// OFF of Geomview: a surface of polygons. Colors, normals and texture coordinates are skipped.
#include <fmt/format.h>

#include "io/readers.h"
#include "io/text_scanner.h"

namespace voropack::io {

namespace {

/// What [ST][C][N]OFF in the header adds to each vertex line.
struct OffColumns {
  int n_fixed_extra = 0;  ///< Normals and texture coordinates.
  bool has_color = false;
};

OffColumns parse_keyword(const TextScanner& scanner, std::string_view keyword) {
  OffColumns columns;
  std::string_view prefix = keyword;
  if (prefix.ends_with("OFF")) {
    prefix.remove_suffix(3);
    if (prefix.starts_with("ST")) {
      columns.n_fixed_extra += 2;
      prefix.remove_prefix(2);
    }
    if (prefix.starts_with("C")) {
      columns.has_color = true;
      prefix.remove_prefix(1);
    }
    if (prefix.starts_with("N")) {
      columns.n_fixed_extra += 3;
      prefix.remove_prefix(1);
    }
    if (prefix.empty()) return columns;
    if (prefix == "4" || prefix == "n" || prefix == "4n")
      scanner.fail("io.unsupported", fmt::format("{} has points of more than 3 coordinates", quote(keyword)),
                   "convert the file to plain OFF");
  }
  scanner.fail("io.bad_header", fmt::format("the file begins with {}, not with OFF", quote(keyword)),
               "begin the file with a line that says OFF, or give the file the extension of its format");
}

void read_vertices(TextScanner& scanner, std::uint64_t n, const OffColumns& columns, std::vector<Vec<3>>& points) {
  constexpr int kMaxColorValues = 4;
  points.reserve(scanner.capacity(n, 6));
  for (std::uint64_t i = 0; i < n; ++i) {
    scanner.next_line("vertex", i);
    Vec<3> point;
    point[0] = scanner.number("x coordinate");
    point[1] = scanner.number("y coordinate");
    point[2] = scanner.number("z coordinate");
    points.push_back(point);
    for (int k = 0; k < columns.n_fixed_extra; ++k) scanner.number("normal or texture coordinate");
    if (columns.has_color)
      for (int k = 0; k < kMaxColorValues && !scanner.at_end_of_line(); ++k) scanner.number("color");
    scanner.end_of_line();
  }
}

void read_faces(TextScanner& scanner, std::uint64_t n, DomainInput<3>& input) {
  constexpr int kMaxColorValues = 4;
  input.facets.reserve(scanner.capacity(n, 4));
  for (std::uint64_t i = 0; i < n; ++i) {
    scanner.next_line("face", i);
    DomainInput<3>::Facet facet;
    facet.line = scanner.line();
    const std::uint64_t n_corners = scanner.count("number of corners");
    if (n_corners == 0) scanner.fail("io.bad_count", fmt::format("face {} has no corners", i), "remove the face");
    std::vector<std::uint32_t> corners;
    corners.reserve(scanner.capacity(n_corners, 2));
    for (std::uint64_t k = 0; k < n_corners; ++k) corners.push_back(scanner.index("vertex", 0, input.points.size()));
    facet.polygons.push_back(std::move(corners));
    for (int k = 0; k < kMaxColorValues && !scanner.at_end_of_line(); ++k) scanner.number("color");
    scanner.end_of_line();
    input.facets.push_back(std::move(facet));
  }
}

}  // namespace

DomainInput<3> parse_off(const Source& source, Observer& observer) {
  TextScanner scanner(source, '#', observer);
  scanner.next_line("header");
  const std::string_view keyword = scanner.token();
  const OffColumns columns = parse_keyword(scanner, keyword);
  if (scanner.at_end_of_line()) scanner.next_line("header");
  if (TextScanner(scanner).token() == "BINARY")
    scanner.fail("io.unsupported", "binary OFF is not supported", "convert the file to OFF in text");
  const std::uint64_t n_vertices = scanner.count("number of vertices");
  const std::uint64_t n_faces = scanner.count("number of faces");
  if (!scanner.at_end_of_line()) scanner.integer("number of edges");  // Nobody keeps it right; unused.
  scanner.end_of_line();

  DomainInput<3> input;
  input.is_surface = true;
  input.file = scanner.file();
  read_vertices(scanner, n_vertices, columns, input.points);
  read_faces(scanner, n_faces, input);
  scanner.end_of_file("face");
  return input;
}

}  // namespace voropack::io
