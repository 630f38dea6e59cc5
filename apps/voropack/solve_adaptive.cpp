#include "solve_adaptive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <string_view>
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

/// `mesh` is one of the domain that shall be meshed.
template <int D>
Guide<D> read_guide(const std::string& field, const Mesh<D>& mesh, Observer& observer) {
  const auto [file, array] = split_field(field);
  AnyMesh any = read_mesh(file, observer);
  Mesh<D>* const from = std::get_if<Mesh<D>>(&any);
  if (from == nullptr)
    throw InputError(Fault{.id = "adapt.dimension",
                           .message = fmt::format("the field's mesh is not {}D, as the case is", D),
                           .fix = "give a field on a mesh of the same domain.",
                           .file = file.string()});
  VertexValues values(read_point_array(file, array, observer));
  if (values.size() != from->points.size())
    throw InputError(Fault{.id = "adapt.wrong_length",
                           .message = fmt::format("the array \"{}\" has {} numbers for {} vertices", array,
                                                  values.size(), from->points.size()),
                           .fix = "give an array with one number for each vertex.",
                           .file = file.string()});
  for (const VertexId v : ids(values))
    if (!std::isfinite(values[v]))
      throw InputError(
          Fault{.id = "adapt.not_finite",
                .message = fmt::format("the array \"{}\" is {} at vertex {} (counted from 0), at ({})", array,
                                       values[v], v.value(), fmt::join(from->points[v].coord, ", ")),
                .fix = "give a field that is finite everywhere.",
                .file = file.string()});
  try {
    require_cover(*from, mesh);
  } catch (const InputError& error) {
    Fault fault = error.faults().front();
    fault.file = file.string();
    throw InputError(std::move(fault));
  }
  Guide<D> guide{.mesh = std::move(*from), .volumes = {}, .derivatives = {}};
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

/// How many vertices the next mesh shall have; nothing, and why in `figures.end`, if there shall be none.
std::optional<double> wish_next(const AdaptiveWishes& wishes, AdaptiveFigures& figures, int dimension) {
  const AdaptiveCycle& last = figures.cycles.back();
  const auto n = static_cast<double>(last.n_vertices);
  const auto stop = [&](AdaptiveEnd why) {
    figures.end = why;
    return std::nullopt;
  };
  if (last.is_trusted && last.estimate == 0) return stop(AdaptiveEnd::kNoError);
  if (wishes.tolerance && last.is_trusted && last.estimate <= *wishes.tolerance) return stop(AdaptiveEnd::kTolerance);
  if (wishes.max_vertices && n * kLeastGrowth > static_cast<double>(*wishes.max_vertices))
    return stop(AdaptiveEnd::kMaxVertices);
  if (static_cast<int>(figures.cycles.size()) > wishes.max_cycles) return stop(AdaptiveEnd::kMaxCycles);
  // Errors fall at least like h, on lattices up to like h^2.
  double wanted = wishes.growth * n;
  if (wishes.tolerance && last.is_trusted)
    wanted = std::min(wanted, n * std::pow(last.estimate / (kAim * *wishes.tolerance), 0.5 * dimension) * kLeastGrowth);
  if (wishes.max_vertices) wanted = std::min(wanted, static_cast<double>(*wishes.max_vertices));
  return std::max(wanted, kLeastGrowth * n);
}

/// A mesh with what is to be reported of it.
template <int D>
struct NextMesh {
  Mesh<D> mesh;
  ControlVolumes<D> volumes{};
  QualityReport quality{};
  Certificate certificate{};
  PackingFigures packing{};
  std::optional<std::uint64_t> n_kept{};
};

/// Makes the meshes.
template <int D>
class Mesher {
 public:
  /// `mesh` is the first one of the domain.
  Mesher(const Domain<D>& domain, const Mesh<D>& mesh, const AdaptiveWishes& wishes, const Case& given,
         Session& session)
      : domain_(domain),
        wishes_(wishes),
        options_(meshing_options<D>(given.wishes, session)),
        observer_(session.observer) {
    if (!wishes.field.empty()) guide_ = read_guide<D>(wishes.field, mesh, observer_);
  }

  /// The next mesh; nothing if there is none with more vertices that are not too many. `derivatives` are those of the
  /// solution on the mesh of the setting. A mesh for a field of the user's may be of any size.
  std::optional<NextMesh<D>> operator()(const Setting<D>& setting, const RecoveredDerivatives<D>& derivatives,
                                        TargetOptions target, StageTimes& times) const {
    StageClock clock(observer_, times);
    std::optional<Made> best;
    const double wanted = target.n_vertices;
    double work = 0;
    for (int trial = 0; trial < kMostTrials && work <= kMostWork * std::max(wanted, kSmallMesh); ++trial) {
      Made made = make(setting, derivatives, target, clock);
      const auto n = static_cast<double>(made.mesh.points.size());
      work += n;
      const bool fits = !wishes_.max_vertices || n <= static_cast<double>(*wishes_.max_vertices);
      if (fits && (!best || n > static_cast<double>(best->mesh.points.size()))) best = std::move(made);
      if (fits && n >= kLeastCount * wanted) break;
      target.n_vertices *= 0.95 * wanted / n;
    }
    if (!best || (!guide_ && best->mesh.points.size() <= setting.mesh.points.size())) return std::nullopt;
    NextMesh<D> next{.mesh = std::move(best->mesh), .n_kept = best->n_kept};
    clock.begin_stage("dual");
    next.volumes = build_control_volumes(next.mesh, clock);
    clock.begin_stage("quality");
    next.quality = measure_quality(next.mesh, next.volumes, clock);
    clock.begin_stage("certificate");
    next.certificate =
        certify(next.mesh, next.volumes, &domain_, packing_claims(best->spacing, options_.packing), clock);
    next.packing.repairs = best->n_repairs;
    return next;
  }

 private:
  struct Made {
    Mesh<D> mesh;
    Spacing<D> spacing;  ///< With the caps of repairs.
    std::size_t n_repairs;
    std::optional<std::uint64_t> n_kept;
  };

  Spacing<D> next_spacing(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                          const RecoveredDerivatives<D>& derivatives, TargetOptions target, Observer& observer) const {
    observer.begin_stage("spacing");
    if (keeps_all()) target.largest_factor = 1;
    const SpacingOptions options{options_.gradation, options_.feature_factor, edge_per_spacing<D>(options_.packing)};
    if (!guide_)
      return adapted_spacing(mesh, domain_, volumes, derivatives, target, options_.wishes, options, options_.packing,
                             observer);
    // The field's mesh may be much finer or coarser than what is wanted.
    target.least_factor = 1e-3;
    target.largest_factor = 1e3;
    return adapted_spacing(guide_->mesh, domain_, guide_->volumes, guide_->derivatives, target, options_.wishes,
                           options, options_.packing, observer);
  }

  Made make(const Setting<D>& setting, const RecoveredDerivatives<D>& derivatives, const TargetOptions& target,
            Observer& observer) const {
    Spacing<D> spacing = next_spacing(setting.mesh, setting.volumes, derivatives, target, observer);
    const auto with_caps = [&](const std::vector<SpacingCap<D>>& caps) {
      return caps.empty() ? spacing : spacing.with_caps(caps);
    };
    observer.begin_stage("packing");
    if (wishes_.keep == AdaptiveWishes::Keep::kNone) {
      Packing<D> packing = pack(domain_, spacing, options_.packing, observer);
      Spacing<D> capped = with_caps(packing.repairs);
      const std::size_t n_repairs = packing.repairs.size();
      observer.begin_stage("delaunay");
      return {triangulate(domain_, std::move(packing), observer), std::move(capped), n_repairs, {}};
    }
    RefinedMesh<D> refined = refine(setting.mesh, place_in_domain(setting.mesh, domain_, 0, observer), spacing,
                                    {.packing = options_.packing, .keep_all = keeps_all()}, observer);
    return {std::move(refined.mesh), with_caps(refined.repairs), refined.repairs.size(), refined.n_kept};
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

std::optional<fs::path> AdaptiveWishes::field_file() const {
  if (field.empty()) return std::nullopt;
  return split_field(field).first;
}

LimitError in_words_of_case(const LimitError& error) {
  constexpr std::string_view kOption = "--max-vertices";
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults)
    if (const std::size_t at = fault.fix.find(kOption); at != std::string::npos)
      fault.fix.replace(at, kOption.size(), "max_vertices under [domain]");
  return LimitError(std::move(faults));
}

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
  command.add_option("--growth", wishes.growth, "Vertices over those of the mesh before, about at most; default 2.5")
      ->check(CLI::Range(1.2, 10.0))
      ->needs(adapt);
  using Keep = AdaptiveWishes::Keep;
  static const std::map<std::string, Keep> kKinds = {
      {"none", Keep::kNone}, {"fitting", Keep::kFitting}, {"all", Keep::kAll}};
  command
      .add_option_function<std::string>(
          "--keep", [&keep = wishes.keep](const std::string& name) { keep = kKinds.at(name); },
          "Old vertices that stay: none, those that fit (fitting), or all; default none")
      ->check(one_of({"none", "fitting", "all"}))
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
           "leave out [time]: adapt a stationary case, to a state with --adapt-field; then go on in time on the mesh "
           "that is written, from initial = { array, file, transfer }.");
  if (given.method == CaseMethod::kFiniteElements)
    refuse("cli.contradiction", "--adapt is given, and the method is \"fem\": errors are estimated for control volumes",
           "set method = \"cvm\".");
  if (!given.levels.empty())
    refuse("cli.contradiction", "--adapt is given, and linear.levels belong to a mesh that will be replaced",
           "leave out linear.levels.");
  std::vector<const CaseCoefficient*> coefficients = {&given.conductivity, &given.reaction, &given.source,
                                                      &given.capacity};
  if (given.newton_initial) coefficients.push_back(&*given.newton_initial);
  const auto is_bound = [](const CaseCoefficient& coefficient) {
    const auto* array = std::get_if<CaseArray>(&coefficient.value);
    return array != nullptr && array->transfer == CaseArray::Transfer::kNone;
  };
  for (const CaseCoefficient* coefficient : coefficients)
    if (is_bound(*coefficient))
      refuse("cli.contradiction",
             fmt::format("--adapt is given, and {} is an array on a mesh that will be replaced", coefficient->name),
             "give a number or a formula, or add transfer = \"interpolate\" to the array.");
  if (!wishes.field.empty()) {
    split_field(wishes.field);
    if (wishes.keep != AdaptiveWishes::Keep::kNone)
      refuse("cli.contradiction", "--keep and --adapt-field are given: a mesh for a field is made anew",
             "leave out one of them.");
    if (!wishes.max_vertices)
      refuse("cli.missing", "--adapt-field says where vertices are wanted, but not how many", "add --max-vertices.");
  }
}

