// voropack solve: the diffusion problem of a case file, by control volumes or finite elements.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "case.h"
#include "case_problem.h"
#include "command.h"
#include "figure3.h"
#include "meshing.h"
#include "print.h"
#include "solve_output.h"
#include "solve_report.h"
#include "stage_clock.h"
#include "voropack/fem.h"
#include "voropack/norms.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct SolveArguments {
  fs::path file;
  CaseOutputs outputs;  ///< What is given takes the place of what the case says.
};

/// A case on its mesh.
template <int D>
struct Setting {
  const Case& given;
  CompiledCase<D> compiled;
  Mesh<D> mesh;
  ControlVolumes<D> volumes;
  BoundaryAreas<D> boundary;
  std::optional<CellShapes<D>> shapes;  ///< Where cells are written or integrated over.
};

template <int D>
struct Solved {
  SolveFigures figures;
  SolutionArrays<D> arrays;
};

/// The solver knows no files: its errors are about the case.
template <class Work>
auto blame_case(const fs::path& file, Work&& work) {
  try {
    return work();
  } catch (const InputError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults)
      if (fault.file.empty()) fault.file = file.string();
    throw InputError(std::move(faults));
  }
}

template <int D>
SolveErrors measure_errors(const Setting<D>& setting, const IdVector<VertexId, double>& values) {
  const auto exact = exact_solution(setting.compiled);
  const auto gradient = exact_gradient(setting.compiled);
  const Mesh<D>& mesh = setting.mesh;
  const VertexValues errors = vertex_errors<D>(mesh.points, values, exact);
  SolveErrors result;
  const auto& areas = setting.volumes.face_area;
  // Where areas are negative it is no norm.
  if (std::all_of(areas.begin(), areas.end(), [](double area) { return area >= 0; }))
    result.w = w_norm(setting.volumes, errors, find_hull_vertices(mesh));
  result.l2 = l2_error<D>(mesh, values, exact);
  result.h1 = h1_error<D>(mesh, values, gradient);
  result.max = max_norm(errors);
  if constexpr (D == 3) {
    IdVector<SimplexId, std::uint8_t> is_sliver(mesh.simplex_vertices.size());
    for (const SimplexId s : ids(is_sliver)) is_sliver[s] = min_dihedral_deg(mesh, s) < kSliverDihedralDeg ? 1 : 0;
    result.n_slivers = static_cast<std::uint64_t>(std::count(is_sliver.begin(), is_sliver.end(), 1));
    result.h1_without_slivers = h1_error<D>(mesh, values, gradient, [&](SimplexId s) { return is_sliver[s] == 0; });
  }
  return result;
}

template <int D>
DiffusionSolution<D> solve_by_finite_elements(const Setting<D>& setting, const DiffusionProblem<D>& problem,
                                              Observer& observer) {
  observer.begin_stage("assemble");
  const LinearSystem system = assemble_fem(setting.mesh, problem);
  LinearOptions options = setting.given.linear;
  if (!setting.given.has_preconditioner) options.preconditioner = fem_linear_options().preconditioner;
  DiffusionSolution<D> solution;
  solution.matrix = check_m_matrix(system);
  LinearSolution linear = solve_linear_system(system, options, observer);
  solution.values = std::move(linear.values);
  solution.linear = std::move(linear.report);
  return solution;
}

template <int D>
Solved<D> solve_case(const Setting<D>& setting, Observer& observer) {
  DiffusionProblem<D> problem = make_problem(setting.compiled);
  const bool is_fem = setting.given.method == CaseMethod::kFiniteElements;
  DiffusionSolution<D> solution = blame_case(setting.given.file, [&] {
    if (is_fem) return solve_by_finite_elements(setting, problem, observer);
    observer.begin_stage("assemble");
    if (setting.shapes) problem.source_integrals = integrate_source(setting.compiled, *setting.shapes, setting.volumes);
    return solve(setting.volumes, setting.boundary, problem, setting.given.linear, observer);
  });
  Solved<D> result;
  const auto [least, largest] = std::minmax_element(solution.values.begin(), solution.values.end());
  result.figures = {.method = setting.given.method,
                    .least = *least,
                    .largest = *largest,
                    .fluxes = std::move(solution.fluxes),
                    .balances = std::move(solution.balances),
                    .matrix = solution.matrix,
                    .linear = std::move(solution.linear),
                    .compensation = solution.compensation,
                    .errors = {}};
  if (setting.compiled.exact) {
    observer.begin_stage("norms");
    result.figures.errors = measure_errors(setting, solution.values);
    result.arrays.error = vertex_errors<D>(setting.mesh.points, solution.values, exact_solution(setting.compiled));
  }
  result.arrays.u = std::move(solution.values);
  return result;
}

