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
#include "voropack/refinement.h"

namespace voropack::app {

namespace {

constexpr std::size_t kMaxListed = 20;

/// The position first, so that a gradient is the derivatives by the first D.
const std::vector<std::string>& variable_names(int dimension) {
  static const std::vector<std::string> plane = {"x", "y", "t", "u"}, space = {"x", "y", "z", "t", "u"};
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
CompiledFormula<D>::CompiledFormula(const CaseFormula& formula, FormulaScope scope, CaseFaults& faults) {
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
    return;
  }
  if (uses_time() && !scope.time)
    faults.add("case.formula", formula.place, fmt::format("{} depends on the time t here", formula.name),
               "add a [time] table, or leave out t; capacity and initial values never depend on it.");
  if (uses_state() && !scope.state)
    faults.add("case.formula", formula.place, fmt::format("{} depends on the solution u", formula.name),
               "leave out u: with method = \"cvm\", equation.conductivity and equation.source may depend on it.");
}

namespace {

template <int D>
std::array<double, D + 2> arguments(const Vec<D>& x, double t, double u) {
  std::array<double, D + 2> values;
  std::copy(x.coord.begin(), x.coord.end(), values.begin());
  values[D] = t;
  values[D + 1] = u;
  return values;
}

}  // namespace

template <int D>
double CompiledFormula<D>::value(const Vec<D>& x, double t, double u) const {
  return formula_ == nullptr ? number_ : (*formula_)(arguments(x, t, u));
}

namespace {

/// Positions coordinate by coordinate, with one t and u for all of them.
template <int D>
class ArgumentLists {
 public:
  ArgumentLists(std::span<const Vec<D>> x, double t) : coordinates_(D * x.size()), time_(t) {
    for (std::size_t k = 0; k < D; ++k) {
      const std::span<double> coordinate = std::span(coordinates_).subspan(k * x.size(), x.size());
      for (std::size_t i = 0; i < x.size(); ++i) coordinate[i] = x[i].coord[k];
      lists_[k] = coordinate;
    }
    lists_[D] = {&time_, 1};
    lists_[D + 1] = {&state_, 1};
  }
  ArgumentLists(const ArgumentLists&) = delete;
  ArgumentLists& operator=(const ArgumentLists&) = delete;
  [[nodiscard]] std::span<const Expression::Argument> get() const { return lists_; }

