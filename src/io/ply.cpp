// PLY of Stanford: text and binary of either byte order, with any properties in any order.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "base/number_text.h"
#include "io/readers.h"
#include "io/text_scanner.h"

namespace voropack::io {

namespace {

enum class Encoding : std::uint8_t { kText, kLittleEndian, kBigEndian };
enum class Scalar : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat64;
  std::optional<Scalar> list_count;  ///< Present for a list.
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
};

Scalar parse_type(const TextScanner& scanner, std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames[i][0] || name == kNames[i][1]) return static_cast<Scalar>(i);
  scanner.fail("io.bad_header", fmt::format("the type {} of a property is not known", quote(name)),
               "use char, uchar, short, ushort, int, uint, float or double");
}

Encoding parse_encoding(TextScanner& scanner) {
  scanner.next_line("format line");
  const std::string_view keyword = scanner.token(), encoding = scanner.token(), version = scanner.token();
  if (keyword == "format" && version == "1.0") {
    if (encoding == "ascii") return Encoding::kText;
    if (encoding == "binary_little_endian") return Encoding::kLittleEndian;
    if (encoding == "binary_big_endian") return Encoding::kBigEndian;
  }
  scanner.fail("io.bad_header", "the second line of the header does not give a known format",
               "write: format ascii 1.0, or binary_little_endian or binary_big_endian in place of ascii");
}

Header parse_header(TextScanner& scanner) {
  scanner.next_line("header");
  if (scanner.token() != "ply")
    scanner.fail("io.bad_header", "the file does not begin with the word ply",
                 "give the file the extension of its format");
  Header header;
  header.encoding = parse_encoding(scanner);
  for (;;) {
    scanner.next_line("header");
    const std::string_view keyword = scanner.token();
    if (keyword == "end_header") return header;
    if (keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "element") {
      Element element;
      element.name = scanner.token();
      element.count = scanner.count("number of elements");
      header.elements.push_back(std::move(element));
    } else if (keyword == "property" && !header.elements.empty()) {
      Property property;
      std::string_view type = scanner.token();
      if (type == "list") {
        property.list_count = parse_type(scanner, scanner.token());
        type = scanner.token();
      }
      property.type = parse_type(scanner, type);
      property.name = scanner.token();
      header.elements.back().properties.push_back(std::move(property));
    } else {
      scanner.fail("io.bad_header", fmt::format("the header has the line {}", quote(keyword)),
                   "lines of the header begin with comment, element, property or end_header");
    }
    scanner.end_of_line();
  }
}

/// Reads one value after another from the text behind the header.
class TextValues {
 public:
  TextValues(TextScanner& scanner, Encoding) : scanner_(scanner) {}
  void begin_element(const Element& element, std::uint64_t i) { scanner_.next_line(element.name, i); }
  void end_element() { scanner_.end_of_line(); }
  double read(Scalar, std::string_view name) { return scanner_.number(name); }
  void skip(Scalar, std::uint64_t n, std::string_view name) {
    for (std::uint64_t i = 0; i < n; ++i)
      if (scanner_.token().empty())
        fail("io.missing_value", fmt::format("the line ends before the {} values of {}", n, name), "complete the line");
  }
  void end_of_file() { scanner_.end_of_file("element"); }
  [[nodiscard]] std::uint64_t bytes_left() const { return scanner_.bytes_left(); }
  /// Bytes that one value takes at least.
  static std::uint64_t min_bytes(Scalar) { return 2; }
  [[nodiscard]] std::optional<std::uint64_t> line() const { return scanner_.line(); }
  [[noreturn]] void fail(std::string id, std::string_view message, std::string fix) const {
    scanner_.fail(std::move(id), fmt::format("{}: {}", scanner_.element(), message), std::move(fix));
  }

 private:
  TextScanner& scanner_;
};

