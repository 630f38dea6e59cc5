// A case file as a tree of values that know where they stand, and the reading of its tables key by key.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "voropack/error.h"

namespace voropack::app {

/// Where something stands in a file: line and column, from 1.
struct CasePlace {
  std::uint64_t line = 1, column = 1;
};

/// A value of a TOML file.
struct CaseValue {
  enum class Kind : std::uint8_t { kNumber, kText, kBoolean, kArray, kTable, kOther };
  Kind kind = Kind::kOther;
  CasePlace place;
  double number = 0;             ///< Of kNumber.
  bool is_integer = false;       ///< Of kNumber: written without point and exponent.
  std::int64_t integer = 0;      ///< If so.
  std::string text;              ///< Of kText.
  std::vector<CaseValue> items;  ///< Of kArray; of kTable, the values of its keys.

  // Of kTable: parallel to `items`, in the order of the file.
  std::vector<std::string> keys;
  std::vector<CasePlace> key_places;
};

/// Reads a TOML file. Throws InputError io.cannot_open, case.syntax.
CaseValue read_case_file(const std::filesystem::path& path);

/// What is wrong with a case file: all of it is told together.
class CaseFaults {
 public:
  explicit CaseFaults(std::filesystem::path file) : file_(std::move(file)) {}
  void add(std::string id, CasePlace place, std::string message, std::string fix);
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Throws InputError if anything was added.
  void check() const;

 private:
  std::filesystem::path file_;
  std::vector<Fault> faults_;
};

/// "number 3", "text", "table", ... for messages.
std::string kind_name(const CaseValue& value);

/// Takes the keys of one table. What is wrong goes to the faults, and the result is as if the key were not there.
class CaseTable {
 public:
  /// `name` is what messages call the table, such as "equation"; empty for the whole file.
  CaseTable(const CaseValue& value, std::string name, CaseFaults& faults);

  [[nodiscard]] const CasePlace& place() const { return value_.place; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] CaseFaults& faults() const { return faults_; }
  /// "equation.source".
  [[nodiscard]] std::string full_name(std::string_view key) const;

  const CaseValue* take(const std::string& key);
  std::optional<CaseTable> take_table(const std::string& key);
  std::optional<std::string> take_text(const std::string& key);
  std::optional<double> take_number(const std::string& key);
  std::optional<double> take_positive(const std::string& key, double at_most);
  std::optional<double> take_positive(const std::string& key);
  std::optional<double> take_not_negative(const std::string& key);
  std::optional<double> take_below(const std::string& key, double below);  ///< And not negative.
  std::optional<std::uint64_t> take_whole(const std::string& key, std::uint64_t at_least, std::uint64_t at_most);
  /// The number of the name in `names`.
  std::optional<std::size_t> take_choice(const std::string& key, const std::vector<std::string>& names);
  /// A path, relative to the folder of the case file.
  std::optional<std::filesystem::path> take_path(const std::string& key);
  /// An array of paths; empty if the key is not there.
  std::vector<std::filesystem::path> take_paths(const std::string& key);

  /// The keys of the table, in order; take what is wanted.
  [[nodiscard]] const std::vector<std::string>& keys() const { return value_.keys; }
  [[nodiscard]] CasePlace key_place(const std::string& key) const;
  /// Adds a fault that the key is missing.
  void miss(const std::string& key, const std::string& example);
  /// Adds a fault for each key that was not asked for.
  void finish();

 private:
  template <class Test>
  std::optional<double> take_checked(const std::string& key, const std::string& wanted, Test is_fine);
  void refuse(const std::string& key, const CaseValue& value, const std::string& wanted);

  const CaseValue& value_;
  std::string name_;
  CaseFaults& faults_;
  std::vector<std::string> known_;
};

}  // namespace voropack::app
