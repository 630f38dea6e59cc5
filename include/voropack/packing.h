// Stage 3: pack the domain with f-spheres, points first, then segments, facets and volumes. Their centers become the
// vertices.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voropack/domain.h"
#include "voropack/index.h"
#include "voropack/observer.h"
#include "voropack/spacing.h"
#include "voropack/vec.h"

namespace voropack {

/// Which of the three relaxed forms of maximality a packing has ([Miller1996], end of section 3).
enum class PackingForm : std::uint8_t {
  kVoronoi,   ///< No circumcenter of the Delaunay triangulation can be added.
  kMaximal,   ///< Every ball of radius epsilon * f holds a point that cannot be added; made by darts into active cells.
  kFiltered,  ///< The same guarantee; made by sampling every such ball and keeping a maximal independent set.
};

/// What fills the interior, away from lower polytopes and where f is constant enough.
enum class Interior : std::uint8_t {
  kLattice,  ///< Spheres on a lattice: hexagonal in the plane, body-centered cubic in space.
  kRandom,   ///< Darts in random order.
};

struct PackingOptions {
  PackingForm form = PackingForm::kVoronoi;
  Interior interior = Interior::kLattice;    ///< Only for kVoronoi; the other forms are random by definition.
  double epsilon = 0.25;                     ///< Only for kMaximal and kFiltered. In (0, 1].
  std::uint64_t seed = 1;                    ///< Same seed, same packing, for any number of threads.
  std::uint64_t max_vertices = 100'000'000;  ///< Budget. An estimate beyond it is a LimitError before the work.
  int max_repairs = 1000;                    ///< Rounds of shrinking f where a protecting ball is not empty.
};

/// Mean edge length divided by f far from features, measured on uniform packings of the unit cube and square
/// (docs/theory/packing.md).
template <int D>
double edge_per_spacing(const PackingOptions& options) {
  if (options.form != PackingForm::kVoronoi) return D == 3 ? 2.755 : 2.71;
  if (options.interior == Interior::kRandom) return D == 3 ? 2.71 : 2.67;
  return D == 3 ? 3.307 : 3.464;
}

/// A simplex of dimension < D on a polytope whose diametral ball (its *protecting ball*) holds no sphere's center.
template <int K>
struct ProtectedSimplex {
  std::array<SphereId, K + 1> spheres;
  PolytopeId carrier;
};

/// A Delaunay triangulation of points: of their convex hull, or of the part of it that regions cover.
template <int D>
struct Triangulation {
  static constexpr std::uint32_t kNoNeighbor = 0xffffffffU;
  std::vector<std::array<std::uint32_t, D + 1>> simplices;  ///< Indices of points; positively oriented.
  std::vector<std::array<std::uint32_t, D + 1>>
      neighbors;             ///< Entry i is opposite to corner i; kNoNeighbor where it ends.
  std::vector<int> regions;  ///< Index of the RegionId of each simplex. Empty: not assigned.
};

/// f-spheres as parallel arrays of length n, ordered: points, segments, facets, volumes.
///
/// Invariants, checked by `find_packing_fault`:
///  1. radius[s] = f(center[s]) > 0, where f is the spacing function (with the caps of the repairs).
///  2. |center[s] - center[t]| >= radius[s] + radius[t] for s != t, unless they are on two polytopes that meet below 60
///     degrees, neither in the other.
///  3. center[s] lies on the polytope carrier[s], and in no protecting ball.
template <int D>
struct Packing {
  IdVector<SphereId, Vec<D>> center;       ///< [n] position, in domain units.
  IdVector<SphereId, double> radius;       ///< [n] length, in domain units.
  IdVector<SphereId, PolytopeId> carrier;  ///< [n] the polytope of lowest dimension that holds the center.

  std::vector<ProtectedSimplex<1>> subsegments;  ///< Every segment as a chain, segment by segment.
  std::vector<ProtectedSimplex<2>> subfacets;    ///< 3D: every facet as its Delaunay triangles, facet by facet.

