// Control volumes and boundary areas may come from another program: whether they fit together.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/parallel.h"
#include "voropack/boundary_areas.h"
#include "voropack/mesh.h"

namespace voropack {

/// The first index for which `is_good` does not hold, or n.
template <class Fn>
std::size_t first_bad(std::size_t n, const Fn& is_good) {
  constexpr std::size_t kBlock = 8192;
  return parallel_reduce_ordered(
      n, kBlock, n,
      [&](std::size_t begin, std::size_t end) {
        while (begin != end && is_good(begin)) ++begin;
        return begin == end ? n : begin;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

/// Throws InputError solve.bad_volumes.
template <int D>
void check_volumes(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary);

}  // namespace voropack
