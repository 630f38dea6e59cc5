// STL, text and binary. It has no indices: equal coordinates are one point.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "base/random.h"
#include "io/readers.h"
#include "io/text_scanner.h"

namespace voropack::io {

namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;

static_assert(std::endian::native == std::endian::little, "binary STL is read without swapping");

/// Gives equal points equal indices.
class PointWelder {
 public:
  PointWelder(std::vector<Vec<3>>& points, std::size_t capacity) : points_(points) {
    std::size_t n_slots = 16;
    while (n_slots < 2 * capacity) n_slots *= 2;
    slots_.assign(n_slots, kEmpty);
  }

  std::uint32_t index_of(Vec<3> point) {
    point += Vec<3>();  // Turns -0.0 into 0.0, which is equal but has other bits.
    std::size_t i = hash_words(std::bit_cast<std::uint64_t>(point[0]), std::bit_cast<std::uint64_t>(point[1]),
                               std::bit_cast<std::uint64_t>(point[2])) &
                    (slots_.size() - 1);
    while (slots_[i] != kEmpty && points_[slots_[i]] != point) i = (i + 1) & (slots_.size() - 1);
    if (slots_[i] == kEmpty) {
      slots_[i] = static_cast<std::uint32_t>(points_.size());
      points_.push_back(point);
    }
    return slots_[i];
  }

 private:
  static constexpr std::uint32_t kEmpty = ~std::uint32_t{0};
  std::vector<Vec<3>>& points_;
  std::vector<std::uint32_t> slots_;
};

void add_triangle(DomainInput<3>& input, const std::array<std::uint32_t, 3>& corners,
                  std::optional<std::uint64_t> line) {
  DomainInput<3>::Facet facet;
  facet.polygons.push_back({corners.begin(), corners.end()});
  facet.line = line;
  input.facets.push_back(std::move(facet));
}

void expect_word(TextScanner& scanner, std::string_view word) {
  const std::string_view found = scanner.token_across_lines();
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  if (!std::equal(found.begin(), found.end(), word.begin(), word.end(), same))
    scanner.fail("io.unexpected_word",
                 fmt::format("{}: {} stands where {} should stand", scanner.element(), quote(found), word),
                 "correct the line; polygons of more than 3 corners are not allowed in STL");
}

bool next_is(const TextScanner& scanner, std::string_view word) {
  TextScanner ahead(scanner);
  while (ahead.at_end_of_line())
    if (!ahead.next_line()) return false;
  const std::string_view found = ahead.token();
  return std::equal(found.begin(), found.end(), word.begin(), word.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

void parse_text(const Source& source, Observer& observer, DomainInput<3>& input) {
  constexpr std::size_t kSmallestTriangle = 80;  // "facet normal 0 0 0 outer loop vertex 0 0 0 ... endloop endfacet"
  TextScanner scanner(source, '\0', observer);
  PointWelder welder(input.points, 3 * (source.bytes.size() / kSmallestTriangle + 1));
  scanner.next_line("header");
  std::uint64_t n = 0;
  do {
    expect_word(scanner, "solid");
    scanner.skip_line();  // Its name.
    while (next_is(scanner, "facet")) {
      while (scanner.at_end_of_line()) scanner.next_line("facet", n);
      scanner.set_element("facet", n++);
      const std::uint64_t line = scanner.line();
      expect_word(scanner, "facet");
      expect_word(scanner, "normal");
      for (int k = 0; k < 3; ++k) scanner.token_across_lines();  // Unused, and often "nan" in degenerate facets.
      expect_word(scanner, "outer");
      expect_word(scanner, "loop");
      std::array<std::uint32_t, 3> corners{};
      for (std::uint32_t& corner : corners) {
        expect_word(scanner, "vertex");
        Vec<3> point;
        point[0] = scanner.number("x coordinate");
        point[1] = scanner.number("y coordinate");
        point[2] = scanner.number("z coordinate");
        corner = welder.index_of(point);
      }
      expect_word(scanner, "endloop");
      expect_word(scanner, "endfacet");
      add_triangle(input, corners, line);
    }
    expect_word(scanner, "endsolid");
    scanner.skip_line();
  } while (next_is(scanner, "solid"));
  scanner.end_of_file("solid");
}

void parse_binary(const Source& source, std::uint32_t n, Observer& observer, DomainInput<3>& input) {
  check_id_range(source.file, "triangle corner", std::uint64_t{3} * n);
  PointWelder welder(input.points, 3 * std::size_t{n});
  input.facets.reserve(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    constexpr std::uint32_t kTrianglesPerCheck = 1U << 16U;
    if (i % kTrianglesPerCheck == 0) {
      observer.check_cancelled();
      observer.progress(i, n);
    }
    const std::size_t at = kHeaderBytes + std::size_t{i} * kTriangleBytes;
    std::array<float, 12> values{};  // Normal and three corners.
    std::memcpy(values.data(), source.bytes.data() + at, sizeof values);
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec<3> point{values[3 + 3 * c], values[4 + 3 * c], values[5 + 3 * c]};
      if (!is_finite(point))
        fail(source.file, "io.not_finite",
             fmt::format("triangle {} (counted from 0) at byte {}: corner {} has a coordinate that is not finite", i,
                         at, c),
             "correct or remove the triangle");
      corners[c] = welder.index_of(point);
    }
    add_triangle(input, corners, {});
  }
}

bool begins_with_solid(std::string_view bytes) {
  const std::size_t start = bytes.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos) return false;
  std::string word(bytes.substr(start, 5));
  for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return word == "solid";
}

}  // namespace

DomainInput<3> parse_stl(const Source& source, Observer& observer) {
  DomainInput<3> input;
  input.is_surface = true;
  input.file = source.file;
  std::uint32_t n = 0;
  if (source.bytes.size() >= kHeaderBytes) std::memcpy(&n, source.bytes.data() + kHeaderBytes - sizeof n, sizeof n);
  const std::uint64_t binary_size = kHeaderBytes + std::uint64_t{n} * kTriangleBytes;
  // Many binary files begin with "solid" too: the size decides.
  if (source.bytes.size() >= kHeaderBytes && source.bytes.size() == binary_size) {
    parse_binary(source, n, observer, input);
  } else if (begins_with_solid(source.bytes.starts_with("\xEF\xBB\xBF") ? source.bytes.substr(3) : source.bytes)) {
    parse_text(source, observer, input);
  } else if (source.bytes.size() < binary_size || source.bytes.size() < kHeaderBytes) {
    fail(
        source.file, "io.truncated",
        source.bytes.size() < kHeaderBytes
            ? fmt::format("the file has {} bytes; a binary STL file has at least {}", source.bytes.size(), kHeaderBytes)
            : fmt::format("the file has {} bytes; {} triangles, as announced at byte 80, need {}", source.bytes.size(),
                          n, binary_size),
        "check that the file is complete and is STL; STL in text begins with the word solid");
  } else {
    fail(source.file, "io.bad_count",
         fmt::format("the file has {} bytes, but ends at byte {} after the {} triangles announced at byte 80",
                     source.bytes.size(), binary_size, n),
         "correct the number of triangles, or remove the rest");
  }
  return input;
}

}  // namespace voropack::io
