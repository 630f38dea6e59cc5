// The exact flux through dual faces.
#include "geom/quadrature.h"
#include "norms/dual_face_parts.h"
#include "voropack/norms.h"

namespace voropack {

template <int D>
EdgeValues mean_fluxes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                       const std::function<Vec<D>(const Vec<D>&)>& gradient) {
  return mean_over_dual_faces<double>(mesh, volumes, [&](const std::array<Vec<D>, D>& part, const Vec<D>& normal) {
    double mean = 0;
    for (const QuadraturePoint<D - 1>& q : kQuadrature<D - 1>) mean -= q.weight * dot(gradient(q.at(part)), normal);
    return mean;
  });
}

template EdgeValues mean_fluxes(const Mesh<2>&, const ControlVolumes<2>&, const std::function<Vec<2>(const Vec<2>&)>&);
template EdgeValues mean_fluxes(const Mesh<3>&, const ControlVolumes<3>&, const std::function<Vec<3>(const Vec<3>&)>&);

}  // namespace voropack