  Triangulation<D> triangulation;      ///< Of the regions. Only kVoronoi, whose maximality it proves; else empty.
  std::vector<SpacingCap<D>> repairs;  ///< Where f was shrunk because a protecting ball was not empty.
  int repair_rounds = 0;
  double triangulation_s =
      0;  ///< Wall time in seconds that the Delaunay kernel took of the whole: stage 4 begins here.
};

/// Vertices of an older mesh of the same domain, with which a packing begins.
template <int D>
struct KeptVertices {
  std::vector<Vec<D>> position;     ///< [n]
  std::vector<PolytopeId> carrier;  ///< [n] the polytope of lowest dimension that holds the position.
  /// True: each becomes a center. f must be so small that their f-spheres do not overlap; where one of them lies in a
  /// protecting ball, f shrinks. False: those become centers that fit, lower polytopes first.
  bool all_stay = true;
};

/// Packs every polytope of `domain` in ascending dimension, as algorithm PACKING of [Miller1996], section 3.
///
/// Throws: LimitError packing.too_many_vertices with the estimate and the costliest features: before the work, or as
///         soon as a repair shrinks f so far.
///         InternalError packing.not_conforming if max_repairs rounds do not empty every protecting ball.
///         Cancelled if the observer asks to stop.
template <int D>
Packing<D> pack(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options = {},
                Observer& observer = silent_observer());

/// The same, beginning on each polytope with what `kept` has there: a maximal packing is completed from any start.
template <int D>
Packing<D> pack_around(const KeptVertices<D>& kept, const Domain<D>& domain, const Spacing<D>& spacing,
                       const PackingOptions& options = {}, Observer& observer = silent_observer());

/// The number of spheres that `pack` will need, within some 20 %, from the integral of f^-D. Cheap.
template <int D>
double estimate_sphere_count(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options = {});

/// A place where geometry asks for smaller spheres than the user's sizes do, and what that costs.
template <int D>
struct CostlyFeature {
  enum class Kind : std::uint8_t {
    kGap,     ///< Two polytopes that do not meet come near to each other.
    kAngle,   ///< Two polytopes meet at a small angle.
    kRepair,  ///< f was shrunk to empty a protecting ball for another reason: symmetry, or non-convex facets.
  };
  Kind kind;
  std::array<PolytopeId, 2> polytopes;  ///< The costliest pair; twice the same if only one is known.
  Vec<D> place;             ///< kGap: between their nearest points. kAngle: the nearest point of where they meet.
  double size = 0;          ///< kGap: their distance. kRepair: the diameter of the ball. Length; 0 for kAngle.
  double angle_deg = 0;     ///< kAngle only.
  double vertices = 0;      ///< How many vertices there are because of it.
  std::size_t n_pairs = 1;  ///< Pairs of polytopes counted as one feature, because they are near and of like size.
  double radius = 0;        ///< These pairs lie within this distance of `place`. Length.
};

/// The features that the most vertices of a packing are due to, at most ten, the costliest first.
///
/// `spacing` is the packing's, with the caps of its repairs. A vertex on a polytope of dimension d counts by the part
/// 1 - (f / f')^d, where f' is what f would be without the feature (docs/theory/spacing.md). Where more than ten pairs
/// matter, near ones are joined until the ten make up 80 % of all vertices that are due to geometry. Features of less
/// than one vertex are left out.
template <int D>
std::vector<CostlyFeature<D>> costliest_features(const Domain<D>& domain, const Spacing<D>& spacing,
                                                 const Packing<D>& packing);

/// The same before the work, from the integrals behind `estimate_sphere_count`.
template <int D>
std::vector<CostlyFeature<D>> estimate_costliest_features(const Domain<D>& domain, const Spacing<D>& spacing,
                                                          const PackingOptions& options = {});

/// One line in words: vertices, gap or angle, the polytopes with their markers, the place.
template <int D>
std::string describe(const CostlyFeature<D>& feature, const Domain<D>& domain);

/// The first broken invariant in words, or an empty string. O(n log n). For tests.
template <int D>
std::string find_packing_fault(const Packing<D>& packing, const Domain<D>& domain, const Spacing<D>& spacing);

}  // namespace voropack
