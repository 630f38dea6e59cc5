#include "case_problem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <type_traits>
#include <utility>

#include "suggest.h"
#include "voropack/cell_integrals.h"
#include "voropack/io.h"

namespace voropack::app {

namespace {

constexpr std::size_t kMaxListed = 20;

const std::vector<std::string>& variable_names(int dimension) {
  static const std::vector<std::string> plane = {"x", "y"}, space = {"x", "y", "z"};
  return dimension == 2 ? plane : space;
}

/// "did you mean 3? The markers are 1, 2, 3": of equally near numbers the one that differs least.
std::string known_ids(const std::string& what, int id, const std::set<int>& known) {
  if (known.empty()) return fmt::format("there are no {}s", what);
  std::vector<int> ids(known.begin(), known.end());
  std::stable_sort(ids.begin(), ids.end(),
                   [&](int a, int b) { return std::abs(std::int64_t{a} - id) < std::abs(std::int64_t{b} - id); });
  std::vector<std::string> names;
  for (const int number : ids) names.push_back(std::to_string(number));
  const std::string near = nearest_name(std::to_string(id), names).value_or("");
  std::vector<int> listed(known.begin(), known.end());
  const bool is_cut = listed.size() > kMaxListed;
  if (is_cut) listed.resize(kMaxListed);
  return fmt::format("did you mean {}? The {}s are {}{}", near, what, fmt::join(listed, ", "), is_cut ? ", ..." : "");
}

}  // namespace

template <int D>
CompiledFormula<D>::CompiledFormula(const CaseFormula& formula, CaseFaults& faults) {
  if (const double* const number = std::get_if<double>(&formula.value)) {
    number_ = *number;
    if (!std::isfinite(number_))
      faults.add("case.formula", formula.place, fmt::format("{} is {}", formula.name, number_),
                 "give a finite number.");
    return;
  }
  const std::string& text = std::get<std::string>(formula.value);
  try {
    formula_ = std::make_shared<const Expression>(text, variable_names(D));
  } catch (const ExpressionError& error) {
    faults.add("case.formula", {formula.place.line, formula.place.column + error.fault().column},
               fmt::format("{}: {}", formula.name, error.what()),
               fmt::format("correct the formula; its variables are {}.", fmt::join(variable_names(D), ", ")));
  }
}

template <int D>
double CompiledFormula<D>::operator()(const Vec<D>& x) const {
  return formula_ == nullptr ? number_ : (*formula_)(x.coord);
}

template <int D>
Vec<D> CompiledFormula<D>::gradient(const Vec<D>& x) const {
  Vec<D> result{};
  for (int k = 0; k < D; ++k)
    result[k] = formula_ == nullptr ? 0.0 : formula_->derivative(x.coord, static_cast<std::size_t>(k));
  return result;
}

namespace {

template <int D>
CompiledCoefficient<D> compile(const CaseCoefficient& coefficient, CaseFaults& faults) {
  if (const auto* const formula = std::get_if<CaseFormula>(&coefficient.value))
    return CompiledFormula<D>(*formula, faults);
  std::map<int, CompiledFormula<D>> by_region;
  if (const auto* const formulas = std::get_if<std::map<int, CaseFormula>>(&coefficient.value))
    for (const auto& [region, formula] : *formulas) by_region.emplace(region, CompiledFormula<D>(formula, faults));
  return by_region;
}

template <int D>
CompiledCondition<D> compile(const CaseCondition& condition, CaseFaults& faults) {
  return {condition.type, CompiledFormula<D>(condition.value, faults), CompiledFormula<D>(condition.transfer, faults)};
}

}  // namespace

template <int D>
CompiledCase<D> compile_case(const Case& given) {
  CaseFaults faults(given.file);
  CompiledCase<D> result;
  result.conductivity = compile<D>(given.conductivity, faults);
  result.reaction = compile<D>(given.reaction, faults);
  result.source = compile<D>(given.source, faults);
  for (const auto& [marker, condition] : given.conditions)
    result.conditions.emplace(marker, compile<D>(condition, faults));
  if (given.other_conditions) result.other_conditions = compile<D>(*given.other_conditions, faults);
  result.mean = given.mean;
  if (given.exact) {
    result.exact = CompiledFormula<D>(given.exact->u, faults);
    for (const CaseFormula& formula : given.exact->gradient) result.exact_gradient.emplace_back(formula, faults);
    if (!result.exact_gradient.empty() && result.exact_gradient.size() != D)
      faults.add("case.wrong_length", given.exact->gradient.front().place,
                 fmt::format("exact.gradient has {} entries in {}D", result.exact_gradient.size(), D),
                 fmt::format("give {} formulas, or none: the gradient is derived from u.", D));
  }
  faults.check();
  return result;
}

namespace {

template <int D>
IdVector<VertexId, double> read_array(const Case& given, const CaseCoefficient& coefficient, const CaseArray& array,
                                      const Mesh<D>& mesh, CaseFaults& faults, Observer& observer) {
  if (!array.file && !given.mesh) {
    faults.add("case.contradiction", coefficient.place,
               fmt::format("{} names an array, but the mesh is still to be made", coefficient.name),
               "give the file that has it and as many points: {array = \"name\", file = \"mesh.vtu\"}.");
    return {};
  }
  const std::filesystem::path& path = array.file ? *array.file : *given.mesh;
  std::vector<double> values = read_point_array(path, array.name, observer);
  if (values.size() != mesh.points.size()) {
    faults.add("case.wrong_length", coefficient.place,
               fmt::format("{}: the array \"{}\" of {} has {} numbers for {} vertices", coefficient.name, array.name,
                           path.string(), values.size(), mesh.points.size()),
               "give an array with one number for each vertex of the mesh.");
    return {};
  }
  return IdVector<VertexId, double>(std::move(values));
}

void check_regions(const CaseCoefficient& coefficient, const std::set<int>& regions, CaseFaults& faults) {
  const auto* const formulas = std::get_if<std::map<int, CaseFormula>>(&coefficient.value);
  if (formulas == nullptr) return;
  for (const auto& [region, formula] : *formulas)
    if (!regions.contains(region))
      faults.add("case.unknown_region", formula.place,
                 fmt::format("{}: the mesh has no region {}", coefficient.name, region),
                 known_ids("region", region, regions) + '.');
  for (const int region : regions)
    if (!formulas->contains(region))
      faults.add("case.unknown_region", coefficient.place,
                 fmt::format("{} says nothing of region {}", coefficient.name, region),
                 fmt::format("add {} = ... to the table.", region));
}

}  // namespace

template <int D>
void bind_case(const Case& given, const Mesh<D>& mesh, const std::set<int>& hull_markers, CompiledCase<D>& compiled,
               Observer& observer) {
  CaseFaults faults(given.file);
  const std::set<int> regions(mesh.simplex_region.begin(), mesh.simplex_region.end());
  const auto bind = [&](const CaseCoefficient& coefficient, CompiledCoefficient<D>& target) {
    check_regions(coefficient, regions, faults);
    if (const auto* const array = std::get_if<CaseArray>(&coefficient.value))
      target = read_array(given, coefficient, *array, mesh, faults, observer);
  };
  bind(given.conductivity, compiled.conductivity);
  bind(given.reaction, compiled.reaction);
  bind(given.source, compiled.source);
  for (const auto& [marker, condition] : given.conditions)
    if (!hull_markers.contains(marker))
      faults.add("case.unknown_marker", condition.place, fmt::format("no boundary has the marker {}", marker),
                 known_ids("marker", marker, hull_markers) + '.');
  if (compiled.other_conditions)
    for (const int marker : hull_markers) compiled.conditions.try_emplace(marker, *compiled.other_conditions);
  faults.check();
}

namespace {

template <int D>
bool is_constant(const std::map<int, CompiledFormula<D>>& by_region) {
  return std::all_of(by_region.begin(), by_region.end(), [](const auto& entry) { return entry.second.is_number(); });
}

template <int D>
Coefficient<D> to_coefficient(const CompiledCoefficient<D>& compiled) {
  return std::visit(
      [](const auto& value) -> Coefficient<D> {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, CompiledFormula<D>>) {
          if (value.is_number()) return value.number();
          return RegionFunction<D>([value](const Vec<D>& x, int) { return value(x); });
        } else if constexpr (std::is_same_v<T, std::map<int, CompiledFormula<D>>>) {
          if (!is_constant(value))
            return RegionFunction<D>([value](const Vec<D>& x, int region) { return value.at(region)(x); });
          std::map<int, double> numbers;
          for (const auto& [region, formula] : value) numbers.emplace(region, formula.number());
          return numbers;
        } else {
          return value;
        }
      },
      compiled);
}

template <int D>
BoundaryValue<D> to_value(const CompiledFormula<D>& formula) {
  if (formula.is_number()) return formula.number();
  return std::function<double(const Vec<D>&)>(formula);
}

template <int D>
BoundaryCondition<D> to_condition(const CompiledCondition<D>& condition) {
  switch (condition.type) {
    case CaseCondition::Type::kNeumann:
      return Neumann<D>{to_value(condition.value)};
    case CaseCondition::Type::kRobin:
      return Robin<D>{.transfer = to_value(condition.transfer), .outside = to_value(condition.value)};
    default:
      return Dirichlet<D>{to_value(condition.value)};
  }
}

}  // namespace

