#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "adaptivity/cell_neighbors.h"
#include "adaptivity/symmetric.h"
#include "voropack/adaptivity.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Samples that a fit needs for each of its unknowns: fewer leave some of them to chance.
constexpr double kSamplesPerUnknown = 1.5;
/// Neighbors of neighbors are two rings; near boundaries a third one may be needed.
constexpr int kMostRings = 3;
/// Directions in which the samples spread less than this, relatively, are taken as not spread.
constexpr double kRankTolerance = 1e-3;

/// A monomial x^exponent / exponent! of degree 1 to 3, whose coefficient is a derivative.
template <int D>
struct Monomial {
  std::array<int, D> exponent{};
  int degree = 0;
  double divisor = 1;    ///< exponent!
  int multiplicity = 1;  ///< Of the derivative among the degree^D entries of its tensor.

  [[nodiscard]] double operator()(const Vec<D>& x) const {
    double value = 1 / divisor;
    for (int k = 0; k < D; ++k)
      for (int p = 0; p < exponent[static_cast<std::size_t>(k)]; ++p) value *= x[k];
    return value;
  }
};

template <int D>
constexpr int kMonomials = D == 2 ? 9 : 19;

/// By degree, within one degree as the entries of a symmetric tensor.
template <int D>
std::array<Monomial<D>, kMonomials<D>> make_monomials() {
  std::array<Monomial<D>, kMonomials<D>> result;
  std::size_t n = 0;
  const auto add = [&](std::initializer_list<int> axes) {
    Monomial<D>& m = result[n++];
    m.degree = static_cast<int>(axes.size());
    for (const int axis : axes) ++m.exponent[static_cast<std::size_t>(axis)];
    constexpr std::array<int, 4> kFactorial = {1, 1, 2, 6};
    for (const int e : m.exponent) m.divisor *= kFactorial[static_cast<std::size_t>(e)];
    m.multiplicity = static_cast<int>(kFactorial[axes.size()] / m.divisor);
  };
  for (int k = 0; k < D; ++k) add({k});
  for (int k = 0; k < D; ++k)
    for (int l = k; l < D; ++l) add({k, l});
  for (int k = 0; k < D; ++k)
    for (int l = k; l < D; ++l)
      for (int m = l; m < D; ++m) add({k, l, m});
  return result;
}

/// The number of monomials up to a degree.
template <int D>
constexpr std::array<int, 4> kUnknowns = D == 2 ? std::array{0, 2, 5, 9} : std::array{0, 3, 9, 19};

/// Cells around a cell, ring by ring.
class Rings {
 public:
  explicit Rings(const Csr<CellId, CellId>& neighbors) : neighbors_(neighbors) {}

  /// Two rings, and more while there are fewer than `wanted` cells. Ascending, without the cell itself.
  const std::vector<CellId>& around(CellId cell, std::size_t wanted) {
    found_.assign(1, cell);
    for (int ring = 1; ring <= kMostRings && (ring <= 2 || found_.size() - 1 < wanted); ++ring) {
      const std::size_t before = found_.size();
      for (std::size_t k = 0; k < before; ++k)
        for (const CellId d : neighbors_[found_[k]]) found_.push_back(d);
      std::ranges::sort(found_);
      found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    }
    std::erase(found_, cell);
    return found_;
  }

 private:
  const Csr<CellId, CellId>& neighbors_;
  std::vector<CellId> found_;
};

/// A polynomial without constant term, about a vertex.
template <int D>
class LocalFit {
 public:
  /// Coefficients by monomial, 0 beyond the degree.
  Eigen::Matrix<double, kMonomials<D>, 1> coefficient = Eigen::Matrix<double, kMonomials<D>, 1>::Zero();

  /// `offset` and `difference` are a neighbor's position and value relative to the vertex.
  void fit(const std::vector<Vec<D>>& offset, const std::vector<double>& difference) {
    int degree = 3;
    while (degree > 1 && static_cast<double>(offset.size()) < kSamplesPerUnknown * unknowns(degree)) --degree;
    const int n = unknowns(degree);
    double scale = 0;  // Lengths of about one keep the columns comparable.
    for (const Vec<D>& x : offset) scale = std::max(scale, norm(x));
    const auto rows = static_cast<Eigen::Index>(offset.size());
    matrix_.resize(rows, n);
    right_.resize(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const Vec<D> x = offset[static_cast<std::size_t>(r)] / scale;
      const double weight = 1 / dot(x, x);
      for (int c = 0; c < n; ++c) matrix_(r, c) = weight * monomials_[static_cast<std::size_t>(c)](x);
      right_[r] = weight * difference[static_cast<std::size_t>(r)];
    }
    solver_.setThreshold(kRankTolerance);
    solver_.compute(matrix_);
    coefficient.setZero();
    coefficient.head(n) = solver_.solve(right_);
    for (int c = 0; c < n; ++c) coefficient[c] /= std::pow(scale, monomials_[static_cast<std::size_t>(c)].degree);
  }

