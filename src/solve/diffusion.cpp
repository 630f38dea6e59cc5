#include "voropack/diffusion.h"

#include <vector>

#include "solve/assemble.h"
#include "solve/balance.h"
#include "solve/coefficients.h"
#include "solve/floating_parts.h"

namespace voropack {

namespace {

/// Takes from the source of each cell what was taken from the load of its vertex.
template <int D>
void compensate(const ControlVolumes<D>& volumes, const std::vector<FloatingPart>& parts,
                IdVector<CellId, double>& source) {
  IdVector<VertexId, double> sink(volumes.sites.size());
  for (const FloatingPart& part : parts)
    for (const VertexId v : part.vertices) sink[v] = part.gain / part.volume;
  for (const CellId c : ids(source)) source[c] -= sink[volumes.cell_vertex[c]] * volumes.cell_volume[c];
}

}  // namespace

template <int D>
DiffusionSolution<D> solve(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                           const DiffusionProblem<D>& problem, const LinearOptions& options, Observer& observer) {
  observer.begin_stage("assemble");
  CellTerms terms = evaluate(volumes, boundary, problem);
  LinearSystem system = assemble_terms(volumes, boundary, terms);
  const std::vector<FloatingPart> parts = ground_floating_parts(volumes, problem.mean, system);

  DiffusionSolution<D> solution;
  solution.matrix = check_m_matrix(system);
  LinearSolution linear = solve_linear_system(system, options, observer);
  solution.values = std::move(linear.values);
  solution.linear = std::move(linear.report);
  if (!parts.empty()) {
    shift_to_mean(volumes, parts, *problem.mean, solution.values);
    compensate(volumes, parts, terms.source);
    for (const FloatingPart& part : parts) solution.compensation += part.gain;
  }
  add_up_flows(volumes, boundary, terms, solution);
  return solution;
}

template DiffusionSolution<2> solve(const ControlVolumes<2>&, const BoundaryAreas<2>&, const DiffusionProblem<2>&,
                                    const LinearOptions&, Observer&);
template DiffusionSolution<3> solve(const ControlVolumes<3>&, const BoundaryAreas<3>&, const DiffusionProblem<3>&,
                                    const LinearOptions&, Observer&);

}  // namespace voropack
