// The sweeps of multigrid, compared with their definitions by full passes over the matrix.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.h"
#include "multigrid/chebyshev.h"
#include "multigrid/level_matrix.h"
#include "support/nested_hierarchy.h"

namespace voropack {
namespace {

using Values = std::vector<double>;

/// A grid of several blocks, some vertices fixed.
LinearSystem grid() { return test::grid_hierarchy<2>(100, {.right = 10}).system; }

/// The same, with couplings between far vertices that make the matrix positive definite but no M-matrix, and plain
/// Gauss-Seidel in blocks divergent: all off-diagonal entries between blocks are as large as definiteness allows.
LinearSystem between_blocks() {
  LinearSystem system;
  constexpr std::size_t n = 3 * kSmoothingBlock;
  for (std::size_t i = 0; i < n; ++i) {
    // Positive couplings 0.9 of i with its images in the other blocks: eigenvalues 1 + 2 * 0.9 and 1 - 0.9.
    for (std::size_t j = i % kSmoothingBlock; j < n; j += kSmoothingBlock) {
      system.matrix.columns.push_back(static_cast<std::uint32_t>(j));
      system.matrix.values.push_back(i == j ? 1.0 : 0.9);
    }
    system.matrix.offsets.push_back(system.matrix.columns.size());
    system.load.push_back(0);
    system.absorption.push_back(1);
    system.is_fixed.push_back(0);
    system.fixed_value.push_back(0);
  }
  return system;
}

Values random_values(const LinearSystem& system, std::uint64_t seed) {
  Random random(seed);
  Values x(system.matrix.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = system.is_fixed[VertexId(i)] != 0 ? 0 : 2 * random.unit() - 1;
  return x;
}

Values plain_residual(const LinearSystem& system, const Values& b, const Values& x) {
  Values r(x.size());
  multiply(system.matrix, x, r);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = system.is_fixed[VertexId(i)] != 0 ? 0 : b[i] - r[i];
  return r;
}

/// Row after row from the definition x += M^-1 (b - A x); `shift` is E.
Values plain_sweep(const LinearSystem& system, const Values& b, const Values& x, bool is_backward, double shift) {
  const Values residual = plain_residual(system, b, x);
  Values change(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    const std::size_t i = is_backward ? x.size() - 1 - k : k;
    if (system.is_fixed[VertexId(i)] != 0) continue;
    double sum = residual[i], diagonal = 0;
    for (std::uint64_t e = system.matrix.offsets[i]; e != system.matrix.offsets[i + 1]; ++e) {
      const std::size_t j = system.matrix.columns[e];
      if (j == i) diagonal = system.matrix.values[e];
      const bool comes_before = is_backward ? j > i : j < i;
      if (comes_before && j / kSmoothingBlock == i / kSmoothingBlock) sum -= system.matrix.values[e] * change[j];
    }
    change[i] = sum / (diagonal + shift);
  }
  for (std::size_t i = 0; i < x.size(); ++i) change[i] += x[i];
  return change;
}

void expect_near(const Values& a, const Values& b) {
  double largest = 0, scale = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a[i] - b[i]));
    scale = std::max(scale, std::abs(b[i]));
  }
  EXPECT_LT(largest, 1e-12 * scale);
  EXPECT_GT(scale, 0);
}

double energy(const LinearSystem& system, const Values& x) {
  const Values image = plain_residual(system, Values(x.size()), x);
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum -= x[i] * image[i];
  return sum;
}

struct Case {
  LinearSystem system;
  double shift;
};

std::vector<Case> cases() { return {{grid(), 0.0}, {between_blocks(), (2 * 0.9 - 1) / 2}}; }

