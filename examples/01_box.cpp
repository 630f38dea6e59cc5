// A box from scratch: give points and facets, ask for an edge length, get a certified mesh and its control volumes.
//
// Usage: 01_box [FOLDER], which receives box.vtu and box_cells.vtu.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

#include "voropack/io.h"
#include "voropack/pipeline.h"

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";

  voropack::DomainInput<3> box;
  for (const double x : {0.0, 2.0})
    for (const double y : {0.0, 1.0})
      for (const double z : {0.0, 1.0}) box.points.push_back({x, y, z});
  // Each facet is one polygon; its marker names it in the mesh: 1 at x = 0, 2 at x = 2, 3 elsewhere.
  const auto add_facet = [&box](std::vector<std::uint32_t> polygon, int marker) {
    voropack::DomainInput<3>::Facet facet;
    facet.polygons = {std::move(polygon)};
    facet.marker = marker;
    box.facets.push_back(facet);
  };
  add_facet({0, 1, 3, 2}, 1);
  add_facet({4, 5, 7, 6}, 2);
  add_facet({0, 1, 5, 4}, 3);
  add_facet({2, 3, 7, 6}, 3);
  add_facet({0, 2, 6, 4}, 3);
  add_facet({1, 3, 7, 5}, 3);

  voropack::MeshingOptions<3> options;
  options.wishes.size = 0.2;
  options.wishes.marker_size = {{1, 0.08}};  // Finer at x = 0.
  try {
    const voropack::MeshingResult<3> result = voropack::make_mesh(box, options);
    voropack::write_mesh(result.mesh, folder / "box.vtu");
    voropack::write_cells(voropack::build_cell_shapes(result.mesh, result.volumes), result.volumes,
                          folder / "box_cells.vtu");
    std::printf("%zu vertices, %zu tetrahedra, volume %.15g, largest radius-edge ratio %.3g, certificate %s\n",
                result.mesh.points.size(), result.mesh.simplex_vertices.size(), result.quality.volume_sum,
                result.quality.radius_edge.max, result.certificate.ok ? "ok" : "FAILED");
    return result.certificate.ok ? 0 : 1;
  } catch (const voropack::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
