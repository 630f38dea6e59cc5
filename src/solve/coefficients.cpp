#include "solve/coefficients.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "base/place_text.h"
#include "solve/check_volumes.h"
#include "solve/faults.h"

namespace voropack {

namespace {

using Solution = IdVector<VertexId, double>;

bool lies_in(double value, Range range) {
  return std::isfinite(value) && (range == Range::kFinite || value > 0 || (range == Range::kNotNegative && value == 0));
}

std::string_view wanted(Range range) {
  return range == Range::kFinite        ? "make it finite"
         : range == Range::kNotNegative ? "make it finite and not negative"
                                        : "make it finite and positive";
}

template <int D>
void check_range(const ControlVolumes<D>& volumes, const IdVector<CellId, double>& values, const Quantity& quantity) {
  const std::size_t bad =
      first_bad(values.size(), [&](std::size_t i) { return lies_in(values[CellId(i)], quantity.range); });
  if (bad == values.size()) return;
  const CellId c(bad);
  const VertexId v = volumes.cell_vertex[c];
  const Vec<D>& x = volumes.sites[v];
  fail_input(std::string(quantity.fault),
             fmt::format("{} is {} in region {} at vertex {} (counted from 0) near {}", quantity.name, values[c],
                         volumes.cell_region[c], v.value(), place_text(x)),
             std::string(wanted(quantity.range)), {x.coord.begin(), x.coord.end()});
}

/// The value of a coefficient at the site of each cell, for a solution if there is one.
template <int D>
class Evaluator {
 public:
  Evaluator(const ControlVolumes<D>& volumes, const Quantity& quantity, const Solution* solution)
      : volumes_(volumes), quantity_(quantity), solution_(solution) {}

  IdVector<CellId, double> operator()(const Coefficient<D>& coefficient) const {
    IdVector<CellId, double> values(volumes_.cell_vertex.size());
    std::visit([&](const auto& given) { fill(given, values); }, coefficient);
    check_range(volumes_, values, quantity_);
    return values;
  }

 private:
  void fill(double value, IdVector<CellId, double>& values) const { std::fill(values.begin(), values.end(), value); }

  void fill(const std::map<int, double>& by_region, IdVector<CellId, double>& values) const {
    check_regions(by_region, {volumes_.cell_region.begin(), volumes_.cell_region.end()}, quantity_.name);
    for (const CellId c : ids(values)) values[c] = by_region.at(volumes_.cell_region[c]);
  }

  void fill(const IdVector<VertexId, double>& by_vertex, IdVector<CellId, double>& values) const {
    check_length(by_vertex, volumes_.sites.size(), quantity_.name);
    for (const CellId c : ids(values)) values[c] = by_vertex[volumes_.cell_vertex[c]];
  }

  void fill(const RegionFunction<D>& function, IdVector<CellId, double>& values) const {
    parallel_for(values.size(), [&](std::size_t i) {
      const CellId c(i);
      values[c] = function(volumes_.sites[volumes_.cell_vertex[c]], volumes_.cell_region[c]);
    });
  }

  void fill(const StateFunction<D>& function, IdVector<CellId, double>& values) const {
    if (solution_ == nullptr)
      refuse_state_function(quantity_.name, "call solve_nonlinear for conductivity and source; nothing else may");
    parallel_for(values.size(), [&](std::size_t i) {
      const CellId c(i);
      const VertexId v = volumes_.cell_vertex[c];
      values[c] = function.value(volumes_.sites[v], volumes_.cell_region[c], (*solution_)[v]);
    });
  }

  const ControlVolumes<D>& volumes_;
  Quantity quantity_;
  const Solution* solution_;
};

/// The derivative by u at u, by central differences, or one-sided ones where the function ends.
double difference_quotient(const std::function<double(double)>& function, double u, double step) {
  const double low = function(u - step), high = function(u + step);
  if (std::isfinite(low) && std::isfinite(high)) return (high - low) / ((u + step) - (u - step));
  const double middle = function(u);
  return std::isfinite(high) ? (high - middle) / ((u + step) - u) : (middle - low) / (u - (u - step));
}

/// The derivative of a coefficient by the solution at each cell; empty if it does not depend on it.
template <int D>
IdVector<CellId, double> derivatives(const ControlVolumes<D>& volumes, const Coefficient<D>& coefficient,
                                     const Solution& solution, const Quantity& quantity) {
  const auto* const function = std::get_if<StateFunction<D>>(&coefficient);
  if (function == nullptr) return {};
  double scale = 0;
  for (const double u : solution) scale = std::max(scale, std::abs(u));
  // The error of central differences is least for a step of about the cube root of rounding.
  const double relative_step = std::cbrt(std::numeric_limits<double>::epsilon());
  IdVector<CellId, double> slope(volumes.cell_vertex.size());
  parallel_for(slope.size(), [&](std::size_t i) {
    const CellId c(i);
    const VertexId v = volumes.cell_vertex[c];
    const Vec<D>& x = volumes.sites[v];
    const int region = volumes.cell_region[c];
    slope[c] = function->derivative ? function->derivative(x, region, solution[v])
                                    : difference_quotient([&](double u) { return function->value(x, region, u); },
                                                          solution[v], relative_step * (scale > 0 ? scale : 1.0));
  });
  check_range(volumes, slope, quantity);
  return slope;
}

/// The terms of the patches of one marker.
template <int D>
class PatchEvaluator {
 public:
  PatchEvaluator(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary)
      : volumes_(volumes), boundary_(boundary) {
    for (const PatchId p : ids(boundary.patch_marker)) marker_area_[boundary.patch_marker[p]] += boundary.patch_area[p];
  }

