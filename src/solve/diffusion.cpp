#include "voropack/diffusion.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "solve/assemble.h"
#include "solve/balance.h"
#include "solve/cell_index.h"
#include "solve/check_volumes.h"
#include "solve/coefficients.h"
#include "solve/conservation.h"
#include "solve/floating_parts.h"

namespace voropack {

namespace {

/// The regions that some vertices, ascending, have cells in.
template <int D>
std::set<int> regions_of(const ControlVolumes<D>& volumes, const std::vector<VertexId>& vertices) {
  std::set<int> regions;
  for (const CellId c : ids(volumes.cell_vertex))
    if (std::binary_search(vertices.begin(), vertices.end(), volumes.cell_vertex[c]))
      regions.insert(volumes.cell_region[c]);
  return regions;
}

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
  check_volumes(volumes, boundary);
  CellTerms terms = evaluate(volumes, boundary, CellIndex(volumes), problem);
  LinearSystem system = assemble_terms(volumes, boundary, terms);
  const IdVector<VertexId, double> volume = vertex_volumes(volumes);
  const std::vector<FloatingPart> parts = ground_floating_parts(
      volume, [&](const std::vector<VertexId>& part) { return regions_of(volumes, part); }, problem.mean, system);

  DiffusionSolution<D> solution;
  solution.matrix = check_m_matrix(system);
  LinearSolution linear = solve_linear_system(system, options, observer);
  close_balances(system, region_groups(volumes), linear);
  solution.values = std::move(linear.values);
  solution.linear = std::move(linear.report);
  if (!parts.empty()) {
    shift_to_mean(volume, parts, *problem.mean, solution.values);
    compensate(volumes, parts, terms.source);
    for (const FloatingPart& part : parts) solution.compensation += part.gain;
  }
  FlowSums sums = add_up_flows(volumes, boundary, terms, flows_at(volumes, boundary, terms, solution.values));
  solution.fluxes = std::move(sums.fluxes);
  solution.balances = std::move(sums.balances);
  return solution;
}

template DiffusionSolution<2> solve(const ControlVolumes<2>&, const BoundaryAreas<2>&, const DiffusionProblem<2>&,
                                    const LinearOptions&, Observer&);
template DiffusionSolution<3> solve(const ControlVolumes<3>&, const BoundaryAreas<3>&, const DiffusionProblem<3>&,
                                    const LinearOptions&, Observer&);

}  // namespace voropack
