#include "io/vtu_data.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/number_text.h"

namespace voropack::io {

namespace {

/// The best that the deflate format can do: https://zlib.net/zlib_tech.html. A block that claims more is corrupt.
constexpr std::uint64_t kMaxCompression = 1032;

constexpr std::array<std::int8_t, 256> make_base64_table() {
  std::array<std::int8_t, 256> table{};
  table.fill(-1);
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    table[static_cast<unsigned char>(kDigits[i])] = static_cast<std::int8_t>(i);
  return table;
}
constexpr std::array<std::int8_t, 256> kBase64 = make_base64_table();

/// Bytes in order, decoded from base64 or raw. A padded group may be followed by more: VTK encodes the numbers in front
/// of compressed data apart from the data.
class ByteStream {
 public:
  ByteStream(std::string_view text, bool is_raw) : text_(text), is_raw_(is_raw) {}

  /// Appends n bytes; false if there are not so many.
  bool read(std::uint64_t n, std::string& out) {
    if (n > max_left()) return false;
    if (is_raw_) {
      out.append(text_.substr(0, n));
      text_.remove_prefix(n);
      return true;
    }
    out.reserve(out.size() + n);
    for (; n > 0; --n) {
      if (n_pending_ == 0 && !decode_group()) return false;
      out += static_cast<char>(pending_[next_pending_++]);
      --n_pending_;
    }
    return true;
  }

  /// An upper bound of the bytes that are left.
  [[nodiscard]] std::uint64_t max_left() const { return is_raw_ ? text_.size() : n_pending_ + text_.size(); }

 private:
  bool decode_group() {
    std::uint32_t bits = 0;
    std::size_t n_digits = 0, n_padding = 0;
    while (n_digits + n_padding < 4) {
      if (text_.empty()) return false;
      const char c = text_.front();
      text_.remove_prefix(1);
      if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
      const std::int8_t digit = kBase64[static_cast<unsigned char>(c)];
      if (c == '=' && n_digits >= 2) {
        ++n_padding;
        bits <<= 6U;
      } else if (digit >= 0 && n_padding == 0) {
        ++n_digits;
        bits = bits << 6U | static_cast<std::uint32_t>(digit);
      } else {
        return false;
      }
    }
    pending_ = {static_cast<unsigned char>(bits >> 16U), static_cast<unsigned char>(bits >> 8U),
                static_cast<unsigned char>(bits)};
    n_pending_ = n_digits - 1;
    next_pending_ = 0;
    return true;
  }