  /// The area of each marker of the boundary.
  [[nodiscard]] const std::map<int, double>& marker_areas() const { return marker_area_; }

  PatchTerm operator()(PatchId p, const BoundaryCondition<D>& condition) const {
    return std::visit([&](const auto& c) { return term(p, c); }, condition);
  }

 private:
  PatchTerm term(PatchId p, const Dirichlet<D>& c) const {
    return {.is_fixed = true,
            .value = value_at(p, volumes_.sites[boundary_.patch_vertex[p]], c.value, "value", Range::kFinite)};
  }
  PatchTerm term(PatchId p, const Neumann<D>& c) const {
    const double inflow = value_at(p, boundary_.patch_centroid[p], c.inflow, "inflow", Range::kFinite);
    return {.inflow = inflow * boundary_.patch_area[p]};
  }
  PatchTerm term(PatchId p, const Rate<D>& c) const {
    const double area = marker_area_.at(boundary_.patch_marker[p]);
    const double density = area > 0 ? c.total / area : std::numeric_limits<double>::quiet_NaN();
    const double inflow = value_at(p, boundary_.patch_centroid[p], density, "rate per area", Range::kFinite);
    return {.inflow = inflow * boundary_.patch_area[p]};
  }
  /// Both where u is taken, so that what drives the flow is consistent.
  PatchTerm term(PatchId p, const Robin<D>& c) const {
    const Vec<D>& x = volumes_.sites[boundary_.patch_vertex[p]];
    const double transfer = value_at(p, x, c.transfer, "transfer", Range::kNotNegative) * boundary_.patch_area[p];
    return {.inflow = transfer * value_at(p, x, c.outside, "outside value", Range::kFinite), .transfer = transfer};
  }

  double value_at(PatchId p, const Vec<D>& x, const BoundaryValue<D>& given, std::string_view name, Range range) const {
    const double* const constant = std::get_if<double>(&given);
    const double value = constant != nullptr ? *constant : std::get<1>(given)(x);
    if (lies_in(value, range)) return value;
    fail_input("solve.bad_condition",
               fmt::format("the {} on marker {} is {} near {}", name, boundary_.patch_marker[p], value, place_text(x)),
               std::string(wanted(range)), {x.coord.begin(), x.coord.end()});
  }

