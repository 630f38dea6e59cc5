// Stages 1 to 6 in one call.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "voropack/certificate.h"
#include "voropack/delaunay.h"
#include "voropack/domain.h"
#include "voropack/dual.h"
#include "voropack/packing.h"
#include "voropack/quality.h"
#include "voropack/spacing.h"

namespace voropack {

template <int D>
struct MeshingOptions {
  DomainOptions domain;
  SizeWishes<D> wishes;
  double gradation = SpacingOptions{}.gradation;            ///< b of SpacingOptions.
  double feature_factor = SpacingOptions{}.feature_factor;  ///< a of SpacingOptions.
  PackingOptions packing;
  int threads = 0;  ///< 0: as many as the machine has.
};

/// Wall-clock seconds of each stage, under the names of the report: read, spacing, packing, delaunay, dual, quality,
/// certificate, ...
using StageTimes = std::map<std::string, double>;

template <int D>
struct MeshingResult {
  Domain<D> domain;
  Mesh<D> mesh;
  ControlVolumes<D> volumes;
  QualityReport quality;
  Certificate certificate;
  std::vector<SpacingCap<D>> repairs;  ///< Where f had to be shrunk.
  int repair_rounds = 0;
  std::vector<CostlyFeature<D>> costliest_features;  ///< What most vertices are due to, beside the wished sizes.
  double spacing_integral = 0;                       ///< Integral of f^-D over the domain.
  StageTimes times;
};

/// What a mesh may claim that was packed with a spacing function (with the caps of its repairs).
template <int D>
CertificateOptions packing_claims(const Spacing<D>& spacing, const PackingOptions& packing);

/// From a domain to a certified mesh with its control volumes.
template <int D>
MeshingResult<D> make_mesh(const DomainInput<D>& input, const MeshingOptions<D>& options = {},
                           Observer& observer = silent_observer());

}  // namespace voropack
