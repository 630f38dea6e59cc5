#include "solve_adaptive.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "print.h"
#include "stage_clock.h"
#include "voropack/delaunay.h"
#include "voropack/error.h"
#include "voropack/refinement.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

/// Of the tolerance, what the next mesh aims at: estimates scatter.
constexpr double kAim = 0.9;
/// A last mesh that has not this many times the vertices is not worth making.
constexpr double kLeastGrowth = 1.15;
/// A mesh that has more vertices than allowed, or fewer than this part of the wanted ones, is made again, while all
/// trials together have not so many times the wanted ones; small meshes cost nothing.
constexpr double kLeastCount = 0.8;
constexpr double kMostWork = 2.5;
constexpr double kSmallMesh = 1000;
constexpr int kMostTrials = 20;

[[noreturn]] void refuse(std::string id, std::string message, std::string fix) {
  throw OptionError(Fault{.id = std::move(id), .message = std::move(message), .fix = std::move(fix)});
}

/// FILE:array, where FILE may have colons of its own.
std::pair<fs::path, std::string> split_field(const std::string& field) {
  const std::size_t colon = field.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == field.size())
    refuse("cli.bad_field", fmt::format("--adapt-field {} is not FILE:array", field),
           "name a .vtu file and one of its point arrays, as in --adapt-field old.vtu:u");
  return {field.substr(0, colon), field.substr(colon + 1)};
}

/// A vertex field that sizes follow, with its derivatives.
template <int D>
struct Guide {
  Mesh<D> mesh;
  ControlVolumes<D> volumes;
  RecoveredDerivatives<D> derivatives;
};

template <int D>
Guide<D> read_guide(const std::string& field, Observer& observer) {
  const auto [file, array] = split_field(field);
  AnyMesh any = read_mesh(file, observer);
  Mesh<D>* const mesh = std::get_if<Mesh<D>>(&any);
  if (mesh == nullptr)
    throw InputError(Fault{.id = "adapt.dimension",
                           .message = fmt::format("the field's mesh is not {}D, as the case is", D),
                           .fix = "give a field on a mesh of the same domain.",
                           .file = file.string()});
  VertexValues values(read_point_array(file, array, observer));
  if (values.size() != mesh->points.size())
    throw InputError(Fault{.id = "adapt.wrong_length",
                           .message = fmt::format("the array \"{}\" has {} numbers for {} vertices", array,
                                                  values.size(), mesh->points.size()),
                           .fix = "give an array with one number for each vertex.",
                           .file = file.string()});
  Guide<D> guide{.mesh = std::move(*mesh), .volumes = {}, .derivatives = {}};
  guide.volumes = build_control_volumes(guide.mesh, observer);
  guide.derivatives = recover_derivatives(guide.volumes, values, observer);
  return guide;
}

/// Estimates of meshes with fewer vertices inside say nothing: the W norm sees none of the edges on the boundary.
constexpr std::size_t kLeastInside = 10;

template <int D>
bool is_trusted(const Mesh<D>& mesh) {
  const VertexFlags on_hull = find_hull_vertices(mesh);
  return mesh.points.size() - static_cast<std::size_t>(std::ranges::count(on_hull, true)) >= kLeastInside;
}

/// How many vertices the next mesh shall have; nothing if there shall be none.
std::optional<double> next_count(const AdaptiveWishes& wishes, AdaptiveFigures& figures, int dimension) {
  const AdaptiveCycle& last = figures.cycles.back();
  const auto n = static_cast<double>(last.n_vertices);
  const auto stop = [&](const char* why) {
    figures.end = why;
    return std::nullopt;
  };
  if (!last.is_certified) return stop("not_certified");
  if (last.is_trusted && last.estimate.w == 0) return stop("no_error");
  if (wishes.tolerance && last.is_trusted && last.estimate.w <= *wishes.tolerance) return stop("tolerance");
  if (wishes.max_vertices && n * kLeastGrowth > static_cast<double>(*wishes.max_vertices)) return stop("max_vertices");
  if (static_cast<int>(figures.cycles.size()) > wishes.max_cycles) return stop("max_cycles");
  // Errors fall at least like h, on lattices up to like h^2.
  double wanted = wishes.growth * n;
  if (wishes.tolerance && last.is_trusted)
    wanted =
        std::min(wanted, n * std::pow(last.estimate.w / (kAim * *wishes.tolerance), 0.5 * dimension) * kLeastGrowth);
  if (wishes.max_vertices) wanted = std::min(wanted, static_cast<double>(*wishes.max_vertices));
  return std::max(wanted, kLeastGrowth * n);
}

