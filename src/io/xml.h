// A reader for the XML that VTK writes: elements, attributes and text, as views into the file.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "io/source.h"

namespace voropack::io {

struct XmlElement {
  std::string_view tag;
  std::vector<std::pair<std::string_view, std::string_view>> attributes;
  std::string_view text;                ///< What stands before the first child, undecoded.
  std::vector<std::uint32_t> children;  ///< Indices into XmlDocument::elements.
  std::uint64_t line = 0;               ///< 1-based.
};

struct XmlDocument {
  std::vector<XmlElement> elements;  ///< The root is the first.

  [[nodiscard]] static std::optional<std::string_view> attribute(const XmlElement& element, std::string_view name);
  /// The first child with that tag, or nullptr.
  [[nodiscard]] const XmlElement* child(const XmlElement& parent, std::string_view tag) const;
};

/// Parses `source`. An element with the tag `last_tag` holds all that follows it as text, and ends the document: its
/// content need not be XML. Throws: InputError io.bad_xml.
XmlDocument parse_xml(const Source& source, std::string_view last_tag);

}  // namespace voropack::io
