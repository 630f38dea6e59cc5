#include "spacing/affine_envelope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voropack {

namespace {

/// Orthonormal coordinates in the affine hull of a face with K + 1 corners: edge j is sum_{i <= j} r[j][i] q[i].
template <int D, int K>
struct FaceFrame {
  std::array<Vec<D>, K> q;
  std::array<std::array<double, K>, K> r;
  bool degenerate = false;
};

/// Modified Gram-Schmidt on the edges from corner 0.
template <int D, int K>
FaceFrame<D, K> orthonormalize(const std::array<Vec<D>, K>& edges) {
  FaceFrame<D, K> frame{};
  for (std::size_t j = 0; j < K; ++j) {
    Vec<D> e = edges[j];
    for (std::size_t i = 0; i < j; ++i) {
      frame.r[j][i] = dot(e, frame.q[i]);
      e -= frame.r[j][i] * frame.q[i];
    }
    frame.r[j][j] = norm(e);
    if (!(frame.r[j][j] > 0)) {
      frame.degenerate = true;
      return frame;
    }
    frame.q[j] = e / frame.r[j][j];
  }
  return frame;
}

/// The value at the stationary point of a K-face, or infinity if that is not in the face.
template <int D, int K>
double face_minimum(const std::array<Vec<D>, K + 1>& corners, const std::array<double, K + 1>& values, double slope,
                    const Vec<D>& x) {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  std::array<Vec<D>, K> edges;
  for (std::size_t j = 0; j < K; ++j) edges[j] = corners[j + 1] - corners[0];
  const FaceFrame<D, K> frame = orthonormalize<D, K>(edges);
  if (frame.degenerate) return kNothing;
  // Gradient in the frame: r g = differences of the values (r is lower triangular).
  std::array<double, K> gradient{};
  double gradient_sq = 0;
  for (std::size_t j = 0; j < K; ++j) {
    double rest = values[j + 1] - values[0];
    for (std::size_t i = 0; i < j; ++i) rest -= frame.r[j][i] * gradient[i];
    gradient[j] = rest / frame.r[j][j];
    gradient_sq += gradient[j] * gradient[j];
  }
  const double root_sq = slope * slope - gradient_sq;
  if (!(root_sq > 0)) return kNothing;
  const double root = std::sqrt(root_sq);
  // Projection of x and the stationary point in the frame's coordinates.
  Vec<D> off = x - corners[0];
  std::array<double, K> projection{};
  for (std::size_t j = 0; j < K; ++j) {
    projection[j] = dot(off, frame.q[j]);
    off -= projection[j] * frame.q[j];
  }
  const double height = K == D ? 0.0 : norm(off);
  double value = values[0] + height * root;
  std::array<double, K> barycentric{};  // Of corners 1 .. K.
  for (std::size_t j = 0; j < K; ++j) {
    value += gradient[j] * projection[j];
    barycentric[j] = projection[j] - gradient[j] * height / root;
  }
  // Solve r^T lambda = y, backwards.
  double sum = 0;
  for (std::size_t j = K; j-- > 0;) {
    for (std::size_t i = j + 1; i < K; ++i) barycentric[j] -= frame.r[i][j] * barycentric[i];
    barycentric[j] /= frame.r[j][j];
    if (barycentric[j] < 0) return kNothing;
    sum += barycentric[j];
  }
  return sum <= 1 ? value : kNothing;
}

/// The least face minimum over all K-faces of the simplex with N corners.
template <int D, int K, std::size_t N>
double faces_minimum(const std::array<Vec<D>, N>& corners, const std::array<double, N>& values, double slope,
                     const Vec<D>& x) {
  double best = std::numeric_limits<double>::infinity();
  for (unsigned subset = 1; subset < (1U << N); ++subset) {
    std::array<Vec<D>, K + 1> face;
    std::array<double, K + 1> at;
    std::size_t n = 0;
    for (std::size_t i = 0; i < N; ++i) {
      if ((subset >> i & 1U) == 0) continue;
      if (n <= K) {
        face[n] = corners[i];
        at[n] = values[i];
      }
      ++n;
    }
    if (n == K + 1) best = std::min(best, face_minimum<D, K>(face, at, slope, x));
  }
  return best;
}

template <int D, std::size_t N>
double corners_minimum(const std::array<Vec<D>, N>& corners, const std::array<double, N>& values, double slope,
                       const Vec<D>& x) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < N; ++i) best = std::min(best, values[i] + slope * distance(x, corners[i]));
  return best;
}

}  // namespace

template <int D>
double affine_envelope(const std::array<Vec<D>, D + 1>& corners, const std::array<double, D + 1>& values, double slope,
                       const Vec<D>& x) {
  // Inside, a function that is itself Lipschitz is its own envelope.
  const double inside = face_minimum<D, D>(corners, values, slope, x);
  if (inside < std::numeric_limits<double>::infinity()) return inside;
  const double best =
      std::min(corners_minimum<D>(corners, values, slope, x), faces_minimum<D, 1>(corners, values, slope, x));
  if constexpr (D == 3) return std::min(best, faces_minimum<D, 2>(corners, values, slope, x));
  return best;
}

template <int D>
double affine_envelope_of_face(const std::array<Vec<D>, D>& corners, const std::array<double, D>& values, double slope,
                               const Vec<D>& x) {
  const double inside = face_minimum<D, D - 1>(corners, values, slope, x);
  if (inside < std::numeric_limits<double>::infinity()) return inside;
  const double best = corners_minimum<D>(corners, values, slope, x);
  if constexpr (D == 3) return std::min(best, faces_minimum<D, 1>(corners, values, slope, x));
  return best;
}

template double affine_envelope<2>(const std::array<Vec<2>, 3>&, const std::array<double, 3>&, double, const Vec<2>&);
template double affine_envelope<3>(const std::array<Vec<3>, 4>&, const std::array<double, 4>&, double, const Vec<3>&);
template double affine_envelope_of_face<2>(const std::array<Vec<2>, 2>&, const std::array<double, 2>&, double,
                                           const Vec<2>&);
template double affine_envelope_of_face<3>(const std::array<Vec<3>, 3>&, const std::array<double, 3>&, double,
                                           const Vec<3>&);

}  // namespace voropack
