// The domain of a mesh, where the user names its file: for `check`, `coarsen` and `refine`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "voropack/mesh_domain.h"

namespace voropack::app {

struct KnownDomain {
  std::optional<std::filesystem::path> file;
  DomainOptions merge;

  /// The files that are read.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
};

/// --domain, --merge-distance, --merge-angle.
void add_domain_options(CLI::App& command, KnownDomain& known, const std::string& purpose);

/// Adds what was given to the options of a report.
void describe_known_domain(const KnownDomain& known, Json& json);

/// Reads the file as `mesh` does. Throws InputError cli.dimension; and as read_domain, build_domain.
template <int D>
Domain<D> read_known_domain(const KnownDomain& known, Observer& observer);

/// Where the mesh is in the domain that the user names, or else in the one that its boundary tells.
/// Throws: as above, domain_of, place_in_domain; errors of domain_of propose to name the domain.
template <int D>
MeshDomain<D> find_place(const Mesh<D>& mesh, const KnownDomain& known, Observer& observer);

}  // namespace voropack::app
