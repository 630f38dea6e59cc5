#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "geom/predicates.h"
#include "mesh/incidence.h"
#include "voropack/coarsening.h"

namespace voropack {

namespace {

/// Simplices that overlap by less than this, relative to their size, along the normal of two edges only touch. Faces
/// are decided exactly.
constexpr double kTouching = 1e-12;
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

/// Where x is with respect to face i of a simplex: positive on the side of corner i, which is positively oriented.
template <int D>
int side_of_face(const Corners<D>& simplex, std::size_t i, const Vec<D>& x) {
  Corners<D> moved = simplex;
  moved[i] = x;
  if constexpr (D == 2)
    return orientation(moved[0], moved[1], moved[2]);
  else
    return orientation(moved[0], moved[1], moved[2], moved[3]);
}

/// True if the plane of a face of `a` has all of `b` on its other side.
template <int D>
bool face_separates(const Corners<D>& a, const Corners<D>& b) {
  for (std::size_t i = 0; i <= D; ++i)
    if (std::ranges::all_of(b, [&](const Vec<D>& x) { return side_of_face<D>(a, i, x) <= 0; })) return true;
  return false;
}

/// True if a plane along an edge of each has them on different sides.
bool edges_separate(const Corners<3>& a, const Corners<3>& b) {
  const auto range = [](const Corners<3>& simplex, const Vec<3>& normal) {
    std::array<double, 2> r = {dot(simplex[0], normal), dot(simplex[0], normal)};
    for (std::size_t k = 1; k < 4; ++k) {
      const double h = dot(simplex[k], normal);
      r = {std::min(r[0], h), std::max(r[1], h)};
    }
    return r;
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = k + 1; l < 4; ++l) {
          const Vec<3> normal = cross(a[j] - a[i], b[l] - b[k]);
          const auto ra = range(a, normal), rb = range(b, normal);
          const double slack = kTouching * (std::max(ra[1], rb[1]) - std::min(ra[0], rb[0]));
          if (ra[1] <= rb[0] + slack || rb[1] <= ra[0] + slack) return true;
        }
  return false;
}

/// Whether the interiors of two positively oriented simplices meet: no plane of a face, and in space none along an edge
/// of each, separates them.
template <int D>
bool interiors_meet(const Corners<D>& a, const Corners<D>& b) {
  for (int k = 0; k < D; ++k) {
    const auto less = [k](const Vec<D>& x, const Vec<D>& y) { return x[k] < y[k]; };
    const auto [a0, a1] = std::minmax_element(a.begin(), a.end(), less);
    const auto [b0, b1] = std::minmax_element(b.begin(), b.end(), less);
    if ((*a1)[k] <= (*b0)[k] || (*b1)[k] <= (*a0)[k]) return false;
  }
  if (face_separates<D>(a, b) || face_separates<D>(b, a)) return false;
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
