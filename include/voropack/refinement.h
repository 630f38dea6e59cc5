// From a mesh to a finer one that keeps its vertices: algorithm PACKING of [Miller1996], section 3, begun with the
// spheres that are there.
#pragma once

#include <cstddef>
#include <vector>

#include "voropack/coarsening.h"
#include "voropack/index.h"
#include "voropack/mesh.h"
#include "voropack/mesh_domain.h"
#include "voropack/observer.h"
#include "voropack/packing.h"
#include "voropack/spacing.h"

namespace voropack {

/// f of a mesh at its vertices: `vertex_spacing`, or if that is absent half the distance to the nearest neighbor; made
/// Lipschitz along the edges. O(n).
template <int D>
IdVector<VertexId, double> spacing_at_vertices(const Mesh<D>& mesh, double lipschitz);

/// The spacing function with the values f at the vertices of a mesh of the domain, made Lipschitz, linear between them;
/// but not above what `wishes` and the domain's features ask for. `wishes.field` may be used beside it, and
/// `wishes.spacing_field` is ignored. Exact on convex domains; where the straight line between two points leaves the
/// mesh, they may differ by more than is Lipschitz as far as linear interpolation does.
/// Throws: as `build_spacing`.
template <int D>
Spacing<D> spacing_through(const Mesh<D>& mesh, const Domain<D>& domain, IdVector<VertexId, double> f,
                           const SizeWishes<D>& wishes, const SpacingOptions& options = {},
                           Observer& observer = silent_observer());

/// `spacing_through` with `factor` times the spacing of the mesh.
/// Throws: as `build_spacing`; OptionError refine.bad_factor if the factor is not in (0, 1].
template <int D>
Spacing<D> refined_spacing(const Mesh<D>& mesh, const Domain<D>& domain, double factor, const SizeWishes<D>& wishes,
                           const SpacingOptions& options = {}, Observer& observer = silent_observer());

struct RefinementOptions {
  PackingOptions packing;
  /// True: every vertex stays. False: those that fit the new spacing stay, where it is larger than before.
  bool keep_all = true;
};

template <int D>
struct RefinedMesh {
  Mesh<D> mesh;  ///< With f in `vertex_spacing`.
  /// [n_vertices] the same vertex in the mesh before, to the bit in the same place; none() if it is new.
  IdVector<VertexId, VertexId> old_vertex;
  std::size_t n_kept = 0, n_added = 0, n_removed = 0;
  std::vector<SpacingCap<D>> repairs;  ///< Where f was shrunk because a protecting ball was not empty.
  int repair_rounds = 0;
  double triangulation_s = 0;  ///< As in Packing.
};

/// Refines a boundary-conforming Delaunay mesh: its vertices stay, lower polytopes are completed before higher ones,
/// and the result is a boundary-conforming Delaunay mesh of the same domain.
///
/// `place` is where the mesh is in its domain, as `domain_of` finds out. Empty protecting balls stay empty of old
/// vertices: a finer simplex on a polytope has its ball within the balls of the coarser ones
/// (docs/theory/refinement.md). Throws: OptionError refine.spacing_grows if all vertices are to stay and the new
/// spacing is larger than the old one
///         at one of them.
///         as `pack`.
template <int D>
RefinedMesh<D> refine(const Mesh<D>& mesh, const MeshDomain<D>& place, const Spacing<D>& spacing,
                      const RefinementOptions& options = {}, Observer& observer = silent_observer());

/// For each vertex of `to` the vertex of `from` in the same place to the bit, or none(). O(n).
template <int D>
IdVector<VertexId, VertexId> same_vertices(const Mesh<D>& from, const Mesh<D>& to);

/// Coarser meshes of the same domain, the finest of them first, as levels for multigrid: what `finest` was refined
/// from, mesh by mesh, or what it was coarsened to. The vertices of each have to be among those of the mesh before.
/// Throws: InputError refine.not_nested, with the vertex.
template <int D>
std::vector<CoarseLevel<D>> nested_levels(const Mesh<D>& finest, std::vector<Mesh<D>> coarser);

/// Throws InputError transfer.not_covered if a vertex of `to` is outside of `from` by more than the edges of `from` are
/// long there: the two are of different domains. Boundaries that were rounded or simplified differ by less. O(n).
template <int D>
void require_cover(const Mesh<D>& from, const Mesh<D>& to);

struct TransferOptions {
  /// Shifts the values of new vertices inside each region, so that the integral over its control volumes stays; where a
  /// region has no new vertices, those of all vertices inside it.
  bool conserve = false;
};

/// Values at the vertices of another mesh of the same domain: vertices that both have keep theirs, others interpolate
/// linearly. A vertex outside of `from` takes the nearest simplex.
/// Throws: InputError transfer.wrong_length.
///         InputError transfer.not_covered as `require_cover`; to conserve, `to` has to cover `from` as well.
///         InputError transfer.not_conserved if a region has no vertex inside in which to put a difference.
template <int D>
IdVector<VertexId, double> transfer(const Mesh<D>& from, const IdVector<VertexId, double>& values, const Mesh<D>& to,
                                    const TransferOptions& options = {});

}  // namespace voropack
