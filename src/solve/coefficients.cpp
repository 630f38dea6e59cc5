#include "solve/coefficients.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/names.h"
#include "base/parallel.h"
#include "solve/check_volumes.h"

namespace voropack {

namespace {

template <int D>
std::string place(const Vec<D>& x) {
  return D == 2 ? fmt::format("({:.6g}, {:.6g})", x[0], x[1])
                : fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[D - 1]);
}

[[noreturn]] void fail(std::string id, std::string message, std::string fix, std::vector<double> position = {}) {
  throw InputError(Fault{
      .id = std::move(id), .message = std::move(message), .fix = std::move(fix), .position = std::move(position)});
}

/// "did you mean 3? " if one of the ids is near, and all of them.
std::string known_ids(std::string_view what, int id, const std::set<int>& ids) {
  constexpr std::size_t kMaxListed = 20;
  std::vector<std::string> names;
  for (const int known : ids) names.push_back(std::to_string(known));
  std::string near = nearest_name(std::to_string(id), names);
  if (near.empty() && !ids.empty()) {  // No misspelling; the next number.
    const int next = *std::min_element(ids.begin(), ids.end(), [&](int a, int b) {
      return std::abs(std::int64_t{a} - id) < std::abs(std::int64_t{b} - id);
    });
    near = std::to_string(next);
  }
  if (names.empty()) return fmt::format("there are no {}", what);
  const bool is_cut = names.size() > kMaxListed;
  if (is_cut) names.resize(kMaxListed);
  return fmt::format("did you mean {}? The {} are {}{}", near, what, join_names(names), is_cut ? ", ..." : "");
}

/// The range that the values of a coefficient have to lie in.
enum class Range : std::uint8_t { kFinite, kNotNegative, kPositive };

bool lies_in(double value, Range range) {
  return std::isfinite(value) && (range == Range::kFinite || value > 0 || (range == Range::kNotNegative && value == 0));
}

struct Quantity {
  std::string_view name;
  std::string_view fault;  ///< Of values out of range.
  Range range;

  [[nodiscard]] std::string_view wanted() const {
    return range == Range::kFinite        ? "make it finite"
           : range == Range::kNotNegative ? "make it finite and not negative"
                                          : "make it finite and positive";
  }
};

/// The value of a coefficient at the site of each cell.
template <int D>
class Evaluator {
 public:
  Evaluator(const ControlVolumes<D>& volumes, const Quantity& quantity) : volumes_(volumes), quantity_(quantity) {}

  IdVector<CellId, double> operator()(const Coefficient<D>& coefficient) const {
    IdVector<CellId, double> values(volumes_.cell_vertex.size());
    std::visit([&](const auto& given) { fill(given, values); }, coefficient);
    const std::size_t bad =
        first_bad(values.size(), [&](std::size_t i) { return lies_in(values[CellId(i)], quantity_.range); });
    if (bad != values.size()) throw_out_of_range(CellId(bad), values[CellId(bad)]);
    return values;
  }

 private:
  void fill(double value, IdVector<CellId, double>& values) const { std::fill(values.begin(), values.end(), value); }

  void fill(const std::map<int, double>& by_region, IdVector<CellId, double>& values) const {
    const std::set<int> regions(volumes_.cell_region.begin(), volumes_.cell_region.end());
    for (const auto& [region, value] : by_region)
      if (!regions.contains(region))
        fail("solve.unknown_region",
             fmt::format("{} is given for region {}, which is not there", quantity_.name, region),
             known_ids("regions", region, regions));
    for (const int region : regions)
      if (!by_region.contains(region))
        fail("solve.unknown_region", fmt::format("{} is not given for region {}", quantity_.name, region),
             "give it for every region");
    for (const CellId c : ids(values)) values[c] = by_region.at(volumes_.cell_region[c]);
  }

  void fill(const IdVector<VertexId, double>& by_vertex, IdVector<CellId, double>& values) const {
    if (by_vertex.size() != volumes_.sites.size())
      fail("solve.wrong_length",
           fmt::format("{} has {} values for {} vertices", quantity_.name, by_vertex.size(), volumes_.sites.size()),
           "give one value for each vertex");
    for (const CellId c : ids(values)) values[c] = by_vertex[volumes_.cell_vertex[c]];
  }

  void fill(const RegionFunction<D>& function, IdVector<CellId, double>& values) const {
    parallel_for(values.size(), [&](std::size_t i) {
      const CellId c(i);
      values[c] = function(volumes_.sites[volumes_.cell_vertex[c]], volumes_.cell_region[c]);
    });
  }