  [[nodiscard]] double operator()(const Vec<D>& x) const {
    double value = 0;
    for (int c = 0; c < kMonomials<D>; ++c) value += coefficient[c] * monomials_[static_cast<std::size_t>(c)](x);
    return value;
  }

  /// The Frobenius norm of the tensor of the derivatives of a degree.
  [[nodiscard]] double tensor_norm(int degree) const {
    double sum = 0;
    for (int c = unknowns(degree - 1); c < unknowns(degree); ++c)
      sum += monomials_[static_cast<std::size_t>(c)].multiplicity * coefficient[c] * coefficient[c];
    return std::sqrt(sum);
  }

  static int unknowns(int degree) { return kUnknowns<D>[static_cast<std::size_t>(degree)]; }

 private:
  std::array<Monomial<D>, kMonomials<D>> monomials_ = make_monomials<D>();
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver_;
};

/// [n_faces] by how much the polynomials of both ends miss the value at the other one.
using Misses = IdVector<DualFaceId, std::array<double, 2>>;

/// What a fit says of its cell and the faces around.
template <int D>
void store(const LocalFit<D>& fit, CellId c, RecoveredDerivatives<D>& result) {
  for (int k = 0; k < D; ++k) result.gradient[c][k] = fit.coefficient[k];
  for (std::size_t k = 0; k < kSymmetricEntries<D>; ++k)
    result.hessian[c][k] = fit.coefficient[D + static_cast<Eigen::Index>(k)];
  result.curvature[c] = fit.tensor_norm(2);
  result.third[c] = fit.tensor_norm(3);
}

}  // namespace

template <int D>
RecoveredDerivatives<D> recover_derivatives(const ControlVolumes<D>& volumes, const VertexValues& values,
                                            Observer& observer) {
  observer.begin_stage("recover");
  if (values.size() != volumes.sites.size())
    throw InputError(Fault{.id = "adapt.wrong_length",
                           .message = fmt::format("{} values for {} vertices", values.size(), volumes.sites.size()),
                           .fix = "give one value for each vertex"});
  const std::size_t n = volumes.cell_vertex.size();
  const auto sides = cells_of_faces(volumes);
  const Csr<CellId, CellId> neighbors = cell_neighbors(sides, n);
  const Csr<CellId, DualFaceId> faces = faces_of_cells(sides, n);
  RecoveredDerivatives<D> result{.gradient = IdVector<CellId, Vec<D>>(n),
                                 .hessian = IdVector<CellId, SymmetricEntries<D>>(n),
                                 .curvature = IdVector<CellId, double>(n, 0.0),
                                 .third = IdVector<CellId, double>(n, 0.0),
                                 .misfit = EdgeValues(sides.size(), 0.0)};
  Misses misses(sides.size());
  const auto wanted = static_cast<std::size_t>(std::ceil(kSamplesPerUnknown * kMonomials<D>));
  constexpr std::size_t kBlock = 256;
  parallel_for((n + kBlock - 1) / kBlock,
               [&](std::size_t block) {
                 observer.check_cancelled();
                 Rings rings(neighbors);
                 LocalFit<D> fit;
                 std::vector<Vec<D>> offset;
                 std::vector<double> difference;
                 for (std::size_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) {
                   const CellId c(i);
                   const VertexId v = volumes.cell_vertex[c];
                   offset.clear();
                   difference.clear();
                   for (const CellId d : rings.around(c, wanted)) {
                     offset.push_back(volumes.sites[volumes.cell_vertex[d]] - volumes.sites[v]);
                     difference.push_back(values[volumes.cell_vertex[d]] - values[v]);
                   }
                   if (offset.empty()) continue;
                   fit.fit(offset, difference);
                   store(fit, c, result);
                   for (const DualFaceId f : faces[c]) {
                     const std::size_t side = sides[f][0] == c ? 0 : 1;
                     const VertexId w = volumes.face_vertices[f][1 - side];
                     misses[f][side] = fit(volumes.sites[w] - volumes.sites[v]) - (values[w] - values[v]);
                   }
                 }
               },
               1);
  parallel_for(sides.size(), [&](std::size_t i) {
    const DualFaceId f(i);
    result.misfit[f] = 0.5 * (misses[f][0] - misses[f][1]) / volumes.face_edge_length[f];
  });
  return result;
}

template RecoveredDerivatives<2> recover_derivatives(const ControlVolumes<2>&, const VertexValues&, Observer&);
template RecoveredDerivatives<3> recover_derivatives(const ControlVolumes<3>&, const VertexValues&, Observer&);

}  // namespace voropack
