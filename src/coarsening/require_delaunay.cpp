#include "coarsening/require_delaunay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "geom/predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

template <int D>
int side_of(const std::array<Vec<D>, D + 1>& x) {
  if constexpr (D == 2)
    return orientation(x[0], x[1], x[2]);
  else
    return orientation(x[0], x[1], x[2], x[3]);
}

template <int D>
bool holds(const std::array<Vec<D>, D + 1>& x, const Vec<D>& apex) {
  if constexpr (D == 2)
    return in_circumball(x[0], x[1], x[2], apex) > 0;
  else
    return in_circumball(x[0], x[1], x[2], x[3], apex) > 0;
}

/// The corner of t that s does not have.
template <int D>
VertexId apex_of(const Mesh<D>& mesh, SimplexId t, SimplexId s) {
  const auto& neighbors = mesh.simplex_neighbors[t];
  for (std::size_t i = 0; i <= D; ++i)
    if (neighbors[i] == s) return mesh.simplex_vertices[t][i];
  return VertexId::none();
}

template <int D>
bool is_delaunay(const Mesh<D>& mesh, SimplexId s) {
  std::array<Vec<D>, D + 1> x;
  for (std::size_t i = 0; i <= D; ++i) x[i] = mesh.points[mesh.simplex_vertices[s][i]];
  if (side_of<D>(x) <= 0) return false;
  for (std::size_t i = 0; i <= D; ++i) {
    const SimplexId t = mesh.simplex_neighbors[s][i];
    if (t.is_none() || t < s) continue;
    const VertexId apex = apex_of(mesh, t, s);
    if (apex.is_none() || holds<D>(x, mesh.points[apex])) return false;
    std::array<Vec<D>, D + 1> beyond = x;
    beyond[i] = mesh.points[apex];
    if (side_of<D>(beyond) >= 0) return false;
  }
  return true;
}

}  // namespace

template <int D>
void require_delaunay(const Mesh<D>& mesh) {
  const std::size_t n = mesh.simplex_vertices.size();
  const std::size_t first = parallel_reduce_ordered(
      n, 4096, n,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s)
          if (!is_delaunay(mesh, SimplexId(s))) return s;
        return n;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (first == n) return;
  const Vec<D>& x = mesh.points[mesh.simplex_vertices[SimplexId(first)][0]];
  std::string place = fmt::format("({}, {}", x[0], x[1]);
  if constexpr (D == 3) place += fmt::format(", {}", x[2]);
  throw InputError(Fault{.id = "coarsen.not_delaunay",
                         .message = fmt::format("the mesh is not Delaunay at simplex {} near {})", first, place),
                         .fix = "triangulate its vertices anew (--redelaunay); `voropack check` names all places.",
                         .position = {x.coord.begin(), x.coord.end()}});
}

template void require_delaunay(const Mesh<2>&);
template void require_delaunay(const Mesh<3>&);

}  // namespace voropack