 private:
  std::vector<double> coordinates_;
  double time_, state_ = 0;
  std::array<Expression::Argument, D + 2> lists_;
};

}  // namespace

template <int D>
void CompiledFormula<D>::values(std::span<const Vec<D>> x, double t, std::span<double> results) const {
  if (formula_ == nullptr)
    std::fill(results.begin(), results.end(), number_);
  else
    formula_->evaluate(ArgumentLists<D>(x, t).get(), results);
}

template <int D>
void CompiledFormula<D>::gradients(std::span<const Vec<D>> x, double t, std::span<Vec<D>> results) const {
  std::fill(results.begin(), results.end(), Vec<D>{});
  if (formula_ == nullptr) return;
  const ArgumentLists<D> arguments(x, t);
  std::vector<double> slopes(x.size());
  for (std::size_t k = 0; k < D; ++k) {
    formula_->differentiate(arguments.get(), k, slopes);
    for (std::size_t i = 0; i < x.size(); ++i) results[i].coord[k] = slopes[i];
  }
}

template <int D>
double CompiledFormula<D>::derivative_by_u(const Vec<D>& x, double t, double u) const {
  return formula_ == nullptr ? 0.0 : formula_->derivative(arguments(x, t, u), D + 1);
}

template <int D>
bool CompiledFormula<D>::uses_position() const {
  for (std::size_t k = 0; k < D; ++k)
    if (formula_ != nullptr && formula_->uses(k)) return true;
  return false;
}

template <int D>
bool any_formula(const CompiledCoefficient<D>& coefficient, bool (CompiledFormula<D>::*property)() const) {
  if (const auto* const formula = std::get_if<CompiledFormula<D>>(&coefficient)) return (formula->*property)();
  if (const auto* const by_region = std::get_if<std::map<int, CompiledFormula<D>>>(&coefficient))
    return std::any_of(by_region->begin(), by_region->end(),
                       [&](const auto& entry) { return (entry.second.*property)(); });
  return false;
}

namespace {

template <int D>
CompiledCoefficient<D> compile(const CaseCoefficient& coefficient, FormulaScope scope, CaseFaults& faults) {
  if (const auto* const formula = std::get_if<CaseFormula>(&coefficient.value))
    return CompiledFormula<D>(*formula, scope, faults);
  std::map<int, CompiledFormula<D>> by_region;
  if (const auto* const formulas = std::get_if<std::map<int, CaseFormula>>(&coefficient.value))
    for (const auto& [region, formula] : *formulas)
      by_region.emplace(region, CompiledFormula<D>(formula, scope, faults));
  return by_region;
}

template <int D>
CompiledCondition<D> compile(const CaseCondition& condition, FormulaScope scope, CaseFaults& faults) {
  const CompiledFormula<D> value(condition.value, scope, faults);
  if (condition.type == CaseCondition::Type::kRate && value.uses_position())
    faults.add("case.formula", condition.value.place,
               fmt::format("{} is one number for the whole marker, not a function of position", condition.value.name),
               "give a number, or a formula in t alone.");
  return {condition.type, value, CompiledFormula<D>(condition.transfer, scope, faults)};
}

template <int D>
void compile_exact(const CaseExact& exact, FormulaScope scope, CompiledCase<D>& result, CaseFaults& faults) {
  result.exact = CompiledFormula<D>(exact.u, scope, faults);
  for (const CaseFormula& formula : exact.gradient) result.exact_gradient.emplace_back(formula, scope, faults);
  if (exact.gradient.empty() || exact.gradient.size() == D) return;
  faults.add("case.wrong_length", exact.gradient.front().place,
             fmt::format("exact.gradient has {} entries in {}D", exact.gradient.size(), D),
             fmt::format("give {} formulas, or none: the gradient is derived from u.", D));
}

}  // namespace

template <int D>
CompiledCase<D> compile_case(const Case& given) {
  CaseFaults faults(given.file);
  CompiledCase<D> result;
  const FormulaScope position, time{.time = given.time.has_value()};
  const FormulaScope state{.time = time.time, .state = given.method == CaseMethod::kControlVolumes};
  result.conductivity = compile<D>(given.conductivity, state, faults);
  result.reaction = compile<D>(given.reaction, time, faults);
  result.source = compile<D>(given.source, state, faults);
  result.capacity = compile<D>(given.capacity, position, faults);
  if (given.time) result.initial = compile<D>(given.time->initial, position, faults);
  if (given.newton_initial) result.newton_initial = compile<D>(*given.newton_initial, position, faults);
  for (const auto& [marker, condition] : given.conditions)
    result.conditions.emplace(marker, compile<D>(condition, time, faults));
  if (given.other_conditions) result.other_conditions = compile<D>(*given.other_conditions, time, faults);
  result.mean = given.mean;
  if (given.exact) compile_exact(*given.exact, time, result, faults);
  faults.check();
  result.is_nonlinear = any_formula<D>(result.conductivity, &CompiledFormula<D>::uses_state) ||
                        any_formula<D>(result.source, &CompiledFormula<D>::uses_state);
  return result;
}

namespace {

/// The values of an array on another mesh of the domain, at the vertices of this one.
template <int D>
IdVector<VertexId, double> transfer_array(const CaseCoefficient& coefficient, const CaseArray& array,
                                          const Mesh<D>& mesh, CaseFaults& faults, Observer& observer) {
  const AnyMesh any = read_mesh(*array.file, observer);
  const Mesh<D>* const from = std::get_if<Mesh<D>>(&any);
  if (from == nullptr) {
    faults.add("case.contradiction", coefficient.place,
               fmt::format("{}: the mesh of {} is not {}D", coefficient.name, array.file->string(), D),
               "give an array on a mesh of the same domain.");
    return {};
  }
  try {
    return transfer(*from, IdVector<VertexId, double>(read_point_array(*array.file, array.name, observer)), mesh,
                    {.conserve = array.transfer == CaseArray::Transfer::kConserve});
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      faults.add(fault.id, coefficient.place,
                 fmt::format("{}: the array \"{}\" of {}: {}", coefficient.name, array.name, array.file->string(),
                             fault.message),
                 fault.fix);
    return {};
  }
}

template <int D>
IdVector<VertexId, double> read_array(const Case& given, const CaseCoefficient& coefficient, const CaseArray& array,
                                      const Mesh<D>& mesh, CaseFaults& faults, Observer& observer) {
  if (!array.file && !given.mesh) {
    faults.add("case.contradiction", coefficient.place,
               fmt::format("{} names an array, but the mesh is still to be made", coefficient.name),
               "give the file that has it and as many points: {array = \"name\", file = \"mesh.vtu\"}.");
    return {};
  }
  if (array.transfer != CaseArray::Transfer::kNone) return transfer_array(coefficient, array, mesh, faults, observer);
  const std::filesystem::path& path = array.file ? *array.file : *given.mesh;
  std::vector<double> values = read_point_array(path, array.name, observer);
  if (values.size() != mesh.points.size()) {
    faults.add("case.wrong_length", coefficient.place,
               fmt::format("{}: the array \"{}\" of {} has {} numbers for {} vertices", coefficient.name, array.name,
                           path.string(), values.size(), mesh.points.size()),
               "give an array with one number for each vertex of the mesh, or add transfer = \"interpolate\".");
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

namespace {

/// The hull's markers, and those of anything inside that the mesh knows.
template <int D>
std::set<int> known_markers(const Mesh<D>& mesh, const std::set<int>& hull) {
  std::set<int> known = hull;
  known.insert(mesh.boundary_marker.begin(), mesh.boundary_marker.end());
  known.insert(mesh.segment_edge_marker.begin(), mesh.segment_edge_marker.end());
  known.insert(mesh.vertex_marker.begin(), mesh.vertex_marker.end());
  if (!hull.contains(0)) known.erase(0);  // What is inside without a marker.
  return known;
}

/// The patches of the hull, and of markers inside that have conditions.
template <int D>
BoundaryAreas<D> build_boundary(const Case& given, const Mesh<D>& mesh, CompiledCase<D>& compiled, CaseFaults& faults) {
  BoundaryAreas<D> boundary = build_boundary_areas(mesh);
  const std::set<int> hull(boundary.patch_marker.begin(), boundary.patch_marker.end());
  std::set<int> inner;
  for (const auto& [marker, condition] : given.conditions)
    if (!hull.contains(marker)) inner.insert(marker);
  if (!inner.empty()) boundary = build_boundary_areas(mesh, inner);
  const std::set<int> found(boundary.patch_marker.begin(), boundary.patch_marker.end());
  const std::set<int> known = known_markers(mesh, hull);
  for (const auto& [marker, condition] : given.conditions)
    if (!found.contains(marker))
      faults.add("case.unknown_marker", condition.place, fmt::format("nothing in the mesh has the marker {}", marker),
                 known_ids("marker", marker, known) + '.');
  if (compiled.other_conditions)
    for (const int marker : hull) compiled.conditions.try_emplace(marker, *compiled.other_conditions);
  return boundary;
}

}  // namespace

template <int D>
BoundaryAreas<D> bind_case(const Case& given, const Mesh<D>& mesh, CompiledCase<D>& compiled, Observer& observer) {
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
  bind(given.capacity, compiled.capacity);
  if (given.time) bind(given.time->initial, compiled.initial);
  if (given.newton_initial) bind(*given.newton_initial, compiled.newton_initial);
  BoundaryAreas<D> boundary = build_boundary(given, mesh, compiled, faults);
  faults.check();
  return boundary;
}

namespace {

template <int D>
std::map<int, double> to_numbers(const std::map<int, CompiledFormula<D>>& by_region) {
  std::map<int, double> numbers;
  for (const auto& [region, formula] : by_region) numbers.emplace(region, formula.number());
  return numbers;
}

/// `formula_of(region)` for the regions of a coefficient.
template <int D, class FormulaOf>
Coefficient<D> to_function(FormulaOf formula_of, bool uses_state, double t) {
  if (!uses_state)
    return RegionFunction<D>([formula_of, t](const Vec<D>& x, int region) { return formula_of(region).value(x, t); });
  return StateFunction<D>{
      .value = [formula_of, t](const Vec<D>& x, int region, double u) { return formula_of(region).value(x, t, u); },
      .derivative = [formula_of, t](const Vec<D>& x, int region,
                                    double u) { return formula_of(region).derivative_by_u(x, t, u); }};
}

}  // namespace

template <int D>
Coefficient<D> to_coefficient(const CompiledCoefficient<D>& compiled, double time) {
  const bool uses_state = any_formula<D>(compiled, &CompiledFormula<D>::uses_state);
  return std::visit(
      [&](const auto& value) -> Coefficient<D> {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, CompiledFormula<D>>) {
          if (value.is_number()) return value.number();
          return to_function<D>([value](int) -> const CompiledFormula<D>& { return value; }, uses_state, time);
        } else if constexpr (std::is_same_v<T, std::map<int, CompiledFormula<D>>>) {
          const bool is_constant =
              std::none_of(value.begin(), value.end(), [](const auto& entry) { return !entry.second.is_number(); });
          if (is_constant) return to_numbers<D>(value);
          return to_function<D>([value](int region) -> const CompiledFormula<D>& { return value.at(region); },
                                uses_state, time);
        } else {
          return value;
        }
      },
      compiled);
}

namespace {

template <int D>
BoundaryValue<D> to_value(const CompiledFormula<D>& formula, double t) {
  if (formula.is_number()) return formula.number();
  return std::function<double(const Vec<D>&)>([formula, t](const Vec<D>& x) { return formula.value(x, t); });
}

template <int D>
BoundaryCondition<D> to_condition(const CompiledCondition<D>& condition, double t) {
  switch (condition.type) {
    case CaseCondition::Type::kNeumann:
      return Neumann<D>{to_value(condition.value, t)};
    case CaseCondition::Type::kRobin:
      return Robin<D>{.transfer = to_value(condition.transfer, t), .outside = to_value(condition.value, t)};
    case CaseCondition::Type::kRate:
      return Rate<D>{condition.value.value(Vec<D>{}, t)};
    default:
      return Dirichlet<D>{to_value(condition.value, t)};
  }
}

}  // namespace

template <int D>
DiffusionProblem<D> make_problem(const CompiledCase<D>& compiled, double time) {
  DiffusionProblem<D> problem;
  problem.conductivity = to_coefficient<D>(compiled.conductivity, time);
  problem.reaction = to_coefficient<D>(compiled.reaction, time);
  problem.source = to_coefficient<D>(compiled.source, time);
  for (const auto& [marker, condition] : compiled.conditions)
    problem.conditions.emplace(marker, to_condition(condition, time));
  problem.mean = compiled.mean;
  return problem;
}

template <int D>
IdVector<VertexId, double> vertex_values(const CompiledCoefficient<D>& compiled, const Mesh<D>& mesh) {
  if (const auto* const array = std::get_if<IdVector<VertexId, double>>(&compiled)) return *array;
  IdVector<VertexId, double> values;
  if (const auto* const formula = std::get_if<CompiledFormula<D>>(&compiled))
    for (const Vec<D>& x : mesh.points) values.push_back(formula->value(x, 0));
  return values;
}

template <int D>
std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<D>& compiled, const CellShapes<D>& shapes,
                                                         const ControlVolumes<D>& volumes, double time) {
  if (!any_formula<D>(compiled.source, &CompiledFormula<D>::is_formula) ||
      any_formula<D>(compiled.source, &CompiledFormula<D>::uses_state))
    return std::nullopt;
  const auto* const same = std::get_if<CompiledFormula<D>>(&compiled.source);
  const auto* const by_region = std::get_if<std::map<int, CompiledFormula<D>>>(&compiled.source);
  const std::function<void(std::span<const Vec<D>>, int, std::span<double>)> source =
      [=](std::span<const Vec<D>> x, int region, std::span<double> values) {
        (same != nullptr ? *same : by_region->at(region)).values(x, time, values);
      };
  return integrate_over_cells<D>(shapes, volumes, source);
}

template <int D>
std::function<void(std::span<const Vec<D>>, std::span<double>)> exact_solution(const CompiledCase<D>& compiled,
                                                                               double time) {
  return
      [u = *compiled.exact, time](std::span<const Vec<D>> x, std::span<double> values) { u.values(x, time, values); };
}

template <int D>
std::function<void(std::span<const Vec<D>>, std::span<Vec<D>>)> exact_gradient(const CompiledCase<D>& compiled,
                                                                               double time) {
  if (compiled.exact_gradient.empty())
    return [u = *compiled.exact, time](std::span<const Vec<D>> x, std::span<Vec<D>> values) {
      u.gradients(x, time, values);
    };
  return [parts = compiled.exact_gradient, time](std::span<const Vec<D>> x, std::span<Vec<D>> values) {
    std::vector<double> part(x.size());
    for (std::size_t k = 0; k < D; ++k) {
      parts[k].values(x, time, part);
      for (std::size_t i = 0; i < x.size(); ++i) values[i].coord[k] = part[i];
    }
  };
}

template class CompiledFormula<2>;
template bool any_formula(const CompiledCoefficient<2>&, bool (CompiledFormula<2>::*)() const);
template CompiledCase<2> compile_case(const Case&);
template BoundaryAreas<2> bind_case(const Case&, const Mesh<2>&, CompiledCase<2>&, Observer&);
template DiffusionProblem<2> make_problem(const CompiledCase<2>&, double);
template Coefficient<2> to_coefficient<2>(const CompiledCoefficient<2>&, double);
template IdVector<VertexId, double> vertex_values(const CompiledCoefficient<2>&, const Mesh<2>&);
template std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<2>&, const CellShapes<2>&,
                                                                  const ControlVolumes<2>&, double);
template std::function<void(std::span<const Vec<2>>, std::span<double>)> exact_solution(const CompiledCase<2>&, double);
template std::function<void(std::span<const Vec<2>>, std::span<Vec<2>>)> exact_gradient(const CompiledCase<2>&, double);

template class CompiledFormula<3>;
template bool any_formula(const CompiledCoefficient<3>&, bool (CompiledFormula<3>::*)() const);
template CompiledCase<3> compile_case(const Case&);
template BoundaryAreas<3> bind_case(const Case&, const Mesh<3>&, CompiledCase<3>&, Observer&);
template DiffusionProblem<3> make_problem(const CompiledCase<3>&, double);
template Coefficient<3> to_coefficient<3>(const CompiledCoefficient<3>&, double);
template IdVector<VertexId, double> vertex_values(const CompiledCoefficient<3>&, const Mesh<3>&);
template std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<3>&, const CellShapes<3>&,
                                                                  const ControlVolumes<3>&, double);
template std::function<void(std::span<const Vec<3>>, std::span<double>)> exact_solution(const CompiledCase<3>&, double);
template std::function<void(std::span<const Vec<3>>, std::span<Vec<3>>)> exact_gradient(const CompiledCase<3>&, double);

}  // namespace voropack::app
