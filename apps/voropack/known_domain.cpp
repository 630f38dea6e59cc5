#include "known_domain.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "meshing.h"
#include "parameters.h"
#include "voropack/error.h"
#include "voropack/io.h"

namespace voropack::app {

std::vector<std::filesystem::path> KnownDomain::files() const {
  return file ? domain_files(*file) : std::vector<std::filesystem::path>{};
}

void add_domain_options(CLI::App& command, KnownDomain& known, const std::string& purpose) {
  command.add_option("--domain", known.file, purpose)->type_name("DOMAIN");
  add_merge_options(command, known.merge);
}

void describe_known_domain(const KnownDomain& known, Json& json) {
  if (known.merge.merge_distance) json["merge_distance"] = *known.merge.merge_distance;
  if (!known.file) return;
  json["domain"] = known.file->string();
  json["merge_angle"] = known.merge.merge_angle_deg;
}

template <int D>
Domain<D> read_known_domain(const KnownDomain& known, Observer& observer) {
  const AnyDomainInput any = read_domain(*known.file, observer);
  if (const auto* const input = std::get_if<DomainInput<D>>(&any)) return build_domain(*input, known.merge, observer);
  throw InputError(Fault{.id = "cli.dimension",
                         .message = "the mesh and the domain have different dimensions",
                         .fix = "give the domain that the mesh was made from.",
                         .file = known.file->string()});
}

/// What no domain of the same vertices mends.
bool is_about_vertices(const Fault& fault) {
  constexpr std::array<std::string_view, 5> kIds = {"mesh.empty", "mesh.too_large", "mesh.too_small", "domain.too_far",
                                                    "domain.empty"};
  return std::find(kIds.begin(), kIds.end(), fault.id) != kIds.end();
}

template <int D>
MeshDomain<D> find_place(const Mesh<D>& mesh, const KnownDomain& known, Observer& observer) {
  if (known.file)
    return place_in_domain(mesh, read_known_domain<D>(known, observer), known.merge.merge_distance.value_or(0),
                           observer);
  try {
    return domain_of(mesh, observer);
  } catch (const InputError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults)
      if (!is_about_vertices(fault)) fault.fix = "name the domain that the mesh was made of: --domain FILE.";
    throw InputError(std::move(faults));
  }
}

template Domain<2> read_known_domain(const KnownDomain&, Observer&);
template Domain<3> read_known_domain(const KnownDomain&, Observer&);
template MeshDomain<2> find_place(const Mesh<2>&, const KnownDomain&, Observer&);
template MeshDomain<3> find_place(const Mesh<3>&, const KnownDomain&, Observer&);

}  // namespace voropack::app
