#include "solve/newton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/iteration_limits.h"
#include "base/parallel.h"
#include "base/place_text.h"
#include "solve/faults.h"
#include "solve/linear_solver.h"
#include "solve/vectors.h"
#include "voropack/error.h"

namespace voropack {

namespace {

void check_options(const NewtonOptions& options) {
  check_iteration_limits("solve.bad_option", "Newton's method", options.tolerance, options.max_steps, "steps");
  if (!(options.smallest_damping > 0 && options.smallest_damping <= 1))
    throw OptionError(
        Fault{.id = "solve.bad_option",
              .message = fmt::format("the smallest damping of Newton's method is {}", options.smallest_damping),
              .fix = "choose it above 0 and at most 1"});
}

/// The equations at one state. Norms are over free vertices.
struct State {
  IdVector<VertexId, double> values;
  CellTerms terms;
  LinearSystem system;
  std::vector<double> residual;  ///< load - matrix values
  double norm = 0;               ///< Of the residual.
  double flow = 0;               ///< Of what each cell exchanges, gains and loses.
  double rounding = 0;           ///< What the norm can be of rounding alone.

  [[nodiscard]] double relative() const { return flow > 0 ? norm / flow : 0.0; }
};

void measure(State& state) {
  const LinearSystem& system = state.system;
  state.residual.resize(state.values.size());
  std::vector<double> flow(state.values.size()), rounding(state.values.size());
  free_residual(system, state.values.raw(), state.residual);
  parallel_for(flow.size(), [&](std::size_t row) {
    const VertexId v(row);
    if (system.is_fixed[v] != 0) return;
    flow[row] = std::abs(system.load[v] - system.absorption[v] * state.values[v]);
    rounding[row] = std::abs(system.load[v]);
    for (std::uint64_t e = system.matrix.offsets[row]; e != system.matrix.offsets[row + 1]; ++e) {
      const VertexId w(system.matrix.columns[e]);
      flow[row] += std::abs(system.matrix.values[e] * (state.values[v] - state.values[w]));
      rounding[row] += std::abs(system.matrix.values[e] * state.values[w]);
    }
  });
  state.norm = norm(state.residual);
  state.flow = norm(flow);
  state.rounding = 4 * std::numeric_limits<double>::epsilon() * norm(rounding);
}

template <int D>
class Newton {
 public:
  Newton(const NonlinearEquations<D>& equations, const NewtonOptions& options, Observer& observer)
      : equations_(equations), options_(options), observer_(observer) {}

  NewtonResult run(IdVector<VertexId, double>& values) {
    fix_values(values);
    State state = state_at(std::move(values));
    refuse_floating(state);
    report_.first_residual = state.relative();
    while (!is_converged(state)) {
      observer_.check_cancelled();
      if (report_.steps.size() == static_cast<std::size_t>(options_.max_steps)) throw_not_converged(state, "");
      state = step(state);
    }
    if (!is_balanced(state)) state = polished(std::move(state));
    report_.residual = state.relative();
    values = std::move(state.values);
    return {std::move(state.terms), std::move(state.system), std::move(linear_), std::move(report_)};
  }

 private:
  [[nodiscard]] bool is_converged(const State& state) const {
    return state.norm <= std::max(options_.tolerance * state.flow, state.rounding);
  }

  /// Whether the residuals of the vertices of each region add up to nothing, against what they exchange with others.
  /// Residuals that are small one by one may all have one sign: they are what is quadratic in the last correction.
  [[nodiscard]] bool is_balanced(const State& state) const {
    constexpr double kBalance = 1e-13;
    const LinearSystem& system = state.system;
    const RegionGroups& groups = equations_.groups;
    std::vector<double> sum(groups.n), exchange(groups.n);
    for (const VertexId v : ids(state.values)) {
      if (system.is_fixed[v] != 0) continue;
      sum[groups.of[v]] += state.residual[v.value()];
      exchange[groups.of[v]] += std::abs(system.load[v] - system.absorption[v] * state.values[v]);
      for (std::uint64_t e = system.matrix.offsets[v.value()]; e != system.matrix.offsets[v.value() + std::size_t{1}];
           ++e) {
        const VertexId w(system.matrix.columns[e]);
        if (system.is_fixed[w] != 0 || groups.of[v] != groups.of[w])
          exchange[groups.of[v]] += std::abs(system.matrix.values[e] * (state.values[v] - state.values[w]));
      }
    }
    for (std::size_t g = 0; g < groups.n; ++g)
      if (std::abs(sum[g]) > kBalance * exchange[g]) return false;
    return true;
  }

  /// One correction more, unless it does harm.
  State polished(State state) {
    const auto is_as_good = [&](const State& trial, double) { return is_converged(trial); };
    if (std::optional<State> next = search(state, correction(state, false), 1, is_as_good)) return std::move(*next);
    return state;
  }

  void fix_values(IdVector<VertexId, double>& values) const {
    const auto patches = evaluate_patches(equations_.volumes, equations_.boundary, equations_.problem.conditions);
    for (std::size_t p = patches.size(); p-- > 0;)  // Backward: the smallest marker wins.
      if (patches[PatchId(p)].is_fixed)
        values[equations_.boundary.patch_vertex[PatchId(p)]] = patches[PatchId(p)].value;
  }