/// Makes the meshes.
template <int D>
class Mesher {
 public:
  Mesher(const Domain<D>& domain, const AdaptiveWishes& wishes, const Case& given, Session& session)
      : domain_(domain),
        wishes_(wishes),
        options_(meshing_options<D>(given.wishes, session)),
        observer_(session.observer) {
    if (!wishes.field.empty()) guide_ = read_guide<D>(wishes.field, observer_);
  }

  /// Replaces the mesh of the setting; false if there is none with more vertices that are not too many. `derivatives`
  /// are those of its solution.
  bool operator()(const RecoveredDerivatives<D>& derivatives, double wanted, Setting<D>& setting, AdaptiveCycle& cycle,
                  Report& report) const {
    StageClock clock(observer_, report.times);
    std::optional<Made> best;
    double aim = wanted, work = 0;
    for (int trial = 0; trial < kMostTrials && work <= kMostWork * std::max(wanted, kSmallMesh); ++trial) {
      Made made = make(setting, derivatives, aim, clock);
      const auto n = static_cast<double>(made.mesh.points.size());
      work += n;
      const bool fits = !wishes_.max_vertices || n <= static_cast<double>(*wishes_.max_vertices);
      if (fits && (!best || n > static_cast<double>(best->mesh.points.size()))) best = std::move(made);
      if (fits && n >= kLeastCount * wanted) break;
      aim *= 0.95 * wanted / n;
    }
    if (!best || best->mesh.points.size() <= setting.mesh.points.size()) return false;
    setting.mesh = std::move(best->mesh);
    cycle.n_kept = best->n_kept;
    cycle.n_vertices = setting.mesh.points.size();
    clock.begin_stage("dual");
    setting.volumes = build_control_volumes(setting.mesh, clock);
    clock.begin_stage("quality");
    report.quality = measure_quality(setting.mesh, setting.volumes, clock);
    clock.begin_stage("certificate");
    report.certificate =
        certify(setting.mesh, setting.volumes, &domain_, packing_claims(best->spacing, options_.packing), clock);
    cycle.is_certified = report.certificate->ok;
    return true;
  }

 private:
  struct Made {
    Mesh<D> mesh;
    Spacing<D> spacing;  ///< With the caps of repairs.
    std::optional<std::uint64_t> n_kept;
  };

  Spacing<D> next_spacing(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                          const RecoveredDerivatives<D>& derivatives, double wanted, Observer& observer) const {
    observer.begin_stage("spacing");
    TargetOptions target{.n_vertices = wanted};
    if (keeps_all()) target.largest_factor = 1;
    const SpacingOptions options{options_.gradation, options_.feature_factor, edge_per_spacing<D>(options_.packing)};
    if (!guide_)
      return adapted_spacing(mesh, domain_, volumes, derivatives, target, options_.wishes, options, options_.packing,
                             observer);
    // The field's mesh may be much finer or coarser than what is wanted.
    target.least_factor = 1e-3;
    if (!keeps_all()) target.largest_factor = 1e3;
    return adapted_spacing(guide_->mesh, domain_, guide_->volumes, guide_->derivatives, target, options_.wishes,
                           options, options_.packing, observer);
  }

  Made make(const Setting<D>& setting, const RecoveredDerivatives<D>& derivatives, double wanted,
            Observer& observer) const {
    Spacing<D> spacing = next_spacing(setting.mesh, setting.volumes, derivatives, wanted, observer);
    const auto with_caps = [&](const std::vector<SpacingCap<D>>& caps) {
      return caps.empty() ? spacing : spacing.with_caps(caps);
    };
    observer.begin_stage("packing");
    if (wishes_.keep == AdaptiveWishes::Keep::kNone) {
      Packing<D> packing = pack(domain_, spacing, options_.packing, observer);
      Spacing<D> capped = with_caps(packing.repairs);
      observer.begin_stage("delaunay");
      return {triangulate(domain_, std::move(packing), observer), std::move(capped), {}};
    }
    RefinedMesh<D> refined = refine(setting.mesh, domain_of(setting.mesh, observer), spacing,
                                    {.packing = options_.packing, .keep_all = keeps_all()}, observer);
    return {std::move(refined.mesh), with_caps(refined.repairs), refined.n_kept};
  }

