// The sequential 3D Delaunay triangulation of the points of a .node file, inserted in Hilbert order.
//
// Usage: delaunay_3 POINTS.node
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/spatial_sort.h>

#include <chrono>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <limits>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

int main(int argc, char** argv) {
  std::ifstream file(argc > 1 ? argv[1] : "");
  std::size_t n = 0;
  if (!(file >> n)) {
    std::cerr << "usage: delaunay_3 POINTS.node\n";
    return 2;
  }
  constexpr auto kLine = std::numeric_limits<std::streamsize>::max();
  file.ignore(kLine, '\n');
  std::vector<Kernel::Point_3> points;
  for (std::size_t i = 0; i < n; ++i) {
    double index = 0, x = 0, y = 0, z = 0;
    if (!(file >> index >> x >> y >> z)) return 2;
    file.ignore(kLine, '\n');
    points.emplace_back(x, y, z);
  }
  const auto start = std::chrono::steady_clock::now();
  CGAL::spatial_sort(points.begin(), points.end());
  CGAL::Delaunay_triangulation_3<Kernel> triangulation;
  CGAL::Delaunay_triangulation_3<Kernel>::Cell_handle hint;
  for (const Kernel::Point_3& point : points) hint = triangulation.insert(point, hint)->cell();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::cout << triangulation.number_of_vertices() << " vertices, " << triangulation.number_of_finite_cells()
            << " tetrahedra, triangulation_s " << seconds.count() << '\n';
  return 0;
}
