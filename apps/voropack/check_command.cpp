// voropack check: the certificate of any mesh file, also one that another program wrote.
#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include "command.h"
#include "known_domain.h"
#include "print.h"
#include "voropack/certificate.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct CheckArguments {
  fs::path mesh;
  bool redelaunay = false;
  KnownDomain domain;
  CertificateOptions claims;
};

Json options_json(const CheckArguments& arguments) {
  Json json = Json::object();
  json["redelaunay"] = arguments.redelaunay;
  describe_known_domain(arguments.domain, json);
  if (arguments.claims.gradation) json["gradation"] = *arguments.claims.gradation;
  json["packing"] = name_of(kFormNames, arguments.claims.form);
  if (arguments.claims.form != PackingForm::kVoronoi) json["epsilon"] = arguments.claims.epsilon;
  return json;
}

template <int D>
ExitCode check_mesh(const Mesh<D>& mesh, const CheckArguments& arguments, StageTimes times, Session& session) {
  Observer& observer = session.observer;
  std::optional<Domain<D>> domain;
  if (arguments.domain.file) timed(times, "read", [&] { domain = read_known_domain<D>(arguments.domain, observer); });

  Report report;
  report.command = "check";
  report.options = options_json(arguments);
  report.input = describe_file(arguments.mesh, D);
  if (domain) report.domain = describe_domain(*arguments.domain.file, *domain);

  const ControlVolumes<D> volumes = timed(times, "dual", [&] { return build_control_volumes(mesh, observer); });
  report.quality = timed(times, "quality", [&] { return measure_quality(mesh, volumes, observer); });
  report.certificate = timed(times, "certificate", [&] {
    return certify(mesh, volumes, domain ? &*domain : nullptr, arguments.claims, observer);
  });
  report.input.regions = report.quality->regions.size();
  report.times = times;
  session.finish(report, certificate_table(*report.certificate));
  return report.certificate->ok ? ExitCode::kDone : ExitCode::kCheckFailed;
}

/// Faults of a file that can be read but whose simplices are no mesh. To `check` that is a verdict; to any other
/// command it is a bad input.
bool is_contradiction(const Fault& fault) {
  constexpr std::array<std::string_view, 5> kIds = {
      "mesh.flat_simplex", "mesh.nonmanifold", "mesh.overlapping_simplices", "io.duplicate_face", "io.duplicate_edge"};
  return std::find(kIds.begin(), kIds.end(), fault.id) != kIds.end();
}

/// The verdict on a mesh that contradicts itself: conformity fails, and nothing else can be tested.
ExitCode reject(const InputError& error, const CheckArguments& arguments, const StageTimes& times, Session& session) {
  Certificate certificate;
  certificate.ok = false;
  certificate.checks = {{.name = "conformity",
                         .ok = false,
                         .tested = error.faults().size(),
                         .violations = error.faults().size(),
                         .worst = {},
                         .where = error.faults().front().message}};
  Report report;
  report.command = "check";
  report.options = options_json(arguments);
  report.input = describe_file(arguments.mesh, std::nullopt);
  report.certificate = certificate;
  report.times = times;
  session.observer.log(LogLevel::kWarning, error.what());
  session.finish(report, certificate_table(certificate));
  return ExitCode::kCheckFailed;
}

ExitCode run_check(const CheckArguments& arguments, Session& session) {
  session.outputs.protect(arguments.mesh);
  for (const std::filesystem::path& file : arguments.domain.files()) session.outputs.protect(file);
  session.observer.begin_stage("read");
  StageTimes times;
  AnyMesh mesh;
  try {
    mesh = timed(times, "read",
                 [&] { return read_mesh_or_triangulate(arguments.mesh, arguments.redelaunay, session.observer); });
  } catch (const InputError& error) {
    if (!is_contradiction(error.faults().front())) throw;
    return reject(error, arguments, times, session);
  }
  return std::visit([&](const auto& any) { return check_mesh(any, arguments, times, session); }, mesh);
}

}  // namespace

Command add_check_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("check", "Check any mesh file, also one that another program wrote");
  const auto arguments = std::make_shared<CheckArguments>();
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele and, where present, .face, .edge) or .vtu")
      ->required();
  add_domain_options(*app, arguments->domain, "Compare with this domain: conformity and volumes");
  add_redelaunay_option(*app, arguments->redelaunay);
  add_gradation_option(*app, arguments->claims.gradation);
  add_form_options(*app, arguments->claims.form, arguments->claims.epsilon);
  add_common_options(*app, common);
  app->footer(
      "A check whose data the file lacks is not tested and does not fail. Exit code 1: a check failed.\n"
      "Example: voropack check part.node --domain part.poly");
  return {app, [arguments](Session& session) { return run_check(*arguments, session); }};
}

}  // namespace voropack::app
