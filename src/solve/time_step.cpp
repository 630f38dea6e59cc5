#include "solve/time_step.h"

#include <utility>

#include "base/parallel.h"
#include "solve/coefficients.h"
#include "solve/faults.h"
#include "solve/newton.h"

namespace voropack {

namespace {

IdVector<PatchId, std::uint8_t> fixed_patches(const IdVector<PatchId, PatchTerm>& patches) {
  IdVector<PatchId, std::uint8_t> is_fixed(patches.size());
  for (const PatchId p : ids(patches)) is_fixed[p] = patches[p].is_fixed ? 1 : 0;
  return is_fixed;
}

/// The mean over each vertex's cells, weighted by what they can store.
template <int D>
IdVector<VertexId, double> vertex_means(const ControlVolumes<D>& volumes, const IdVector<CellId, double>& weight,
                                        const IdVector<CellId, double>& cell_values) {
  IdVector<VertexId, double> values(volumes.sites.size()), weights(volumes.sites.size());
  for (const CellId c : ids(cell_values)) {
    const VertexId v = volumes.cell_vertex[c];
    weights[v] += weight[c];
    // A step towards the new value, so that equal values keep all their bits.
    values[v] += (cell_values[c] - values[v]) * (weight[c] / weights[v]);
  }
  return values;
}

}  // namespace

const LinearSolver& SolverCache::solver_for(const LinearSystem& system, const LinearOptions& options) {
  for (std::size_t k = 0; k < entries_.size(); ++k)
    if (entries_[k] && entries_[k]->matrix == system.matrix && entries_[k]->is_fixed == system.is_fixed) {
      newest_ = k;
      return entries_[k]->solver;
    }
  newest_ = 1 - newest_;
  entries_[newest_].reset();  // First, so that its memory is free.
  entries_[newest_].emplace(Entry{system.matrix, system.is_fixed, LinearSolver(system, options)});
  ++n_made_;
  return entries_[newest_]->solver;
}

template <int D>
TimeStepper<D>::TimeStepper(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                            const TransientProblem<D>& problem, const NewtonOptions& options, Observer& observer)
    : volumes_(volumes),
      boundary_(boundary),
      problem_(problem),
      options_(options),
      observer_(observer),
      index_(volumes),
      groups_(region_groups(volumes)),
      capacity_(
          evaluate_at_sites(volumes, problem.capacity, {"the capacity", "solve.bad_capacity", Range::kPositive})) {
  for (const CellId c : ids(capacity_)) capacity_[c] *= volumes.cell_volume[c];
}

template <int D>
TimeState TimeStepper<D>::start(double time) {
  const DiffusionProblem<D> problem = problem_.at(time);
  const auto initial =
      evaluate_at_sites(volumes_, problem_.initial, {"the initial value", "solve.bad_initial", Range::kFinite});
  TimeState state{.time = time, .values = vertex_means(volumes_, capacity_, initial), .is_fixed = {}, .flows = {}};
  const auto patches = evaluate_patches(volumes_, boundary_, problem.conditions);
  for (std::size_t p = patches.size(); p-- > 0;)  // Backward: the smallest marker wins.
    if (patches[PatchId(p)].is_fixed) state.values[boundary_.patch_vertex[PatchId(p)]] = patches[PatchId(p)].value;
  state.is_fixed = fixed_patches(patches);
  state.flows =
      flows_at(volumes_, boundary_, evaluate(volumes_, boundary_, index_, problem, &state.values), state.values);
  return state;
}

/// With R(u) = A(u) u - b, what leaves a cell, the step from u0 to u solves
/// C (u - u0) / length + theta R(u) + (1 - theta) R(u0) = 0; divided by theta, this is R(u) = 0 with further terms.
template <int D>
StepTerms TimeStepper<D>::step_terms(const TimeState& from, double length, double implicitness) const {
  StepTerms step{IdVector<VertexId, double>(volumes_.sites.size()), IdVector<VertexId, double>(volumes_.sites.size())};
  const double explicit_part = (1 - implicitness) / implicitness;
  for (const CellId c : ids(capacity_)) {
    const VertexId v = volumes_.cell_vertex[c];
    const double storage = capacity_[c] / (implicitness * length);
    step.storage[v] += storage;
    step.load[v] += storage * from.values[v];
    if (explicit_part > 0) step.load[v] -= explicit_part * from.flows.deficit[c];
  }
  return step;
}

template <int D>
void TimeStepper<D>::check_matrix(const LinearSystem& system) {
  if (!matrix_) matrix_ = check_m_matrix(system);
}

template <int D>
CellTerms TimeStepper<D>::solve_linear(const DiffusionProblem<D>& problem, const StepTerms& step,
                                       IdVector<VertexId, double>& values, TransientStep<D>& record) {
  CellTerms terms = evaluate(volumes_, boundary_, index_, problem);
  const LinearSystem system = assemble_terms(volumes_, boundary_, terms, &step);
  check_matrix(system);
  LinearSolution linear = cache_.solver_for(system, options_.linear).solve(system, observer_, &values);
  close_balances(system, groups_, linear);
  values = std::move(linear.values);
  linear_ = std::move(linear.report);
  record.linear_iterations = linear_.n_iterations;
  return terms;
}

template <int D>
CellTerms TimeStepper<D>::solve_newton(const DiffusionProblem<D>& problem, const StepTerms& step,
                                       IdVector<VertexId, double>& values, TransientStep<D>& record) {
  NewtonResult result =
      run_newton<D>({volumes_, boundary_, index_, groups_, problem, &step}, options_, observer_, values);
  check_matrix(result.system);
  linear_ = std::move(result.linear);
  record.newton = std::move(result.newton.steps);
  n_newton_ += record.newton.size();
  for (const NewtonStep& newton : record.newton) record.linear_iterations += newton.linear_iterations;
  return std::move(result.terms);
}

template <int D>
std::optional<TimeStep<D>> TimeStepper<D>::advance(const TimeState& from, double time, double length,
                                                   double implicitness) {
  observer_.check_cancelled();
  const DiffusionProblem<D> problem = problem_.at(time);
  if (problem.mean)
    fail_input("solve.mean_not_free", "a mean is given, but the initial values decide about it", "leave out the mean");
  TimeStep<D> step{{.time = time, .values = from.values, .is_fixed = {}, .flows = {}}, {}};
  step.to.is_fixed = fixed_patches(evaluate_patches(volumes_, boundary_, problem.conditions));
  if (implicitness < 1 && step.to.is_fixed != from.is_fixed) return {};

  const StepTerms step_part = step_terms(from, length, implicitness);
  const CellTerms terms = depends_on_solution(problem) ? solve_newton(problem, step_part, step.to.values, step.record)
                                                       : solve_linear(problem, step_part, step.to.values, step.record);
  step.to.flows = flows_at(volumes_, boundary_, terms, step.to.values);
  Flows mean = step.to.flows;
  if (implicitness < 1) blend_flows(mean, from.flows, implicitness);
  IdVector<CellId, double> stored(capacity_.size());
  for (const CellId c : ids(stored)) {
    const VertexId v = volumes_.cell_vertex[c];
    stored[c] = capacity_[c] * ((step.to.values[v] - from.values[v]) / length);
  }
  add_storage(mean, stored);
  FlowSums sums = add_up_flows(volumes_, boundary_, terms, mean);
  step.record.time = time;
  step.record.length = length;
  step.record.values = step.to.values;
  step.record.fluxes = std::move(sums.fluxes);
  step.record.balances = std::move(sums.balances);
  return step;
}

template class TimeStepper<2>;
template class TimeStepper<3>;

}  // namespace voropack
