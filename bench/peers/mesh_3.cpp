// CGAL's Delaunay refinement of a polyhedral solid with sharp edges, parallel, without the optimizers.
//
// Usage: mesh_3 SURFACE.off EDGE_LENGTH OUT.mesh [THREADS]
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/make_mesh_3.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Mesh_polyhedron_3<Kernel>::type;
using MeshDomain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<MeshDomain, CGAL::Default, CGAL::Parallel_tag>::type;
using Complex =
    CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, MeshDomain::Corner_index, MeshDomain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

int main(int argc, char** argv) {
  Polyhedron surface;
  std::ifstream file(argc > 3 ? argv[1] : "");
  if (!(file >> surface)) {
    std::cerr << "usage: mesh_3 SURFACE.off EDGE_LENGTH OUT.mesh [THREADS]\n";
    return 2;
  }
  const double size = std::atof(argv[2]);
  const int n_threads = argc > 4 ? std::atoi(argv[4]) : 1;
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n_threads));
  MeshDomain domain(surface);
  domain.detect_features();
  namespace p = CGAL::parameters;
  // Circumradius over shortest edge at most 2, as the manual's example; sizes bound circumradii.
  const double radius = 0.62 * size;
  const Criteria criteria(p::edge_size = size, p::facet_angle = 25, p::facet_size = radius,
                          p::facet_distance = 0.1 * size, p::cell_radius_edge_ratio = 2, p::cell_size = radius);
  const Complex mesh = CGAL::make_mesh_3<Complex>(domain, criteria, p::no_perturb(), p::no_exude());
  std::ofstream out(argv[3]);
  out.precision(17);
  mesh.output_to_medit(out);
  return out ? 0 : 1;
}