namespace {

struct EndDescription {
  const char* name;  ///< In the report.
  const char* words;
  ExitCode code = ExitCode::kDone;
};

EndDescription description(AdaptiveEnd end) {
  switch (end) {
    case AdaptiveEnd::kTolerance:
      return {"tolerance", "the tolerance is met"};
    case AdaptiveEnd::kNoError:
      return {"no_error", "no more: nothing is left to be estimated"};
    case AdaptiveEnd::kMaxVertices:
      return {"max_vertices", "no more: --max-vertices"};
    case AdaptiveEnd::kMaxCycles:
      return {"max_cycles", "no more: --cycles"};
    case AdaptiveEnd::kNoFinerMesh:
      return {"no_finer_mesh", "no more: no mesh would be finer"};
    case AdaptiveEnd::kField:
      return {"field", "the mesh follows the field"};
    case AdaptiveEnd::kNoMeshForField:
      return {"no_mesh_for_field", "no mesh follows the field with so few vertices", ExitCode::kLimit};
    case AdaptiveEnd::kNotCertified:
      return {"not_certified", "no more: the next mesh is not certified", ExitCode::kCheckFailed};
    case AdaptiveEnd::kLimit:
      return {"limit", "no more: a limit", ExitCode::kLimit};
    case AdaptiveEnd::kNotConverged:
      return {"not_converged", "no more: no convergence", ExitCode::kNotConverged};
  }
  return {};
}

std::string end_in_words(const AdaptiveFigures& figures) {
  return figures.reason.empty() ? description(figures.end).words : "no more: " + figures.reason;
}

/// Three decimals, as long as they fit the column.
std::string effectivity_text(double effectivity) {
  return effectivity < 1e4 ? fmt::format("{:.3f}", effectivity) : fmt::format("{:.4g}", effectivity);
}

}  // namespace

