// OBJ of Wavefront: v, f and l. Texture coordinates, normals, groups and materials are skipped.
#include <fmt/format.h>

#include <algorithm>

#include "base/number_text.h"
#include "io/readers.h"
#include "io/text_scanner.h"

namespace voropack::io {

namespace {

constexpr std::array<std::string_view, 15> kSkippedKeywords = {
    "vt", "vn", "vp", "g", "o", "s", "mg", "usemtl", "mtllib", "p", "bevel", "c_interp", "d_interp", "lod", "usemap"};

/// Joins lines that end with a backslash, keeping the number of lines. Empty if there are none.
std::string join_continued_lines(std::string_view bytes) {
  std::string joined;
  if (bytes.find('\\') == std::string_view::npos) return joined;
  joined = bytes;
  std::size_t n_joined = 0;
  const std::size_t size = joined.size();
  std::string result;
  result.reserve(size);
  for (std::size_t i = 0; i < size; ++i) {
    std::size_t next = i + 1;
    if (joined[i] == '\\' && next < size && joined[next] == '\r') ++next;
    if (joined[i] == '\\' && next < size && joined[next] == '\n') {
      result += ' ';
      ++n_joined;
      i = next;
      continue;
    }
    result += joined[i];
    if (joined[i] == '\n') {
      result.append(n_joined, '\n');  // Empty lines keep later line numbers right.
      n_joined = 0;
    }
  }
  return result;
}

/// The 0-based vertex of a reference `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative numbers count back from the last.
std::uint32_t vertex_of(const TextScanner& scanner, std::string_view reference, std::size_t n_points) {
  const std::string_view text = reference.substr(0, reference.find('/'));
  std::int64_t number = 0;
  if (!parse_integer(text, number))
    scanner.fail("io.bad_number", fmt::format("{}: {} is not a vertex", scanner.element(), quote(reference)),
                 "write the number of a vertex, such as 7 or 7/1/3");
  const auto n = static_cast<std::int64_t>(n_points);
  if (number == 0 || number > n || number < -n)
    scanner.fail("io.bad_index",
                 fmt::format("{}: vertex {} is not one of the {} vertices so far", scanner.element(), number, n),
                 "count vertices from 1, or back from -1, and list them before they are used");
  return static_cast<std::uint32_t>(number > 0 ? number - 1 : n + number);
}

std::vector<std::uint32_t> read_corners(TextScanner& scanner, std::size_t n_points, std::size_t min_corners) {
  std::vector<std::uint32_t> corners;
  while (!scanner.at_end_of_line()) corners.push_back(vertex_of(scanner, scanner.token(), n_points));
  if (corners.size() < min_corners)
    scanner.fail("io.bad_count",
                 fmt::format("{} has {} corners; it needs {} or more", scanner.element(), corners.size(), min_corners),
                 "complete or remove it");
  return corners;
}

}  // namespace

DomainInput<3> parse_obj(const Source& source, Observer& observer) {
  const std::string joined = join_continued_lines(source.bytes);
  TextScanner scanner(joined.empty() ? source : Source{source.file, joined}, '#', observer);
  DomainInput<3> input;
  input.is_surface = true;
  input.first_index = 1;
  input.file = source.file;
  std::size_t n_lines = 0;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.token();
    if (keyword == "v") {
      scanner.set_element("vertex", input.points.size() + 1);
      Vec<3> point;
      point[0] = scanner.number("x coordinate");
      point[1] = scanner.number("y coordinate");
      point[2] = scanner.number("z coordinate");
      constexpr int kMaxWeightAndColor = 4;
      for (int k = 0; k < kMaxWeightAndColor && !scanner.at_end_of_line(); ++k) scanner.number("weight or color");
      scanner.end_of_line();
      input.points.push_back(point);
    } else if (keyword == "f") {
      scanner.set_element("face", input.facets.size() + 1);
      DomainInput<3>::Facet facet;
      facet.line = scanner.line();
      facet.polygons.push_back(read_corners(scanner, input.points.size(), 3));
      input.facets.push_back(std::move(facet));
    } else if (keyword == "l") {
      scanner.set_element("line", ++n_lines);
      const std::vector<std::uint32_t> corners = read_corners(scanner, input.points.size(), 2);
      for (std::size_t k = 0; k + 1 < corners.size(); ++k)
        input.segments.push_back({{corners[k], corners[k + 1]}, {}, scanner.line()});
    } else if (std::find(kSkippedKeywords.begin(), kSkippedKeywords.end(), keyword) == kSkippedKeywords.end()) {
      scanner.set_element("line", scanner.line());
      scanner.fail("io.unexpected_word", fmt::format("the keyword {} is not known", quote(keyword)),
                   "export the model as polygons; free-form curves and surfaces are not supported");
    }
  }
  check_id_range(source.file, "point", input.points.size());
  return input;
}

}  // namespace voropack::io
