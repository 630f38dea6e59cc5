// What all simplices of a mesh say, found by several threads, in the order of the simplices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.h"
#include "voropack/mesh.h"

namespace voropack {

/// visit(simplex, out) may append to `out`; returns all that was appended, simplex by simplex. In parallel.
template <class T, int D, class Visit>
std::vector<T> collect_from_simplices(const Mesh<D>& mesh, Visit&& visit) {
  constexpr std::size_t kBlock = 16384;
  const std::size_t n = mesh.simplex_vertices.size();
  std::vector<std::vector<T>> parts((n + kBlock - 1) / kBlock);
  parallel_for(
      parts.size(),
      [&](std::size_t block) {
        for (std::size_t s = block * kBlock; s < std::min(n, (block + 1) * kBlock); ++s)
          visit(SimplexId(s), parts[block]);
      },
      1);
  std::vector<T> all;
  for (const std::vector<T>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace voropack