  [[noreturn]] void throw_out_of_range(CellId c, double value) const {
    const VertexId v = volumes_.cell_vertex[c];
    const Vec<D>& x = volumes_.sites[v];
    fail(std::string(quantity_.fault),
         fmt::format("{} is {} in region {} at vertex {} near {}", quantity_.name, value, volumes_.cell_region[c],
                     v.value(), place(x)),
         std::string(quantity_.wanted()), {x.coord.begin(), x.coord.end()});
  }

  const ControlVolumes<D>& volumes_;
  Quantity quantity_;
};

/// The terms of the patches of one marker.
template <int D>
class PatchEvaluator {
 public:
  PatchEvaluator(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary)
      : volumes_(volumes), boundary_(boundary) {}

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
    fail("solve.bad_condition",
         fmt::format("the {} on marker {} is {} near {}", name, boundary_.patch_marker[p], value, place(x)),
         range == Range::kFinite ? "make it finite" : "make it finite and not negative",
         {x.coord.begin(), x.coord.end()});
  }

  const ControlVolumes<D>& volumes_;
  const BoundaryAreas<D>& boundary_;
};

template <int D>
IdVector<PatchId, PatchTerm> evaluate_patches(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                                              const std::map<int, BoundaryCondition<D>>& conditions) {
  const std::set<int> markers(boundary.patch_marker.begin(), boundary.patch_marker.end());
  for (const auto& [marker, condition] : conditions)
    if (!markers.contains(marker))
      fail("solve.unknown_marker", fmt::format("a condition is given for marker {}, which no boundary has", marker),
           known_ids("markers", marker, markers));
  const PatchEvaluator<D> evaluator(volumes, boundary);
  IdVector<PatchId, PatchTerm> terms(boundary.patch_vertex.size());
  for (const PatchId p : ids(terms)) {
    const auto condition = conditions.find(boundary.patch_marker[p]);
    if (condition != conditions.end()) terms[p] = evaluator(p, condition->second);
  }
  return terms;
}

template <int D>
IdVector<DualFaceId, double> couplings(const ControlVolumes<D>& volumes, const CellIndex& index,
                                       const IdVector<CellId, double>& conductivity) {
  IdVector<DualFaceId, double> coupling(volumes.face_vertices.size());
  parallel_for(coupling.size(), [&](std::size_t k) {
    const DualFaceId f(k);
    const auto [i, j] = volumes.face_vertices[f];
    const double a = conductivity[index(i, volumes.face_region[f])], b = conductivity[index(j, volumes.face_region[f])];
    coupling[f] = (a == b ? a : 2 / (1 / a + 1 / b)) * (volumes.face_area[f] / volumes.face_edge_length[f]);
  });
  return coupling;
}

/// The integral of the source over each cell.
template <int D>
IdVector<CellId, double> integrate_source(const ControlVolumes<D>& volumes, const DiffusionProblem<D>& problem) {
  const Quantity quantity{"the source", "solve.bad_source", Range::kFinite};
  if (!problem.source_integrals) {
    IdVector<CellId, double> source = Evaluator<D>(volumes, quantity)(problem.source);
    for (const CellId c : ids(source)) source[c] *= volumes.cell_volume[c];
    return source;
  }
  const IdVector<CellId, double>& given = *problem.source_integrals;
  if (given.size() != volumes.cell_vertex.size())
    fail("solve.wrong_length",
         fmt::format("{} integrals of the source are given for {} cells", given.size(), volumes.cell_vertex.size()),
         "give one integral for each cell");
  for (const CellId c : ids(given))
    if (!std::isfinite(given[c]))
      fail("solve.bad_source", fmt::format("the integral of the source over cell {} is {}", c.value(), given[c]),
           "make it finite");
  return given;
}

}  // namespace

template <int D>
CellTerms evaluate(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                   const DiffusionProblem<D>& problem) {
  check_volumes(volumes, boundary);
  const Evaluator<D> conductivity(volumes, {"the conductivity", "solve.bad_conductivity", Range::kPositive});
  const Evaluator<D> reaction(volumes, {"the reaction", "solve.bad_reaction", Range::kNotNegative});
  const CellIndex index(volumes);
  CellTerms terms{index, couplings(volumes, index, conductivity(problem.conductivity)), reaction(problem.reaction),
                  integrate_source(volumes, problem), evaluate_patches(volumes, boundary, problem.conditions)};
  parallel_for(terms.absorption.size(),
               [&](std::size_t i) { terms.absorption[CellId(i)] *= volumes.cell_volume[CellId(i)]; });
  return terms;
}

template CellTerms evaluate(const ControlVolumes<2>&, const BoundaryAreas<2>&, const DiffusionProblem<2>&);
template CellTerms evaluate(const ControlVolumes<3>&, const BoundaryAreas<3>&, const DiffusionProblem<3>&);

}  // namespace voropack