TEST(Smoother, SweepsFollowTheirDefinition) {
  for (const auto& [system, shift] : cases()) {
    const std::size_t n = system.matrix.size();
    const LevelMatrix<double> matrix(system.matrix, system.is_fixed.raw(), 1.0);
    const Values b = random_values(system, 1), x = random_values(system, 2);
    Values result(n), first(n), extra(n), residual(n);
    for (const bool is_backward : {false, true}) {
      matrix.sweep(b.data(), x.data(), is_backward, result.data());
      expect_near(result, plain_sweep(system, b, x, is_backward, shift));
    }
    const Values from_zero = plain_sweep(system, b, Values(n), false, shift);
    matrix.sweep_from_zero(b.data(), result.data());
    expect_near(result, from_zero);
    matrix.residual_after_sweep(result.data(), residual.data());
    expect_near(residual, plain_residual(system, b, from_zero));

    const Values both_from_zero = plain_sweep(system, b, from_zero, true, shift);
    matrix.symmetric_sweep_from_zero(b.data(), first.data(), extra.data(), result.data());
    expect_near(result, both_from_zero);
    matrix.residual_after_symmetric_sweep(extra.data(), residual.data());
    expect_near(residual, plain_residual(system, b, both_from_zero));

    result = x;
    matrix.symmetric_sweep(b.data(), first.data(), extra.data(), result.data());
    expect_near(result, plain_sweep(system, b, plain_sweep(system, b, x, false, shift), true, shift));
    matrix.residual(b.data(), x.data(), residual.data());
    expect_near(residual, plain_residual(system, b, x));
  }
}

TEST(Smoother, EnergyNeverGrows) {
  for (const auto& [system, shift] : cases()) {
    const LevelMatrix<double> matrix(system.matrix, system.is_fixed.raw(), 1.0);
    const Values zero(system.matrix.size());
    Values x = random_values(system, 3), next(x.size());
    for (int step = 0; step < 20; ++step) {
      matrix.sweep(zero.data(), x.data(), step % 2 == 1, next.data());
      EXPECT_LT(energy(system, next), energy(system, x));
      std::swap(x, next);
    }
  }
  // The shift is what does it: without, the second case diverges.
  const LinearSystem system = between_blocks();
  const Values x = Values(system.matrix.size(), 1.0);
  const Values next = plain_sweep(system, Values(x.size()), x, false, 0.0);
  EXPECT_GT(energy(system, next), energy(system, x));
}

TEST(Smoother, ChebyshevDampsItsRangeAsThePolynomialDoes) {
  // Eigenvalues of the diagonal scaled matrix lie in (0, 2): the bound found has to be near the largest one.
  const LinearSystem system = grid();
  const LevelMatrix<double> matrix(system.matrix, system.is_fixed.raw(), 1.0);
  const std::size_t n = system.matrix.size();
  Values zero(n), r(n), d(n);
  for (const int degree : {1, 2, 4}) {
    const ChebyshevSmoother<double> smoother(matrix, degree, 4);
    EXPECT_GT(smoother.largest(), 1.9);
    EXPECT_LT(smoother.largest(), 2.2);
    // With b = 0 the smoother multiplies by the polynomial, whose largest value on the upper range is 1 / T_k(5/3).
    Values x(n);
    for (std::size_t i = 0; i < n; ++i) {
      // The checkerboard, of the largest eigenvalue.
      x[i] = system.is_fixed[VertexId(i)] != 0 ? 0 : ((i % 101 + i / 101) % 2 == 0 ? 1 : -1);
    }
    const double before = energy(system, x);
    smoother.smooth(matrix, zero.data(), false, x.data(), r.data(), d.data());
    const double bound = 1 / std::cosh(degree * std::acosh(5.0 / 3.0));
    EXPECT_LT(std::sqrt(energy(system, x) / before), 1.2 * bound) << degree;
  }
}

TEST(Smoother, ChebyshevFromZeroAgreesWithAStartOfZeros) {
  const LinearSystem system = grid();
  const LevelMatrix<double> matrix(system.matrix, system.is_fixed.raw(), 1.0);
  const std::size_t n = system.matrix.size();
  const ChebyshevSmoother<double> smoother(matrix, 3, 4);
  const Values b = random_values(system, 5);
  Values r(n), d(n), x(n), unset(n, 1e300);
  smoother.smooth(matrix, b.data(), false, x.data(), r.data(), d.data());
  smoother.smooth(matrix, b.data(), true, unset.data(), r.data(), d.data());
  expect_near(unset, x);
}

}  // namespace
}  // namespace voropack
