#include "case_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include <toml++/toml.h>

#include "suggest.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

CasePlace place_of(const toml::source_region& region) { return {region.begin.line, region.begin.column}; }

CaseValue convert(const toml::node& node);

CaseValue convert_table(const toml::table& table) {
  CaseValue value;
  value.kind = CaseValue::Kind::kTable;
  // toml++ sorts the keys; messages and tables follow the file.
  std::vector<std::pair<const toml::key*, const toml::node*>> entries;
  for (const auto& [key, node] : table) entries.emplace_back(&key, &node);
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    const toml::source_position x = a.first->source().begin, y = b.first->source().begin;
    return x.line < y.line || (x.line == y.line && x.column < y.column);
  });
  for (const auto& [key, node] : entries) {
    value.keys.emplace_back(key->str());
    value.key_places.push_back(place_of(key->source()));
    value.items.push_back(convert(*node));
  }
  return value;
}

CaseValue convert(const toml::node& node) {
  using Kind = CaseValue::Kind;
  CaseValue value;
  if (const toml::table* const table = node.as_table()) {
    value = convert_table(*table);
  } else if (const toml::array* const array = node.as_array()) {
    value.kind = Kind::kArray;
    for (const toml::node& item : *array) value.items.push_back(convert(item));
  } else if (const auto* const text = node.as_string()) {
    value.kind = Kind::kText;
    value.text = text->get();
  } else if (const auto* const integer = node.as_integer()) {
    value.kind = Kind::kNumber;
    value.is_integer = true;
    value.integer = integer->get();
    value.number = static_cast<double>(value.integer);
  } else if (const auto* const number = node.as_floating_point()) {
    value.kind = Kind::kNumber;
    value.number = number->get();
  } else if (node.is_boolean()) {
    value.kind = Kind::kBoolean;
  }
  value.place = place_of(node.source());
  return value;
}

}  // namespace

CaseValue read_case_file(const fs::path& path) {
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  const bool is_empty = fs::is_regular_file(path, ignored) && fs::is_empty(path, ignored);  // `<<` fails on nothing.
  if (!fs::is_regular_file(path, ignored) || (!is_empty && !(content << file.rdbuf())))
    throw InputError(Fault{.id = "io.cannot_open",
                           .message = "cannot be read: a case file is wanted",
                           .fix = "give the name of a .toml file.",
                           .file = path.string()});
  try {
    return convert(toml::parse(content.str()));
  } catch (const toml::parse_error& error) {
    throw InputError(Fault{.id = "case.syntax",
                           .message = std::string(error.description()),
                           .fix = "correct the line; docs/case.md has an example, https://toml.io the rules.",
                           .file = path.string(),
                           .line = error.source().begin.line,
                           .column = error.source().begin.column});
  }
}

void CaseFaults::add(std::string id, CasePlace place, std::string message, std::string fix) {
  if (faults_.size() == kMaxFaults) return;
  faults_.push_back({.id = std::move(id),
                     .message = std::move(message),
                     .fix = std::move(fix),
                     .file = file_.string(),
                     .line = place.line,
                     .column = place.column});
}

void CaseFaults::check() const {
  if (!faults_.empty()) throw InputError(faults_);
}

std::string kind_name(const CaseValue& value) {
  switch (value.kind) {
    case CaseValue::Kind::kNumber:
      return fmt::format("the number {}", value.number);
    case CaseValue::Kind::kText:
      return fmt::format("the text \"{}\"", value.text);
    case CaseValue::Kind::kBoolean:
      return "true or false";
    case CaseValue::Kind::kArray:
      return "an array";
    case CaseValue::Kind::kTable:
      return "a table";
    default:
      return "a date or time";
  }
}

CaseTable::CaseTable(const CaseValue& value, std::string name, CaseFaults& faults)
    : value_(value), name_(std::move(name)), faults_(faults) {}