std::vector<std::string> left_out_of_estimate(const Case& given) {
  std::vector<std::string> parts;
  for (const CaseCoefficient* coefficient : {&given.conductivity, &given.reaction, &given.source})
    if (std::holds_alternative<CaseArray>(coefficient->value))
      parts.push_back(fmt::format("{} between the vertices of its array", coefficient->name));
  return parts;
}

std::string adaptive_table(const AdaptiveFigures& figures) {
  const bool is_known = figures.cycles.back().error.has_value();
  std::string text =
      fmt::format("{:<6}{:>12}{:>14}{:>12}{:>12}", "cycle", "vertices", "est. error W", "smooth", "rough");
  if (is_known) text += fmt::format("{:>14}{:>13}", "true error W", "effectivity");
  text += fmt::format("{:>10}\n", "seconds");
  for (std::size_t k = 0; k < figures.cycles.size(); ++k) {
    const AdaptiveCycle& c = figures.cycles[k];
    text +=
        fmt::format("{:<6}{:>12}{:>14.4g}{:>12.4g}{:>12.4g}", k, grouped(c.n_vertices), c.estimate, c.smooth, c.rough);
    if (is_known)
      text += fmt::format("{:>14.4g}{:>13}", *c.error,
                          *c.error > 0 ? effectivity_text(c.estimate / *c.error) : std::string("-"));
    text += fmt::format("{:>10.3g}\n", c.seconds);
  }
  text += end_in_words(figures) + '\n';
  if (!figures.not_estimated.empty())
    text += fmt::format("not in the estimate: {}\n", fmt::join(figures.not_estimated, ", "));
  return text;
}

