#include "solve/conservation.h"

#include <Eigen/SparseCholesky>
#include <map>
#include <utility>

#include "solve/vectors.h"

namespace voropack {

namespace {

using GroupMatrix = Eigen::SparseMatrix<double>;

/// The matrix of the groups, and the sums of their residuals.
GroupMatrix galerkin_matrix(const LinearSystem& system, const IdVector<VertexId, std::uint32_t>& group,
                            std::uint32_t n_groups) {
  std::vector<double> diagonal(n_groups);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> between;
  const SparseMatrix& matrix = system.matrix;
  for (const VertexId v : ids(group)) {
    if (system.is_fixed[v] != 0) continue;
    // A row sums up to what it absorbs: only entries that lead out of the group remain.
    double sum = system.absorption[v];
    for (std::uint64_t e = matrix.offsets[v.value()]; e != matrix.offsets[v.value() + std::size_t{1}]; ++e) {
      const VertexId w(matrix.columns[e]);
      if (system.is_fixed[w] != 0) {
        sum -= matrix.values[e];
      } else if (group[v] != group[w]) {
        sum -= matrix.values[e];
        between[{group[v], group[w]}] += matrix.values[e];
      }
    }
    diagonal[group[v]] += sum;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t g = 0; g < n_groups; ++g)
    entries.emplace_back(static_cast<int>(g), static_cast<int>(g), diagonal[g] > 0 ? diagonal[g] : 1.0);
  for (const auto& [pair, value] : between)
    entries.emplace_back(static_cast<int>(pair.first), static_cast<int>(pair.second), value);
  GroupMatrix result(static_cast<int>(n_groups), static_cast<int>(n_groups));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

void close_balances(const LinearSystem& system, const IdVector<VertexId, std::uint32_t>& group, std::uint32_t n_groups,
                    LinearSolution& solution) {
  const Eigen::SimplicialLDLT<GroupMatrix> factors(galerkin_matrix(system, group, n_groups));
  if (factors.info() != Eigen::Success) return;
  std::vector<double> residual(group.size());
  for (int pass = 0; pass < 2; ++pass) {  // The second one removes what rounding left in the first.
    free_residual(system, solution.values.raw(), residual);
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<int>(n_groups));
    for (const VertexId v : ids(group)) sums[static_cast<int>(group[v])] += residual[v.value()];
    const Eigen::VectorXd shift = factors.solve(sums);
    for (const VertexId v : ids(group))
      if (system.is_fixed[v] == 0) solution.values[v] += shift[static_cast<int>(group[v])];
  }
}

}  // namespace voropack