template <int D>
DiffusionProblem<D> make_problem(const CompiledCase<D>& compiled) {
  DiffusionProblem<D> problem;
  problem.conductivity = to_coefficient(compiled.conductivity);
  problem.reaction = to_coefficient(compiled.reaction);
  problem.source = to_coefficient(compiled.source);
  for (const auto& [marker, condition] : compiled.conditions)
    problem.conditions.emplace(marker, to_condition(condition));
  problem.mean = compiled.mean;
  return problem;
}

template <int D>
std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<D>& compiled, const CellShapes<D>& shapes,
                                                         const ControlVolumes<D>& volumes) {
  const Coefficient<D> source = to_coefficient(compiled.source);
  const auto* const function = std::get_if<RegionFunction<D>>(&source);
  if (function == nullptr) return std::nullopt;
  return integrate_over_cells(shapes, volumes, *function);
}

template <int D>
std::function<double(const Vec<D>&)> exact_solution(const CompiledCase<D>& compiled) {
  return *compiled.exact;
}

template <int D>
std::function<Vec<D>(const Vec<D>&)> exact_gradient(const CompiledCase<D>& compiled) {
  if (compiled.exact_gradient.empty()) return [u = *compiled.exact](const Vec<D>& x) { return u.gradient(x); };
  return [parts = compiled.exact_gradient](const Vec<D>& x) {
    Vec<D> gradient{};
    for (int k = 0; k < D; ++k) gradient[k] = parts[static_cast<std::size_t>(k)](x);
    return gradient;
  };
}

#define VOROPACK_FOR_DIMENSION(D)                                                                                 \
  template class CompiledFormula<D>;                                                                              \
  template CompiledCase<D> compile_case(const Case&);                                                             \
  template void bind_case(const Case&, const Mesh<D>&, const std::set<int>&, CompiledCase<D>&, Observer&);        \
  template DiffusionProblem<D> make_problem(const CompiledCase<D>&);                                              \
  template std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<D>&, const CellShapes<D>&, \
                                                                    const ControlVolumes<D>&);                    \
  template std::function<double(const Vec<D>&)> exact_solution(const CompiledCase<D>&);                           \
  template std::function<Vec<D>(const Vec<D>&)> exact_gradient(const CompiledCase<D>&)
VOROPACK_FOR_DIMENSION(2);
VOROPACK_FOR_DIMENSION(3);

}  // namespace voropack::app