  [[nodiscard]] State state_at(IdVector<VertexId, double> values) const {
    CellTerms terms = evaluate(equations_.volumes, equations_.boundary, equations_.index, equations_.problem, &values);
    LinearSystem system = assemble_terms(equations_.volumes, equations_.boundary, terms, equations_.step);
    State state{.values = std::move(values), .terms = std::move(terms), .system = std::move(system), .residual = {}};
    measure(state);
    return state;
  }

  /// A source that depends on the solution may hold it, anything else is as in linear problems.
  void refuse_floating(const State& state) const {
    if (!state.terms.source_slope.empty() || check_m_matrix(state.system).n_floating == 0) return;
    fail_input("solve.no_condition", "no condition holds the solution in some part: it is free up to a constant",
               "give a Dirichlet or Robin condition on its boundary, or a reaction");
  }

  /// The correction of an undamped step, with the derivatives of all coefficients or with the conductivity held.
  IdVector<VertexId, double> correction(const State& state, bool holds_conductivity) {
    LinearSystem system = state.system;
    CellTerms terms = state.terms;
    if (holds_conductivity) terms.coupling_slope.clear();
    differentiate_terms(equations_.volumes, terms, state.values, system);
    system.load.raw() = state.residual;
    system.fixed_value = IdVector<VertexId, double>(state.values.size());
    LinearSolution solution = LinearSolver(system, options_.linear).solve(system, observer_);
    close_balances(system, equations_.groups, solution);
    linear_ = std::move(solution.report);
    return std::move(solution.values);
  }

  State step(const State& state) {
    // Far from the solution, as with initial values that do not fit the conditions, Newton's method for kappa(u) may
    // run to where nothing conducts, which makes residuals small too. Fixed-point steps do not.
    constexpr double kFarAway = 0.1, kWorthwhile = 0.9;
    if (!state.terms.coupling_slope.empty() && state.relative() > kFarAway && uses_fixed_point_) {
      const auto closer = [&](const State& trial, double) {
        return trial.relative() <= kWorthwhile * state.relative();
      };
      if (std::optional<State> next = search(state, correction(state, true), 0.1, closer)) return std::move(*next);
      uses_fixed_point_ = false;
    }
    // Armijo's rule, with the usual slope. Below rounding there is nothing to gain.
    constexpr double kSufficient = 1e-4;
    const auto falls = [&](const State& trial, double damping) {
      return trial.norm <= (1 - kSufficient * damping) * state.norm || trial.norm <= trial.rounding;
    };
    if (std::optional<State> next = search(state, correction(state, false), options_.smallest_damping, falls))
      return std::move(*next);
    throw_not_converged(state, ", from where no correction however small gains anything");
  }

  /// The first state along the correction that is accepted, by halving.
  template <class Accepts>
  std::optional<State> search(const State& state, const IdVector<VertexId, double>& correction, double smallest_damping,
                              const Accepts& accepts) {
    for (double damping = 1; damping >= smallest_damping; damping /= 2) {
      IdVector<VertexId, double> values = state.values;
      for (const VertexId v : ids(values)) values[v] += damping * correction[v];
      std::optional<State> trial = try_state(std::move(values));
      if (!trial || !accepts(*trial, damping)) continue;
      report_.steps.push_back({trial->relative(), damping, linear_.n_iterations});
      return trial;
    }
    return {};
  }

  /// None if a coefficient leaves its range there: such a state is not an answer, but no fault of the caller's either.
  std::optional<State> try_state(IdVector<VertexId, double> values) const {
    try {
      return state_at(std::move(values));
    } catch (const InputError&) {
      return {};
    }
  }

  [[noreturn]] void throw_not_converged(const State& state, const char* how) const {
    std::size_t worst = 0;
    for (std::size_t v = 0; v < state.residual.size(); ++v)
      if (std::abs(state.residual[v]) > std::abs(state.residual[worst])) worst = v;
    const Vec<D>& x = equations_.volumes.sites[VertexId(worst)];
    throw NumericalError(
        Fault{.id = "solve.not_converged",
              .message = fmt::format("Newton's method reached a residual of {:.3g} of what flows in {} steps{}; it is "
                                     "largest at vertex {} (counted from 0) near {}, where u = {:.6g}",
                                     state.relative(), report_.steps.size(), how, worst, place_text(x),
                                     state.values[VertexId(worst)]),
              .fix = "begin with better initial values, allow more steps, or follow the problem in time",
              .position = {x.coord.begin(), x.coord.end()}});
  }

  const NonlinearEquations<D>& equations_;
  const NewtonOptions& options_;
  Observer& observer_;
  bool uses_fixed_point_ = true;
  NewtonReport report_;
  LinearReport linear_;
};

}  // namespace

template <int D>
NewtonResult run_newton(const NonlinearEquations<D>& equations, const NewtonOptions& options, Observer& observer,
                        IdVector<VertexId, double>& values) {
  check_options(options);
  return Newton<D>(equations, options, observer).run(values);
}

template NewtonResult run_newton(const NonlinearEquations<2>&, const NewtonOptions&, Observer&,
                                 IdVector<VertexId, double>&);
template NewtonResult run_newton(const NonlinearEquations<3>&, const NewtonOptions&, Observer&,
                                 IdVector<VertexId, double>&);

}  // namespace voropack
