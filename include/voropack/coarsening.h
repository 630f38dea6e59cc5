// From a fine mesh of any origin to a node-nested hierarchy of coarser ones: algorithm COARSEN of [Miller1996],
// section 4, graded, in the plane and in space.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voropack/domain.h"
#include "voropack/index.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/mesh_domain.h"
#include "voropack/observer.h"

namespace voropack {

/// What the spacing of the fine mesh is at a vertex.
enum class InitialSpacing : std::uint8_t {
  kNearest,   ///< Half the distance to the nearest neighbor [Miller1996, Figure 6].
  kMeanEdge,  ///< That of a packing with such edges: their mean length at the vertex over 2.4, or 2.7 in space.
};

/// In which order the vertices of one polytope are tried.
enum class CoarseningOrder : std::uint8_t {
  kFront,   ///< From the boundary inwards: fewer vertices, and better shapes.
  kCurve,   ///< Along a Hilbert curve.
  kRandom,  ///< As Luby's algorithm would choose them.
};

struct CoarseningOptions {
  int levels = 4;  ///< The hierarchy ends earlier where the boundary allows no further coarsening. >= 1.
  /// Vertices of level i keep a distance that grows by this factor from level to level. > 1.
  double growth = 2;
  /// Instead of `levels` and `growth`: numbers of vertices of levels 1, 2, ..., falling. Each level is the one that
  /// comes closest from below among all growth factors; the smallest one where none is below.
  std::vector<std::size_t> target_vertices;
  double lipschitz = 0.25;  ///< Of the spacing function of each level. In (0, 1).
  InitialSpacing initial = InitialSpacing::kMeanEdge;
  CoarseningOrder order = CoarseningOrder::kFront;
  /// f_i = max(growth^i min f_0, f_0), as in Figure 6: for quasi-uniform meshes. Else growth^i f_0, made Lipschitz.
  bool quasi_uniform = false;
  std::uint64_t seed = 1;  ///< For kRandom.
};

/// One mesh of a hierarchy.
template <int D>
struct CoarseLevel {
  Mesh<D> mesh;                                ///< With f in `vertex_spacing`.
  IdVector<VertexId, VertexId> finest_vertex;  ///< [n_vertices] the same vertex in the finest mesh.
  /// [n_vertices] the same vertex one level finer.
  IdVector<VertexId, VertexId> finer_vertex;
  /// [n_vertices of the next finer mesh] rows of barycentric coordinates in this mesh: from its vertices to those of
  /// the finer one. A vertex on a facet or segment is interpolated from that facet or segment, any other one inside its
  /// own region.
  SparseMatrix prolongation;
  /// No point of a region is farther than this, in units of the spacing there, from a vertex that keeps others away: E
  /// of the check voronoi_maximal.
  double epsilon = 0;
  double growth = 1;             ///< f = growth f_0, made Lipschitz.
  double boundary_distance = 0;  ///< How far the boundary is from that of the finest mesh, at most. Length.
};

/// A boundary of the user's own for a level and all coarser ones, up to the next that has one.
template <int D>
struct LevelBoundary {
  int level = 1;  ///< >= 1.
  /// Its points are vertices of the finest mesh, whether these are on its boundary or inside.
  Domain<D> domain;
};

/// Levels 1, 2, ..., each coarser than the one before.
template <int D>
struct CoarseningHierarchy {
  Domain<D> domain;  ///< The polytopes that the boundary of the finest mesh consists of.
  std::vector<CoarseLevel<D>> levels;
  std::vector<LevelBoundary<D>> boundaries;  ///< As they were given, by ascending level.

  /// What level i + 1, levels[i], is a mesh of.
  [[nodiscard]] const Domain<D>& domain_of(std::size_t i) const {
    const Domain<D>* found = &domain;
    for (const LevelBoundary<D>& boundary : boundaries)
      if (static_cast<std::size_t>(boundary.level) <= i + 1) found = &boundary.domain;
    return *found;
  }
};

/// Coarsens a boundary-conforming Delaunay mesh. The vertices of each level are some of those of the level before, and
/// every level is a boundary-conforming Delaunay mesh of the same domain with the same regions and markers.
///
/// Built from the coarsest level up, each time from the vertices of the finest mesh, so that shapes do not get worse
/// from level to level. Where a coarse boundary does not conform, f shrinks, at worst to that of the finest mesh.
/// Cost: O(n) per level. The same result for any number of threads.
/// Throws: OptionError coarsen.bad_option.
///         InputError  coarsen.not_delaunay  if the mesh is not Delaunay, or its own vertices lie in protecting balls.
///         Cancelled   if the observer asks to stop.
template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, const CoarseningOptions& options = {},
                               Observer& observer = silent_observer());

/// The same with boundaries for some levels. Vertices of the finest mesh on such a boundary may join it; those outside
/// of it have no place on its level. Interpolation at them is from the nearest simplex. `boundary_distance` is the
/// largest distance of boundary vertices of the level and of the finest mesh from the boundary of the other.
///
/// Throws: as above; InputError coarsen.level_boundary if a point of a boundary is no vertex of the finest mesh, if a
/// coarser level reaches out of it, or if its protecting balls hold vertices and there are none on it to mend that.
template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, std::vector<LevelBoundary<D>> boundaries,
                               const CoarseningOptions& options = {}, Observer& observer = silent_observer());

