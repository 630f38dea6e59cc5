// voropack solve: the diffusion problem of a case file, by control volumes or finite elements.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "case.h"
#include "case_problem.h"
#include "command.h"
#include "meshing.h"
#include "print.h"
#include "solve_adaptive.h"
#include "solve_case.h"
#include "solve_output.h"
#include "solve_report.h"
#include "stage_clock.h"
#include "unused_vertices.h"
#include "voropack/mesh_domain.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct SolveArguments {
  fs::path file;
  bool redelaunay = false;
  AdaptiveWishes adaptive;
  CaseOutputs outputs;  ///< What is given takes the place of what the case says.
};

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

Json options_json(const Case& given, const AdaptiveWishes& adaptive) {
  Json json;
  json["adapt"] = adaptive.is_wished ? options_json(adaptive) : Json(false);
  json["method"] = given.method == CaseMethod::kControlVolumes ? "cvm" : "fem";
  for (const fs::path& mesh : given.outputs.meshes) json["output"].push_back(mesh.string());
  if (given.outputs.cells) json["cells"] = given.outputs.cells->string();
  if (given.outputs.fluxes) json["fluxes"] = given.outputs.fluxes->string();
  return json;
}

std::string output_lines(const StagedSolution& staged, std::size_t n_states) {
  std::string text;
  for (const fs::path& name : staged.names) {
    text += "file              " + name.string();
    if (name.extension() == ".pvd") text += fmt::format(", {} states", n_states);
    text += '\n';
  }
  return text;
}

std::string timing_line(const StageTimes& times) {
  std::string text = "wall time";
  for (const char* name : {"assemble", "coarsen", "multigrid", "solve"})
    if (const auto found = times.find(name); found != times.end())
      text += fmt::format("{}{} {:.3g} s", text == "wall time" ? std::string(9, ' ') : ", ", name, found->second);
  return text + '\n';
}

/// The solution, written on the way: of a case in time its states, of an adaptive one its meshes.
template <int D>
Solved<D> solve_and_write(Setting<D>& setting, const Domain<D>* domain, const SolveArguments& arguments,
                          SolutionWriter<D>& writer, AdaptiveFigures& adaptive, Report& report, Session& session) {
  if (arguments.adaptive.is_wished)
    return solve_adaptively<D>(
        setting, *domain, arguments.adaptive,
        [&](std::size_t cycle, const SolutionArrays<D>& arrays) { writer.add(static_cast<double>(cycle), arrays); },
        adaptive, report, session);
  StageClock clock(session.observer, report.times);
  clock.begin_stage("dual");
  prepare(setting, clock);
  Solved<D> solved = solve_case<D>(
      setting, [&](double time, const SolutionArrays<D>& arrays) { writer.add(time, arrays); }, clock);
  clock.begin_stage("write");
  writer.add(setting.given.time ? setting.given.time->options.end : 0, solved.arrays);
  return solved;
}

/// Everything from the mesh on. `setting` has mesh and control volumes; `domain` is needed to adapt only.
template <int D>
ExitCode finish_case(Setting<D>& setting, const Domain<D>* domain, const SolveArguments& arguments,
                     const StagedSolution& staged, Report& report, std::string text, Session& session) {
  const Case& given = setting.given;
  if (given.method == CaseMethod::kControlVolumes)
    refuse_negative_areas<D>(given.mesh ? *given.mesh : *given.domain, *report.quality);
  setting.writes_cells = staged.cells.has_value();
  SolutionWriter<D> writer(setting, staged);
  AdaptiveFigures adaptive;
  const Solved<D> solved = solve_and_write(setting, domain, arguments, writer, adaptive, report, session);
  StageClock clock(session.observer, report.times);
  clock.begin_stage("write");
  writer.finish();
  if (staged.fluxes) write_text(fluxes_csv(solved.figures), *staged.fluxes);
  clock.stop();
  if (const auto steps = report.times.extract("time steps"); !steps.empty()) report.times["solve"] += steps.mapped();
  report.solve = solve_json(solved.figures);
  ExitCode code = ExitCode::kDone;
  if (arguments.adaptive.is_wished) {
    (*report.solve)["adaptivity"] = adaptive_json(adaptive);
    text += adaptive_table(adaptive) + '\n';
    code = adaptive_exit_code(adaptive, arguments.adaptive);
  }
  text += count_table(*report.quality) + '\n';
  text += solve_tables(solved.figures) + timing_line(report.times) + output_lines(staged, writer.n_states()) +
          staged.stale_line(writer.n_states());
  session.finish(report, text);
  return code;
}

