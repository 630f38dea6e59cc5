// Symmetric matrices by their entries xx, xy, (xz,) yy, (yz, zz).
#pragma once

#include <array>
#include <cstddef>

#include "voropack/vec.h"

namespace voropack {

template <int D>
constexpr std::size_t kSymmetricEntries = D*(D + 1) / 2;

template <int D>
using SymmetricEntries = std::array<double, kSymmetricEntries<D>>;

/// Calls visit(entry, k, l) for each entry, k <= l.
template <int D, class Visit>
void for_symmetric_entries(Visit&& visit) {
  std::size_t entry = 0;
  for (int k = 0; k < D; ++k)
    for (int l = k; l < D; ++l, ++entry) visit(entry, k, l);
}

template <int D>
Vec<D> times(const SymmetricEntries<D>& matrix, const Vec<D>& x) {
  Vec<D> y;
  for_symmetric_entries<D>([&](std::size_t entry, int k, int l) {
    y[k] += matrix[entry] * x[l];
    if (l != k) y[l] += matrix[entry] * x[k];
  });
  return y;
}

/// The sum of the products of all entries of the matrices.
template <int D>
double contract(const SymmetricEntries<D>& a, const SymmetricEntries<D>& b) {
  double sum = 0;
  for_symmetric_entries<D>([&](std::size_t entry, int k, int l) { sum += (k == l ? 1 : 2) * a[entry] * b[entry]; });
  return sum;
}

}  // namespace voropack
