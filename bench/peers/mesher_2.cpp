// CGAL's 2D Delaunay refinement of the segments of a .poly file (no holes).
//
// Usage: mesher_2 DOMAIN.poly EDGE_LENGTH OUT.node
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_2<Kernel>;
using FaceBase = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Triangulation>;

namespace {

/// Points and constraints of a .poly file with 1-based numbers.
bool read_poly(std::istream& file, Triangulation& triangulation) {
  constexpr auto kLine = std::numeric_limits<std::streamsize>::max();
  std::size_t n = 0;
  if (!(file >> n)) return false;
  file.ignore(kLine, '\n');
  std::vector<Triangulation::Vertex_handle> vertices;
  for (std::size_t i = 0; i < n; ++i) {
    double index = 0, x = 0, y = 0;
    if (!(file >> index >> x >> y)) return false;
    file.ignore(kLine, '\n');
    vertices.push_back(triangulation.insert({x, y}));
  }
  if (!(file >> n)) return false;
  file.ignore(kLine, '\n');
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t index = 0, a = 0, b = 0;
    if (!(file >> index >> a >> b)) return false;
    file.ignore(kLine, '\n');
    triangulation.insert_constraint(vertices.at(a - 1), vertices.at(b - 1));
  }
  return true;
}

void write_mesh(const Triangulation& triangulation, const std::string& path) {
  std::map<Triangulation::Vertex_handle, std::size_t> number;
  std::ofstream node(path), ele(path.substr(0, path.rfind('.')) + ".ele");
  node.precision(17);
  node << triangulation.number_of_vertices() << " 2 0 0\n";
  for (const auto v : triangulation.finite_vertex_handles()) {
    number.emplace(v, number.size() + 1);
    node << number[v] << ' ' << v->point() << '\n';
  }
  std::vector<Triangulation::Face_handle> inside;
  for (const auto f : triangulation.finite_face_handles())
    if (f->is_in_domain()) inside.push_back(f);
  ele << inside.size() << " 3 0\n";
  for (std::size_t i = 0; i < inside.size(); ++i) {
    ele << i + 1;
    for (int k = 0; k < 3; ++k) ele << ' ' << number[inside[i]->vertex(k)];
    ele << '\n';
  }
}

}  // namespace

int main(int argc, char** argv) {
  Triangulation triangulation;
  std::ifstream file(argc > 3 ? argv[1] : "");
  if (!read_poly(file, triangulation)) {
    std::cerr << "usage: mesher_2 DOMAIN.poly EDGE_LENGTH OUT.node\n";
    return 2;
  }
  // 0.125 bounds the smallest angle by 20.7 degrees, the largest bound with a proof of termination.
  CGAL::Delaunay_mesher_2<Triangulation, Criteria> mesher(triangulation, Criteria(0.125, std::atof(argv[2])));
  mesher.refine_mesh();
  write_mesh(triangulation, argv[3]);
  return 0;
}
