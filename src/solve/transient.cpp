#include "voropack/transient.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "solve/check_volumes.h"
#include "solve/time_step.h"
#include "voropack/error.h"

namespace voropack {

namespace {

void check_options(const TimeOptions& options) {
  const auto require = [](bool is_good, std::string message, std::string fix) {
    if (!is_good)
      throw OptionError(Fault{.id = "solve.bad_option", .message = std::move(message), .fix = std::move(fix)});
  };
  require(std::isfinite(options.begin) && std::isfinite(options.end) && options.begin < options.end,
          fmt::format("time begins at {} and ends at {}", options.begin, options.end), "let it end later");
  require(options.step > 0 && std::isfinite(options.step), fmt::format("the time step is {}", options.step),
          "make it positive");
  require(options.n_startup >= 0, fmt::format("there are {} startup steps", options.n_startup), "allow 0 or more");
  require(!options.tolerance || (*options.tolerance > 0 && std::isfinite(*options.tolerance)),
          fmt::format("the tolerance of a time step is {}", options.tolerance.value_or(0)), "make it positive");
  require(options.smallest_step >= 0 && std::isfinite(options.smallest_step),
          fmt::format("the smallest time step is {}", options.smallest_step), "make it 0 or positive");
}

double largest_difference(const IdVector<VertexId, double>& a, const IdVector<VertexId, double>& b) {
  double largest = 0;
  for (const VertexId v : ids(a)) largest = std::max(largest, std::abs(a[v] - b[v]));
  return largest;
}

/// Chooses steps, fixed or adaptive, and hands them on.
template <int D>
class March {
 public:
  using Steps = std::vector<TimeStep<D>>;

  March(TimeStepper<D>& stepper, const TimeOptions& options, const StepCallback<D>& on_step, Observer& observer)
      : stepper_(stepper), options_(options), on_step_(on_step), observer_(observer) {
    if (options.scheme == TimeScheme::kCrankNicolson) startup_left_ = options.n_startup;
  }

  TransientSolution<D> run() {
    state_ = stepper_.start(options_.begin);
    if (on_step_) {
      TransientStep<D> initial;
      initial.time = options_.begin;
      initial.values = state_.values;
      on_step_(initial);
    }
    options_.tolerance ? run_adaptive() : run_fixed();
    solution_.values = std::move(state_.values);
    solution_.matrix = stepper_.matrix().value_or(MatrixCheck{});
    solution_.linear = stepper_.linear();
    solution_.report.n_factorizations = stepper_.n_factorizations();
    return std::move(solution_);
  }

 private:
  [[nodiscard]] bool is_euler() const { return options_.scheme == TimeScheme::kBackwardEuler; }
  /// Whether a step is made as two backward Euler steps of half its length.
  [[nodiscard]] bool is_startup() const { return startup_left_ > 0; }
  [[nodiscard]] int order() const { return is_euler() || is_startup() ? 1 : 2; }

  void run_fixed() {
    const double duration = options_.end - options_.begin;
    // A step that fits but for rounding is not divided.
    const double n = std::max(1.0, std::ceil(duration / options_.step * (1 - 1e-12)));
    if (!(n <= static_cast<double>(options_.max_steps))) throw_too_many(n);
    const auto n_steps = static_cast<std::uint64_t>(n);
    for (std::uint64_t k = 1; k <= n_steps; ++k) {
      const double time = k == n_steps ? options_.end : options_.begin + duration * (static_cast<double>(k) / n);
      accept(make(state_, time, duration / n));
      end_startup_step();
      observer_.progress(k, n_steps);
    }
  }

  void run_adaptive() {
    const double duration = options_.end - options_.begin;
    const double smallest = options_.smallest_step > 0 ? options_.smallest_step : 1e-12 * duration;
    double length = std::min(options_.step, duration);
    while (state_.time < options_.end) {
      const double left = options_.end - state_.time;
      const bool is_last = length >= left * (1 - 1e-12);
      const double trial_length = is_last ? left : length;
      const int n_halvings = try_step(is_last ? options_.end : state_.time + trial_length, trial_length);
      if (n_halvings > 0) {
        length = std::ldexp(trial_length, -n_halvings);
        if (length < smallest) throw_too_small(length);
      } else if (n_halvings < 0 && !is_last) {
        length *= 2;
      }
      observer_.progress(static_cast<std::uint64_t>(1000 * ((state_.time - options_.begin) / duration)), 1000);
    }
  }

