// Smoothing by a Chebyshev polynomial in D^-1 A.
#pragma once

#include "multigrid/level_matrix.h"

namespace voropack {

/// x += p(D^-1 A) D^-1 (b - A x), where 1 - t p(t) is the Chebyshev polynomial that is least on [largest / range,
/// largest], and 1 at 0 [Adams2003].
template <class Real>
class ChebyshevSmoother {
 public:
  ChebyshevSmoother(const LevelMatrix<Real>& matrix, int degree, double range);

  /// `r` and `d` are scratch. If is_zero, x counts as 0 and need not be set.
  void smooth(const LevelMatrix<Real>& matrix, const Real* b, bool is_zero, Real* x, Real* r, Real* d) const;
  [[nodiscard]] double largest() const { return largest_; }

 private:
  int degree_;
  double range_;
  double largest_;  ///< Bound of the eigenvalues of D^-1 A.
};

extern template class ChebyshevSmoother<float>;
extern template class ChebyshevSmoother<double>;

}  // namespace voropack