template <int D>
bool is_function(const CompiledCoefficient<D>& coefficient) {
  if (const auto* const formula = std::get_if<CompiledFormula<D>>(&coefficient)) return !formula->is_number();
  return std::holds_alternative<std::map<int, CompiledFormula<D>>>(coefficient);
}

/// Two-point fluxes through negative areas would flow uphill.
template <int D>
void refuse_negative_areas(const fs::path& mesh, const QualityReport& quality) {
  if (quality.n_negative_faces == 0) return;
  throw InputError(Fault{.id = "case.not_delaunay",
                         .message = fmt::format("{} of {} dual faces have a negative area, down to {:.4g}: the mesh is "
                                                "not a Delaunay mesh, or its boundary is not conforming",
                                                quality.n_negative_faces, quality.n_dual_faces, quality.min_face_area),
                         .fix = "mesh the domain with voropack ([domain] instead of [mesh]), or set method = \"fem\".",
                         .file = mesh.string()});
}

Json options_json(const Case& given) {
  Json json;
  json["method"] = given.method == CaseMethod::kControlVolumes ? "cvm" : "fem";
  for (const fs::path& mesh : given.outputs.meshes) json["output"].push_back(mesh.string());
  if (given.outputs.cells) json["cells"] = given.outputs.cells->string();
  if (given.outputs.fluxes) json["fluxes"] = given.outputs.fluxes->string();
  return json;
}

std::string output_lines(const CaseOutputs& outputs) {
  std::string text;
  for (const fs::path& mesh : outputs.meshes) text += "mesh:   " + mesh.string() + '\n';
  if (outputs.cells) text += "cells:  " + outputs.cells->string() + '\n';
  if (outputs.fluxes) text += "fluxes: " + outputs.fluxes->string() + '\n';
  return text;
}

std::string timing_line(const StageTimes& times) {
  std::string text = "time";
  for (const char* name : {"assemble", "solve"})
    if (const auto found = times.find(name); found != times.end())
      text += fmt::format("{}{} {:.3g} s", text == "time" ? std::string(14, ' ') : ", ", name, found->second);
  return text + '\n';
}

/// Everything from the mesh on. `setting` has mesh and control volumes.
template <int D>
ExitCode finish_case(Setting<D>& setting, const StagedSolution& staged, Report& report, std::string text,
                     Session& session) {
  const Case& given = setting.given;
  text += count_table(*report.quality) + '\n';
  const bool is_cvm = given.method == CaseMethod::kControlVolumes;
  if (is_cvm) refuse_negative_areas<D>(given.mesh ? *given.mesh : *given.domain, *report.quality);
  StageClock clock(session.observer, report.times);
  clock.begin_stage("dual");
  setting.boundary = build_boundary_areas(setting.mesh);
  const auto& markers = setting.boundary.patch_marker;
  bind_case(given, setting.mesh, std::set<int>(markers.begin(), markers.end()), setting.compiled, clock);
  if (staged.cells || (is_cvm && is_function(setting.compiled.source)))
    setting.shapes = build_cell_shapes(setting.mesh, setting.volumes);
  const Solved<D> solved = solve_case(setting, clock);
  clock.begin_stage("write");
  write_solution(setting.mesh, setting.volumes, setting.shapes ? &*setting.shapes : nullptr, solved.arrays, staged);
  if (staged.fluxes) write_text(fluxes_csv(solved.figures), *staged.fluxes);
  clock.stop();
  report.solve = solve_json(solved.figures);
  text += solve_tables(solved.figures) + timing_line(report.times) + output_lines(given.outputs);
  session.finish(report, text);
  return ExitCode::kDone;
}

template <int D>
ExitCode solve_on_mesh(const Case& given, Mesh<D> mesh, const StagedSolution& staged, Report& report,
                       Session& session) {
  Setting<D> setting{given, compile_case<D>(given), std::move(mesh), {}, {}, {}};
  report.input = describe_file(*given.mesh, D);
  setting.volumes = timed(report.times, "dual", [&] { return build_control_volumes(setting.mesh, session.observer); });
  report.quality =
      timed(report.times, "quality", [&] { return measure_quality(setting.mesh, setting.volumes, session.observer); });
  return finish_case(setting, staged, report, fmt::format("{}: {}D\n\n", given.mesh->string(), D), session);
}

