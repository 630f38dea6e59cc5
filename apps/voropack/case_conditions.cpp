// The equation's coefficients and the conditions on boundaries, as a case file gives them.
#include <fmt/format.h>

#include <charconv>

#include "case.h"

namespace voropack::app {

namespace {

using Kind = CaseValue::Kind;

std::optional<CaseFormula> to_formula(const CaseValue& value, std::string name) {
  if (value.kind == Kind::kNumber) return CaseFormula{value.number, std::move(name), value.place};
  if (value.kind == Kind::kText) return CaseFormula{value.text, std::move(name), value.place};
  return std::nullopt;
}

void refuse(CaseFaults& faults, const CaseValue& value, const std::string& name, const std::string& wanted) {
  faults.add("case.wrong_type", value.place, fmt::format("{} is {}, but has to be {}", name, kind_name(value), wanted),
             "for example 2.5 or \"1 + x^2\".");
}

/// Of keys such as 1 and 01, which are different texts.
void refuse_twice(const CaseTable& table, const std::string& key) {
  table.faults().add("case.given_twice", table.key_place(key), fmt::format("{} is given twice", table.full_name(key)),
                     "leave one of them out.");
}

CaseArray take_array(CaseTable& table) {
  CaseArray array;
  array.name = table.take_text("array").value_or("");
  array.file = table.take_path("file");
  if (const std::optional<std::size_t> way = table.take_choice("transfer", {"none", "interpolate", "conserve"}))
    array.transfer = static_cast<CaseArray::Transfer>(*way);
  if (array.transfer != CaseArray::Transfer::kNone && !array.file)
    table.miss("file", "file = \"before.vtu\", the mesh that the array is on");
  table.finish();
  return array;
}

std::map<int, CaseFormula> take_regions(CaseTable& table) {
  std::map<int, CaseFormula> formulas;
  for (const std::string& key : table.keys()) {
    const CaseValue& value = *table.take(key);
    const std::optional<int> region = id_of_key(table, key, "region");
    const std::optional<CaseFormula> formula = to_formula(value, table.full_name(key));
    if (!formula)
      refuse(table.faults(), value, table.full_name(key), "a number or a formula in quotation marks");
    else if (region && !formulas.emplace(*region, *formula).second)
      refuse_twice(table, key);
  }
  return formulas;
}

/// A value that a type of condition cannot do without.
CaseFormula require_formula(CaseTable& table, const std::string& key) {
  if (table.take(key) == nullptr) table.miss(key, fmt::format("{} = 0.0, or a formula in quotation marks", key));
  return take_formula(table, key, 0);
}

CaseCondition take_condition(CaseTable& table) {
  CaseCondition condition;
  condition.place = table.place();
  const std::optional<std::size_t> type = table.take_choice("type", {"dirichlet", "neumann", "robin", "rate"});
  if (!type) {
    if (table.take("type") == nullptr) table.miss("type", "type = \"dirichlet\", \"neumann\", \"robin\" or \"rate\"");
    return condition;  // Which keys belong here is not known.
  }
  condition.type = static_cast<CaseCondition::Type>(*type);
  switch (condition.type) {
    case CaseCondition::Type::kDirichlet:
      condition.value = require_formula(table, "value");
      break;
    case CaseCondition::Type::kNeumann:
      condition.value = require_formula(table, "inflow");
      break;
    case CaseCondition::Type::kRobin:
      condition.transfer = require_formula(table, "transfer");
      condition.value = require_formula(table, "outside");
      break;
    case CaseCondition::Type::kRate:
      condition.value = require_formula(table, "total");
      break;
  }
  table.finish();
  return condition;
}

}  // namespace

std::optional<int> id_of_key(const CaseTable& table, const std::string& key, const std::string& what) {
  int id = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), id);
  if (error == std::errc() && end == key.data() + key.size()) return id;
  table.faults().add("case.unknown_key", table.key_place(key),
                     fmt::format("{} is not the number of a {}", table.full_name(key), what),
                     fmt::format("give the whole number that the {} has in the mesh or domain file.", what));
  return std::nullopt;
}

CaseFormula take_formula(CaseTable& table, const std::string& key, double otherwise) {
  CaseFormula formula{otherwise, table.full_name(key), table.place()};
  const CaseValue* const value = table.take(key);
  if (value == nullptr) return formula;
  if (const std::optional<CaseFormula> given = to_formula(*value, table.full_name(key))) return *given;
  refuse(table.faults(), *value, formula.name, "a number or a formula in quotation marks");
  return formula;
}

CaseCoefficient take_coefficient(CaseTable& table, const std::string& key, double otherwise) {
  CaseCoefficient coefficient;
  coefficient.name = table.full_name(key);
  const CaseValue* const value = table.take(key);
  if (value == nullptr) {
    coefficient.value = CaseFormula{otherwise, coefficient.name, table.place()};
    return coefficient;
  }
  coefficient.place = value->place;
  if (value->kind == Kind::kTable) {
    CaseTable inner(*value, coefficient.name, table.faults());
    if (inner.take("array") != nullptr)
      coefficient.value = take_array(inner);
    else
      coefficient.value = take_regions(inner);
  } else if (const std::optional<CaseFormula> formula = to_formula(*value, coefficient.name)) {
    coefficient.value = *formula;
  } else {
    refuse(table.faults(), *value, coefficient.name,
           "a number, a formula in quotation marks, a table by region, or {array = \"name\"}");
  }
  return coefficient;
}

void read_conditions(CaseTable& file, Case& result) {
  std::optional<CaseTable> boundary = file.take_table("boundary");
  if (!boundary) return;
  for (const std::string& key : boundary->keys()) {
    std::optional<CaseTable> table = boundary->take_table(key);
    if (key == "others") {
      if (table) result.other_conditions = take_condition(*table);
      continue;
    }
    const std::optional<int> marker = id_of_key(*boundary, key, "marker, nor \"others\"");
    if (marker && table && !result.conditions.emplace(*marker, take_condition(*table)).second)
      refuse_twice(*boundary, key);
  }
}

}  // namespace voropack::app
