#include "coarsening/require_delaunay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/place_text.h"
#include "geom/filtered_predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// What one simplex knows of the points beyond its faces. With its last corner as the origin, E a point, A_k the other
/// corners, V the (positive) volume and g_k the normals with A_k . g_k = V, all up to the same factor:
///   g_k . E / V are the barycentric coordinates of E, and the last one is what they leave of 1;
///   |E|^2 V - E . sum |A_k|^2 g_k is positive outside of the circumsphere.
/// So most of the work is done for all neighbors at once. It answers only what rounding cannot change: a sum of n
/// monomials of degree k, each with at most r roundings on its way, has an error below n r u M^k, where M is the
/// largest coordinate. In space n and r are at most 24 and 11 for V and the coordinates, 72 and 17 for the
/// circumsphere; in the plane less.
template <int D>
class SimplexFilter {
 public:
  void set(const Vec<D>& first, const Vec<D>& second, const Vec<D>& origin) requires(D == 2) {
    const Vec<D> a = first - origin, b = second - origin;
    normal_[0] = {b[1], -b[0]};
    normal_[1] = {-a[1], a[0]};
    normal_[2] = {a[1] - b[1], b[0] - a[0]};
    sum_ = norm_sq(a) * normal_[0] + norm_sq(b) * normal_[1];
    size_ = extent(a) + extent(b);
    finish(a, origin);
  }
  void set(const Vec<D>& first, const Vec<D>& second, const Vec<D>& third, const Vec<D>& origin) requires(D == 3) {
    const Vec<D> a = first - origin, b = second - origin, c = third - origin;
    const Vec<D> of_a = cross(c, b), of_b = cross(a, c), of_c = cross(b, a);
    normal_[0] = of_a;
    normal_[1] = of_b;
    normal_[2] = of_c;
    normal_[3] = -1.0 * (of_a + of_b + of_c);
    sum_ = norm_sq(a) * of_a + norm_sq(b) * of_b + norm_sq(c) * of_c;
    size_ = extent(a) + extent(b) + extent(c);
    finish(a, origin);
  }

  /// True only if the simplex is positively oriented.
  [[nodiscard]] bool is_positive() const { return is_in_range(size_) & (volume_ > kVolume * power<D>(size_)); }

  /// True only if y lies beyond the face opposite to corner i and outside of the circumsphere.
  [[nodiscard]] bool keeps_out(const Vec<D>& y, std::size_t i) const {
    const Vec<D> e = y - origin_;
    const double size = size_ + extent(e);
    const double coordinate = dot(e, normal_[i]) + constant_[i];
    const double outside = norm_sq(e) * volume_ - dot(e, sum_);
    return is_in_range(size) & (-coordinate > kVolume * power<D>(size)) &
           (outside > kCircumsphere * power<D + 2>(size));
  }

 private:
  static constexpr double kVolume = filter::kSlack * filter::kRoundoff * 24 * 11;
  static constexpr double kCircumsphere = filter::kSlack * filter::kRoundoff * 72 * 17;

  void finish(const Vec<D>& a, const Vec<D>& origin) {
    origin_ = origin;
    constant_[D] = volume_ = dot(a, normal_[0]);
  }

  static double extent(const Vec<D>& x) {
    double sum = 0;
    for (int k = 0; k < D; ++k) sum += std::abs(x[k]);
    return sum;
  }
  template <int N>
  static double power(double x) {
    double product = x;
    for (int k = 1; k < N; ++k) product *= x;
    return product;
  }
  /// Products of so many lengths neither overflow nor underflow.
  static bool is_in_range(double size) { return (size > filter::kSmallest) & (size < filter::kLargest); }

  Vec<D> origin_;
  std::array<Vec<D>, D + 1> normal_;
  std::array<double, D + 1> constant_{};
  Vec<D> sum_;
  double volume_ = 0, size_ = 0;
};

template <int D>
class DelaunayCheck {
 public:
  explicit DelaunayCheck(const Mesh<D>& mesh) : mesh_(mesh) {
    Box<D> box;
    for (const Vec<D>& x : mesh.points) box.add(x);
    predicates_.set_box(box);
  }

  /// The first simplex of [begin, end) that is no Delaunay simplex, or `end`. Pieces of the range go through loops that
  /// a processor can overlap: who is beyond which face, without branches, and only then where they are.
  [[nodiscard]] std::size_t find_fault(std::size_t begin, std::size_t end) const {
    Piece memory;
    for (std::size_t piece = begin; piece < end; piece += kPiece) {
      const std::size_t found = find_fault_in_piece(piece, std::min(end, piece + kPiece), memory);
      if (found != std::min(end, piece + kPiece)) return found;
    }
    return end;
  }

