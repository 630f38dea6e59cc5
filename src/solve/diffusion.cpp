#include "voropack/diffusion.h"

#include <cstdint>
#include <map>
#include <vector>

#include "solve/assemble.h"
#include "solve/balance.h"
#include "solve/coefficients.h"
#include "solve/conservation.h"
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

/// Numbers the regions, and puts each vertex into the group of its region; those on interfaces form one more.
template <int D>
IdVector<VertexId, std::uint32_t> region_groups(const ControlVolumes<D>& volumes, std::uint32_t& n_groups) {
  std::map<int, std::uint32_t> number;
  for (const int region : volumes.cell_region) number.try_emplace(region, static_cast<std::uint32_t>(number.size()));
  const auto interface = static_cast<std::uint32_t>(number.size());
  n_groups = interface + 1;
  IdVector<VertexId, std::uint32_t> group(volumes.sites.size());
  for (const CellId c : ids(volumes.cell_vertex)) {
    const bool repeats =
        c.value() > 0 && volumes.cell_vertex[CellId(c.value() - std::size_t{1})] == volumes.cell_vertex[c];
    group[volumes.cell_vertex[c]] = repeats ? interface : number.at(volumes.cell_region[c]);
  }
  return group;
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
  std::uint32_t n_groups = 0;
  const auto group = region_groups(volumes, n_groups);
  close_balances(system, group, n_groups, linear);
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
