#include "meshing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "voropack/error.h"

namespace voropack::app {

namespace fs = std::filesystem;

std::vector<fs::path> domain_files(const fs::path& domain) {
  std::vector<fs::path> files = {domain};
  if (domain.extension() != ".poly" && domain.extension() != ".smesh") return files;
  std::ifstream file(domain);
  std::string word;
  while (file >> word && word.front() == '#') std::getline(file, word);
  if (word == "0") files.push_back(fs::path(domain).replace_extension(".node"));
  return files;
}

namespace {

template <int D>
typename SizeWishes<D>::Field read_size_field(const fs::path& path, Observer& observer) {
  AnyMesh any = read_mesh(path, observer);
  auto* const mesh = std::get_if<Mesh<D>>(&any);
  const auto fault = [&](const std::string& message, const std::string& fix) {
    return InputError(Fault{.id = "cli.size_field", .message = message, .fix = fix, .file = path.string()});
  };
  if (mesh == nullptr)
    throw fault(fmt::format("this size field is {}D, the domain {}D", 5 - D, D), "give a mesh of the same dimension.");
  std::vector<double> size = mesh->vertex_spacing.raw();
  if (size.empty())
    throw fault("the vertices have no attribute", "give every vertex the wanted edge length as its first attribute.");
  for (std::size_t i = 0; i < size.size(); ++i)
    if (!(std::isfinite(size[i]) && size[i] > 0))
      throw fault(fmt::format("the wanted edge length of vertex {} (counted from 0) is {}", i, size[i]),
                  "give a positive number.");
  return {std::move(*mesh), std::move(size)};
}

/// The numbers that describe a place, so many as it takes.
std::vector<double> numbers_of(const SizedPlace& place, std::size_t n, const std::string& option,
                               const std::string& what) {
  const std::optional<std::vector<double>> numbers = number_list(place.place);
  if (numbers && numbers->size() == n) return *numbers;
  throw OptionError(Fault{.id = "cli.bad_place",
                          .message = fmt::format("{} has '{}' where {} numbers are wanted", option, place.place, n),
                          .fix = fmt::format("give {}, with commas in between.", what)});
}

template <int D>
Vec<D> point_at(const std::vector<double>& numbers, std::size_t first) {
  Vec<D> x;
  std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(first), D, x.coord.begin());
  return x;
}

template <int D>
std::vector<Vec<D>> read_line(const fs::path& path) {
  std::ifstream file(path);
  if (!file)
    throw InputError(Fault{.id = "cli.line_file",
                           .message = "the file cannot be opened",
                           .fix = "give a text file with the coordinates of one point in each line.",
                           .file = path.string()});
  std::vector<Vec<D>> points;
  std::uint64_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    line.erase(std::min(line.find('#'), line.size()));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<double> numbers;
    for (std::string word; words >> word;) {
      const auto parsed = number_list(word);
      numbers.push_back(parsed ? parsed->front() : std::numeric_limits<double>::quiet_NaN());
    }
    if (numbers.empty()) continue;
    if (numbers.size() != D || std::ranges::any_of(numbers, [](double x) { return std::isnan(x); }))
      throw InputError(Fault{.id = "cli.line_file",
                             .message = fmt::format("this line is not {} numbers", D),
                             .fix = "give the coordinates of one point in each line.",
                             .file = path.string(),
                             .line = number});
    points.push_back(point_at<D>(numbers, 0));
  }
  if (points.empty())
    throw InputError(Fault{.id = "cli.line_file",
                           .message = "the file has no point",
                           .fix = "give the coordinates of one point in each line.",
                           .file = path.string()});
  return points;
}

