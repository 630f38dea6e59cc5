#include "voropack/fem.h"

#include <algorithm>
#include <set>

#include "fem/conditions.h"
#include "fem/flows.h"
#include "solve/conservation.h"
#include "solve/faults.h"
#include "solve/floating_parts.h"

namespace voropack {

namespace {

bool is_zero(const auto& coefficient) {
  const auto* const constant = std::get_if<double>(&coefficient);
  return constant != nullptr && *constant == 0;
}

template <int D>
LinearSystem assemble(const Mesh<D>& mesh, const DiffusionProblem<D>& problem, const Conditions<D>& conditions) {
  const std::size_t n = mesh.points.size();
  LinearSystem system;
  system.matrix = stiffness_matrix(mesh, problem.conductivity);
  system.load = is_zero(problem.source) ? IdVector<VertexId, double>(n, 0.0) : load_vector(mesh, problem.source);
  system.absorption.resize(n);
  if (!is_zero(problem.reaction)) {
    const SparseMatrix mass = mass_matrix(mesh, problem.reaction);  // The same pattern: both list every edge.
    for (std::size_t e = 0; e < mass.values.size(); ++e) system.matrix.values[e] += mass.values[e];
    system.absorption = load_vector(mesh, problem.reaction);
  }
  system.is_fixed.resize(n);
  system.fixed_value.resize(n);
  conditions.add_to(system);
  for (const VertexId v : ids(mesh.points))
    if (system.matrix.offsets[v.value() + std::size_t{1}] - system.matrix.offsets[v.value()] == 1)
      system.is_fixed[v] = 1;
  return system;
}

template <int D>
void refuse_cell_integrals(const DiffusionProblem<D>& problem) {
  if (problem.source_integrals)
    fail_input("solve.cell_integrals",
               "integrals of the source over cells are given, which finite elements do not have",
               "give the source itself");
}

/// The regions that some vertices, ascending, lie in.
template <int D>
std::set<int> regions_of(const Mesh<D>& mesh, const std::vector<VertexId>& vertices) {
  std::set<int> regions;
  for (const SimplexId s : ids(mesh.simplex_vertices))
    if (std::binary_search(vertices.begin(), vertices.end(), mesh.simplex_vertices[s][0]))
      regions.insert(mesh.simplex_region[s]);
  return regions;
}

}  // namespace

template <int D>
LinearSystem assemble_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem) {
  refuse_cell_integrals(problem);
  return assemble(mesh, problem, Conditions<D>(mesh, problem.conditions));
}

template <int D>
DiffusionSolution<D> solve_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem, const LinearOptions& options,
                               Observer& observer) {
  observer.begin_stage("assemble");
  refuse_cell_integrals(problem);
  const Conditions<D> conditions(mesh, problem.conditions);
  LinearSystem system = assemble(mesh, problem, conditions);
  const IdVector<VertexId, double> volume = load_vector<D>(mesh, 1.0);  // The integral of each hat function.
  const std::vector<FloatingPart> parts = ground_floating_parts(
      volume, [&](const std::vector<VertexId>& part) { return regions_of(mesh, part); }, problem.mean, system);

  DiffusionSolution<D> solution;
  solution.matrix = check_m_matrix(system);
  LinearSolution linear = solve_linear_system(system, options, observer);
  const ControlVolumes<D> hats = hat_cells(mesh);
  close_balances(system, region_groups(hats), linear);
  solution.values = std::move(linear.values);
  solution.linear = std::move(linear.report);
  IdVector<VertexId, double> sink(mesh.points.size());
  for (const FloatingPart& part : parts) {
    for (const VertexId v : part.vertices) sink[v] = part.gain / part.volume;
    solution.compensation += part.gain;
  }
  if (problem.mean) shift_to_mean(volume, parts, *problem.mean, solution.values);
  FlowSums sums = add_up_fem_flows(mesh, hats, problem, conditions, sink, solution.values);
  solution.fluxes = std::move(sums.fluxes);
  solution.balances = std::move(sums.balances);
  return solution;
}

template LinearSystem assemble_fem(const Mesh<2>&, const DiffusionProblem<2>&);
template LinearSystem assemble_fem(const Mesh<3>&, const DiffusionProblem<3>&);
template DiffusionSolution<2> solve_fem(const Mesh<2>&, const DiffusionProblem<2>&, const LinearOptions&, Observer&);
template DiffusionSolution<3> solve_fem(const Mesh<3>&, const DiffusionProblem<3>&, const LinearOptions&, Observer&);

}  // namespace voropack
