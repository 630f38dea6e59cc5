// Points along a Hilbert curve, and the order in which a triangulation visits them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// Bits per axis of a Hilbert key.
template <int K>
inline constexpr int kHilbertBits = 60 / K;

/// The place of the grid cell `cell` on the Hilbert curve through the grid with 2^kHilbertBits cells per axis: below
/// 2^60. Keys that differ by one belong to cells that share a face.
template <int K>
std::uint64_t hilbert_key(const std::array<std::uint32_t, K>& cell);

/// The key of the cell of x in such a grid over `box`, each axis scaled on its own.
template <int K>
std::uint64_t hilbert_key(const Vec<K>& x, const Box<K>& box);

/// The indices of `points` along a Hilbert curve through their bounding box. Clusters too small for the curve's
/// resolution are ordered along a finer curve of their own. Ties are broken by index. O(n log n).
template <int K>
std::vector<std::uint32_t> hilbert_order(std::span<const Vec<K>> points);

/// The indices of `points` by `hilbert_key` in `box`; equal keys by index. In parallel. O(n) but for clusters.
template <int K>
std::vector<std::uint32_t> hilbert_order(std::span<const Vec<K>> points, const Box<K>& box);

/// A biased randomized insertion order (Amenta, Choi, Rote, SoCG 2003) of n points that are sorted along a Hilbert
/// curve: the numbers 0 .. n - 1 in rounds, ascending in each. A round holds about eight times as many points as all
/// before, chosen by a hash of the number. An early round spreads over the whole box, so no later insertion meets
/// simplices that are much longer than its own.
std::vector<std::uint32_t> insertion_rounds(std::size_t n);

}  // namespace voropack