template <int D>
ExitCode solve_on_domain(const Case& given, const DomainInput<D>& input, const StagedSolution& staged, Report& report,
                         Session& session) {
  Setting<D> setting{given, compile_case<D>(given), {}, {}, {}, {}};
  const MeshingOptions<D> options =
      timed(report.times, "read", [&] { return meshing_options<D>(given.wishes, session); });
  MeshingResult<D> result = make_mesh<D>(input, options, session.observer);
  report.options.update(meshing_json(given.wishes, options));
  report.input = describe_domain(*given.domain, result.domain);
  describe_meshing(result, report);
  for (const auto& [stage, seconds] : result.times) report.times[stage] += seconds;
  std::string text = domain_line(*given.domain, result.domain) + '\n';
  if (!result.certificate.ok) {
    text += certificate_table(result.certificate) + "not solved: the mesh is not certified\n";
    session.finish(report, text);
    return ExitCode::kCheckFailed;
  }
  setting.mesh = std::move(result.mesh);
  setting.volumes = std::move(result.volumes);
  return finish_case(setting, staged, report, std::move(text), session);
}

/// Files named on the command line take the place of those in the case.
void replace_outputs(const CaseOutputs& wanted, CaseOutputs& outputs) {
  if (!wanted.meshes.empty()) outputs.meshes = wanted.meshes;
  if (wanted.cells) outputs.cells = wanted.cells;
  if (wanted.fluxes) outputs.fluxes = wanted.fluxes;
}

void protect_inputs(const Case& given, const OutputSet& outputs) {
  outputs.protect(given.file);
  for (const std::optional<fs::path>& input : {given.mesh, given.domain, given.wishes.size_field})
    if (input) outputs.protect(*input);
  for (const CaseCoefficient* coefficient : {&given.conductivity, &given.reaction, &given.source})
    if (const auto* const array = std::get_if<CaseArray>(&coefficient->value))
      if (array->file) outputs.protect(*array->file);
}

ExitCode run_solve(const SolveArguments& arguments, Session& session) {
  Case given = read_case(arguments.file);
  replace_outputs(arguments.outputs, given.outputs);
  const StagedSolution staged = stage(given.outputs, session.outputs);
  protect_inputs(given, session.outputs);

  Report report;
  report.command = "solve";
  report.options["case"] = given.file.string();
  report.options.update(options_json(given));
  session.observer.begin_stage("read");
  if (given.mesh) {
    AnyMesh mesh = timed(report.times, "read", [&] { return read_mesh(*given.mesh, session.observer); });
    return std::visit([&](auto& any) { return solve_on_mesh(given, std::move(any), staged, report, session); }, mesh);
  }
  const AnyDomainInput input =
      timed(report.times, "read", [&] { return read_domain(*given.domain, session.observer); });
  return std::visit([&](const auto& any) { return solve_on_domain(given, any, staged, report, session); }, input);
}

}  // namespace

Command add_solve_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("solve", "Solve a diffusion problem by control volumes or finite elements");
  const auto arguments = std::make_shared<SolveArguments>();
  app->add_option("CASE", arguments->file, "Case file (.toml): mesh or domain, equation, conditions, outputs")
      ->required();
  app->add_option("-o,--output", arguments->outputs.meshes,
                  "Mesh with the solution as array u, instead of the case's output.mesh")
      ->allow_extra_args(false)
      ->type_name("MESH.vtu");
  app->add_option("--cells", arguments->outputs.cells,
                  "Control volumes with the solution as array u, instead of output.cells")
      ->type_name("FILE.vtu");
  app->add_option("--fluxes", arguments->outputs.fluxes, "Table of what enters by marker, instead of output.fluxes")
      ->type_name("FILE.csv");
  add_common_options(*app, common);
  app->footer(
      "docs/case.md describes the case file. It needs a mesh or a domain, and conditions:\n"
      "  [domain]\n"
      "  file = \"plate.poly\"\n"
      "  size = 0.2\n"
      "  [equation]\n"
      "  conductivity = {1 = 1.0, 2 = 10.0}\n"
      "  [boundary.1]\n"
      "  type = \"dirichlet\"\n"
      "  value = \"20 + x\"\n"
      "Example: voropack solve heat.toml -o heat.vtu --report heat.json");
  return {app, [arguments](Session& session) { return run_solve(*arguments, session); }};
}

}  // namespace voropack::app
