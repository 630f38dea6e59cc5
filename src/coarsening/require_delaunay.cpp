#include "coarsening/require_delaunay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "geom/filtered_predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Predicates whose first filter knows how large the mesh is.
template <int D>
class DelaunayCheck {
 public:
  explicit DelaunayCheck(const Mesh<D>& mesh) : mesh_(mesh) {
    Box<D> box;
    for (const Vec<D>& x : mesh.points) box.add(x);
    predicates_.set_box(box);
  }

  [[nodiscard]] bool is_delaunay(SimplexId s) const {
    std::array<Vec<D>, D + 1> x;
    for (std::size_t i = 0; i <= D; ++i) x[i] = mesh_.points[mesh_.simplex_vertices[s][i]];
    if (side_of(x) <= 0) return false;
    for (std::size_t i = 0; i <= D; ++i) {
      const SimplexId t = mesh_.simplex_neighbors[s][i];
      if (t.is_none() || t < s) continue;
      const VertexId apex = apex_of(t, s);
      if (apex.is_none() || holds(x, mesh_.points[apex])) return false;
      std::array<Vec<D>, D + 1> beyond = x;
      beyond[i] = mesh_.points[apex];
      if (side_of(beyond) >= 0) return false;
    }
    return true;
  }

 private:
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

  /// The corner of t that s does not have.
  [[nodiscard]] VertexId apex_of(SimplexId t, SimplexId s) const {
    const auto& neighbors = mesh_.simplex_neighbors[t];
    for (std::size_t i = 0; i <= D; ++i)
      if (neighbors[i] == s) return mesh_.simplex_vertices[t][i];
    return VertexId::none();
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
        for (std::size_t s = begin; s < end; ++s)
          if (!check.is_delaunay(SimplexId(s))) return s;
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
