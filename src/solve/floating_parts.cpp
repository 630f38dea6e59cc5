#include "solve/floating_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "base/disjoint_sets.h"
#include "base/names.h"

namespace voropack {

namespace {

/// What a part may gain, relative to what goes in and out, and still count as compatible: the quadrature of a source
/// that is given as a function leaves a few thousandths on coarse meshes, and data that are wrong are so by far more.
constexpr double kMaxGain = 0.01;

using RegionsOf = std::function<std::set<int>(const std::vector<VertexId>&)>;

/// Regions as text.
std::string region_text(const std::set<int>& regions) {
  std::vector<std::string> names;
  for (const int region : regions) names.push_back(std::to_string(region));
  return (names.size() == 1 ? "region " : "regions ") + join_names(names);
}

/// Sets the gain of the part, and takes it away from its load.
void balance_load(const IdVector<VertexId, double>& volume, const RegionsOf& regions_of, FloatingPart& part,
                  LinearSystem& system) {
  double magnitude = 0;
  for (const VertexId v : part.vertices) {
    part.gain += system.load[v];
    magnitude += std::abs(system.load[v]);
  }
  if (!(std::abs(part.gain) <= kMaxGain * magnitude))
    throw InputError(
        Fault{.id = "solve.incompatible",
              .message = fmt::format("{}: a gain of {:.6g} on the whole with no way to lose it",
                                     region_text(regions_of(part.vertices)), part.gain),
              .fix = "make the source and the inflow through the boundary add up to 0, or give a Dirichlet condition"});
  for (const VertexId v : part.vertices) system.load[v] -= part.gain * (volume[v] / part.volume);
}

/// The floating parts with their vertices and volumes.
std::vector<FloatingPart> collect_parts(const LinearSystem& system, const std::vector<VertexId>& floating,
                                        const IdVector<VertexId, double>& volume) {
  std::map<std::uint32_t, FloatingPart> part_of;
  for (const VertexId root : floating) part_of[root.value()];
  const std::vector<std::uint32_t> roots = part_roots(system.matrix);
  for (const VertexId v : ids(volume)) {
    const auto part = part_of.find(roots[v.value()]);
    if (part == part_of.end()) continue;
    part->second.vertices.push_back(v);
    part->second.volume += volume[v];
  }
  std::vector<FloatingPart> parts;
  for (auto& [root, part] : part_of) parts.push_back(std::move(part));
  return parts;
}

}  // namespace

std::vector<std::uint32_t> part_roots(const SparseMatrix& matrix) {
  DisjointSets parts(matrix.size());
  for (std::uint32_t row = 0; row < matrix.size(); ++row)
    for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1]; ++e)
      if (matrix.columns[e] < row && matrix.values[e] != 0) parts.join(row, matrix.columns[e]);
  std::vector<std::uint32_t> roots(matrix.size());
  for (std::uint32_t row = 0; row < matrix.size(); ++row) roots[row] = parts.find(row);
  return roots;
}

std::vector<VertexId> floating_roots(const LinearSystem& system) {
  const std::vector<std::uint32_t> roots = part_roots(system.matrix);
  std::vector<bool> is_held(roots.size());
  for (std::size_t v = 0; v < roots.size(); ++v)
    if (system.is_fixed[VertexId(v)] != 0 || system.absorption[VertexId(v)] > 0) is_held[roots[v]] = true;
  std::vector<VertexId> floating;
  for (std::size_t v = 0; v < roots.size(); ++v)
    if (roots[v] == v && !is_held[v]) floating.emplace_back(v);
  return floating;
}

std::vector<FloatingPart> ground_floating_parts(const IdVector<VertexId, double>& volume, const RegionsOf& regions_of,
                                                const std::optional<double>& mean, LinearSystem& system) {
  const std::vector<VertexId> floating = floating_roots(system);
  if (floating.empty()) {
    if (!mean) return {};
    throw InputError(Fault{.id = "solve.mean_not_free",
                           .message = "a mean is given, but the conditions leave no part free up to a constant",
                           .fix = "leave out the mean, or the Dirichlet and Robin conditions and the reaction"});
  }
  std::vector<FloatingPart> parts = collect_parts(system, floating, volume);
  if (!mean)
    throw InputError(Fault{.id = "solve.no_condition",
                           .message = fmt::format("no condition holds the solution in {}: it is free up to a constant",
                                                  region_text(regions_of(parts.front().vertices))),
                           .fix = "give a Dirichlet or Robin condition on its boundary, a reaction, or a mean value"});
  for (FloatingPart& part : parts) {
    balance_load(volume, regions_of, part, system);
    system.is_fixed[part.vertices.front()] = 1;
  }
  return parts;
}

void shift_to_mean(const IdVector<VertexId, double>& volume, const std::vector<FloatingPart>& parts, double mean,
                   IdVector<VertexId, double>& values) {
  for (const FloatingPart& part : parts) {
    double integral = 0;
    for (const VertexId v : part.vertices) integral += volume[v] * values[v];
    const double shift = mean - integral / part.volume;
    for (const VertexId v : part.vertices) values[v] += shift;
  }
}

}  // namespace voropack