Json options_json(const AdaptiveWishes& wishes) {
  Json json;
  if (wishes.tolerance) json["tolerance"] = *wishes.tolerance;
  if (wishes.max_vertices) json["max_vertices"] = *wishes.max_vertices;
  json["cycles"] = wishes.max_cycles;
  json["growth"] = wishes.growth;
  constexpr std::array<const char*, 3> kKeep = {"none", "fitting", "all"};
  json["keep"] = kKeep[static_cast<std::size_t>(wishes.keep)];
  if (!wishes.field.empty()) json["field"] = wishes.field;
  return json;
}

Json adaptive_json(const AdaptiveFigures& figures) {
  Json json;
  json["end"] = description(figures.end).name;
  if (!figures.reason.empty()) json["reason"] = figures.reason;
  if (!figures.not_estimated.empty()) json["not_estimated"] = figures.not_estimated;
  json["cycles"] = Json::array();
  for (const AdaptiveCycle& c : figures.cycles) {
    Json row{{"vertices", c.n_vertices},
             {"estimate", c.estimate},
             {"smooth", c.smooth},
             {"rough", c.rough},
             {"truncation", c.truncation}};
    if (c.error) {
      row["error"] = *c.error;
      if (*c.error > 0) row["effectivity"] = c.estimate / *c.error;
    }
    if (c.n_kept) row["kept"] = *c.n_kept;
    if (c.is_certified) row["certified"] = *c.is_certified;
    row["seconds"] = c.seconds;
    json["cycles"].push_back(std::move(row));
  }
  return json;
}

ExitCode adaptive_exit_code(const AdaptiveFigures& figures, const AdaptiveWishes& wishes) {
  const ExitCode code = description(figures.end).code;
  const bool is_met = figures.end == AdaptiveEnd::kTolerance || figures.end == AdaptiveEnd::kNoError;
  return code == ExitCode::kDone && wishes.tolerance && !is_met ? ExitCode::kNotConverged : code;
}

