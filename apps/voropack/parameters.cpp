#include "parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "suggest.h"
#include "voropack/error.h"

namespace voropack::app {

namespace {

constexpr std::uint64_t kMaxThreads = 4096;
constexpr double kMaxMergeAngleDeg = 90;
constexpr double kMaxGradation = 0.4;  // As SpacingOptions says.

/// The whole of `text` as a number, with an optional leading plus.
std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string number_fault(const std::string& text, double at_most) {
  const std::optional<double> value = parse_number(text);
  if (value && std::isfinite(*value) && *value > 0 && *value <= at_most) return {};
  if (std::isinf(at_most)) return fmt::format("must be a positive number, not '{}'", text);
  return fmt::format("must be a number above 0 and at most {}, not '{}'", at_most, text);
}

std::optional<int> parse_id(std::string_view text) {
  int id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return id;
}

}  // namespace

CLI::Validator positive_number(double at_most) {
  return {[at_most](std::string& text) { return number_fault(text, at_most); }, "", "positive"};
}

CLI::Validator number_below(double below) {
  return {[below](const std::string& text) -> std::string {
            const std::optional<double> value = parse_number(text);
            if (value && *value >= 0 && *value < below) return {};
            if (std::isinf(below)) return fmt::format("must be a number of at least 0, not '{}'", text);
            return fmt::format("must be a number of at least 0 and below {}, not '{}'", below, text);
          },
          "", "not negative"};
}

CLI::Validator whole_number(std::uint64_t at_least, std::uint64_t at_most) {
  return {[=](const std::string& text) -> std::string {
            std::uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (error == std::errc{} && end == text.data() + text.size() && value >= at_least && value <= at_most)
              return {};
            return fmt::format("must be an integer from {} to {}, not '{}'", at_least, at_most, text);
          },
          "", "integer"};
}

CLI::Validator size_of_id() {
  return {[](std::string& text) -> std::string {
            const std::size_t equals = text.find('=');
            if (equals == std::string::npos || !parse_id(std::string_view(text).substr(0, equals)))
              return fmt::format("must be ID=H with an integer ID, such as 2=0.1, not '{}'", text);
            const std::string fault = number_fault(text.substr(equals + 1), std::numeric_limits<double>::infinity());
            return fault.empty() ? fault : "the size " + fault;
          },
          "", "size of id"};
}

CLI::Validator size_of_place() {
  return {[](std::string& text) -> std::string {
            const std::size_t equals = text.rfind('=');
            if (equals == std::string::npos || equals == 0)
              return fmt::format("must be PLACE=H, a place and an edge length, not '{}'", text);
            const std::string fault = number_fault(text.substr(equals + 1), std::numeric_limits<double>::infinity());
            return fault.empty() ? fault : "the size " + fault;
          },
          "", "size of place"};
}

SizedPlace sized_place(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  return {text.substr(0, equals), parse_number(std::string_view(text).substr(equals + 1)).value()};
}

std::optional<std::vector<double>> number_list(std::string_view text) {
  std::vector<double> numbers;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::optional<double> number = parse_number(text.substr(0, comma));
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

CLI::Validator one_of(std::vector<std::string> names) {
  return {[names](std::string& text) -> std::string {
            if (std::find(names.begin(), names.end(), text) != names.end()) return {};
            return fmt::format("must be one of {}, not '{}'; did you mean '{}'?", fmt::join(names, ", "), text,
                               nearest_name(text, names).value_or(""));
          },
          "", "name"};
}

std::map<int, double> sizes_by_id(const std::vector<std::string>& texts, const std::string& option) {
  std::map<int, double> sizes;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const int id = parse_id(std::string_view(text).substr(0, equals)).value();
    if (!sizes.emplace(id, parse_number(text.substr(equals + 1)).value()).second)
      throw OptionError(Fault{.id = "cli.given_twice",
                              .message = fmt::format("{} gives {} two sizes", option, id),
                              .fix = "give each id once."});
  }
  return sizes;
}

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--report", options.report, "Write a report with every figure as JSON")->type_name("FILE.json");
  command.add_option("--threads", options.threads, "Threads to use; 0: all of the machine")
      ->check(whole_number(0, kMaxThreads))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of the random numbers; the same seed gives the same files")
      ->check(whole_number(0))
      ->type_name("N")
      ->capture_default_str();
  command.add_flag("--quiet,-q", options.verbosity.quiet, "Say nothing but errors");
  command.add_flag("--no-progress", options.verbosity.no_progress, "No progress bar and no lines of progress");
  command.add_flag("--verbose,-v", options.verbosity.verbose, "Say more, such as the time of each stage");
}