template <int D>
ExitCode solve_on_mesh(const Case& given, Mesh<D> mesh, const SolveArguments& arguments, const StagedSolution& staged,
                       Report& report, Session& session) {
  if (mesh.simplex_vertices.empty())
    throw InputError(Fault{.id = "case.empty_mesh",
                           .message = "the mesh has no simplices",
                           .fix = "give a mesh, or a domain under [domain].",
                           .file = given.mesh->string()});
  const std::vector<VertexId> unused = unused_vertices(mesh);
  Setting<D> setting{.given = given, .compiled = compile_case<D>(given), .mesh = without(std::move(mesh), unused)};
  report.input = describe_file(*given.mesh, D);
  setting.volumes = timed(report.times, "dual", [&] { return build_control_volumes(setting.mesh, session.observer); });
  report.quality =
      timed(report.times, "quality", [&] { return measure_quality(setting.mesh, setting.volumes, session.observer); });
  std::optional<MeshDomain<D>> place;
  if (arguments.adaptive.is_wished)
    place = timed(report.times, "domain", [&] { return domain_of(setting.mesh, session.observer); });
  std::string text = fmt::format("{}: {}D\n", given.mesh->string(), D);
  if (!unused.empty()) text += fmt::format("left out: {}\n", unused_in_words(unused));
  return finish_case(setting, place ? &place->domain : nullptr, arguments, staged, report, text + '\n', session);
}

template <int D>
ExitCode solve_on_domain(const Case& given, const DomainInput<D>& input, const SolveArguments& arguments,
                         const StagedSolution& staged, Report& report, Session& session) {
  Setting<D> setting{.given = given, .compiled = compile_case<D>(given)};
  const MeshingOptions<D> options =
      timed(report.times, "read", [&] { return meshing_options<D>(given.wishes, session); });
  MeshingResult<D> result = [&] {
    try {
      return make_mesh<D>(input, options, session.observer);
    } catch (const LimitError& error) {
      throw in_words_of_case(error);
    }
  }();
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
  text += "certificate: ok\n\n";
  setting.mesh = std::move(result.mesh);
  setting.domain = std::move(result.domain);
  setting.volumes = std::move(result.volumes);
  return finish_case(setting, &*setting.domain, arguments, staged, report, std::move(text), session);
}

/// Files named on the command line take the place of those in the case.
void replace_outputs(const CaseOutputs& wanted, CaseOutputs& outputs) {
  if (!wanted.meshes.empty()) outputs.meshes = wanted.meshes;
  if (wanted.cells) outputs.cells = wanted.cells;
  if (wanted.fluxes) outputs.fluxes = wanted.fluxes;
}

void protect_inputs(const Case& given, const AdaptiveWishes& adaptive, OutputSet& outputs) {
  outputs.protect(given.file);
  if (given.mesh) outputs.protect(*given.mesh);
  if (given.domain)
    for (const fs::path& file : domain_files(*given.domain)) outputs.protect(file);
  for (const fs::path& file : given.wishes.files()) outputs.protect(file);
  if (const std::optional<fs::path> field = adaptive.field_file()) outputs.protect(*field);
  for (const fs::path& level : given.levels) outputs.protect(level);
  std::vector<const CaseCoefficient*> coefficients = {&given.conductivity, &given.reaction, &given.source,
                                                      &given.capacity};
  if (given.time) coefficients.push_back(&given.time->initial);
  if (given.newton_initial) coefficients.push_back(&*given.newton_initial);
  for (const CaseCoefficient* coefficient : coefficients)
    if (const auto* const array = std::get_if<CaseArray>(&coefficient->value))
      if (array->file) outputs.protect(*array->file);
}

ExitCode run_solve(const SolveArguments& arguments, Session& session) {
  Case given = read_case(arguments.file);
  replace_outputs(arguments.outputs, given.outputs);
  check_adaptive(arguments.adaptive, given);
  const StagedSolution staged =
      stage(given.outputs, given.time.has_value() || arguments.adaptive.is_wished, session.outputs);
  protect_inputs(given, arguments.adaptive, session.outputs);

  Report report;
  report.command = "solve";
  report.case_file = describe_file(given.file, {});
  report.options["redelaunay"] = arguments.redelaunay;
  report.options.update(options_json(given, arguments.adaptive));
  session.observer.begin_stage("read");
  if (given.mesh) {
    AnyMesh mesh = timed(report.times, "read",
                         [&] { return read_mesh_or_triangulate(*given.mesh, arguments.redelaunay, session.observer); });
    return std::visit(
        [&](auto& any) { return solve_on_mesh(given, std::move(any), arguments, staged, report, session); }, mesh);
  }
  if (arguments.redelaunay)
    throw OptionError(Fault{.id = "cli.contradiction",
                            .message = "--redelaunay is given, and the case has a domain, whose mesh is Delaunay",
                            .fix = "leave it out, or name a mesh under [mesh].",
                            .file = given.file.string()});
  const AnyDomainInput input =
      timed(report.times, "read", [&] { return read_domain(*given.domain, session.observer); });
  return std::visit([&](const auto& any) { return solve_on_domain(given, any, arguments, staged, report, session); },
                    input);
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
  add_redelaunay_option(*app, arguments->redelaunay);
  add_adaptive_options(*app, arguments->adaptive);
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
      "Example: voropack solve heat.toml -o heat.vtu --report heat.json\n"
      "         voropack solve heat.toml -o heat.vtu --adapt --tolerance 0.01 --max-vertices 200000");
  return {app, [arguments](Session& session) { return run_solve(*arguments, session); }};
}

}  // namespace voropack::app
