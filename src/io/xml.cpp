#include "io/xml.h"

#include <fmt/format.h>

#include <algorithm>

namespace voropack::io {

namespace {

/// A .vtu file has some tens of elements. The limit keeps a malicious file from taking memory.
constexpr std::size_t kMaxElements = 100'000;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

class XmlParser {
 public:
  XmlParser(const Source& source, std::string_view last_tag) : source_(source), last_tag_(last_tag) {
    if (source.bytes.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  XmlDocument parse() {
    while (!done_) {
      const std::size_t open = bytes().find('<', at_);
      if (open == std::string_view::npos) fail("the file ends before the XML is complete");
      if (!open_elements_.empty() && !text_is_over_) {
        XmlElement& element = document_.elements[open_elements_.back()];
        element.text = bytes().substr(at_, open - at_);
      }
      text_is_over_ = true;
      at_ = open;
      if (starts_with("<?"))
        skip_past("?>");
      else if (starts_with("<!--"))
        skip_past("-->");
      else if (starts_with("<!"))
        skip_past(">");
      else if (starts_with("</"))
        close_element();
      else
        open_element();
    }
    return std::move(document_);
  }

 private:
  [[nodiscard]] std::string_view bytes() const { return source_.bytes; }
  [[nodiscard]] bool starts_with(std::string_view text) const { return bytes().substr(at_).starts_with(text); }

  void skip_past(std::string_view text) {
    const std::size_t end = bytes().find(text, at_);
    if (end == std::string_view::npos) fail(fmt::format("{} is missing", text));
    at_ = end + text.size();
  }
  void skip_space() {
    while (at_ < bytes().size() && is_space(bytes()[at_])) ++at_;
  }
  std::string_view name() {
    const std::size_t begin = at_;
    while (at_ < bytes().size() && !is_space(bytes()[at_]) &&
           std::string_view("=/><\"'").find(bytes()[at_]) == std::string_view::npos)
      ++at_;
    if (at_ == begin) fail("a name is missing");
    return bytes().substr(begin, at_ - begin);
  }
  void expect(char c) {
    if (at_ >= bytes().size() || bytes()[at_] != c) fail(fmt::format("{} is missing", c));
    ++at_;
  }

  void open_element() {
    if (document_.elements.size() == kMaxElements) fail("there are too many elements");
    expect('<');
    XmlElement element;
    element.line = line_at(at_);
    element.tag = name();
    for (skip_space(); at_ < bytes().size() && bytes()[at_] != '>' && bytes()[at_] != '/'; skip_space()) {
      const std::string_view key = name();
      skip_space();
      expect('=');
      skip_space();
      const char quote_char = at_ < bytes().size() ? bytes()[at_] : '\0';
      if (quote_char != '"' && quote_char != '\'') fail("the value of an attribute lacks its quotes");
      const std::size_t begin = ++at_;
      skip_past(std::string_view(&quote_char, 1));
      element.attributes.emplace_back(key, bytes().substr(begin, at_ - 1 - begin));
    }
    const bool is_closed = at_ < bytes().size() && bytes()[at_] == '/';
    if (is_closed) ++at_;
    expect('>');
    const auto index = static_cast<std::uint32_t>(document_.elements.size());
    if (!open_elements_.empty())
      document_.elements[open_elements_.back()].children.push_back(index);
    else if (index > 0)
      fail("there is more than one outermost element");
    if (element.tag == last_tag_ && !is_closed) {
      element.text = bytes().substr(at_);
      done_ = true;
    }
    document_.elements.push_back(std::move(element));
    if (is_closed) {
      done_ = done_ || open_elements_.empty();
    } else {
      open_elements_.push_back(index);
      text_is_over_ = false;
    }
  }

  void close_element() {
    at_ += 2;
    const std::string_view tag = name();
    if (open_elements_.empty() || document_.elements[open_elements_.back()].tag != tag)
      fail(fmt::format("</{}> closes nothing", tag));
    skip_space();
    expect('>');
    open_elements_.pop_back();
    done_ = open_elements_.empty();
  }

  /// Counts on from the last call: elements come in order.
  std::uint64_t line_at(std::size_t position) {
    line_ += static_cast<std::uint64_t>(
        std::count(bytes().begin() + static_cast<std::ptrdiff_t>(counted_to_),
                   bytes().begin() + static_cast<std::ptrdiff_t>(std::max(counted_to_, position)), '\n'));
    counted_to_ = std::max(counted_to_, position);
    return line_;
  }

  [[noreturn]] void fail(std::string_view reason) {
    io::fail(source_.file, "io.bad_xml", fmt::format("this is not the XML of a .vtu file: {}", reason),
             "check that the file is complete, and write it anew", line_at(std::min(at_, bytes().size())));
  }

  const Source& source_;
  std::string_view last_tag_;
  std::size_t at_ = 0;
  std::size_t counted_to_ = 0;
  std::uint64_t line_ = 1;
  bool done_ = false;
  bool text_is_over_ = false;
  std::vector<std::uint32_t> open_elements_;
  XmlDocument document_;
};

}  // namespace

std::optional<std::string_view> XmlDocument::attribute(const XmlElement& element, std::string_view name) {
  for (const auto& [key, value] : element.attributes)
    if (key == name) return value;
  return {};
}

const XmlElement* XmlDocument::child(const XmlElement& parent, std::string_view tag) const {
  for (const std::uint32_t index : parent.children)
    if (elements[index].tag == tag) return &elements[index];
  return nullptr;
}

XmlDocument parse_xml(const Source& source, std::string_view last_tag) { return XmlParser(source, last_tag).parse(); }

}  // namespace voropack::io
