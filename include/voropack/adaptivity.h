// Where a solution bends, how large its error is, and what spacing would make that small with few vertices.
#pragma once

#include <array>
#include <cstddef>

#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/domain.h"
#include "voropack/index.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/norms.h"
#include "voropack/observer.h"
#include "voropack/packing.h"
#include "voropack/spacing.h"

namespace voropack {

/// Derivatives of a solution at the vertices, recovered from its values. Where a vertex is on an interface there is a
/// set for each region: nothing is compared across it, so that kinks of the solution there are no curvature.
template <int D>
struct RecoveredDerivatives {
  IdVector<CellId, Vec<D>> gradient;                            ///< [n_cells]
  IdVector<CellId, std::array<double, D*(D + 1) / 2>> hessian;  ///< [n_cells] xx, xy, yy; 3D: xx, xy, xz, yy, yz, zz.
  IdVector<CellId, double> curvature;                           ///< [n_cells] |H|, the Frobenius norm of the Hessian.
  IdVector<CellId, double> third;                               ///< [n_cells] |grad H|, that of the third derivatives.
  /// [n_faces] on each dual face the mean difference quotient of both ends' polynomials, along the edge, less that of
  /// the values: what the polynomials do not explain.
  EdgeValues misfit;
};

/// Fits a cubic polynomial through the value at each vertex to those of its neighbors in the region and their
/// neighbors, by least squares with weights 1 / distance^2; a quadratic or linear one where these are too few.
/// Throws: InputError adapt.wrong_length.
/// Cost: O(n), some 100 microseconds per vertex in space. The same result for any number of threads.
template <int D>
RecoveredDerivatives<D> recover_derivatives(const ControlVolumes<D>& volumes, const VertexValues& values,
                                            Observer& observer = silent_observer());

/// What is known of the error of a solution by control volumes.
struct ErrorEstimate {
  double w = 0;        ///< || U - U1 ||_W of Theorem 2.1 of [Miller1996]: `smooth` and `rough` together.
  double smooth = 0;   ///< The W norm of `error`.
  double rough = 0;    ///< 0.8 times the W norm of RecoveredDerivatives::misfit: singularities, and unresolved layers.
  VertexValues error;  ///< [n_vertices] u_h - u as far as the recovered derivatives explain it.
  EdgeValues defect;   ///< [n_faces] U1 - U2 on each dual face: difference quotient less mean flux over kappa there.
  double truncation = 0;  ///< || U1 - U2 ||_W; at least `smooth` if kappa = 1, nothing is taken at sites and u is given
                          ///< on the boundary.
};

/// Solves for the error. With e = u_h - u, the exact fluxes U2 and the difference quotients U1 of the exact solution,
///
///     sum_j c_ij (e_i - e_j) + sigma_i |V_i| e_i = sum_j c_ij h_ij (U2_ij - U1_ij) + d_i, e = 0 where u is given.
///
/// U1 - U2 is that of the recovered polynomials, with kappa as it varies over the dual face; d_i is what reaction,
/// sources and Robin conditions add that are taken at sites, by integrals over cells and patches
/// (docs/theory/adaptivity.md). `problem` has to be the one that was solved, with the same `source_integrals`. A
/// problem that depends on u is linearized about `values`. What is given by vertex is taken as constant in cells;
/// conditions inside the domain are not in the estimate. Cost: as `solve`. Throws: as `solve`; InputError
/// adapt.wrong_length.
template <int D>
ErrorEstimate estimate_error(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                             const DiffusionProblem<D>& problem, const VertexValues& values,
                             const RecoveredDerivatives<D>& derivatives, const LinearOptions& options = {},
                             Observer& observer = silent_observer());

struct TargetOptions {
  double n_vertices = 0;  ///< Wanted number of vertices. > 0.
  /// f changes by no more than these factors from one mesh to the next.
  double least_factor = 0.25, largest_factor = 4;
  /// The present mesh resolves the solution: most of the error is ErrorEstimate::smooth. Then third derivatives say how
  /// far a lattice should reach.
  bool is_resolved = false;
};

/// [n_vertices of the present mesh] the spacing that makes the error small with the wanted number of vertices, by the
/// number that the present mesh has for its own spacing, and up to what the Lipschitz condition adds:
///
///     f = k (|H| |grad H|)^(-1 / (D + 3)),
///
/// but with its least value where f is small, and in steps of 2 in space: difference quotients are more accurate on the
/// lattices that constant f gets (docs/theory/adaptivity.md). `spacing` is that of the present mesh at its vertices.
/// Throws: OptionError adapt.bad_option; InputError adapt.wrong_length.
template <int D>
VertexValues target_spacing(const ControlVolumes<D>& volumes, const RecoveredDerivatives<D>& derivatives,
                            const IdVector<VertexId, double>& spacing, const TargetOptions& options);

/// The spacing function through `target_spacing`, for as many vertices as `estimate_sphere_count` says; and not above
/// what `wishes` and the domain's features ask for. If those alone ask for more vertices, there are more.
/// Throws: as `target_spacing` and `build_spacing`.
template <int D>
Spacing<D> adapted_spacing(const Mesh<D>& mesh, const Domain<D>& domain, const ControlVolumes<D>& volumes,
                           const RecoveredDerivatives<D>& derivatives, const TargetOptions& options,
                           const SizeWishes<D>& wishes = {}, const SpacingOptions& spacing_options = {},
                           const PackingOptions& packing = {}, Observer& observer = silent_observer());

}  // namespace voropack
