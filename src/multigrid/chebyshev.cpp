#include "multigrid/chebyshev.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "base/random.h"
#include "solve/vectors.h"

namespace voropack {

namespace {

/// Steps of the power iteration, and what their result is raised by: it is too small by a few percent, and the
/// polynomial grows fast beyond the interval.
constexpr int kPowerSteps = 10;
constexpr double kSafety = 1.1;

template <class Real>
double product_sum(std::size_t n, const Real* a, const Real* b) {
  return parallel_reduce_ordered(
      n, kVectorBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i != end; ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
        return sum;
      },
      [](double x, double y) { return x + y; });
}

/// The largest Rayleigh quotient x^T A x / x^T D x of a power iteration from a random vector, raised.
template <class Real>
double estimate_largest(const LevelMatrix<Real>& matrix) {
  const std::size_t n = matrix.size();
  RawArray<Real> x(n), negative_image(n), next(n), zero(n);
  const auto inverse = matrix.inverse_diagonal();
  parallel_for(n, [&](std::size_t i) {
    zero[i] = 0;
    x[i] = inverse[i] > 0 ? static_cast<Real>(to_unit(hash_words(i)) - 0.5) : Real(0);
  });
  double largest = 0;
  for (int step = 0; step < kPowerSteps; ++step) {
    matrix.residual(zero.data(), x.data(), negative_image.data());
    parallel_for(n, [&](std::size_t i) { next[i] = inverse[i] > 0 ? x[i] / inverse[i] : Real(0); });
    const double scale = product_sum(n, x.data(), next.data());
    if (!(scale > 0)) break;
    largest = std::max(largest, -product_sum(n, x.data(), negative_image.data()) / scale);
    const auto factor = static_cast<Real>(1 / std::sqrt(scale));
    parallel_for(n, [&](std::size_t i) { x[i] = -factor * inverse[i] * negative_image[i]; });
  }
  return kSafety * largest;
}

}  // namespace

template <class Real>
ChebyshevSmoother<Real>::ChebyshevSmoother(const LevelMatrix<Real>& matrix, int degree, double range)
    : degree_(degree), range_(range), largest_(estimate_largest(matrix)) {}

template <class Real>
void ChebyshevSmoother<Real>::smooth(const LevelMatrix<Real>& matrix, const Real* b, bool is_zero, Real* x, Real* r,
                                     Real* d) const {
  if (!(largest_ > 0)) {
    if (is_zero) std::fill(x, x + matrix.size(), Real(0));
    return;
  }
  const double center = largest_ * (1 + 1 / range_) / 2, radius = largest_ * (1 - 1 / range_) / 2;
  const double sigma = center / radius;
  const auto inverse = matrix.inverse_diagonal();
  double rho = 1 / sigma;
  for (int k = 0; k < degree_; ++k) {
    const bool is_first = k == 0;
    const Real* residual = r;
    if (is_first && is_zero)
      residual = b;
    else
      matrix.residual(b, x, r);
    const double rho_next = is_first ? rho : 1 / (2 * sigma - rho);
    const auto keep = static_cast<Real>(is_first ? 0.0 : rho_next * rho);
    const auto step = static_cast<Real>(is_first ? 1 / center : 2 * rho_next / radius);
    const bool sets_x = is_first && is_zero;
    parallel_for(matrix.size(), [&](std::size_t i) {
      const Real move = step * inverse[i] * residual[i] + (is_first ? Real(0) : keep * d[i]);
      d[i] = move;
      x[i] = sets_x ? move : x[i] + move;
    });
    rho = rho_next;
  }
}

template class ChebyshevSmoother<float>;
template class ChebyshevSmoother<double>;

}  // namespace voropack