/// The same for binary files.
class BinaryValues {
 public:
  BinaryValues(const TextScanner& scanner, Encoding encoding)
      : file_(scanner.file()),
        rest_(scanner.rest()),
        swap_((encoding == Encoding::kBigEndian) == (std::endian::native == std::endian::little)) {
    start_ = rest_.data();
  }
  void begin_element(const Element& element, std::uint64_t i) {
    kind_ = element.name;
    number_ = i;
  }
  void end_element() {}
  double read(Scalar type, std::string_view name) {
    const std::size_t size = size_of(type);
    if (rest_.size() < size) truncated(name);
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), rest_.data(), size);
    rest_.remove_prefix(size);
    if (swap_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    const double value = to_double(type, raw.data());
    if (!std::isfinite(value))
      fail("io.not_finite", fmt::format("the {} is not a finite number", name), "correct or remove the element");
    return value;
  }
  void skip(Scalar type, std::uint64_t n, std::string_view name) {
    if (n > rest_.size() / size_of(type)) truncated(name);
    rest_.remove_prefix(n * size_of(type));
  }
  void end_of_file() {
    if (rest_.empty() || rest_.find_first_not_of(" \t\r\n") == std::string_view::npos) return;
    io::fail(file_, "io.bad_count", fmt::format("the file goes on for {} bytes after the last element", rest_.size()),
             "correct the counts of the header, or remove the rest");
  }
  [[nodiscard]] std::uint64_t bytes_left() const { return rest_.size(); }
  static std::uint64_t min_bytes(Scalar type) { return size_of(type); }
  [[nodiscard]] std::optional<std::uint64_t> line() const { return {}; }
  [[noreturn]] void fail(std::string id, std::string_view message, std::string fix) const {
    io::fail(file_, std::move(id),
             fmt::format("{} {}, {} bytes behind the header: {}", kind_, number_, rest_.data() - start_, message),
             std::move(fix));
  }

 private:
  template <class T>
  static double value_of(const char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }
  static double to_double(Scalar type, const char* raw) {
    switch (type) {
      case Scalar::kInt8:
        return value_of<std::int8_t>(raw);
      case Scalar::kUint8:
        return value_of<std::uint8_t>(raw);
      case Scalar::kInt16:
        return value_of<std::int16_t>(raw);
      case Scalar::kUint16:
        return value_of<std::uint16_t>(raw);
      case Scalar::kInt32:
        return value_of<std::int32_t>(raw);
      case Scalar::kUint32:
        return value_of<std::uint32_t>(raw);
      case Scalar::kFloat32:
        return value_of<float>(raw);
      case Scalar::kFloat64:
        break;
    }
    return value_of<double>(raw);
  }
  [[noreturn]] void truncated(std::string_view name) const {
    fail("io.truncated", fmt::format("the file ends before the {}", name),
         "check that the file is complete and that its counts are right");
  }

  std::string file_;
  std::string_view rest_;
  const char* start_;
  bool swap_;
  std::string_view kind_;
  std::uint64_t number_ = 0;
};

template <class Values>
std::uint64_t read_list_length(Values& values, const Property& property) {
  const double length = values.read(*property.list_count, property.name);
  const auto bytes_left = static_cast<double>(values.bytes_left() + 1);
  if (length < 0 || length != std::floor(length) || length > bytes_left)
    values.fail("io.bad_count", fmt::format("the list {} has the length {}", property.name, length),
                "correct the length, or check that the file is complete");
  if (length * static_cast<double>(Values::min_bytes(property.type)) > bytes_left)
    values.fail("io.truncated", fmt::format("the file ends before the {} values of {}", length, property.name),
                "check that the file is complete and that its counts are right");
  return static_cast<std::uint64_t>(length);
}

template <class Values>
void skip_property(Values& values, const Property& property) {
  values.skip(property.type, property.list_count ? read_list_length(values, property) : 1, property.name);
}

