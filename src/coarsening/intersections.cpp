#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "mesh/incidence.h"
#include "voropack/coarsening.h"

namespace voropack {

namespace {

/// Simplices that overlap by less than this, relative to their size, along a normal only touch: lattices are jittered
/// by less, and vertices on a common line or plane are rounded.
constexpr double kTouching = 1e-6;
/// Each has marks on all finer simplices.
constexpr std::size_t kBlocks = 16;

template <int D>
using Corners = std::array<Vec<D>, D + 1>;

template <int D>
Corners<D> corners_of(const Mesh<D>& mesh, SimplexId s) {
  Corners<D> x;
  for (std::size_t i = 0; i <= D; ++i) x[i] = mesh.points[mesh.simplex_vertices[s][i]];
  return x;
}

/// True if a plane with this normal has the simplices on different sides.
template <int D>
bool separates(const Vec<D>& normal, const Corners<D>& a, const Corners<D>& b) {
  if (!(norm_sq(normal) > 0)) return false;
  const auto range = [&](const Corners<D>& simplex) {
    double least = dot(simplex[0] - a[0], normal), most = least;
    for (std::size_t k = 1; k <= D; ++k) {
      const double h = dot(simplex[k] - a[0], normal);
      least = std::min(least, h);
      most = std::max(most, h);
    }
    return std::array{least, most};
  };
  const auto [a0, a1] = range(a);
  const auto [b0, b1] = range(b);
  const double slack = kTouching * (std::max(a1, b1) - std::min(a0, b0));
  return a1 <= b0 + slack || b1 <= a0 + slack;
}

/// True if the plane of a face of `simplex` separates a and b.
template <int D>
bool faces_separate(const Corners<D>& simplex, const Corners<D>& a, const Corners<D>& b) {
  for (std::size_t i = 0; i <= D; ++i) {
    const Vec<D> x = simplex[(i + 1) % (D + 1)];
    const Vec<D> u = simplex[(i + 2) % (D + 1)] - x;
    if constexpr (D == 2) {
      if (separates<2>({u[1], -u[0]}, a, b)) return true;
    } else {
      if (separates<3>(cross(u, simplex[(i + 3) % 4] - x), a, b)) return true;
    }
  }
  return false;
}

/// True if a plane along an edge of each separates them.
bool edges_separate(const Corners<3>& a, const Corners<3>& b) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = k + 1; l < 4; ++l)
          if (separates<3>(cross(a[j] - a[i], b[l] - b[k]), a, b)) return true;
  return false;
}

/// Whether the interiors of two simplices meet: convex bodies do unless a plane separates them, and those of faces and
/// of pairs of edges suffice.
template <int D>
bool interiors_meet(const Corners<D>& a, const Corners<D>& b) {
  for (int k = 0; k < D; ++k) {
    const auto less = [k](const Vec<D>& x, const Vec<D>& y) { return x[k] < y[k]; };
    const auto [a0, a1] = std::minmax_element(a.begin(), a.end(), less);
    const auto [b0, b1] = std::minmax_element(b.begin(), b.end(), less);
    if ((*a1)[k] <= (*b0)[k] || (*b1)[k] <= (*a0)[k]) return false;
  }
  if (faces_separate<D>(a, a, b) || faces_separate<D>(b, a, b)) return false;
  if constexpr (D == 3) return !edges_separate(a, b);
  return true;
}

}  // namespace

// The finer simplices that meet a coarse one are connected through their faces, and each corner of it has one.
template <int D>
IdVector<SimplexId, std::uint32_t> count_intersections(const Mesh<D>& finer, const CoarseLevel<D>& level) {
  const Csr<VertexId, SimplexId> around = invert_incidence(finer.simplex_vertices, finer.points.size());
  const std::size_t n = level.mesh.simplex_vertices.size();
  IdVector<SimplexId, std::uint32_t> counts;
  counts.resize(n);
  const std::size_t n_blocks = std::min(kBlocks, n);
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        std::vector<SimplexId> last_seen_from(finer.simplex_vertices.size());
        std::vector<SimplexId> found;
        for (std::size_t i = block * n / n_blocks; i < (block + 1) * n / n_blocks; ++i) {
          const SimplexId s(i);
          const Corners<D> coarse = corners_of(level.mesh, s);
          found.clear();
          const auto visit = [&](SimplexId t) {
            if (last_seen_from[t.value()] == s) return;
            last_seen_from[t.value()] = s;
            if (interiors_meet<D>(coarse, corners_of(finer, t))) found.push_back(t);
          };
          for (const VertexId v : level.mesh.simplex_vertices[s])
            for (const SimplexId t : around[level.finer_vertex[v]]) visit(t);
          for (std::size_t k = 0; k < found.size(); ++k)
            for (const SimplexId t : finer.simplex_neighbors[found[k]])
              if (!t.is_none()) visit(t);
          counts[s] = static_cast<std::uint32_t>(found.size());
        }
      },
      1);
  return counts;
}

template IdVector<SimplexId, std::uint32_t> count_intersections(const Mesh<2>&, const CoarseLevel<2>&);
template IdVector<SimplexId, std::uint32_t> count_intersections(const Mesh<3>&, const CoarseLevel<3>&);

}  // namespace voropack
