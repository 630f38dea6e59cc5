#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "geom/tolerance.h"
#include "voropack/delaunay.h"
#include "voropack/error.h"
#include "voropack/refinement.h"

namespace voropack {

namespace {

/// All vertices fit a spacing that is nowhere larger than before.
template <int D>
void check_room(const Mesh<D>& mesh, const Spacing<D>& spacing) {
  const IdVector<VertexId, double> before = spacing_at_vertices(mesh, spacing.lipschitz());
  IdVector<VertexId, double> f(mesh.points.size());
  parallel_for(f.size(), [&](std::size_t i) { f[VertexId(i)] = spacing(mesh.points[VertexId(i)]); });
  for (const VertexId v : ids(mesh.points)) {
    if (f[v] <= before[v] * (1 + kPackingCheckSlack)) continue;
    throw OptionError(
        Fault{.id = "refine.spacing_grows",
              .message = fmt::format(
                  "the new spacing is {} at vertex {} (counted from 0), where it was {}: not all vertices can stay",
                  f[v], v.value(), before[v]),
              .fix = "ask for a smaller spacing, or let vertices go where it grows (--keep fitting)",
              .position = {mesh.points[v].coord.begin(), mesh.points[v].coord.end()}});
  }
}

template <int D>
KeptVertices<D> kept_vertices(const Mesh<D>& mesh, const MeshDomain<D>& place, bool all_stay) {
  KeptVertices<D> kept;
  kept.all_stay = all_stay;
  for (const VertexId v : ids(mesh.points)) {
    if (place.carrier[v].dimension == 0) continue;
    kept.position.push_back(mesh.points[v]);
    kept.carrier.push_back(place.carrier[v]);
  }
  return kept;
}

}  // namespace

template <int D>
RefinedMesh<D> refine(const Mesh<D>& mesh, const MeshDomain<D>& place, const Spacing<D>& spacing,
                      const RefinementOptions& options, Observer& observer) {
  if (options.keep_all) check_room(mesh, spacing);
  Packing<D> packing =
      pack_around(kept_vertices(mesh, place, options.keep_all), place.domain, spacing, options.packing, observer);
  RefinedMesh<D> result;
  result.repairs = packing.repairs;
  result.repair_rounds = packing.repair_rounds;
  result.triangulation_s = packing.triangulation_s;
  result.mesh = triangulate(place.domain, std::move(packing), observer);
  result.old_vertex = same_vertices(mesh, result.mesh);
  result.n_kept =
      static_cast<std::size_t>(std::ranges::count_if(result.old_vertex, [](VertexId v) { return !v.is_none(); }));
  result.n_added = result.mesh.points.size() - result.n_kept;
  result.n_removed = mesh.points.size() - result.n_kept;
  return result;
}

template RefinedMesh<2> refine(const Mesh<2>&, const MeshDomain<2>&, const Spacing<2>&, const RefinementOptions&,
                               Observer&);
template RefinedMesh<3> refine(const Mesh<3>&, const MeshDomain<3>&, const Spacing<3>&, const RefinementOptions&,
                               Observer&);

}  // namespace voropack