template <class Values>
void read_vertices(Values& values, const Element& element, std::vector<Vec<3>>& points) {
  std::array<bool, 3> present{};
  for (const Property& property : element.properties)
    for (std::size_t k = 0; k < 3; ++k)
      if (property.name == std::string(1, static_cast<char>('x' + k)) && !property.list_count) present[k] = true;
  if (!present[0] || !present[1] || !present[2])
    values.fail("io.bad_header", "vertices lack one of the properties x, y, z", "export the coordinates");
  points.reserve(std::min(element.count, values.bytes_left() / 3 + 1));
  for (std::uint64_t i = 0; i < element.count; ++i) {
    values.begin_element(element, i);
    Vec<3> point;
    for (const Property& property : element.properties) {
      const bool is_coordinate = property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z';
      if (is_coordinate && !property.list_count)
        point[property.name[0] - 'x'] = values.read(property.type, property.name);
      else
        skip_property(values, property);
    }
    values.end_element();
    points.push_back(point);
  }
}

template <class Values>
void read_faces(Values& values, const Element& element, std::uint64_t n_points, DomainInput<3>& input) {
  input.facets.reserve(std::min(element.count, values.bytes_left() / 4 + 1));
  for (std::uint64_t i = 0; i < element.count; ++i) {
    values.begin_element(element, i);
    DomainInput<3>::Facet facet;
    facet.line = values.line();
    for (const Property& property : element.properties) {
      const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
      if (!is_corners || !property.list_count || !facet.polygons.empty()) {
        skip_property(values, property);
        continue;
      }
      std::vector<std::uint32_t> corners(read_list_length(values, property));
      for (std::uint32_t& corner : corners) {
        const double index = values.read(property.type, property.name);
        if (!(index >= 0 && index < static_cast<double>(n_points)) || index != std::floor(index))
          values.fail("io.bad_index", fmt::format("the corner {} is not one of the {} vertices", index, n_points),
                      "correct the index; vertices are counted from 0 and come before faces");
        corner = static_cast<std::uint32_t>(index);
      }
      if (corners.empty()) values.fail("io.bad_count", "the face has no corners", "remove the face");
      facet.polygons.push_back(std::move(corners));
    }
    values.end_element();
    if (facet.polygons.empty())
      values.fail("io.bad_header", "faces lack the list property vertex_indices", "export the corners of the faces");
    input.facets.push_back(std::move(facet));
  }
}

template <class Values>
void check_element_count(const Values& values, const Element& element, const std::string& file) {
  std::uint64_t bytes = 0;
  for (const Property& property : element.properties)
    bytes += Values::min_bytes(property.list_count ? *property.list_count : property.type);
  if (element.count > 0 && (bytes == 0 || element.count > (values.bytes_left() + 1) / bytes))
    fail(file, "io.truncated",
         fmt::format("the header announces {} elements {} of {} bytes or more each, but {} bytes remain", element.count,
                     quote(element.name), bytes, values.bytes_left()),
         "check that the file is complete and that its counts are right");
}

template <class Values>
void read_body(TextScanner& scanner, const Header& header, DomainInput<3>& input) {
  Values values(scanner, header.encoding);
  for (const Element& element : header.elements) {
    check_element_count(values, element, scanner.file());
    if (element.name == "vertex") {
      read_vertices(values, element, input.points);
    } else if (element.name == "face") {
      read_faces(values, element, input.points.size(), input);
    } else {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        values.begin_element(element, i);
        for (const Property& property : element.properties) skip_property(values, property);
        values.end_element();
      }
    }
  }
  values.end_of_file();
}

}  // namespace

DomainInput<3> parse_ply(const Source& source, Observer& observer) {
  TextScanner scanner(source, '\0', observer);
  const Header header = parse_header(scanner);
  const auto has = [&](std::string_view name) {
    for (const Element& element : header.elements)
      if (element.name == name) return true;
    return false;
  };
  if (!has("vertex") || !has("face"))
    fail(source.file, has("tristrips") ? "io.unsupported" : "io.bad_header",
         fmt::format("the file has no element {}", has("vertex") ? "face" : "vertex"),
         "export the surface with vertices and faces, not as points or strips");
  DomainInput<3> input;
  input.is_surface = true;
  input.file = source.file;
  if (header.encoding == Encoding::kText)
    read_body<TextValues>(scanner, header, input);
  else
    read_body<BinaryValues>(scanner, header, input);
  return input;
}

}  // namespace voropack::io