  const ControlVolumes<D>& volumes_;
  const BoundaryAreas<D>& boundary_;
  std::map<int, double> marker_area_;
};

/// The conductance of each face: kappa's harmonic mean, as for two resistances in series, times |A| / h. With the
/// derivative of kappa, that of the conductance too: d/da of 2ab/(a + b) is 2 (b/(a + b))^2.
template <int D>
void set_couplings(const ControlVolumes<D>& volumes, const IdVector<CellId, double>& conductivity,
                   const IdVector<CellId, double>& slope, CellTerms& terms) {
  terms.coupling.resize(volumes.face_vertices.size());
  if (!slope.empty()) terms.coupling_slope.resize(volumes.face_vertices.size());
  parallel_for(terms.coupling.size(), [&](std::size_t k) {
    const DualFaceId f(k);
    const auto [i, j] = volumes.face_vertices[f];
    const CellId ci = terms.index(i, volumes.face_region[f]), cj = terms.index(j, volumes.face_region[f]);
    const double a = conductivity[ci], b = conductivity[cj];
    const double shape = volumes.face_area[f] / volumes.face_edge_length[f];
    terms.coupling[f] = (a == b ? a : 2 / (1 / a + 1 / b)) * shape;
    if (slope.empty()) return;
    const double share_a = a / (a + b), share_b = b / (a + b);
    terms.coupling_slope[f] = {2 * share_b * share_b * slope[ci] * shape, 2 * share_a * share_a * slope[cj] * shape};
  });
}

void multiply_by_volume(const IdVector<CellId, double>& volume, IdVector<CellId, double>& density) {
  parallel_for(density.size(), [&](std::size_t i) { density[CellId(i)] *= volume[CellId(i)]; });
}

IdVector<CellId, double> checked_integrals(const IdVector<CellId, double>& given, std::size_t n_cells) {
  if (given.size() != n_cells)
    fail_input("solve.wrong_length",
               fmt::format("{} integrals of the source are given for {} cells", given.size(), n_cells),
               "give one integral for each cell");
  for (const CellId c : ids(given))
    if (!std::isfinite(given[c]))
      fail_input("solve.bad_source",
                 fmt::format("the integral of the source over cell {} (counted from 0) is {}", c.value(), given[c]),
                 "make it finite");
  return given;
}

/// The integral of the source over each cell, and its derivative.
template <int D>
void set_source(const ControlVolumes<D>& volumes, const DiffusionProblem<D>& problem, const Solution* solution,
                CellTerms& terms) {
  if (problem.source_integrals) {
    if (std::holds_alternative<StateFunction<D>>(problem.source))
      refuse_state_function("the source", "leave out its integrals");
    terms.source = checked_integrals(*problem.source_integrals, volumes.cell_vertex.size());
    return;
  }
  terms.source = Evaluator<D>(volumes, {"the source", "solve.bad_source", Range::kFinite}, solution)(problem.source);
  multiply_by_volume(volumes.cell_volume, terms.source);
  if (solution == nullptr) return;
  terms.source_slope = derivatives(volumes, problem.source, *solution,
                                   {"the derivative of the source", "solve.bad_source", Range::kFinite});
  multiply_by_volume(volumes.cell_volume, terms.source_slope);
}

}  // namespace

template <int D>
IdVector<CellId, double> evaluate_at_sites(const ControlVolumes<D>& volumes, const Coefficient<D>& coefficient,
                                           const Quantity& quantity) {
  return Evaluator<D>(volumes, quantity, nullptr)(coefficient);
}

template <int D>
IdVector<PatchId, PatchTerm> evaluate_patches(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                              const std::map<int, BoundaryCondition<D>>& conditions) {
  const PatchEvaluator<D> evaluator(volumes, boundary);
  std::set<int> markers;
  for (const auto& [marker, area] : evaluator.marker_areas()) markers.insert(marker);
  for (const auto& [marker, condition] : conditions) check_marker(marker, markers);
  IdVector<PatchId, PatchTerm> terms(boundary.patch_vertex.size());
  for (const PatchId p : ids(terms)) {
    const auto condition = conditions.find(boundary.patch_marker[p]);
    if (condition != conditions.end()) terms[p] = evaluator(p, condition->second);
  }
  return terms;
}

template <int D>
CellTerms evaluate(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellIndex& index,
                   const DiffusionProblem<D>& problem, const Solution* solution) {
  CellTerms terms{index, {}, {}, {}, {}, {}, {}};
  const auto conductivity = Evaluator<D>(volumes, {"the conductivity", "solve.bad_conductivity", Range::kPositive},
                                         solution)(problem.conductivity);
  IdVector<CellId, double> slope;
  if (solution != nullptr)
    slope = derivatives(volumes, problem.conductivity, *solution,
                        {"the derivative of the conductivity", "solve.bad_conductivity", Range::kFinite});
  set_couplings(volumes, conductivity, slope, terms);
  if (std::holds_alternative<StateFunction<D>>(problem.reaction))
    refuse_state_function("the reaction", "make what depends on the solution part of the source");
  terms.absorption =
      evaluate_at_sites(volumes, problem.reaction, {"the reaction", "solve.bad_reaction", Range::kNotNegative});
  multiply_by_volume(volumes.cell_volume, terms.absorption);
  set_source(volumes, problem, solution, terms);
  terms.patches = evaluate_patches(volumes, boundary, problem.conditions);
  return terms;
}

template IdVector<CellId, double> evaluate_at_sites(const ControlVolumes<2>&, const Coefficient<2>&, const Quantity&);
template IdVector<PatchId, PatchTerm> evaluate_patches(const ControlVolumes<2>&, const BoundaryAreas<2>&,
                                                       const std::map<int, BoundaryCondition<2>>&);
template CellTerms evaluate(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellIndex&,
                            const DiffusionProblem<2>&, const Solution*);
template IdVector<CellId, double> evaluate_at_sites(const ControlVolumes<3>&, const Coefficient<3>&, const Quantity&);
template IdVector<PatchId, PatchTerm> evaluate_patches(const ControlVolumes<3>&, const BoundaryAreas<3>&,
                                                       const std::map<int, BoundaryCondition<3>>&);
template CellTerms evaluate(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellIndex&,
                            const DiffusionProblem<3>&, const Solution*);

}  // namespace voropack