  /// Makes a step at once and in two halves, and keeps the halves if they agree. Returns how often the next step has to
  /// be halved: more than 0 if this one was rejected, -1 if it may be doubled.
  int try_step(double time, double length) {
    constexpr double kSafety = 0.7;    // Of the error that is expected after a change of length.
    constexpr int kMostHalvings = 10;  // At once.
    double error = 0;
    Steps halves;
    const int order_before = order();
    try {
      const TimeState whole = std::move(make(state_, time, length).back().to);
      halves = make(state_, state_.time + 0.5 * length, 0.5 * length);
      for (TimeStep<D>& step : make(halves.back().to, time, 0.5 * length)) halves.push_back(std::move(step));
      error = largest_difference(whole.values, halves.back().to.values) / (order_before == 1 ? 1 : 3);
    } catch (const NumericalError&) {  // A shorter step is easier for Newton's method.
      ++solution_.report.n_rejected;
      return 1;
    }
    const double growth = std::ldexp(1.0, order_before + 1);
    if (!(error <= *options_.tolerance)) {
      ++solution_.report.n_rejected;
      const double n = std::ceil(std::log2(error / (kSafety * *options_.tolerance)) / (order_before + 1));
      return std::isfinite(n) ? std::clamp(static_cast<int>(std::min(n, 1e3)), 1, kMostHalvings) : kMostHalvings;
    }
    accept(std::move(halves));
    end_startup_step();
    return error * growth <= kSafety * *options_.tolerance ? -1 : 0;
  }

  void end_startup_step() { startup_left_ = std::max(0, startup_left_ - 1); }

  /// One step of the scheme, which may consist of several.
  Steps make(const TimeState& from, double time, double length) {
    Steps steps;
    if (is_euler() || !is_startup()) {
      auto step = stepper_.advance(from, time, length, is_euler() ? 1.0 : 0.5);
      if (step) {
        steps.push_back(std::move(*step));
        return steps;
      }
      startup_left_ = std::max(1, options_.n_startup);  // Other vertices are fixed now.
    }
    steps.push_back(*stepper_.advance(from, from.time + 0.5 * length, 0.5 * length, 1));
    steps.push_back(*stepper_.advance(steps.front().to, time, 0.5 * length, 1));
    return steps;
  }

  void accept(Steps steps) {
    TransientReport& report = solution_.report;
    for (TimeStep<D>& step : steps) {
      if (report.n_steps == options_.max_steps) throw_too_many(0);
      ++report.n_steps;
      report.linear_iterations += static_cast<std::uint64_t>(step.record.linear_iterations);
      report.shortest_step =
          report.n_steps == 1 ? step.record.length : std::min(report.shortest_step, step.record.length);
      report.longest_step = std::max(report.longest_step, step.record.length);
      if (on_step_) on_step_(step.record);
      state_ = std::move(step.to);
    }
  }

  [[noreturn]] void throw_too_small(double length) const {
    throw NumericalError(
        Fault{.id = "solve.step_too_small",
              .message = fmt::format("after time {:.6g} a step of {:.3g} would be needed", state_.time, length),
              .fix = "raise the tolerance, or look for jumps of the data at this time"});
  }
  [[noreturn]] void throw_too_many(double needed) const {
    throw LimitError(Fault{
        .id = "solve.too_many_steps",
        .message = needed > 0 ? fmt::format("{:.6g} time steps are needed, and {} allowed", needed, options_.max_steps)
                              : fmt::format("{} time steps reach time {:.6g} only", options_.max_steps, state_.time),
        .fix = "allow more steps, or make them longer"});
  }

  TimeStepper<D>& stepper_;
  const TimeOptions& options_;
  const StepCallback<D>& on_step_;
  Observer& observer_;
  TimeState state_;
  int startup_left_ = 0;
  TransientSolution<D> solution_;
};

}  // namespace

template <int D>
TransientSolution<D> solve_transient(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                     const TransientProblem<D>& problem, const TimeOptions& options,
                                     const StepCallback<D>& on_step, Observer& observer) {
  observer.begin_stage("time steps");
  check_options(options);
  if (!problem.at)
    throw OptionError(Fault{.id = "solve.bad_option",
                            .message = "no problem is given",
                            .fix = "set TransientProblem::at to a function of time"});
  check_volumes(volumes, boundary);
  TimeStepper<D> stepper(volumes, boundary, problem, options.newton, observer);
  return March<D>(stepper, options, on_step, observer).run();
}

template TransientSolution<2> solve_transient(const ControlVolumes<2>&, const BoundaryAreas<2>&,
                                              const TransientProblem<2>&, const TimeOptions&, const StepCallback<2>&,
                                              Observer&);
template TransientSolution<3> solve_transient(const ControlVolumes<3>&, const BoundaryAreas<3>&,
                                              const TransientProblem<3>&, const TimeOptions&, const StepCallback<3>&,
                                              Observer&);

}  // namespace voropack
