#include "voropack/nonlinear.h"

#include <utility>

#include "solve/balance.h"
#include "solve/check_volumes.h"
#include "solve/faults.h"
#include "solve/newton.h"

namespace voropack {

template <int D>
NonlinearSolution<D> solve_nonlinear(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                     const DiffusionProblem<D>& problem, const IdVector<VertexId, double>& initial,
                                     const NewtonOptions& options, Observer& observer) {
  observer.begin_stage("solve");
  check_volumes(volumes, boundary);
  if (problem.mean)
    fail_input("solve.nonlinear_mean", "a mean is given for a nonlinear problem",
               "leave it out, and hold the solution by a condition");
  IdVector<VertexId, double> values = initial;
  if (initial.empty()) values.resize(volumes.sites.size());
  check_length(values, volumes.sites.size(), "the initial solution");
  const CellIndex index(volumes);
  const RegionGroups groups = region_groups(volumes);
  NewtonResult result = run_newton<D>({volumes, boundary, index, groups, problem}, options, observer, values);

  NonlinearSolution<D> solution;
  solution.newton = std::move(result.newton);
  DiffusionSolution<D>& state = solution.state;
  state.matrix = check_m_matrix(result.system);
  state.linear = std::move(result.linear);
  FlowSums sums = add_up_flows(volumes, boundary, result.terms, flows_at(volumes, boundary, result.terms, values));
  state.values = std::move(values);
  state.fluxes = std::move(sums.fluxes);
  state.balances = std::move(sums.balances);
  return solution;
}

template NonlinearSolution<2> solve_nonlinear(const ControlVolumes<2>&, const BoundaryAreas<2>&,
                                              const DiffusionProblem<2>&, const IdVector<VertexId, double>&,
                                              const NewtonOptions&, Observer&);
template NonlinearSolution<3> solve_nonlinear(const ControlVolumes<3>&, const BoundaryAreas<3>&,
                                              const DiffusionProblem<3>&, const IdVector<VertexId, double>&,
                                              const NewtonOptions&, Observer&);

}  // namespace voropack
