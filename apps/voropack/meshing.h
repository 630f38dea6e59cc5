// Making a mesh of a domain, as the commands mesh and solve have it in common.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "voropack/pipeline.h"

namespace voropack::app {

/// What a user may wish of a mesh, under the names of the command line.
struct MeshingWishes {
  std::optional<double> size, spacing;
  std::map<int, double> region_size, marker_size;
  std::vector<SizedPlace> boxes, balls, lines;  ///< Two corners; center and radius; a file with one point in each line.
  std::optional<std::filesystem::path> size_field;
  std::optional<std::string> size_expression;
  double gradation = MeshingOptions<3>{}.gradation;
  double feature_factor = MeshingOptions<3>{}.feature_factor;
  DomainOptions merge;
  PackingOptions packing;

  /// Whether anything is said about sizes.
  [[nodiscard]] bool has_size() const;
  /// The files that are read.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
};

/// The options that say how large elements shall be.
void add_size_options(CLI::App& command, MeshingWishes& wishes);
/// --packing, --epsilon, --interior, --max-vertices.
void add_packing_options(CLI::App& command, PackingOptions& packing);

/// Reads the size field and lines, if there are any. Throws InputError cli.size_field, cli.line_file; OptionError
/// cli.bad_place; and as read_mesh.
template <int D>
MeshingOptions<D> meshing_options(const MeshingWishes& wishes, const Session& session);

/// The options as the report lists them.
template <int D>
Json meshing_json(const MeshingWishes& wishes, const MeshingOptions<D>& options);

/// Adds to the report what is known of a mesh and how it was made.
template <int D>
void describe_meshing(const MeshingResult<D>& result, Report& report);

/// The domain in one line.
template <int D>
std::string domain_line(const std::filesystem::path& path, const Domain<D>& domain);

/// The files of a domain: the one named, and the .node file with the points of a .poly or .smesh that announces none.
std::vector<std::filesystem::path> domain_files(const std::filesystem::path& domain);

}  // namespace voropack::app