template <int D>
void add_places(const MeshingWishes& wishes, SizeWishes<D>& result) {
  for (const SizedPlace& ball : wishes.balls) {
    const auto x = numbers_of(ball, D + 1, "--ball", D == 3 ? "X,Y,Z,R=H" : "X,Y,R=H");
    result.tubes.push_back({{point_at<D>(x, 0)}, x[D], ball.size});
  }
  for (const SizedPlace& box : wishes.boxes) {
    const auto x = numbers_of(box, 2 * D, "--box", D == 3 ? "X0,Y0,Z0,X1,Y1,Z1=H" : "X0,Y0,X1,Y1=H");
    Box<D> both(point_at<D>(x, 0), point_at<D>(x, 0));
    both.add(point_at<D>(x, D));
    result.boxes.push_back({both, box.size});
  }
  for (const SizedPlace& line : wishes.lines) result.tubes.push_back({read_line<D>(line.place), 0, line.size});
}

}  // namespace

bool MeshingWishes::has_size() const {
  return size || spacing || size_field || size_expression || !region_size.empty() || !marker_size.empty() ||
         !boxes.empty() || !balls.empty() || !lines.empty();
}

std::vector<fs::path> MeshingWishes::files() const {
  std::vector<fs::path> result;
  if (size_field) result.push_back(*size_field);
  for (const SizedPlace& line : lines) result.emplace_back(line.place);
  return result;
}

template <int D>
MeshingOptions<D> meshing_options(const MeshingWishes& wishes, const Session& session) {
  MeshingOptions<D> options;
  options.domain = wishes.merge;
  options.wishes.size = wishes.size;
  options.wishes.spacing = wishes.spacing;
  options.wishes.region_size = wishes.region_size;
  options.wishes.marker_size = wishes.marker_size;
  options.wishes.expression = wishes.size_expression;
  if (wishes.size_field) options.wishes.field = read_size_field<D>(*wishes.size_field, session.observer);
  add_places(wishes, options.wishes);
  options.gradation = wishes.gradation;
  options.feature_factor = wishes.feature_factor;
  options.packing = wishes.packing;
  options.packing.seed = session.common.seed;
  options.threads = thread_count(session.common.threads);
  return options;
}

template <int D>
Json meshing_json(const MeshingWishes& wishes, const MeshingOptions<D>& options) {
  Json json;
  if (options.wishes.size) json["size"] = *options.wishes.size;
  if (options.wishes.spacing) json["spacing"] = *options.wishes.spacing;
  for (const auto& [id, size] : options.wishes.region_size) json["region_size"][std::to_string(id)] = size;
  for (const auto& [id, size] : options.wishes.marker_size) json["marker_size"][std::to_string(id)] = size;
  const auto add_all = [&](const char* name, const std::vector<SizedPlace>& places) {
    for (const SizedPlace& place : places) json[name][place.place] = place.size;
  };
  add_all("box", wishes.boxes);
  add_all("ball", wishes.balls);
  add_all("near", wishes.lines);
  if (wishes.size_field) json["size_field"] = wishes.size_field->string();
  if (options.wishes.expression) json["size_expr"] = *options.wishes.expression;
  if (options.domain.merge_distance) json["merge_distance"] = *options.domain.merge_distance;
  json["merge_angle"] = options.domain.merge_angle_deg;
  json["gradation"] = options.gradation;
  json["feature_factor"] = options.feature_factor;
  json["packing"] = name_of(kFormNames, options.packing.form);
  if (options.packing.form == PackingForm::kVoronoi)
    json["interior"] = name_of(kInteriorNames, options.packing.interior);
  else
    json["epsilon"] = options.packing.epsilon;
  json["max_vertices"] = options.packing.max_vertices;
  json["seed"] = options.packing.seed;
  return json;
}

template <int D>
void describe_meshing(const MeshingResult<D>& result, Report& report) {
  report.quality = result.quality;
  report.certificate = result.certificate;
  report.packing = PackingFigures{.repairs = result.repairs.size(), .repair_rounds = result.repair_rounds};
  if (result.spacing_integral > 0)
    report.packing->size_ratio = static_cast<double>(result.mesh.points.size()) / result.spacing_integral;
  report.costliest_features = features_json(result.costliest_features, result.domain);
}

template <int D>
std::string domain_line(const fs::path& path, const Domain<D>& domain) {
  std::string text = fmt::format("{}: {}D, {} points, {} segments", path.string(), D, grouped(domain.points.size()),
                                 grouped(domain.segments.size()));
  if (D == 3) text += fmt::format(", {} facets", grouped(domain.facet_frame.size()));
  return text + fmt::format(", {} regions\n", grouped(domain.region_id.size()));
}

