#include "mesh/extent.h"

#include <fmt/format.h>

#include <cmath>

#include "base/place_text.h"
#include "geom/tolerance.h"
#include "voropack/error.h"

namespace voropack {

template <int D>
void check_extent(const Mesh<D>& mesh) {
  if (mesh.simplex_vertices.empty())
    throw InputError(
        Fault{.id = "mesh.empty", .message = "the mesh has no simplices", .fix = "give a mesh with simplices"});
  Box<D> box;
  for (const VertexId v : ids(mesh.points)) {
    const Vec<D>& x = mesh.points[v];
    box.add(x);
    for (int k = 0; k < D; ++k)
      if (!(std::abs(x[k]) <= kMaxCoordinate))
        throw InputError(Fault{.id = "mesh.too_large",
                               .message = fmt::format("vertex {} (counted from 0) lies at {}, beyond {:g}", v.value(),
                                                      place_text(x), kMaxCoordinate),
                               .fix = "scale the mesh down",
                               .position = {x.coord.begin(), x.coord.end()}});
  }
  if (!(box.diagonal() >= kMinDiameter))
    throw InputError(Fault{.id = "mesh.too_small",
                           .message = fmt::format("all vertices lie within {:g} of each other", kMinDiameter),
                           .fix = "scale the mesh up"});
}

template void check_extent(const Mesh<2>&);
template void check_extent(const Mesh<3>&);

}  // namespace voropack