CLI::Option* add_output_option(CLI::App& command, std::vector<std::filesystem::path>& outputs,
                               const std::string& description) {
  return command.add_option("-o,--output", outputs, description)->allow_extra_args(false)->required();
}

CLI::Option* add_gradation_option(CLI::App& command, double& gradation) {
  return command.add_option("--gradation", gradation, "Lipschitz constant of the spacing function, at most 0.4")
      ->check(positive_number(kMaxGradation))
      ->type_name("B")
      ->capture_default_str();
}

CLI::Option* add_gradation_option(CLI::App& command, std::optional<double>& gradation) {
  return command
      .add_option("--gradation", gradation, "Claimed Lipschitz constant of the spacing, at most 0.4; else measured")
      ->check(positive_number(kMaxGradation))
      ->type_name("B");
}

void add_merge_options(CLI::App& command, DomainOptions& options) {
  command
      .add_option("--merge-distance", options.merge_distance,
                  "Facets whose points are this near to one plane are one facet, and its points move into the plane;\n"
                  "without it 1e-5 of the diagonal of the domain's bounding box, or what the file's digits leave open")
      ->check(number_below())
      ->type_name("LENGTH");
  command
      .add_option("--merge-angle", options.merge_angle_deg,
                  "Facets whose planes differ by more than this do not become one facet")
      ->check(number_below(kMaxMergeAngleDeg))
      ->type_name("DEG")
      ->capture_default_str();
}

void add_form_options(CLI::App& command, PackingForm& form, double& epsilon) {
  std::vector<std::string> names;
  for (const auto& [name, value] : kFormNames) names.push_back(name);
  command
      .add_option_function<std::string>(
          "--packing", [&form](const std::string& name) { form = kFormNames.at(name); },
          "Packing completed at Voronoi vertices (voronoi), epsilon-maximal by active cells (maximal), or\n"
          "oversampled and filtered (filtered)")
      ->check(one_of(names))
      ->type_name("FORM")
      ->default_str(name_of(kFormNames, form));
  command.add_option("--epsilon", epsilon, "With --packing maximal or filtered: how near to maximal, relative to f")
      ->check(positive_number(1))
      ->type_name("E")
      ->capture_default_str();
}

void check_extension(const std::filesystem::path& path, const std::vector<std::string>& extensions) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) return;
  throw OptionError(Fault{.id = "io.unknown_format",
                          .message = fmt::format("{}: unknown format '{}'", path.string(), extension),
                          .fix = fmt::format("let the name end in {}.", fmt::join(extensions, " or "))});
}

namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

OptionError unknown(const std::string& what, const std::string& typed, const std::vector<std::string>& known,
                    const std::string& help) {
  return OptionError(Fault{.id = "cli.unknown_" + what,
                           .message = fmt::format("unknown {} '{}'; did you mean '{}'?", what, typed,
                                                  nearest_name(typed, known).value_or("")),
                           .fix = fmt::format("see {} --help.", help)});
}

}  // namespace

void check_names(const CLI::App& root, const std::vector<std::string>& arguments) {
  const CLI::App* app = &root;
  std::string help = root.get_name();
  for (const std::string& argument : arguments) {
    if (argument == "--") return;
    if (argument.starts_with("--")) {
      const std::string name = argument.substr(0, argument.find('='));
      const std::vector<std::string> options = option_names(*app);
      if (std::find(options.begin(), options.end(), name) == options.end())
        throw unknown("option", name, options, help);
    } else if (!app->get_subcommands({}).empty() && !argument.starts_with('-')) {
      std::vector<std::string> commands;
      for (const CLI::App* command : app->get_subcommands({})) commands.push_back(command->get_name());
      if (std::find(commands.begin(), commands.end(), argument) == commands.end())
        throw unknown("command", argument, commands, help);
      app = app->get_subcommand(argument);
      help += ' ' + argument;
    }
  }
}

OptionError unexpected_arguments(const CLI::App& root) {
  const CLI::App* command = &root;
  std::string help = root.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    help += ' ' + command->get_name();
  }
  const std::vector<std::string> arguments = root.remaining(true);
  for (const std::string& argument : arguments)
    if (argument.starts_with('-')) return unknown("option", argument, option_names(*command), help);
  return OptionError(Fault{.id = "cli.too_many_arguments",
                           .message = fmt::format("not expected: {}", fmt::join(arguments, " ")),
                           .fix = fmt::format("see {} --help.", help)});
}

}  // namespace voropack::app
