// voropack check: the certificate of any mesh file, also one that another program wrote.
#include <memory>

#include "command.h"
#include "print.h"
#include "voropack/certificate.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

struct CheckArguments {
  fs::path mesh;
  std::optional<fs::path> domain;
  CertificateOptions claims;
};

template <int D>
Domain<D> read_domain_of(const fs::path& path, Observer& observer) {
  const AnyDomainInput any = read_domain(path, observer);
  if (const auto* const input = std::get_if<DomainInput<D>>(&any)) return build_domain(*input, {}, observer);
  throw InputError(Fault{.id = "cli.dimension",
                         .message = "the mesh and the domain have different dimensions",
                         .fix = "give the domain that the mesh was made from.",
                         .file = path.string()});
}

Json options_json(const CheckArguments& arguments) {
  Json json = Json::object();
  if (arguments.domain) json["domain"] = arguments.domain->string();
  if (arguments.claims.gradation) json["gradation"] = *arguments.claims.gradation;
  json["packing"] = name_of(kFormNames, arguments.claims.form);
  if (arguments.claims.form != PackingForm::kVoronoi) json["epsilon"] = arguments.claims.epsilon;
  return json;
}

template <int D>
ExitCode check_mesh(const Mesh<D>& mesh, const CheckArguments& arguments, StageTimes times, Session& session) {
  Observer& observer = session.observer;
  std::optional<Domain<D>> domain;
  if (arguments.domain) timed(times, "read", [&] { domain = read_domain_of<D>(*arguments.domain, observer); });

  Report report;
  report.command = "check";
  report.options = options_json(arguments);
  report.input = describe_file(arguments.mesh, D);
  if (domain) report.domain = describe_domain(*arguments.domain, *domain);

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

ExitCode run_check(const CheckArguments& arguments, Session& session) {
  session.outputs.protect(arguments.mesh);
  session.observer.begin_stage("read");
  StageTimes times;
  const AnyMesh mesh = timed(times, "read", [&] { return read_mesh(arguments.mesh, session.observer); });
  return std::visit([&](const auto& any) { return check_mesh(any, arguments, times, session); }, mesh);
}

}  // namespace

Command add_check_command(CLI::App& root, CommonOptions& common) {
  CLI::App* const app = root.add_subcommand("check", "Check any mesh file, also one that another program wrote");
  const auto arguments = std::make_shared<CheckArguments>();
  app->add_option("MESH", arguments->mesh, "Mesh: .node (with .ele and, where present, .face, .edge) or .vtu")
      ->required();
  app->add_option("--domain", arguments->domain, "Compare with this domain: conformity and volumes")
      ->type_name("DOMAIN");
  add_gradation_option(*app, arguments->claims.gradation);
  add_form_options(*app, arguments->claims.form, arguments->claims.epsilon);
  add_common_options(*app, common);
  app->footer(
      "A check whose data the file lacks is not tested and does not fail. Exit code 1: a check failed.\n"
      "Example: voropack check part.node --domain part.poly");
  return {app, [arguments](Session& session) { return run_check(*arguments, session); }};
}

}  // namespace voropack::app
