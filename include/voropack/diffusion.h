// Stage 8: ControlVolumes<D>, BoundaryAreas<D> and a diffusion problem -> its solution by the control volume method.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "voropack/boundary_areas.h"
#include "voropack/linear_system.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack {

/// A function of position and region. On an interface it is asked once for each region.
template <int D>
using RegionFunction = std::function<double(const Vec<D>& x, int region)>;

/// A function of position, region and the solution u there. It makes a problem nonlinear (voropack/nonlinear.h).
template <int D>
struct StateFunction {
  std::function<double(const Vec<D>& x, int region, double u)> value;
  std::function<double(const Vec<D>& x, int region, double u)> derivative;  ///< By u. If absent, by differences.
};

/// A coefficient of the equation: a number, a number for each region, a number for each vertex, or a function.
template <int D>
using Coefficient =
    std::variant<double, std::map<int, double>, IdVector<VertexId, double>, RegionFunction<D>, StateFunction<D>>;

/// A value given on the boundary: a number, or a function of position.
template <int D>
using BoundaryValue = std::variant<double, std::function<double(const Vec<D>& x)>>;

/// u = value.
template <int D>
struct Dirichlet {
  BoundaryValue<D> value = 0.0;
};
/// kappa du/dn = inflow, where n points outward: what enters per area.
template <int D>
struct Neumann {
  BoundaryValue<D> inflow = 0.0;
};
/// kappa du/dn = transfer (outside - u), transfer >= 0.
template <int D>
struct Robin {
  BoundaryValue<D> transfer = 0.0;
  BoundaryValue<D> outside = 0.0;
};
/// As much as `total` enters on the whole, spread evenly: a Neumann condition with inflow = total / area.
template <int D>
struct Rate {
  double total = 0;
};
template <int D>
using BoundaryCondition = std::variant<Dirichlet<D>, Neumann<D>, Robin<D>, Rate<D>>;

/// -div(conductivity grad u) + reaction u = source, with a condition for each marker of the boundary. Nothing enters
/// through a boundary whose marker has no condition.
///
/// Markers inside the domain, such as those of wells, may have conditions as well, if `build_boundary_areas` was asked
/// for them. An area is then that of both sides together, or the length of segments, or the number of points.
///
/// A vertex on markers with different Dirichlet values takes that of the smallest marker.
template <int D>
struct DiffusionProblem {
  Coefficient<D> conductivity = 1.0;  ///< kappa > 0. May depend on u.
  Coefficient<D> reaction = 0.0;      ///< sigma >= 0.
  Coefficient<D> source = 0.0;        ///< f, per volume. May depend on u.
  /// [n_cells] the integral of the source over each cell; if absent, volume times the value at the site.
  std::optional<IdVector<CellId, double>> source_integrals;
  std::map<int, BoundaryCondition<D>> conditions;  ///< By marker.
  /// The mean of u over each connected part that is free up to a constant (Neumann conditions only, no reaction). What
  /// such a part gains on the whole has to vanish; up to 1 percent of what goes in and out is put down to the
  /// quadrature and spread evenly over its volume.
  std::optional<double> mean;
};

/// What goes through the boundary faces of one marker.
struct MarkerFlux {
  int marker = 0;
  double area = 0;
  double inflow = 0;  ///< Integral of kappa du/dn.
};

/// What one region gains and loses per time. The sum of the gains is `imbalance`: the residual of the solution, summed.
struct RegionBalance {
  int region = 0;
  double volume = 0;
  double source = 0;            ///< Integral of f.
  double absorbed = 0;          ///< Integral of sigma u.
  double boundary_inflow = 0;   ///< Through the domain's boundary.
  double interface_inflow = 0;  ///< From other regions.
  double stored = 0;            ///< Integral of capacity du/dt; 0 where nothing depends on time.
  double imbalance = 0;         ///< source - absorbed + boundary_inflow + interface_inflow - stored
  double throughput = 0;        ///< The magnitudes of all of it, cell by cell: what to compare `imbalance` with.
};

template <int D>
struct DiffusionSolution {
  IdVector<VertexId, double> values;    ///< [n_vertices] u.
  std::vector<MarkerFlux> fluxes;       ///< One for each marker of the boundary, ascending.
  std::vector<RegionBalance> balances;  ///< One for each region, ascending.
  MatrixCheck matrix;
  LinearReport linear;
  double compensation = 0;  ///< Source that was taken away so that a problem without Dirichlet conditions is solvable.
};

/// The matrix and load of the control volume method, with unknowns at the vertices:
///
///     sum_j c_ij (u_i - u_j) + sigma_i |V_i| u_i = f_i |V_i| + what enters through the boundary,
///     c_ij = sum over regions r of kappa_r |A_ij^r| / h_ij.
///
/// Where kappa varies within a region, c_ij takes the harmonic mean of its values at i and j. A matrix of control
/// volumes without negative areas is an M-matrix.
/// Cost: O(n): some 20 products of the matrix and a vector. The same result for any number of threads.
/// Throws: InputError solve.bad_volumes      if arrays do not fit together, or a number is not finite.
///         InputError solve.unknown_marker   if no boundary has the marker of a condition; names the nearest.
///         InputError solve.unknown_region   if a coefficient names a region that is not there, or misses one.
///         InputError solve.wrong_length     if a coefficient per vertex or cell has another length.
///         InputError solve.bad_conductivity if kappa is not positive and finite somewhere; the message says where.
///         InputError solve.bad_reaction     if sigma is negative or not finite.
///         InputError solve.bad_source       if f is not finite.
///         InputError solve.bad_condition    if a value on the boundary is not finite or a transfer is negative.
///         InputError solve.nonlinear        if a coefficient depends on u: `solve_nonlinear` takes it.
template <int D>
LinearSystem assemble(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                      const DiffusionProblem<D>& problem);

/// Assembles and solves, and adds up what flows where.
///
/// Throws as `assemble` and `solve_linear_system`, and
///         InputError solve.no_condition  if a part is free up to a constant and no mean is given; names its regions.
///         InputError solve.mean_not_free if a mean is given and no part is free.
///         InputError solve.incompatible  if such a part gains or loses.
template <int D>
DiffusionSolution<D> solve(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                           const DiffusionProblem<D>& problem, const LinearOptions& options = {},
                           Observer& observer = silent_observer());

}  // namespace voropack
