#include "solve/conservation.h"

#include <Eigen/SparseLU>
#include <map>
#include <utility>

#include "solve/vectors.h"

namespace voropack {

namespace {

using GroupMatrix = Eigen::SparseMatrix<double>;

/// The matrix of the groups.
GroupMatrix galerkin_matrix(const LinearSystem& system, const RegionGroups& groups) {
  std::vector<double> diagonal(groups.n);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> between;
  const SparseMatrix& matrix = system.matrix;
  for (const VertexId v : ids(groups.of)) {
    if (system.is_fixed[v] != 0) continue;
    // A symmetric row sums up to what it absorbs: only entries that lead out of the group remain.
    double sum = system.is_symmetric ? system.absorption[v] : 0.0;
    for (std::uint64_t e = matrix.offsets[v.value()]; e != matrix.offsets[v.value() + std::size_t{1}]; ++e) {
      const VertexId w(matrix.columns[e]);
      const bool is_outside = system.is_fixed[w] != 0 || groups.of[v] != groups.of[w];
      if (is_outside == system.is_symmetric) sum += system.is_symmetric ? -matrix.values[e] : matrix.values[e];
      if (is_outside && system.is_fixed[w] == 0) between[{groups.of[v], groups.of[w]}] += matrix.values[e];
    }
    diagonal[groups.of[v]] += sum;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t g = 0; g < groups.n; ++g)
    entries.emplace_back(static_cast<int>(g), static_cast<int>(g), diagonal[g] != 0 ? diagonal[g] : 1.0);
  for (const auto& [pair, value] : between)
    entries.emplace_back(static_cast<int>(pair.first), static_cast<int>(pair.second), value);
  GroupMatrix result(static_cast<int>(groups.n), static_cast<int>(groups.n));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

template <int D>
RegionGroups region_groups(const ControlVolumes<D>& volumes) {
  std::map<int, std::uint32_t> number;
  for (const int region : volumes.cell_region) number.try_emplace(region, static_cast<std::uint32_t>(number.size()));
  const auto interface = static_cast<std::uint32_t>(number.size());
  RegionGroups groups{IdVector<VertexId, std::uint32_t>(volumes.sites.size()), interface + 1};
  for (const CellId c : ids(volumes.cell_vertex)) {
    const bool repeats =
        c.value() > 0 && volumes.cell_vertex[CellId(c.value() - std::size_t{1})] == volumes.cell_vertex[c];
    groups.of[volumes.cell_vertex[c]] = repeats ? interface : number.at(volumes.cell_region[c]);
  }
  return groups;
}
template RegionGroups region_groups(const ControlVolumes<2>&);
template RegionGroups region_groups(const ControlVolumes<3>&);

void close_balances(const LinearSystem& system, const RegionGroups& groups, LinearSolution& solution) {
  Eigen::SparseLU<GroupMatrix, Eigen::COLAMDOrdering<int>> factors;
  factors.compute(galerkin_matrix(system, groups));
  if (factors.info() != Eigen::Success) return;
  std::vector<double> residual(groups.of.size());
  for (int pass = 0; pass < 2; ++pass) {  // The second one removes what rounding left in the first.
    free_residual(system, solution.values.raw(), residual);
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<int>(groups.n));
    for (const VertexId v : ids(groups.of)) sums[static_cast<int>(groups.of[v])] += residual[v.value()];
    const Eigen::VectorXd shift = factors.solve(sums);
    for (const VertexId v : ids(groups.of))
      if (system.is_fixed[v] == 0) solution.values[v] += shift[static_cast<int>(groups.of[v])];
  }
}

}  // namespace voropack
