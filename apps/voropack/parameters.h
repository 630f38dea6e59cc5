// Options of the command line that are checked as they are read, and names for values of the library's enumerations.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "terminal_observer.h"
#include "voropack/domain.h"
#include "voropack/error.h"
#include "voropack/packing.h"

namespace voropack::app {

/// Options that mean the same in every command.
struct CommonOptions {
  std::optional<std::filesystem::path> report;
  int threads = 0;  ///< 0: all of the machine.
  std::uint64_t seed = 1;
  Verbosity verbosity;
};

void add_common_options(CLI::App& command, CommonOptions& options);

/// -o/--output, once or several times.
CLI::Option* add_output_option(CLI::App& command, std::vector<std::filesystem::path>& outputs,
                               const std::string& description);

// What is claimed or wanted of a packing: --gradation, --packing, --epsilon.
CLI::Option* add_gradation_option(CLI::App& command, double& gradation);
CLI::Option* add_gradation_option(CLI::App& command, std::optional<double>& gradation);
void add_form_options(CLI::App& command, PackingForm& form, double& epsilon);

// Which facets of a domain are taken as coplanar: --merge-distance, --merge-angle.
void add_merge_options(CLI::App& command, DomainOptions& options);

/// A finite number in [0, below).
CLI::Validator number_below(double below = std::numeric_limits<double>::infinity());

/// A finite number in (0, at_most]; an infinite `at_most` allows every positive number.
CLI::Validator positive_number(double at_most = std::numeric_limits<double>::infinity());

/// A decimal integer in [at_least, at_most].
CLI::Validator whole_number(std::uint64_t at_least, std::uint64_t at_most = std::numeric_limits<std::uint64_t>::max());

/// ID=H with an integer ID and a positive H.
CLI::Validator size_of_id();

/// A size in a part of space that numbers or a file describe: PLACE=H.
struct SizedPlace {
  std::string place;
  double size = 0;
};

/// PLACE=H with a positive H.
CLI::Validator size_of_place();

/// Parses what size_of_place() accepted.
SizedPlace sized_place(const std::string& text);

/// Numbers between commas; nothing if some part is none.
std::optional<std::vector<double>> number_list(std::string_view text);

/// One of `names`; else the message says which is nearest.
CLI::Validator one_of(std::vector<std::string> names);

/// Parses what size_of_id() accepted. Throws OptionError cli.given_twice.
std::map<int, double> sizes_by_id(const std::vector<std::string>& texts, const std::string& option);

inline const std::map<std::string, PackingForm> kFormNames = {
    {"voronoi", PackingForm::kVoronoi}, {"maximal", PackingForm::kMaximal}, {"filtered", PackingForm::kFiltered}};
inline const std::map<std::string, Interior> kInteriorNames = {{"lattice", Interior::kLattice},
                                                               {"random", Interior::kRandom}};

/// The key of `value`, which is there.
template <class T>
std::string name_of(const std::map<std::string, T>& names, T value) {
  for (const auto& [name, named] : names)
    if (named == value) return name;
  return {};
}

/// Throws OptionError io.unknown_format unless `path` ends in one of `extensions`.
void check_extension(const std::filesystem::path& path, const std::vector<std::string>& extensions);

inline const std::vector<std::string> kMeshExtensions = {".node", ".vtu"};

/// Throws OptionError cli.unknown_option, with the nearest known name, for the first argument that begins with -- and
/// that neither `root` nor its chosen command knows; cli.unknown_command for a word that is no command where one has
/// to be.
void check_names(const CLI::App& root, const std::vector<std::string>& arguments);

/// What to say of arguments that are left after parsing: the nearest known name if one looks like an option.
OptionError unexpected_arguments(const CLI::App& root);

}  // namespace voropack::app
