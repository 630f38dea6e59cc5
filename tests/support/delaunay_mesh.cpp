#include "support/delaunay_mesh.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>

#include "base/random.h"
#include "geom/predicates.h"

namespace voropack::test {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

template <int D>
using Simplices = std::vector<std::array<VertexId, D + 1>>;

Simplices<3> triangulate(const std::vector<Vec<3>>& points) {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_3<VertexId, Kernel>;
  using Cell = CGAL::Delaunay_triangulation_cell_base_3<Kernel>;
  std::vector<std::pair<Kernel::Point_3, VertexId>> input;
  for (const Vec<3>& p : points) input.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), VertexId(input.size()));
  const CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>> dt(input.begin(),
                                                                                                      input.end());
  Simplices<3> simplices;
  for (const auto& cell : dt.finite_cell_handles())
    simplices.push_back(
        {cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(), cell->vertex(3)->info()});
  return simplices;
}

Simplices<2> triangulate(const std::vector<Vec<2>>& points) {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<VertexId, Kernel>;
  std::vector<std::pair<Kernel::Point_2, VertexId>> input;
  for (const Vec<2>& p : points) input.emplace_back(Kernel::Point_2(p[0], p[1]), VertexId(input.size()));
  const CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>> dt(input.begin(),
                                                                                                input.end());
  Simplices<2> simplices;
  for (const auto& face : dt.finite_face_handles())
    simplices.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return simplices;
}

bool is_flat(const std::array<Vec<2>, 3>& p) { return orientation(p[0], p[1], p[2]) == 0; }

// Four points of one face of the unit cube: coplanar in the model, though rotations may have rounded them apart.
bool is_flat(const std::array<Vec<3>, 4>& p) { return orientation(p[0], p[1], p[2], p[3]) == 0; }

}  // namespace

template <int D>
void connect(Mesh<D>& mesh) {
  struct Side {
    std::array<VertexId, D> key, face;
    SimplexId simplex;
    std::size_t corner;
  };
  std::vector<Side> sides;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    for (std::size_t i = 0; i <= D; ++i) {
      Side side{.key = {}, .face = {}, .simplex = s, .corner = i};
      for (std::size_t k = 0; k < D; ++k) side.face[k] = mesh.simplex_vertices[s][k < i ? k : k + 1];
      side.key = side.face;
      std::sort(side.key.begin(), side.key.end());
      sides.push_back(side);
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return std::tie(a.key, a.simplex) < std::tie(b.key, b.simplex); });
  mesh.simplex_neighbors.clear();
  std::array<SimplexId, D + 1> nobody;
  nobody.fill(SimplexId::none());
  mesh.simplex_neighbors.resize(mesh.simplex_vertices.size(), nobody);
  for (std::size_t f = 0; f < sides.size();) {
    const bool pair = f + 1 < sides.size() && sides[f].key == sides[f + 1].key;
    if (pair) {
      mesh.simplex_neighbors[sides[f].simplex][sides[f].corner] = sides[f + 1].simplex;
      mesh.simplex_neighbors[sides[f + 1].simplex][sides[f + 1].corner] = sides[f].simplex;
    }
    if (!pair || mesh.simplex_region[sides[f].simplex] != mesh.simplex_region[sides[f + 1].simplex]) {
      mesh.boundary_vertices.push_back(sides[f].face);
      mesh.boundary_marker.push_back(0);
    }
    f += pair ? 2 : 1;
  }
}

template <int D>
Mesh<D> delaunay_mesh(const std::vector<Vec<D>>& points, const std::function<int(const Vec<D>&)>& region_of) {
  Mesh<D> mesh;
  mesh.points = IdVector<VertexId, Vec<D>>(points);
  Simplices<D> simplices = triangulate(points);
  std::sort(simplices.begin(), simplices.end());
  for (const auto& simplex : simplices) {
    std::array<Vec<D>, D + 1> p;
    Vec<D> mean;
    for (std::size_t k = 0; k <= D; ++k) {
      p[k] = points[simplex[k].value()];
      mean += p[k] / (D + 1.0);
    }
    if (is_flat(p)) continue;
    mesh.simplex_vertices.push_back(simplex);
    mesh.simplex_region.push_back(region_of(mean));
  }
  connect(mesh);
  return mesh;
}

template <int D>
std::vector<Vec<D>> perturbed_grid(int n, double eps, std::uint64_t seed, bool keep_middle) {
  int count = 1;
  for (int k = 0; k < D; ++k) count *= n + 1;
  std::vector<Vec<D>> points;
  Random random(seed);
  for (int g = 0; g < count; ++g) {
    Vec<D> p;
    for (int k = 0, rest = g; k < D; ++k, rest /= n + 1) {
      const int step = rest % (n + 1);
      const double move = eps * (2 * random.unit() - 1);
      const bool fixed = step == 0 || step == n || (keep_middle && k == 0 && 2 * step == n);
      p[k] = (step + (fixed ? 0 : move)) / n;
    }
    points.push_back(p);
  }
  return points;
}

template void connect(Mesh<2>&);
template void connect(Mesh<3>&);
template Mesh<2> delaunay_mesh(const std::vector<Vec<2>>&, const std::function<int(const Vec<2>&)>&);
template Mesh<3> delaunay_mesh(const std::vector<Vec<3>>&, const std::function<int(const Vec<3>&)>&);
template std::vector<Vec<2>> perturbed_grid<2>(int, double, std::uint64_t, bool);
template std::vector<Vec<3>> perturbed_grid<3>(int, double, std::uint64_t, bool);

}  // namespace voropack::test