namespace {

void add_sized_places(CLI::App& command, const std::string& name, std::vector<SizedPlace>& places,
                      const std::string& description, const std::string& form) {
  command
      .add_option_function<std::vector<std::string>>(
          name,
          [&places](const std::vector<std::string>& given) {
            places.clear();
            for (const std::string& text : given) places.push_back(sized_place(text));
          },
          description)
      ->check(size_of_place())
      ->allow_extra_args(false)
      ->type_name(form);
}

void add_sizes_by_id(CLI::App& command, const std::string& name, std::map<int, double>& sizes,
                     const std::string& description) {
  command
      .add_option_function<std::vector<std::string>>(
          name, [&sizes, name](const std::vector<std::string>& given) { sizes = sizes_by_id(given, name); },
          description)
      ->check(size_of_id())
      ->allow_extra_args(false)
      ->type_name("ID=H");
}

}  // namespace

void add_size_options(CLI::App& command, MeshingWishes& wishes) {
  command.add_option("--size", wishes.size, "Wanted mean edge length; without it the geometry alone decides")
      ->check(positive_number())
      ->type_name("H");
  command.add_option("--spacing", wishes.spacing, "Upper bound on the spacing function f itself (a radius)")
      ->check(positive_number())
      ->type_name("F");
  add_sizes_by_id(command, "--region-size", wishes.region_size, "Wanted edge length in one region; may be given again");
  add_sizes_by_id(command, "--marker-size", wishes.marker_size,
                  "Wanted edge length at facets, segments, points of one marker; may be given again");
  add_sized_places(command, "--box", wishes.boxes, "Wanted edge length in a box; may be given again",
                   "X0,Y0,..,X1,Y1,..=H");
  add_sized_places(command, "--ball", wishes.balls, "Wanted edge length in a ball; may be given again", "X,Y,..,R=H");
  add_sized_places(command, "--near", wishes.lines,
                   "Wanted edge length along a polyline, one point in each line of FILE; may be given again", "FILE=H");
  command
      .add_option("--size-field", wishes.size_field,
                  "Mesh (.node, .vtu) whose first vertex attribute is the wanted edge length")
      ->type_name("FILE");
  command.add_option("--size-expr", wishes.size_expression, "Wanted edge length as a formula in x, y and z")
      ->type_name("\"0.05+0.1*x\"");
  add_gradation_option(command, wishes.gradation);
  command.add_option("--feature-factor", wishes.feature_factor, "Spacing over local feature size, at most 1")
      ->check(positive_number(1))
      ->type_name("A")
      ->capture_default_str();
}

void add_packing_options(CLI::App& command, PackingOptions& packing) {
  add_form_options(command, packing.form, packing.epsilon);
  std::vector<std::string> names;
  for (const auto& [name, value] : kInteriorNames) names.push_back(name);
  command
      .add_option_function<std::string>(
          "--interior", [&interior = packing.interior](const std::string& name) { interior = kInteriorNames.at(name); },
          "With --packing voronoi: what fills the interior, lattice or random")
      ->check(one_of(names))
      ->type_name("KIND")
      ->default_str(name_of(kInteriorNames, packing.interior));
  command
      .add_option("--max-vertices", packing.max_vertices,
                  "Stop before the work if more vertices than this are expected")
      ->check(whole_number(1))
      ->type_name("N")
      ->capture_default_str();
}

template MeshingOptions<2> meshing_options(const MeshingWishes&, const Session&);
template Json meshing_json(const MeshingWishes&, const MeshingOptions<2>&);
template void describe_meshing(const MeshingResult<2>&, Report&);
template std::string domain_line(const fs::path&, const Domain<2>&);
template MeshingOptions<3> meshing_options(const MeshingWishes&, const Session&);
template Json meshing_json(const MeshingWishes&, const MeshingOptions<3>&);
template void describe_meshing(const MeshingResult<3>&, Report&);
template std::string domain_line(const fs::path&, const Domain<3>&);

}  // namespace voropack::app