std::string CaseTable::full_name(std::string_view key) const {
  return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

CasePlace CaseTable::key_place(const std::string& key) const {
  const auto found = std::find(value_.keys.begin(), value_.keys.end(), key);
  return found == value_.keys.end() ? value_.place
                                    : value_.key_places[static_cast<std::size_t>(found - value_.keys.begin())];
}

const CaseValue* CaseTable::take(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  const auto found = std::find(value_.keys.begin(), value_.keys.end(), key);
  return found == value_.keys.end() ? nullptr : &value_.items[static_cast<std::size_t>(found - value_.keys.begin())];
}

void CaseTable::refuse(const std::string& key, const CaseValue& value, const std::string& wanted) {
  faults_.add("case.wrong_type", value.place,
              fmt::format("{} is {}, but has to be {}", full_name(key), kind_name(value), wanted),
              fmt::format("give {}.", wanted));
}

std::optional<CaseTable> CaseTable::take_table(const std::string& key) {
  const CaseValue* const value = take(key);
  if (value == nullptr) return std::nullopt;
  if (value->kind == CaseValue::Kind::kTable) return CaseTable(*value, full_name(key), faults_);
  refuse(key, *value, fmt::format("a table, such as [{}]", full_name(key)));
  return std::nullopt;
}

std::optional<std::string> CaseTable::take_text(const std::string& key) {
  const CaseValue* const value = take(key);
  if (value == nullptr) return std::nullopt;
  if (value->kind == CaseValue::Kind::kText && !value->text.empty()) return value->text;
  refuse(key, *value, "a text in quotation marks");
  return std::nullopt;
}

template <class Test>
std::optional<double> CaseTable::take_checked(const std::string& key, const std::string& wanted, Test is_fine) {
  const CaseValue* const value = take(key);
  if (value == nullptr) return std::nullopt;
  if (value->kind == CaseValue::Kind::kNumber && std::isfinite(value->number) && is_fine(value->number))
    return value->number;
  refuse(key, *value, wanted);
  return std::nullopt;
}

std::optional<double> CaseTable::take_number(const std::string& key) {
  return take_checked(key, "a number", [](double) { return true; });
}

std::optional<double> CaseTable::take_positive(const std::string& key, double at_most) {
  return take_checked(key, fmt::format("a number above 0 and at most {}", at_most),
                      [&](double x) { return x > 0 && x <= at_most; });
}

std::optional<double> CaseTable::take_positive(const std::string& key) {
  return take_checked(key, "a positive number", [](double x) { return x > 0; });
}

std::optional<double> CaseTable::take_not_negative(const std::string& key) {
  return take_checked(key, "a number of at least 0", [](double x) { return x >= 0; });
}

std::optional<double> CaseTable::take_below(const std::string& key, double below) {
  return take_checked(key, fmt::format("a number of at least 0 and below {}", below),
                      [&](double x) { return x >= 0 && x < below; });
}

std::optional<std::uint64_t> CaseTable::take_whole(const std::string& key, std::uint64_t at_least,
                                                   std::uint64_t at_most) {
  const CaseValue* const value = take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_integer && value->integer >= 0) {
    const auto whole = static_cast<std::uint64_t>(value->integer);
    if (whole >= at_least && whole <= at_most) return whole;
  }
  refuse(key, *value, fmt::format("an integer from {} to {}", at_least, at_most));
  return std::nullopt;
}

std::optional<std::size_t> CaseTable::take_choice(const std::string& key, const std::vector<std::string>& names) {
  const CaseValue* const value = take(key);
  if (value == nullptr) return std::nullopt;
  if (value->kind != CaseValue::Kind::kText) {
    refuse(key, *value, fmt::format("one of \"{}\"", fmt::join(names, "\", \"")));
    return std::nullopt;
  }
  const auto found = std::find(names.begin(), names.end(), value->text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  faults_.add("case.unknown_name", value->place,
              fmt::format("{} is \"{}\", but has to be one of {}", full_name(key), value->text, fmt::join(names, ", ")),
              fmt::format("did you mean \"{}\"?", nearest_name(value->text, names).value_or("")));
  return std::nullopt;
}

std::optional<fs::path> CaseTable::take_path(const std::string& key) {
  const std::optional<std::string> text = take_text(key);
  if (!text) return std::nullopt;
  return faults_.file().parent_path() / *text;
}

std::vector<fs::path> CaseTable::take_paths(const std::string& key) {
  std::vector<fs::path> paths;
  const CaseValue* const value = take(key);
  if (value == nullptr) return paths;
  const auto is_text = [](const CaseValue& item) { return item.kind == CaseValue::Kind::kText; };
  if (value->kind != CaseValue::Kind::kArray || value->items.empty() ||
      !std::all_of(value->items.begin(), value->items.end(), is_text)) {
    refuse(key, *value, "an array of files, such as [\"coarse.vtu\"]");
    return paths;
  }
  for (const CaseValue& item : value->items) paths.push_back(faults_.file().parent_path() / item.text);
  return paths;
}

void CaseTable::miss(const std::string& key, const std::string& example) {
  faults_.add("case.missing_key", place(),
              name_.empty() ? fmt::format("{} is missing", key) : fmt::format("[{}] has no {}", name_, key),
              fmt::format("add {}.", example));
}

void CaseTable::finish() {
  for (std::size_t i = 0; i < value_.keys.size(); ++i) {
    const std::string& key = value_.keys[i];
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    faults_.add("case.unknown_key", value_.key_places[i],
                fmt::format("unknown key {}; did you mean {}?", full_name(key),
                            full_name(nearest_name(key, known_).value_or(""))),
                fmt::format("known here: {}.", fmt::join(known_, ", ")));
  }
}

}  // namespace voropack::app
