#include "multigrid/singular_parts.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// A vertex of each vertex's connected part, the same for all of the part. One pass along first neighbors joins nearly
/// all of a part; what is left is found in parallel and joined after.
std::vector<std::uint32_t> connected_parts(const SparseMatrix& matrix) {
  const std::size_t n = matrix.size();
  std::vector<std::uint32_t> root(n);
  for (std::uint32_t row = 0; row < n; ++row) {
    root[row] = row;
    const std::uint64_t first = matrix.offsets[row];
    if (first != matrix.offsets[row + 1] && matrix.columns[first] < row && matrix.values[first] != 0)
      root[row] = root[matrix.columns[first]];
  }
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  const std::size_t n_blocks = (n + kVectorBlock - 1) / kVectorBlock;
  std::vector<Pairs> links(n_blocks);
  parallel_for(
      n_blocks,
      [&](std::size_t b) {
        Pairs& mine = links[b];
        for (std::size_t row = b * kVectorBlock; row != std::min(n, (b + 1) * kVectorBlock); ++row)
          for (std::uint64_t e = matrix.offsets[row]; e != matrix.offsets[row + 1] && matrix.columns[e] < row; ++e) {
            const std::pair link(root[row], root[matrix.columns[e]]);
            if (link.first == link.second || matrix.values[e] == 0) continue;
            if (mine.empty() || mine.back() != link) mine.push_back(link);
          }
      },
      1);
  DisjointSets sets(n);
  for (const Pairs& pairs : links)
    for (const auto& [a, b] : pairs) sets.join(a, b);
  for (std::uint32_t row = 0; row < n; ++row) root[row] = sets.find(root[row]);
  return root;
}

}  // namespace

SingularParts::SingularParts(const LinearSystem& system) {
  const std::vector<std::uint32_t> root = connected_parts(system.matrix);
  const std::size_t n = root.size();
  constexpr std::uint8_t kHeld = 2;  // By absorption, or by more than one vertex.
  std::vector<std::uint8_t> hold(n);
  for (std::size_t v = 0; v < n; ++v) {
    std::uint8_t& state = hold[root[v]];
    if (system.absorption[VertexId(v)] > 0)
      state = kHeld;
    else if (system.is_fixed[VertexId(v)] != 0 && state < kHeld)
      ++state;
  }
  std::vector<std::uint32_t> number(n);  // k + 1 at the root of part k.
  for (std::size_t v = 0; v < n; ++v) {
    if (hold[root[v]] == kHeld) continue;
    if (part_.empty()) part_.resize(n);
    std::uint32_t& part = number[root[v]];
    if (part == 0) {
      held_.emplace_back();
      n_vertices_.push_back(0);
      part = static_cast<std::uint32_t>(held_.size());
    }
    part_[v] = part;
    ++n_vertices_[part - 1];
    if (system.is_fixed[VertexId(v)] != 0) held_[part - 1] = static_cast<std::uint32_t>(v);
  }
}

std::vector<std::uint8_t> SingularParts::without_held(const LinearSystem& system) const {
  std::vector<std::uint8_t> is_fixed = system.is_fixed.raw();
  for (std::size_t k = 0; k < held_.size(); ++k)
    // A vertex without neighbors stays as it is: its row is empty.
    if (held_[k] && n_vertices_[k] > 1) is_fixed[*held_[k]] = 0;
  return is_fixed;
}

std::vector<double> SingularParts::sums(std::span<const double> values) const {
  return parallel_reduce_ordered(
      values.size(), kVectorBlock, std::vector<double>(size()),
      [&](std::size_t begin, std::size_t end) {
        std::vector<double> sum(size());
        for (std::size_t i = begin; i != end; ++i)
          if (part_[i] > 0) sum[part_[i] - 1] += values[i];
        return sum;
      },
      [](std::vector<double> a, const std::vector<double>& b) {
        for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
        return a;
      });
}

void SingularParts::subtract(const std::vector<double>& amounts, std::span<double> values) const {
  parallel_for(values.size(), [&](std::size_t i) {
    if (part_[i] > 0) values[i] -= amounts[part_[i] - 1];
  });
}

void SingularParts::make_compatible(std::span<const double> residual, std::span<double> result) const {
  std::copy(residual.begin(), residual.end(), result.begin());
  std::vector<double> amounts = sums(residual);
  for (std::size_t k = 0; k < size(); ++k) {
    if (held_[k]) result[*held_[k]] -= std::exchange(amounts[k], 0.0);
    amounts[k] /= n_vertices_[k];
  }
  subtract(amounts, result);
}

void SingularParts::shift(std::span<double> values) const {
  std::vector<double> amounts = sums(values);
  for (std::size_t k = 0; k < size(); ++k) amounts[k] = held_[k] ? values[*held_[k]] : amounts[k] / n_vertices_[k];
  subtract(amounts, values);
}

}  // namespace voropack
