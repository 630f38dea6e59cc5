// Writes a mesh and its cells of each dimension as .vtu into the folder given, for check_vtu.py.
#include <cstdio>
#include <filesystem>
#include <vector>

#include "support/grid_mesh.h"
#include "voropack/io.h"

int main(int argc, char** argv) {
  using namespace voropack;
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_samples FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  // Large enough for several compressed blocks in an array.
  constexpr std::size_t kSide2 = 100, kSide3 = 25, kCells3 = 12;
  const Mesh<2> mesh2 = test::grid_mesh<2>(kSide2);
  std::vector<double> u;
  for (const Vec<2>& x : mesh2.points) u.push_back(x[0] + 2 * x[1]);
  const MeshArrays arrays{.vertex = {{"u", u}}, .simplex = {}};
  write_mesh(mesh2, folder / "mesh2.vtu", arrays);
  write_mesh(test::grid_mesh<3>(kSide3), folder / "mesh3.vtu");
  write_mesh(test::grid_mesh<2>(4), folder / "mesh2.node");
  write_mesh(test::grid_mesh<3>(4), folder / "mesh3.node");
  const auto polygons = test::box_cells<2>(kSide2);
  write_cells(polygons.shapes, polygons.volumes, folder / "cells2.vtu");
  const auto polyhedra = test::box_cells<3>(kCells3);
  std::vector<double> volume_twice;
  for (const double volume : polyhedra.volumes.cell_volume) volume_twice.push_back(2 * volume);
  const std::vector<NamedArray> cell_arrays = {{"volume_twice", volume_twice}};
  write_cells(polyhedra.shapes, polyhedra.volumes, folder / "cells3.vtu", cell_arrays);
  return 0;
}
