// voropack refine: a finer mesh that keeps the vertices of the one given.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>

#include "command.h"
#include "known_domain.h"
#include "meshing.h"
#include "print.h"
#include "unused_vertices.h"
#include "voropack/refinement.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct RefineArguments {
  fs::path mesh;
  KnownDomain domain;
  std::vector<fs::path> outputs;
  std::optional<fs::path> cells;
  std::optional<int> levels;
  bool keep_fitting = false, force = false, redelaunay = false;
  MeshingWishes wishes;

  /// One level if nothing else is wished.
  [[nodiscard]] int n_levels() const { return levels.value_or(wishes.has_size() ? 0 : 1); }
  /// Vertices may go, and sizes say what the spacing is: that of the mesh given does not matter.
  [[nodiscard]] bool may_grow() const { return keep_fitting && wishes.has_size() && !levels; }
};

template <int D>
Json options_json(const RefineArguments& arguments, const MeshingOptions<D>& options) {
  Json json;
  json["output"] = Json::array();
  for (const fs::path& output : arguments.outputs) json["output"].push_back(output.string());
  if (arguments.cells) json["cells"] = arguments.cells->string();
  json["levels"] = arguments.n_levels();
  json["keep"] = arguments.keep_fitting ? "fitting" : "all";
  json["force"] = arguments.force;
  json["redelaunay"] = arguments.redelaunay;
  json.update(meshing_json(arguments.wishes, options));
  describe_known_domain(arguments.domain, json);
  return json;
}

/// What refinement relies on. Whether the mesh given is maximal or well shaped is for its maker to answer.
bool is_relied_upon(std::string_view check) {
  constexpr std::array<std::string_view, 3> kNot = {"voronoi_maximal", "radius_edge", "spacing_lipschitz"};
  return std::find(kNot.begin(), kNot.end(), check) == kNot.end();
}

template <class Id>
void forget(IdVector<Id, int>& markers) {
  std::fill(markers.begin(), markers.end(), 0);
}

/// A domain that is known gives the new mesh its markers, whatever those of the old one are.
template <int D>
Certificate certify_without_markers(Mesh<D> mesh, Domain<D> domain, const ControlVolumes<D>& volumes,
                                    const CertificateOptions& claims, Observer& observer) {
  forget(mesh.boundary_marker);
  forget(mesh.segment_edge_marker);
  forget(domain.segment_marker);
  forget(domain.facet_marker);
  return certify(mesh, volumes, &domain, claims, observer);
}

/// The names of the checks that the mesh given fails.
template <int D>
std::vector<std::string> failed_checks(const Mesh<D>& mesh, const Domain<D>& domain, const RefineArguments& arguments,
                                       Observer& observer) {
  CertificateOptions claims;
  claims.form = arguments.wishes.packing.form;
  claims.epsilon = arguments.wishes.packing.epsilon;
  const ControlVolumes<D> volumes = build_control_volumes(mesh, observer);
  const Certificate certificate = arguments.domain.file
                                      ? certify_without_markers(mesh, domain, volumes, claims, observer)
                                      : certify(mesh, volumes, &domain, claims, observer);
  std::vector<std::string> failed;
  for (const Certificate::Check& check : certificate.checks)
    if (!check.ok && is_relied_upon(check.name)) failed.push_back(check.name);
  return failed;
}

/// The spacing of the finer mesh: at most that of the mesh given, but where it may grow what `mesh` would take.
template <int D>
Spacing<D> new_spacing(const Mesh<D>& mesh, const Domain<D>& domain, const RefineArguments& arguments,
                       const MeshingOptions<D>& options, Observer& observer) {
  const SpacingOptions spacing_options{options.gradation, options.feature_factor, edge_per_spacing<D>(options.packing)};
  if (arguments.may_grow()) return build_spacing(domain, options.wishes, spacing_options, observer);
  return refined_spacing(mesh, domain, std::ldexp(1.0, -arguments.n_levels()), options.wishes, spacing_options,
                         observer);
}

/// Why vertices were not added or not there, where one might wonder.
template <int D>
std::string remarks(const RefinedMesh<D>& refined, const std::vector<VertexId>& unused,
                    const RefineArguments& arguments) {
  std::string text;
  if (!unused.empty()) text += fmt::format("left out: {}\n", unused_in_words(unused));
  if (refined.n_added == 0 && arguments.wishes.has_size() && !arguments.may_grow())
    text +=
        "No size asks for more vertices: sizes are upper bounds, and so is the spacing of the mesh given.\n"
        "--keep fitting without --levels lets vertices go where sizes are larger.\n";
  return text;
}