  [[nodiscard]] bool keeps_all() const { return wishes_.keep == AdaptiveWishes::Keep::kAll; }

  const Domain<D>& domain_;
  const AdaptiveWishes& wishes_;
  MeshingOptions<D> options_;
  Observer& observer_;
  std::optional<Guide<D>> guide_;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

void add_adaptive_options(CLI::App& command, AdaptiveWishes& wishes) {
  CLI::Option* const adapt =
      command.add_flag("--adapt", wishes.is_wished, "Solve, estimate the error, mesh again where it is large; repeat");
  command.add_option("--tolerance", wishes.tolerance, "Enough when the estimated error in the W norm is at most this")
      ->check(positive_number())
      ->needs(adapt);
  command
      .add_option("--max-vertices", wishes.max_vertices, "Enough when a mesh has about as many vertices; never more")
      ->check(whole_number(1))
      ->needs(adapt);
  command.add_option("--cycles", wishes.max_cycles, "Enough after so many meshes beside the first; default 8")
      ->check(whole_number(1, 1000))
      ->needs(adapt);
  command.add_option("--growth", wishes.growth, "Vertices over those of the mesh before, at most; default 2.5")
      ->check(CLI::Range(1.2, 10.0))
      ->needs(adapt);
  using Keep = AdaptiveWishes::Keep;
  const std::vector<std::pair<std::string, Keep>> kinds = {
      {"none", Keep::kNone}, {"fitting", Keep::kFitting}, {"all", Keep::kAll}};
  command.add_option("--keep", wishes.keep, "Old vertices that stay: none, those that fit, or all; default none")
      ->transform(CLI::CheckedTransformer(kinds))
      ->type_name("KIND")
      ->needs(adapt);
  command
      .add_option("--adapt-field", wishes.field,
                  "Mesh once, where this point array of a .vtu file bends, not where the solution does")
      ->type_name("FILE:ARRAY")
      ->needs(adapt);
}

void check_adaptive(const AdaptiveWishes& wishes, const Case& given) {
  if (!wishes.is_wished) return;
  if (given.time)
    refuse("cli.contradiction", "--adapt is given, and the case is one in time",
           "leave out [time], or adapt the mesh to an earlier solution with --adapt-field on a stationary case.");
  if (given.method == CaseMethod::kFiniteElements)
    refuse("cli.contradiction", "--adapt is given, and the method is \"fem\": errors are estimated for control volumes",
           "set method = \"cvm\".");
  std::vector<const CaseCoefficient*> coefficients = {&given.conductivity, &given.reaction, &given.source};
  if (given.newton_initial) coefficients.push_back(&*given.newton_initial);
  for (const CaseCoefficient* coefficient : coefficients)
    if (std::holds_alternative<CaseArray>(coefficient->value))
      refuse("cli.contradiction",
             fmt::format("--adapt is given, and {} is an array on a mesh that will be replaced", coefficient->name),
             "give a number, a formula, or one of them for each region.");
  if (!wishes.field.empty()) {
    split_field(wishes.field);
    if (!wishes.max_vertices)
      refuse("cli.missing", "--adapt-field says where vertices are wanted, but not how many", "add --max-vertices.");
  }
}

std::string adaptive_table(const AdaptiveFigures& figures) {
  const bool is_known = figures.cycles.back().error.has_value();
  std::string text =
      fmt::format("{:<6}{:>12}{:>14}{:>12}{:>12}", "cycle", "vertices", "est. error W", "smooth", "rough");
  if (is_known) text += fmt::format("{:>14}{:>13}", "true error W", "effectivity");
  text += fmt::format("{:>10}\n", "seconds");
  for (std::size_t k = 0; k < figures.cycles.size(); ++k) {
    const AdaptiveCycle& c = figures.cycles[k];
    text += fmt::format("{:<6}{:>12}{:>14.4g}{:>12.4g}{:>12.4g}", k, grouped(c.n_vertices), c.estimate.w,
                        c.estimate.smooth, c.estimate.rough);
    if (is_known) text += fmt::format("{:>14.4g}{:>13.3f}", *c.error, c.estimate.w / *c.error);
    text += fmt::format("{:>10.3g}\n", c.seconds);
  }
  if (figures.end == "tolerance") return text + "the tolerance is met\n";
  if (figures.end == "no_error") return text + "no more: nothing is left to be estimated\n";
  if (figures.end == "max_vertices") return text + "no more: --max-vertices\n";
  if (figures.end == "max_cycles") return text + "no more: --cycles\n";
  if (figures.end == "no_finer_mesh") return text + "no more: no mesh would be finer\n";
  return text + "no more: the last mesh is not certified\n";
}

Json adaptive_json(const AdaptiveWishes& wishes, const AdaptiveFigures& figures) {
  Json json;
  if (wishes.tolerance) json["tolerance"] = *wishes.tolerance;
  json["end"] = figures.end;
  json["cycles"] = Json::array();
  for (const AdaptiveCycle& c : figures.cycles) {
    Json row{{"vertices", c.n_vertices},
             {"estimate", c.estimate.w},
             {"smooth", c.estimate.smooth},
             {"rough", c.estimate.rough},
             {"truncation", c.estimate.truncation}};
    if (c.error) {
      row["error"] = *c.error;
      if (*c.error > 0) row["effectivity"] = c.estimate.w / *c.error;
    }
    if (c.n_kept) row["kept"] = *c.n_kept;
    row["certified"] = c.is_certified;
    row["seconds"] = c.seconds;
    json["cycles"].push_back(std::move(row));
  }
  return json;
}

template <int D>
Solved<D> solve_adaptively(Setting<D>& setting, const Domain<D>& domain, const AdaptiveWishes& wishes,
                           const std::function<void(std::size_t cycle, const SolutionArrays<D>&)>& on_cycle,
                           AdaptiveFigures& figures, Report& report, Session& session) {
  const Case& given = setting.given;
  const Mesher<D> make_next(domain, wishes, given, session);
  AdaptiveCycle cycle{.n_vertices = setting.mesh.points.size()};
  for (;;) {
    const auto start = std::chrono::steady_clock::now();
    Solved<D> solved = [&] {
      StageClock clock(session.observer, report.times);
      prepare(setting, clock);
      return solve_case<D>(setting, {}, clock);
    }();
    StageClock clock(session.observer, report.times);
    clock.begin_stage("recover");
    const RecoveredDerivatives<D> derivatives = recover_derivatives(setting.volumes, solved.arrays.u, clock);
    clock.begin_stage("estimate");
    cycle.estimate = estimate_error(setting.mesh, setting.volumes, setting.boundary, make_problem(setting.compiled, 0),
                                    solved.arrays.u, derivatives, given.newton.linear, clock);
    clock.stop();
    cycle.is_trusted = is_trusted(setting.mesh);
    cycle.estimate.error = {};
    cycle.estimate.defect = {};
    if (solved.figures.errors) cycle.error = solved.figures.errors->w;
    cycle.seconds += seconds_since(start);
    figures.cycles.push_back(cycle);
    on_cycle(figures.cycles.size() - 1, solved.arrays);

    std::optional<double> wanted = next_count(wishes, figures, D);
    if (wanted && !wishes.field.empty()) {
      wanted = static_cast<double>(*wishes.max_vertices);
      if (figures.cycles.size() > 1) figures.end = "max_vertices", wanted.reset();
    }
    if (!wanted) return solved;
    cycle = {};
    const auto begin = std::chrono::steady_clock::now();
    if (!make_next(derivatives, *wanted, setting, cycle, report)) {
      figures.end = wishes.max_vertices ? "max_vertices" : "no_finer_mesh";
      return solved;
    }
    cycle.seconds = seconds_since(begin);
  }
}

#define VOROPACK_INSTANTIATE(D)                                                                          \
  template Solved<D> solve_adaptively(Setting<D>&, const Domain<D>&, const AdaptiveWishes&,              \
                                      const std::function<void(std::size_t, const SolutionArrays<D>&)>&, \
                                      AdaptiveFigures&, Report&, Session&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack::app
