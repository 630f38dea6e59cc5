#include "case.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "parameters.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

constexpr double kMaxGradation = 0.4;  // As SpacingOptions says.
constexpr double kMaxMergeAngleDeg = 90;
constexpr std::uint64_t kMaxIterations = 1'000'000'000;

/// `target` becomes the value, if there is one.
template <class T, class V>
void set(T& target, const std::optional<V>& value) {
  if (value) target = static_cast<T>(*value);
}

std::map<int, double> take_sizes(CaseTable& table, const std::string& key, const std::string& what) {
  std::map<int, double> sizes;
  std::optional<CaseTable> inner = table.take_table(key);
  if (!inner) return sizes;
  for (const std::string& id_text : inner->keys()) {
    const std::optional<double> size = inner->take_positive(id_text);
    const std::optional<int> id = id_of_key(*inner, id_text, what);
    if (size && id) sizes[*id] = *size;
  }
  return sizes;
}

template <class T>
void take_enum(CaseTable& table, const std::string& key, const std::map<std::string, T>& values, T& target) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  if (const std::optional<std::size_t> choice = table.take_choice(key, names)) target = values.at(names[*choice]);
}

/// The options of `voropack mesh` by their names, with _ for -.
void read_domain_table(CaseTable& table, Case& result) {
  MeshingWishes& wishes = result.wishes;
  result.domain = table.take_path("file");
  if (!result.domain && table.take("file") == nullptr) table.miss("file", "file = \"part.poly\"");
  wishes.size = table.take_positive("size");
  wishes.spacing = table.take_positive("spacing");
  wishes.region_size = take_sizes(table, "region_size", "region");
  wishes.marker_size = take_sizes(table, "marker_size", "marker");
  wishes.size_field = table.take_path("size_field");
  wishes.size_expression = table.take_text("size_expr");
  set(wishes.gradation, table.take_positive("gradation", kMaxGradation));
  set(wishes.feature_factor, table.take_positive("feature_factor", 1));
  take_enum(table, "packing", kFormNames, wishes.packing.form);
  take_enum(table, "interior", kInteriorNames, wishes.packing.interior);
  set(wishes.packing.epsilon, table.take_positive("epsilon", 1));
  set(wishes.packing.max_vertices, table.take_whole("max_vertices", 1, std::numeric_limits<std::int64_t>::max()));
  wishes.merge.merge_distance = table.take_not_negative("merge_distance");
  set(wishes.merge.merge_angle_deg, table.take_below("merge_angle", kMaxMergeAngleDeg));
  table.finish();
}

void read_places(CaseTable& file, Case& result, CaseFaults& faults) {
  std::optional<CaseTable> mesh = file.take_table("mesh"), domain = file.take_table("domain");
  if (mesh && domain)
    faults.add("case.contradiction", domain->place(), "the file has both [mesh] and [domain]",
               "leave out [domain] to use the mesh as it is, or [mesh] to make one.");
  if (!mesh && !domain && file.take("mesh") == nullptr && file.take("domain") == nullptr)
    file.miss("[mesh] or [domain]", "[mesh] with file = \"part.vtu\", or [domain] with file = \"part.poly\"");
  if (mesh) {
    result.mesh = mesh->take_path("file");
    if (!result.mesh && mesh->take("file") == nullptr) mesh->miss("file", "file = \"part.vtu\"");
    mesh->finish();
  }
  if (domain) read_domain_table(*domain, result);
}

void read_equation(CaseTable& file, Case& result) {
  CaseValue none;
  none.kind = CaseValue::Kind::kTable;
  CaseTable table = file.take_table("equation").value_or(CaseTable(none, "equation", file.faults()));
  result.conductivity = take_coefficient(table, "conductivity", 1);
  result.reaction = take_coefficient(table, "reaction", 0);
  result.source = take_coefficient(table, "source", 0);
  result.capacity = take_coefficient(table, "capacity", 1);
  result.mean = table.take_number("mean");
  table.finish();
}

void read_exact(CaseTable& file, Case& result) {
  std::optional<CaseTable> table = file.take_table("exact");
  if (!table) return;
  CaseExact exact;
  if (table->take("u") == nullptr) table->miss("u", "u = \"sin(pi*x)\"");
  exact.u = take_formula(*table, "u", 0);
  if (const CaseValue* const gradient = table->take("gradient")) {
    const std::string name = table->full_name("gradient");
    for (const CaseValue& item : gradient->items) {
      if (item.kind == CaseValue::Kind::kText)
        exact.gradient.push_back({item.text, name, item.place});
      else if (item.kind == CaseValue::Kind::kNumber)
        exact.gradient.push_back({item.number, name, item.place});
    }
    if (gradient->kind != CaseValue::Kind::kArray || exact.gradient.empty() ||
        exact.gradient.size() != gradient->items.size())
      file.faults().add(
          "case.wrong_type", gradient->place,
          fmt::format("{} is {}, but has to be an array of formulas", name, kind_name(*gradient)),
          "give as many as there are dimensions, such as [\"2*x\", \"0\"], or none: it is derived from u.");
  }
  table->finish();
  result.exact = std::move(exact);
}