  std::string_view text_;
  bool is_raw_;
  std::array<unsigned char, 3> pending_{};
  std::size_t n_pending_ = 0, next_pending_ = 0;
};

template <class T>
T load(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// False if `value` is no whole number, or T cannot hold it.
template <class T, class Stored>
bool convert(Stored value, T& result) {
  if constexpr (std::is_same_v<T, double>) {
    result = static_cast<double>(value);
  } else if constexpr (std::is_floating_point_v<Stored>) {
    constexpr double kLimit = 9.0e18;
    if (!(std::abs(static_cast<double>(value)) < kLimit) || value != std::floor(value)) return false;
    result = static_cast<T>(value);
  } else {
    if (!std::in_range<T>(value)) return false;
    result = static_cast<T>(value);
  }
  return true;
}

template <class Stored, class T>
bool convert_all(std::string_view bytes, bool swap, std::vector<T>& values) {
  values.resize(bytes.size() / sizeof(Stored));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!convert(load<Stored>(bytes.data() + i * sizeof(Stored), swap), values[i])) return false;
  return true;
}

struct StoredType {
  std::string_view name;
  std::uint64_t size;
};
constexpr std::array<StoredType, 10> kStoredTypes = {{{"Float64", 8},
                                                      {"Float32", 4},
                                                      {"Int64", 8},
                                                      {"Int32", 4},
                                                      {"UInt8", 1},
                                                      {"UInt64", 8},
                                                      {"UInt32", 4},
                                                      {"Int8", 1},
                                                      {"Int16", 2},
                                                      {"UInt16", 2}}};

template <class T>
bool convert_type(std::size_t type, std::string_view bytes, bool swap, std::vector<T>& values) {
  switch (type) {
    case 0:
      return convert_all<double>(bytes, swap, values);
    case 1:
      return convert_all<float>(bytes, swap, values);
    case 2:
      return convert_all<std::int64_t>(bytes, swap, values);
    case 3:
      return convert_all<std::int32_t>(bytes, swap, values);
    case 4:
      return convert_all<std::uint8_t>(bytes, swap, values);
    case 5:
      return convert_all<std::uint64_t>(bytes, swap, values);
    case 6:
      return convert_all<std::uint32_t>(bytes, swap, values);
    case 7:
      return convert_all<std::int8_t>(bytes, swap, values);
    case 8:
      return convert_all<std::int16_t>(bytes, swap, values);
    default:
      return convert_all<std::uint16_t>(bytes, swap, values);
  }
}

}  // namespace

VtuData::VtuData(const Source& source, const XmlDocument& document) : file_(source.file) {
  const XmlElement& root = document.elements.front();
  const auto attribute = [&](std::string_view name, std::string_view otherwise) {
    return XmlDocument::attribute(root, name).value_or(otherwise);
  };
  const std::string_view header_type = attribute("header_type", "UInt32");
  if (header_type != "UInt32" && header_type != "UInt64")
    io::fail(file_, "io.unsupported", fmt::format("the header_type {} is not known", quote(header_type)),
             "write the file with header_type UInt64");
  word_size_ = header_type == "UInt64" ? 8 : 4;
  const std::string_view order = attribute("byte_order", "LittleEndian");
  if (order != "LittleEndian" && order != "BigEndian")
    io::fail(file_, "io.unsupported", fmt::format("the byte_order {} is not known", quote(order)),
             "write the file with byte_order LittleEndian");
  swap_ = (order == "BigEndian") == (std::endian::native == std::endian::little);
  const std::string_view compressor = attribute("compressor", "");
  is_compressed_ = compressor == "vtkZLibDataCompressor";
  if (!compressor.empty() && !is_compressed_)
    io::fail(file_, "io.unsupported", fmt::format("data compressed by {} cannot be read", quote(compressor)),
             "write the file with zlib compression or none (ParaView: Compressor Type ZLib)");
  if (const XmlElement* appended = document.child(root, "AppendedData")) {
    const std::size_t start = appended->text.find('_');
    if (start == std::string_view::npos || XmlDocument::attribute(*appended, "encoding").value_or("").empty())
      io::fail(file_, "io.bad_xml", "the appended data does not begin with _, or lacks its encoding",
               "write the file anew", appended->line);
    appended_ = appended->text.substr(start + 1);
    appended_is_raw_ = XmlDocument::attribute(*appended, "encoding") == "raw";
  }
}

void VtuData::fail(const XmlElement& array, std::string id, std::string_view message, std::string fix) const {
  io::fail(file_, std::move(id),
           fmt::format("array {}: {}", quote(XmlDocument::attribute(array, "Name").value_or("")), message),
           std::move(fix), array.line);
}

std::string VtuData::read_bytes(const XmlElement& array, std::uint64_t n_bytes) const {
  const std::string_view format = XmlDocument::attribute(array, "format").value_or("");
  std::uint64_t offset = 0;
  if (format == "appended") {
    const std::string_view text = XmlDocument::attribute(array, "offset").value_or("");
    const std::size_t start = std::min(text.find_first_not_of(' '), text.size());
    if (!parse_integer(text.substr(start, text.find_last_not_of(' ') + 1 - start), offset) || offset > appended_.size())
      fail(array, "io.truncated", fmt::format("its offset {} is not in the appended data", quote(text)),
           "check that the file is complete");
  } else if (format != "binary") {
    fail(array, "io.unsupported", fmt::format("its format {} is not known", quote(format)),
         "write the file with format ascii, binary or appended");
  }
  ByteStream stream(format == "appended" ? appended_.substr(offset) : array.text,
                    format == "appended" && appended_is_raw_);
  const auto truncated = [&]() {
    fail(array, "io.truncated", "its data ends early or is not valid base64", "check that the file is complete");
  };
  const auto word = [&]() -> std::uint64_t {
    std::string bytes;
    if (!stream.read(word_size_, bytes)) truncated();
    return word_size_ == 8 ? load<std::uint64_t>(bytes.data(), swap_) : load<std::uint32_t>(bytes.data(), swap_);
  };
  const auto check_size = [&](std::uint64_t size) {
    if (size != n_bytes)
      fail(array, "io.bad_count", fmt::format("it has {} bytes instead of {}", size, n_bytes),
           "correct the numbers of points and cells");
  };

  std::string bytes;
  if (!is_compressed_) {
    check_size(word());
    if (!stream.read(n_bytes, bytes)) truncated();
    return bytes;
  }
  const std::uint64_t n_blocks = word();
  if (n_blocks == 0) {
    check_size(0);
    return bytes;
  }
  const std::uint64_t block_size = word(), last_size = word();
  if (n_blocks > stream.max_left() / word_size_) truncated();
  std::vector<std::uint64_t> packed_sizes(n_blocks);
  for (std::uint64_t& size : packed_sizes) size = word();
  std::string packed;
  for (std::uint64_t b = 0; b < n_blocks; ++b) {
    packed.clear();
    if (!stream.read(packed_sizes[b], packed)) truncated();
    const std::uint64_t size = b + 1 == n_blocks && last_size != 0 ? last_size : block_size;
    const std::uint64_t start = bytes.size();
    if (size > n_bytes - start) check_size(start + std::min(size, ~start));
    if (size / kMaxCompression > packed.size())
      fail(array, "io.bad_data", fmt::format("block {} claims to hold more than zlib can pack", b),
           "write the file anew");
    bytes.resize(start + size);
    auto unpacked_size = static_cast<uLongf>(size);
    if (uncompress(reinterpret_cast<Bytef*>(bytes.data() + start), &unpacked_size,
                   reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size())) != Z_OK ||
        unpacked_size != size)
      fail(array, "io.bad_data", fmt::format("block {} is not valid zlib data", b), "write the file anew");
  }
  check_size(bytes.size());
  return bytes;
}

