// The values of DataArray elements: text, base64 or raw; inside the element or appended; compressed by zlib or not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/xml.h"

namespace voropack::io {

class VtuData {
 public:
  /// `root` is the VTKFile element. Throws: InputError io.unsupported, io.bad_xml.
  VtuData(const Source& source, const XmlDocument& document);

  /// The values of `array`, exactly `n` of them, converted to T (double or std::int64_t). Nothing is allocated on the
  /// word of a count alone. Throws: InputError io.bad_count, io.bad_number, io.bad_data, io.truncated, io.unsupported.
  template <class T>
  std::vector<T> read(const XmlElement& array, std::uint64_t n) const;

  [[noreturn]] void fail(const XmlElement& array, std::string id, std::string_view message, std::string fix) const;

 private:
  template <class T>
  std::vector<T> read_text(const XmlElement& array, std::uint64_t n) const;
  std::string read_bytes(const XmlElement& array, std::uint64_t n_bytes) const;

  std::string file_;
  std::size_t word_size_ = 4;  ///< Of the numbers in front of binary data.
  bool swap_ = false;
  bool is_compressed_ = false;
  std::string_view appended_;
  bool appended_is_raw_ = false;
};

}  // namespace voropack::io
