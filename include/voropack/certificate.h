// Stage 6: Mesh<D>, ControlVolumes<D> -> Certificate: what the mesh is claimed to be, proved by code that did not make
// it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "voropack/domain.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"
#include "voropack/packing.h"

namespace voropack {

/// What the maker of the mesh claims; absent claims are measured from the mesh or not tested.
struct CertificateOptions {
  std::optional<double> gradation;  ///< b: claimed Lipschitz constant of the vertex spacings.
  PackingForm form = PackingForm::kVoronoi;
  double epsilon = 0.25;              ///< With kMaximal and kFiltered.
  std::optional<double> radius_edge;  ///< Largest ratio to accept; default: the bounds of docs/theory/certificate.md.
  /// f at a point of D coordinates; safe to call from many threads. Without it, voronoi_maximal knows f at a
  /// circumcenter only up to b R, and counts as violations those where a vertex would fit whatever f is.
  std::function<double(std::span<const double>)> spacing;
};

struct Certificate {
  struct Check {
    std::string name;  ///< One of the names in docs/theory/certificate.md; stable.
    bool ok = true;
    std::uint64_t tested = 0;  ///< 0: the data for this check is absent.
    std::uint64_t violations = 0;
    std::optional<double> worst;  ///< The worst figure seen; its meaning depends on the check.
    std::string where;            ///< The worst case: element and place. Empty if nothing was tested.
  };
  bool ok = true;
  std::vector<Check> checks;
};

/// Runs every check on the mesh: packing, spacing_lipschitz, voronoi_maximal, delaunay, conformity, protecting_balls,
/// voronoi_containment, radius_edge, dual_nonnegative, volume_sum, closure. With `domain`, conformity and volumes are
/// compared with it.
///
/// Shares no code with the stages that made the mesh, only src/base and the exact predicates.
template <int D>
Certificate certify(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const Domain<D>* domain = nullptr,
                    const CertificateOptions& options = {}, Observer& observer = silent_observer());

}  // namespace voropack