template <int D>
ExitCode refine_mesh(const Mesh<D>& given, const RefineArguments& arguments, StageTimes times, Session& session) {
  Observer& observer = session.observer;
  std::vector<fs::path> staged;
  for (const fs::path& output : arguments.outputs) staged.push_back(session.outputs.stage(output));
  std::optional<fs::path> staged_cells;
  if (arguments.cells) staged_cells = session.outputs.stage(*arguments.cells);

  const std::vector<VertexId> unused = unused_vertices(given);
  const Mesh<D> mesh = without(given, unused);
  const MeshingOptions<D> options = timed(times, "read", [&] { return meshing_options<D>(arguments.wishes, session); });
  const MeshDomain<D> place = timed(times, "domain", [&] { return find_place(mesh, arguments.domain, observer); });
  const std::vector<std::string> failed =
      timed(times, "certificate", [&] { return failed_checks(mesh, place.domain, arguments, observer); });
  if (!failed.empty() && !arguments.force)
    throw InputError(
        Fault{.id = "refine.not_certified",
              .message = fmt::format("the mesh fails {} of its certificate", fmt::join(failed, ", ")),
              .fix = arguments.redelaunay
                         ? "see `voropack check --redelaunay`; --force goes on, `voropack mesh` meshes the "
                           "domain again"
                         : "see `voropack check`; --redelaunay triangulates its points anew, --force goes on",
              .file = arguments.mesh.string()});

  const Spacing<D> spacing =
      timed(times, "spacing", [&] { return new_spacing(mesh, place.domain, arguments, options, observer); });
  RefinedMesh<D> refined = timed(times, "packing", [&] {
    return refine(mesh, place, spacing, {.packing = options.packing, .keep_all = !arguments.keep_fitting}, observer);
  });
  times["packing"] -= refined.triangulation_s;
  times["delaunay"] += refined.triangulation_s;
  const ControlVolumes<D> volumes = timed(times, "dual", [&] { return build_control_volumes(refined.mesh, observer); });

  Report report;
  report.command = "refine";
  report.options = options_json(arguments, options);
  report.input = describe_file(arguments.mesh, D);
  report.input.regions = place.domain.region_id.size();
  report.quality = timed(times, "quality", [&] { return measure_quality(refined.mesh, volumes, observer); });
  const CertificateOptions claims =
      packing_claims(refined.repairs.empty() ? spacing : spacing.with_caps(refined.repairs), options.packing);
  report.certificate =
      timed(times, "certificate", [&] { return certify(refined.mesh, volumes, &place.domain, claims, observer); });
  report.packing = PackingFigures{.repairs = refined.repairs.size(), .repair_rounds = refined.repair_rounds};
  report.refinement = Json{{"kept", refined.n_kept}, {"added", refined.n_added}, {"removed", refined.n_removed}};
  if (!failed.empty()) (*report.refinement)["input_failed"] = failed;
  if (!unused.empty()) (*report.refinement)["unused"] = unused.size();
  report.times = std::move(times);

  observer.begin_stage("write");
  timed(report.times, "write", [&] {
    for (const fs::path& path : staged) {
      observer.check_cancelled();
      write_mesh(refined.mesh, path);
    }
    observer.check_cancelled();
    if (staged_cells) write_cells(build_cell_shapes(refined.mesh, volumes), volumes, *staged_cells);
  });
  std::string text = fmt::format("{} vertices kept, {} added, {} removed\n", grouped(refined.n_kept),
                                 grouped(refined.n_added), grouped(refined.n_removed));
  text += remarks(refined, unused, arguments) + '\n';
  if (!failed.empty()) text += fmt::format("The mesh given fails {} of its certificate.\n\n", fmt::join(failed, ", "));
  text += count_table(*report.quality) + '\n' + quality_table(*report.quality) + '\n';
  text += certificate_table(*report.certificate);
  for (const fs::path& output : arguments.outputs) text += "mesh:  " + output.string() + '\n';
  if (arguments.cells) text += "cells: " + arguments.cells->string() + '\n';
  session.finish(report, text);
  return report.certificate->ok ? ExitCode::kDone : ExitCode::kCheckFailed;
}

ExitCode run_refine(const RefineArguments& arguments, Session& session) {
  for (const fs::path& output : arguments.outputs) check_extension(output, kMeshExtensions);
  if (arguments.cells) check_extension(*arguments.cells, {".vtu"});
  session.outputs.protect(arguments.mesh);
  for (const fs::path& file : arguments.domain.files()) session.outputs.protect(file);
  for (const fs::path& file : arguments.wishes.files()) session.outputs.protect(file);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(
      times, "read", [&] { return read_mesh_or_triangulate(arguments.mesh, arguments.redelaunay, session.observer); });
  return std::visit([&](const auto& any) { return refine_mesh(any, arguments, times, session); }, mesh);
}

}  // namespace

Command add_refine_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("refine", "A finer mesh that keeps the vertices of the one given");
  const auto arguments = std::make_shared<RefineArguments>();
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele) or .vtu, of any program")->required();
  add_output_option(*app, arguments->outputs,
                    "Mesh to write: .node (with .ele, .face, .edge) or .vtu; may be given again")
      ->type_name("OUT");
  app->add_option("--cells", arguments->cells, "Write the control volumes as polyhedra or polygons")
      ->type_name("FILE.vtu");
  app->add_option("--levels", arguments->levels,
                  "Halve the spacing everywhere so many times; default 1, or 0 where a size is given")
      ->check(whole_number(0, 30));
  std::vector<std::string> kinds = {"all", "fitting"};
  app->add_option_function<std::string>(
         "--keep", [arguments](const std::string& kind) { arguments->keep_fitting = kind == "fitting"; },
         "Old vertices that stay: all, so that the spacing shrinks only; or those that fit (fitting), where sizes "
         "given\n"
         "without --levels may be larger than the mesh's and say what the spacing is, as in mesh")
      ->check(one_of(kinds))
      ->type_name("KIND")
      ->default_str("all");
  app->add_flag("--force", arguments->force, "Go on where the certificate of MESH fails, and report it");
  add_redelaunay_option(*app, arguments->redelaunay);
  add_domain_options(*app, arguments->domain,
                     "The domain that MESH was made of; else what its boundary tells.\nMesh and domain may differ by "
                     "--merge-distance");
  add_size_options(*app, arguments->wishes);
  add_packing_options(*app, arguments->wishes.packing);
  add_common_options(*app, common);
  app->footer(
      "The spacing of MESH is its first vertex attribute, or else half the distance to the nearest vertex.\n"
      "Example: voropack refine part.node -o fine.node --levels 1\n"
      "         voropack refine part.vtu -o near-well.vtu --ball 0.5,0.5,0.1=0.01");
  return {app, [arguments](Session& session) { return run_refine(*arguments, session); }};
}

}  // namespace voropack::app