void read_linear(CaseTable& file, Case& result) {
  std::optional<CaseTable> table = file.take_table("linear");
  if (!table) return;
  LinearOptions& linear = result.newton.linear;
  set(linear.method, table->take_choice("method", {"automatic", "direct", "conjugate-gradients"}));
  set(result.preconditioner,
      table->take_choice("preconditioner", {"automatic", "multigrid", "incomplete-cholesky", "diagonal"}));
  set(linear.tolerance, table->take_positive("tolerance", 0.1));
  set(linear.max_iterations, table->take_whole("max_iterations", 1, kMaxIterations));
  result.levels = table->take_paths("levels");
  if (!result.levels.empty()) {
    if (!result.mesh)
      file.faults().add("case.contradiction", table->key_place("levels"),
                        "linear.levels are given, and the mesh is still to be made",
                        "name the mesh that they belong to under [mesh], or leave them out.");
    if (result.preconditioner == CasePreconditioner::kAutomatic) result.preconditioner = CasePreconditioner::kMultigrid;
    if (result.preconditioner != CasePreconditioner::kMultigrid)
      file.faults().add("case.contradiction", table->key_place("levels"),
                        "linear.levels are given, and the preconditioner is not multigrid",
                        "leave out one of the two.");
  }
  table->finish();
}

void read_newton(CaseTable& file, Case& result) {
  std::optional<CaseTable> table = file.take_table("newton");
  if (!table) return;
  set(result.newton.tolerance, table->take_positive("tolerance", 0.1));
  set(result.newton.max_steps, table->take_whole("max_steps", 1, kMaxIterations));
  set(result.newton.smallest_damping, table->take_positive("smallest_damping", 1));
  if (const CaseValue* const initial = table->take("initial")) {
    result.newton_initial = take_coefficient(*table, "initial", 0);
    if (std::holds_alternative<std::map<int, CaseFormula>>(result.newton_initial->value))
      file.faults().add("case.wrong_type", initial->place, "newton.initial cannot differ by region",
                        "give a number, a formula in quotation marks, or {array = \"name\"}.");
  }
  table->finish();
}

void read_time(CaseTable& file, Case& result) {
  std::optional<CaseTable> table = file.take_table("time");
  if (!table) return;
  CaseTime time;
  TimeOptions& options = time.options;
  set(options.begin, table->take_number("begin"));
  const std::optional<double> end = table->take_number("end");
  if (!end && table->take("end") == nullptr) table->miss("end", "end = 1.0");
  options.end = end.value_or(options.begin + 1);
  if (!(options.end > options.begin))
    file.faults().add("case.contradiction", table->key_place("end"),
                      fmt::format("time ends at {} and begins at {}", options.end, options.begin),
                      "let time.end be later than time.begin, which is 0 unless given.");
  options.step = 0.01 * (options.end - options.begin);
  set(options.step, table->take_positive("step"));
  set(options.scheme, table->take_choice("scheme", {"backward-euler", "crank-nicolson"}));
  set(options.n_startup, table->take_whole("startup_steps", 0, kMaxIterations));
  options.tolerance = table->take_positive("tolerance");
  set(options.smallest_step, table->take_positive("smallest_step"));
  set(options.max_steps, table->take_whole("max_steps", 1, std::numeric_limits<std::int64_t>::max()));
  time.initial = take_coefficient(*table, "initial", 0);
  table->finish();
  result.time = std::move(time);
}

/// What finite elements are not there for.
void check_method(const Case& result, CaseFaults& faults, const CaseTable& file) {
  if (result.method == CaseMethod::kFiniteElements && result.time)
    faults.add("case.contradiction", file.key_place("time"), "finite elements solve stationary problems only",
               "leave out [time], or set method = \"cvm\".");
}

void read_outputs(CaseTable& file, Case& result) {
  std::optional<CaseTable> table = file.take_table("output");
  if (!table) return;
  if (const std::optional<fs::path> mesh = table->take_path("mesh")) result.outputs.meshes.push_back(*mesh);
  result.outputs.cells = table->take_path("cells");
  result.outputs.fluxes = table->take_path("fluxes");
  result.outputs.every = table->take_positive("every");
  table->finish();
}

}  // namespace

Case read_case(const fs::path& path) {
  const CaseValue root = read_case_file(path);
  CaseFaults faults(path);
  CaseTable file(root, "", faults);
  Case result;
  result.file = path;
  file.take_text("title");
  set(result.method, file.take_choice("method", {"cvm", "fem"}));
  read_places(file, result, faults);
  read_equation(file, result);
  read_conditions(file, result);
  read_exact(file, result);
  read_time(file, result);
  read_linear(file, result);
  read_newton(file, result);
  read_outputs(file, result);
  file.finish();
  check_method(result, faults, file);
  faults.check();
  return result;
}

}  // namespace voropack::app
