// Positions along a Hilbert curve: sorting by them puts near points near in memory.
#pragma once

#include <array>
#include <cstdint>

#include "voropack/vec.h"

namespace voropack {

/// The index along the Hilbert curve of the cell of x in a grid of 2^(63 / D) cells per axis over `box` (J. Skilling,
/// Programming the Hilbert curve, AIP Conf. Proc. 707, 2004).
template <int D>
std::uint64_t hilbert_index(const Vec<D>& x, const Box<D>& box) {
  constexpr int kBits = D == 2 ? 31 : 20;
  std::array<std::uint32_t, D> t;
  for (int k = 0; k < D; ++k) {
    const double extent = box.hi[k] - box.lo[k];
    const double u = extent > 0 ? (x[k] - box.lo[k]) / extent : 0.0;
    t[static_cast<std::size_t>(k)] =
        static_cast<std::uint32_t>(std::clamp(u, 0.0, 1.0) * static_cast<double>((1U << kBits) - 1));
  }
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1U) {
    const std::uint32_t p = q - 1;
    for (std::size_t i = 0; i < D; ++i) {
      if ((t[i] & q) != 0) {
        t[0] ^= p;
      } else {
        const std::uint32_t s = (t[0] ^ t[i]) & p;
        t[0] ^= s;
        t[i] ^= s;
      }
    }
  }
  for (std::size_t i = 1; i < D; ++i) t[i] ^= t[i - 1];
  std::uint32_t s = 0;
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1U)
    if ((t[D - 1] & q) != 0) s ^= q - 1;
  for (std::size_t i = 0; i < D; ++i) t[i] ^= s;
  std::uint64_t index = 0;
  for (int bit = kBits - 1; bit >= 0; --bit)
    for (std::size_t i = 0; i < D; ++i) index = (index << 1U) | (t[i] >> static_cast<unsigned>(bit) & 1U);
  return index;
}

}  // namespace voropack
