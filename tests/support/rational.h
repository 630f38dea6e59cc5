// Exact rational geometry, written as plainly as possible: what the library's numbers are compared with.
#pragma once

#include <gmpxx.h>

#include <array>
#include <map>
#include <tuple>

#include "voropack/mesh.h"

namespace voropack::test {

using Rational = mpq_class;

template <int D>
using RationalVec = std::array<Rational, D>;

template <int D>
RationalVec<D> exact(const Vec<D>& p) {
  RationalVec<D> r;
  for (int k = 0; k < D; ++k) r[static_cast<std::size_t>(k)] = Rational(p[k]);
  return r;
}

template <std::size_t D>
std::array<Rational, D> minus(const std::array<Rational, D>& a, const std::array<Rational, D>& b) {
  std::array<Rational, D> r;
  for (std::size_t k = 0; k < D; ++k) r[k] = a[k] - b[k];
  return r;
}

template <std::size_t D>
Rational inner(const std::array<Rational, D>& a, const std::array<Rational, D>& b) {
  Rational s = 0;
  for (std::size_t k = 0; k < D; ++k) s += a[k] * b[k];
  return s;
}

inline RationalVec<3> outer(const RationalVec<3>& a, const RationalVec<3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Determinant by cofactors.
template <std::size_t N>
Rational determinant(const std::array<std::array<Rational, N>, N>& m) {
  if constexpr (N == 1) {
    return m[0][0];
  } else {
    Rational sum = 0;
    for (std::size_t c = 0; c < N; ++c) {
      std::array<std::array<Rational, N - 1>, N - 1> minor;
      for (std::size_t i = 1; i < N; ++i)
        for (std::size_t j = 0, k = 0; j < N; ++j)
          if (j != c) minor[i - 1][k++] = m[i][j];
      sum += (c % 2 == 0 ? 1 : -1) * m[0][c] * determinant<N - 1>(minor);
    }
    return sum;
  }
}

/// The point of the affine hull of `p` at equal distance from all of p, by Cramer's rule on the Gram matrix.
template <int D, std::size_t N>
RationalVec<D> exact_circumcenter(const std::array<Vec<D>, N>& p) {
  constexpr std::size_t kUnknowns = N - 1;
  const RationalVec<D> origin = exact(p[0]);
  std::array<RationalVec<D>, kUnknowns> v;
  for (std::size_t k = 0; k < kUnknowns; ++k) v[k] = minus(exact(p[k + 1]), origin);
  std::array<std::array<Rational, kUnknowns>, kUnknowns> gram;
  for (std::size_t i = 0; i < kUnknowns; ++i)
    for (std::size_t j = 0; j < kUnknowns; ++j) gram[i][j] = inner(v[i], v[j]);
  const Rational whole = 2 * determinant(gram);
  RationalVec<D> center = origin;
  for (std::size_t k = 0; k < kUnknowns; ++k) {
    auto replaced = gram;
    for (std::size_t i = 0; i < kUnknowns; ++i) replaced[i][k] = gram[i][i];
    const Rational t = determinant(replaced) / whole;
    for (std::size_t axis = 0; axis < D; ++axis) center[axis] += t * v[k][axis];
  }
  return center;
}

/// (i, j, region) -> signed circumcentric area of the dual face times twice the edge length (3D) or, in 2D, times the
/// edge length: rational in both cases. Summed simplex by simplex from exact circumcenters.
using ExactAreas = std::map<std::tuple<VertexId, VertexId, int>, Rational>;

inline ExactAreas exact_areas(const Mesh<3>& mesh) {
  ExactAreas areas;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& v = mesh.simplex_vertices[s];
    const auto at = [&](std::size_t k) -> const Vec<3>& { return mesh.points[v[k]]; };
    const RationalVec<3> center = exact_circumcenter<3, 4>({at(0), at(1), at(2), at(3)});
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b) {
        const std::size_t k = a > 0 ? 0 : b > 1 ? 1 : 2;
        const std::size_t l = 6 - a - b - k;
        const RationalVec<3> axis = minus(exact(at(b)), exact(at(a)));
        const RationalVec<3> middle = exact_circumcenter<3, 2>({at(a), at(b)});
        const RationalVec<3> ck = minus(exact_circumcenter<3, 3>({at(a), at(b), at(k)}), middle);
        const RationalVec<3> cl = minus(exact_circumcenter<3, 3>({at(a), at(b), at(l)}), middle);
        const RationalVec<3> c = minus(center, middle);
        Rational twice = inner(axis, outer(ck, c)) + inner(axis, outer(c, cl));
        if (inner(axis, outer(minus(exact(at(k)), middle), minus(exact(at(l)), middle))) < 0) twice = -twice;
        areas[{std::min(v[a], v[b]), std::max(v[a], v[b]), mesh.simplex_region[s]}] += twice;
      }
    }
  }
  return areas;
}

inline ExactAreas exact_areas(const Mesh<2>& mesh) {
  ExactAreas areas;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& v = mesh.simplex_vertices[s];
    const auto at = [&](std::size_t k) -> const Vec<2>& { return mesh.points[v[k % 3]]; };
    const RationalVec<2> center = exact_circumcenter<2, 3>({at(0), at(1), at(2)});
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      const RationalVec<2> edge = minus(exact(at(b)), exact(at(a)));
      const RationalVec<2> to_center = minus(center, exact(at(a)));
      areas[{std::min(v[a], v[b]), std::max(v[a], v[b]), mesh.simplex_region[s]}] +=
          edge[0] * to_center[1] - edge[1] * to_center[0];
    }
  }
  return areas;
}

}  // namespace voropack::test