/// The same with a domain that is known: `place` says where the mesh is in it (domain_of, place_in_domain).
template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, MeshDomain<D> place, std::vector<LevelBoundary<D>> boundaries,
                               const CoarseningOptions& options = {}, Observer& observer = silent_observer());

/// For each simplex of a level, how many of the next finer mesh it meets with its interior: what Theorem 4.1 bounds.
///
/// Simplices that overlap by less than a millionth of their size only touch.
/// Both meshes fill the same domain. Cost: proportional to the number of intersections, some ten times O(n).
template <int D>
IdVector<SimplexId, std::uint32_t> count_intersections(const Mesh<D>& finer, const CoarseLevel<D>& level);

/// What may be done for better shapes once a level is packed.
enum class LocalImprovement : std::uint8_t {
  kNone,    ///< Nothing.
  kPacked,  ///< Vertices are exchanged, added and removed, but f-spheres do not overlap.
  kFree,    ///< Vertices are exchanged, added and removed, and `largest_overlap` says how much packing that gave up.
};

/// Settings of `coarsen_beyond_boundary`.
struct BeyondBoundaryOptions {
  int levels = 4;     ///< >= 1.
  double growth = 2;  ///< f_i = growth^i f_0, made Lipschitz. > 1.
  /// Instead of `levels` and `growth`: numbers of vertices of levels 1, 2, ..., falling. The growth of each level is
  /// the one that comes closest from below. In the plane, where no growth suffices, the Lipschitz constant is raised
  /// for that level; in space ten hierarchies are tried, and one within 5 % below is near enough.
  std::vector<std::size_t> target_vertices;
  /// Of the spacing function of each level. In (0, 1). If absent: 0.1 in the plane, 0.25 in space.
  std::optional<double> lipschitz = std::nullopt;
  InitialSpacing initial = InitialSpacing::kMeanEdge;
  CoarseningOrder order = CoarseningOrder::kFront;
  int restarts = 1;  ///< Packings tried per level, with different seeds; the best shapes are taken. >= 1. In the plane.
  LocalImprovement improvement = LocalImprovement::kFree;  ///< In the plane.
  int trials = 300;                                        ///< Exchanges tried per vertex of a level. >= 0.
  double max_area_change = 0.02;  ///< Of each region, as a part of its area, in space of its volume. In (0, 1).
  /// Boundary vertices where the boundary turns by more than this stay on all levels, in space those between edges
  /// where it does; along such edges every other one may go. In (0, 180]: none stays for its angle.
  double feature_angle_deg = 180;
  /// In space: faces of different markers may be joined where the regions beside them are the same. A part of the
  /// boundary between curves gets the marker of most of it. For meshes of surface files, in which each triangle has a
  /// marker of its own.
  bool merge_markers = false;
  std::uint64_t seed = 1;
};

/// A level with a simplified boundary. Vertices of the finer level that lie outside of it are interpolated from the
/// nearest triangle. The spacing of the mesh is f of the packing; after
/// LocalImprovement::kFree, which keeps none, half the distance to the nearest vertex.
template <int D>
struct SimplifiedLevel : CoarseLevel<D> {
  double lipschitz = 0;        ///< Of f.
  double area_change = 0;      ///< The largest one of a region, as a part of its area or volume.
  double largest_overlap = 0;  ///< Of two f-spheres: 1 - distance / sum of the radii. 0 if it is a packing.
  std::size_t n_exchanges = 0;
};

/// Coarsens a Delaunay mesh and its boundary with it, beyond what keeps the domain's shape.
///
/// The vertices of each level are some of those of the level before. Its boundary passes some of the boundary vertices
/// in the order of the original one; it does not cross itself, holes stay holes and interfaces interfaces, with their
/// markers. Each level is the boundary-conforming Delaunay mesh of the domain that its own boundary encloses: diametral
/// balls of boundary edges, in space equatorial balls of boundary triangles, are empty, and no simplex is left out.
///
/// In the plane: built from the coarsest level up. A level is packed with vertices of the finest mesh, boundary chains
/// first; where the boundary does not conform, vertices are left out (tips of wedges that are too thin for f), or f is
/// halved. Then vertices are exchanged by simulated annealing, except for those of the next coarser level.
/// Cost: O(n log n) per packing, and `trials` local changes per vertex. Deterministic.
///
/// In space: first the surfaces of all levels, each from the one before, by taking vertices away one by one; then the
/// vertices inside, from the coarsest level up. The hierarchy ends early where a level would not be coarser. No
/// f-spheres overlap. `boundary_distance` is the Hausdorff distance, at most 2 % too small, or below 1 % of the
/// diameter. Cost: O(n log n) per level. The same result for any number of threads.
///
/// Throws: OptionError coarsen.bad_option.
///         InputError  coarsen.not_delaunay, coarsen.not_conforming, coarsen.not_an_edge.
///         Cancelled   if the observer asks to stop.
template <int D>
std::vector<SimplifiedLevel<D>> coarsen_beyond_boundary(const Mesh<D>& mesh, const BeyondBoundaryOptions& options = {},
                                                        Observer& observer = silent_observer());

}  // namespace voropack