template <class T>
std::vector<T> VtuData::read_text(const XmlElement& array, std::uint64_t n) const {
  std::vector<T> values;
  std::string_view text = array.text;
  for (;;) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t\r\n", begin), text.size());
    const std::string_view token = text.substr(begin, end - begin);
    double number = 0;
    T value{};
    bool ok = false;
    if constexpr (std::is_same_v<T, double>) {
      // Infinite and undefined values are for the caller to judge, who knows what they belong to.
      ok = parse_double(token, value) != NumberFault::kNotANumber;
    } else {
      ok = parse_integer(token, value) || (parse_double(token, number) == NumberFault::kNone && convert(number, value));
    }
    if (!ok)
      fail(array, "io.bad_number",
           fmt::format("{} is not a {}number", quote(token), std::is_same_v<T, double> ? "" : "whole "),
           "correct the value");
    values.push_back(value);
    text.remove_prefix(end);
  }
  if (values.size() != n)
    fail(array, "io.bad_count", fmt::format("it has {} values instead of {}", values.size(), n),
         "correct the numbers of points and cells, or the array");
  return values;
}

template <class T>
std::vector<T> VtuData::read(const XmlElement& array, std::uint64_t n) const {
  const std::string_view format = XmlDocument::attribute(array, "format").value_or("ascii");
  if (format == "ascii") return read_text<T>(array, n);
  const std::string_view type_name = XmlDocument::attribute(array, "type").value_or("");
  const auto* type =
      std::find_if(kStoredTypes.begin(), kStoredTypes.end(), [&](const StoredType& t) { return t.name == type_name; });
  if (type == kStoredTypes.end())
    fail(array, "io.unsupported", fmt::format("its type {} is not known", quote(type_name)),
         "use Float64, Float32, Int64, Int32 or UInt8");
  if (n > std::numeric_limits<std::uint64_t>::max() / type->size)
    fail(array, "io.bad_count", fmt::format("{} values are announced", n), "correct the numbers of points and cells");
  std::vector<T> values;
  if (!convert_type(static_cast<std::size_t>(type - kStoredTypes.begin()), read_bytes(array, n * type->size), swap_,
                    values))
    fail(array, "io.bad_number", "it holds a value that is not a whole number of 64 bits", "correct the values");
  return values;
}

template std::vector<double> VtuData::read<double>(const XmlElement&, std::uint64_t) const;
template std::vector<std::int64_t> VtuData::read<std::int64_t>(const XmlElement&, std::uint64_t) const;

}  // namespace voropack::io