 private:
  static constexpr std::size_t kPiece = 32;

  /// A face of a simplex, opposite to one of its corners, and the vertex beyond.
  struct Side {
    SimplexId simplex;
    std::uint32_t corner;
    std::uint32_t apex;  ///< No vertex where the simplices beside the face do not have it in common.
  };

  struct Piece {
    std::array<Side, kPiece*(D + 1)> sides;
    std::array<SimplexFilter<D>, kPiece> filters;
  };

  [[nodiscard]] std::size_t find_fault_in_piece(std::size_t begin, std::size_t end, Piece& piece) const {
    auto& [sides, filters] = piece;
    std::size_t n_sides = 0;
    for (std::size_t s = begin; s < end; ++s) {
      const auto& corners = mesh_.simplex_vertices[SimplexId(s)];
      const std::uint32_t mine = combined(corners);
      for (std::uint32_t i = 0; i <= D; ++i) {
        const std::uint32_t t = mesh_.simplex_neighbors[SimplexId(s)][i].value();
        const std::uint32_t is_before = t < s;  // None is the largest number of all.
        const std::uint32_t theirs = combined(mesh_.simplex_vertices[SimplexId(std::size_t{is_before * t})]);
        sides[n_sides] = {SimplexId(s), i, mine ^ theirs ^ corners[i].value()};
        n_sides += is_before;
      }
    }
    std::size_t fault = end;
    for (std::size_t s = end; s-- > begin;) {
      std::apply([&](const auto&... x) { filters[s - begin].set(x...); }, corners_of(SimplexId(s)));
      if (!filters[s - begin].is_positive() && side_of(corners_of(SimplexId(s))) <= 0) fault = s;
    }
    for (std::size_t k = 0; k < n_sides; ++k) {
      const Side& side = sides[k];
      if (side.apex < mesh_.points.size()) {
        const Vec<D>& y = mesh_.points[VertexId(side.apex)];
        if (filters[side.simplex.value() - begin].keeps_out(y, side.corner)) continue;
        if (keeps_out_exactly(corners_of(side.simplex), y, side.corner)) continue;
      }
      return std::min<std::size_t>(fault, side.simplex.value());
    }
    return fault;
  }

  [[nodiscard]] std::array<Vec<D>, D + 1> corners_of(SimplexId s) const {
    const auto& v = mesh_.simplex_vertices[s];
    if constexpr (D == 2)
      return {mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]]};
    else
      return {mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]], mesh_.points[v[3]]};
  }

  [[nodiscard]] bool keeps_out_exactly(std::array<Vec<D>, D + 1> x, const Vec<D>& y, std::size_t i) const {
    if (holds(x, y)) return false;
    x[i] = y;
    return side_of(x) < 0;
  }

  [[nodiscard]] int side_of(const std::array<Vec<D>, D + 1>& x) const {
    if constexpr (D == 2)
      return predicates_.orientation(x[0], x[1], x[2]);
    else
      return predicates_.orientation(x[0], x[1], x[2], x[3]);
  }

  [[nodiscard]] bool holds(const std::array<Vec<D>, D + 1>& x, const Vec<D>& apex) const {
    if constexpr (D == 2)
      return predicates_.in_circumball(x[0], x[1], x[2], apex) > 0;
    else
      return predicates_.in_circumball(x[0], x[1], x[2], x[3], apex) > 0;
  }

  /// Of the numbers of two simplices with a common face, combined, only those of the other two corners are left.
  static std::uint32_t combined(const std::array<VertexId, D + 1>& corners) {
    std::uint32_t all = 0;
    for (const VertexId v : corners) all ^= v.value();
    return all;
  }

  const Mesh<D>& mesh_;
  FilteredPredicates<D> predicates_;
};

}  // namespace

template <int D>
void require_delaunay(const Mesh<D>& mesh) {
  const DelaunayCheck<D> check(mesh);
  const std::size_t n = mesh.simplex_vertices.size();
  const std::size_t first = parallel_reduce_ordered(
      n, 4096, n,
      [&](std::size_t begin, std::size_t end) {
        const std::size_t found = check.find_fault(begin, end);
        return found == end ? n : found;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (first == n) return;
  const Vec<D>& x = mesh.points[mesh.simplex_vertices[SimplexId(first)][0]];
  throw InputError(Fault{
      .id = "coarsen.not_delaunay",
      .message = fmt::format("the mesh is not Delaunay at simplex {} (counted from 0) near {}", first, place_text(x)),
      .fix = "triangulate its vertices anew (--redelaunay); `voropack check` names all places.",
      .position = {x.coord.begin(), x.coord.end()}});
}

template void require_delaunay(const Mesh<2>&);
template void require_delaunay(const Mesh<3>&);

}  // namespace voropack