namespace {

/// Solves on the mesh of the setting, and estimates the error.
template <int D>
Solved<D> solve_cycle(Setting<D>& setting, RecoveredDerivatives<D>& derivatives, AdaptiveCycle& cycle, Report& report,
                      Session& session) {
  const auto start = std::chrono::steady_clock::now();
  StageClock clock(session.observer, report.times);
  prepare(setting, clock);
  Solved<D> solved = solve_case<D>(setting, {}, clock);
  derivatives = recover_derivatives(setting.volumes, solved.arrays.u, clock);
  const ErrorEstimate estimate =
      estimate_error(setting.mesh, setting.volumes, setting.boundary, stationary_problem(setting), solved.arrays.u,
                     derivatives, setting.given.newton.linear, clock);
  cycle.n_vertices = setting.mesh.points.size();
  cycle.estimate = estimate.w;
  cycle.smooth = estimate.smooth;
  cycle.rough = estimate.rough;
  cycle.truncation = estimate.truncation;
  cycle.is_trusted = is_trusted(setting.mesh);
  if (solved.figures.errors) cycle.error = solved.figures.errors->w;
  cycle.seconds += seconds_since(start);
  return solved;
}

/// Gives the setting another mesh.
template <int D>
void adopt(NextMesh<D>& next, Setting<D>& setting, Report& report) {
  std::swap(setting.mesh, next.mesh);
  std::swap(setting.volumes, next.volumes);
  report.quality = next.quality;
  report.certificate = next.certificate;
  report.packing = next.packing;
  report.costliest_features.reset();
}

}  // namespace

template <int D>
Solved<D> solve_adaptively(Setting<D>& setting, const Domain<D>& domain, const AdaptiveWishes& wishes,
                           const std::function<void(std::size_t cycle, const SolutionArrays<D>&)>& on_cycle,
                           AdaptiveFigures& figures, Report& report, Session& session) {
  const bool follows_field = !wishes.field.empty();
  if (wishes.max_vertices && !follows_field && setting.mesh.points.size() > *wishes.max_vertices)
    throw LimitError(Fault{.id = "adapt.too_many_vertices",
                           .message = fmt::format("the first mesh has {} vertices, more than --max-vertices {}",
                                                  setting.mesh.points.size(), *wishes.max_vertices),
                           .fix = "allow more, or begin with a larger size.",
                           .file = setting.given.file.string()});
  figures.not_estimated = left_out_of_estimate(setting.given);
  const Mesher<D> make_next(domain, setting.mesh, wishes, setting.given, session);
  RecoveredDerivatives<D> derivatives;
  AdaptiveCycle first;
  if (report.certificate) first.is_certified = report.certificate->ok;
  Solved<D> solved = solve_cycle(setting, derivatives, first, report, session);
  figures.cycles.push_back(first);
  on_cycle(0, solved.arrays);
  for (;;) {
    std::optional<double> wanted;
    if (!follows_field)
      wanted = wish_next(wishes, figures, D);
    else if (figures.cycles.size() == 1)
      wanted = static_cast<double>(*wishes.max_vertices);
    else
      figures.end = AdaptiveEnd::kField;
    if (!wanted) return solved;
    // What cannot be made or solved leaves what was there before.
    try {
      const auto start = std::chrono::steady_clock::now();
      std::optional<NextMesh<D>> next =
          make_next(setting, derivatives, {.n_vertices = *wanted, .is_resolved = figures.cycles.back().is_resolved()},
                    report.times);
      if (!next || !next->certificate.ok) {
        figures.end = next                  ? AdaptiveEnd::kNotCertified
                      : follows_field       ? AdaptiveEnd::kNoMeshForField
                      : wishes.max_vertices ? AdaptiveEnd::kMaxVertices
                                            : AdaptiveEnd::kNoFinerMesh;
        return solved;
      }
      AdaptiveCycle cycle{.n_kept = next->n_kept, .is_certified = true, .seconds = seconds_since(start)};
      Report before = report;
      adopt(*next, setting, report);
      try {
        solved = solve_cycle(setting, derivatives, cycle, report, session);
      } catch (const NumericalError&) {
        std::swap(setting.mesh, next->mesh);
        std::swap(setting.volumes, next->volumes);
        report = std::move(before);
        prepare(setting, session.observer);
        throw;
      }
      figures.cycles.push_back(cycle);
      on_cycle(figures.cycles.size() - 1, solved.arrays);
    } catch (const LimitError& error) {
      figures.end = AdaptiveEnd::kLimit;
      figures.reason = in_words_of_case(error).what();
      return solved;
    } catch (const NumericalError& error) {
      figures.end = AdaptiveEnd::kNotConverged;
      figures.reason = error.what();
      return solved;
    }
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
