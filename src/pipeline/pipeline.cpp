#include "voropack/pipeline.h"

#include <algorithm>
#include <chrono>
#include <span>

#include "base/parallel.h"

namespace voropack {

namespace {

/// Runs a stage and notes how long it took.
class Stopwatch {
 public:
  explicit Stopwatch(StageTimes& times) : times_(times) {}
  template <class Stage>
  auto operator()(const char* name, Stage&& stage) {
    const auto begin = std::chrono::steady_clock::now();
    auto result = stage();
    times_[name] += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
  }

 private:
  StageTimes& times_;
};

}  // namespace

template <int D>
CertificateOptions packing_claims(const Spacing<D>& spacing, const PackingOptions& packing) {
  CertificateOptions claims;
  claims.gradation = spacing.lipschitz();
  claims.form = packing.form;
  claims.epsilon = packing.epsilon;
  claims.spacing = [spacing](std::span<const double> x) {
    Vec<D> p;
    std::copy(x.begin(), x.end(), p.coord.begin());
    return spacing(p);
  };
  return claims;
}

template <int D>
MeshingResult<D> make_mesh(const DomainInput<D>& input, const MeshingOptions<D>& options, Observer& observer) {
  MeshingResult<D> result;
  Stopwatch timed(result.times);
  run_with_threads(options.threads, [&] {
    // 1. The domain as a piecewise linear system.
    result.domain = timed("domain", [&] { return build_domain(input, options.domain, observer); });

    // 2. How large spheres may be.
    const SpacingOptions spacing_options{options.gradation, options.feature_factor,
                                         edge_per_spacing<D>(options.packing)};
    Spacing<D> spacing =
        timed("spacing", [&] { return build_spacing(result.domain, options.wishes, spacing_options, observer); });
    result.spacing_integral = timed("spacing", [&] { return spacing.integral(result.domain); });

    // 3. Where they go.
    Packing<D> packing = timed("packing", [&] { return pack(result.domain, spacing, options.packing, observer); });
    // The kernel's work within `pack` is the Delaunay triangulation, wherever it is called from.
    result.times["packing"] -= packing.triangulation_s;
    result.times["delaunay"] += packing.triangulation_s;
    result.repairs = packing.repairs;
    result.repair_rounds = packing.repair_rounds;
    if (!result.repairs.empty()) spacing = spacing.with_caps(result.repairs);
    result.costliest_features = timed("packing", [&] { return costliest_features(result.domain, spacing, packing); });

    // 4. The mesh of their centers.
    result.mesh = timed("delaunay", [&] { return triangulate(result.domain, std::move(packing), observer); });

    // 5. Its control volumes.
    result.volumes = timed("dual", [&] { return build_control_volumes(result.mesh, observer); });

    // 6. What they are worth, and the proof of what is claimed.
    result.quality = timed("quality", [&] { return measure_quality(result.mesh, result.volumes, observer); });
    const CertificateOptions claims = packing_claims(spacing, options.packing);
    result.certificate =
        timed("certificate", [&] { return certify(result.mesh, result.volumes, &result.domain, claims, observer); });
  });
  return result;
}

template CertificateOptions packing_claims(const Spacing<2>&, const PackingOptions&);
template CertificateOptions packing_claims(const Spacing<3>&, const PackingOptions&);
template MeshingResult<2> make_mesh(const DomainInput<2>&, const MeshingOptions<2>&, Observer&);
template MeshingResult<3> make_mesh(const DomainInput<3>&, const MeshingOptions<3>&, Observer&);

}  // namespace voropack
