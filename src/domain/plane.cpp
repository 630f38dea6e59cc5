#include "domain/plane.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

namespace voropack::domain_impl {

Vec<3> area_vector(const std::vector<Vec<3>>& points, const std::vector<std::uint32_t>& polygon) {
  Vec<3> twice;
  const Vec<3>& origin = points[polygon.front()];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    twice += cross(points[polygon[i]] - origin, points[polygon[i + 1]] - origin);
  return 0.5 * twice;
}

PlaneFrame plane_frame(const Vec<3>& normal, const Vec<3>& center, const std::vector<Vec<3>>& positions) {
  PlaneFrame frame;
  for (int k = 0; k < 3; ++k) {
    bool equal = !positions.empty() && normal[k] != 0;
    for (const Vec<3>& x : positions) equal = equal && x[k] == positions.front()[k];
    if (!equal) continue;
    const bool up = normal[k] > 0;
    frame.origin[k] = positions.front()[k];
    frame.normal[k] = up ? 1 : -1;
    frame.u[(k + (up ? 1 : 2)) % 3] = 1;
    frame.v[(k + (up ? 2 : 1)) % 3] = 1;
    return frame;
  }
  frame.origin = center;
  frame.normal = normal / norm(normal);
  int smallest = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(frame.normal[k]) < std::abs(frame.normal[smallest])) smallest = k;
  Vec<3> axis;
  axis[smallest] = 1;
  frame.u = cross(axis, frame.normal);
  frame.u = frame.u / norm(frame.u);
  frame.v = cross(frame.normal, frame.u);
  return frame;
}

namespace {

constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();

struct FaceMark {
  bool inside = true;
  bool reached = false;
  std::uint32_t piece = kUnset;
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase =
    CGAL::Constrained_triangulation_face_base_2<Kernel, CGAL::Triangulation_face_base_with_info_2<FaceMark, Kernel>>;
using Tds = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Tds,
                                                       CGAL::No_constraint_intersection_requiring_constructions_tag>;
using Face = Cdt::Face_handle;
using Vertex = Cdt::Vertex_handle;

class Builder {
 public:
  explicit Builder(const PlanarProblem& problem) : problem_(problem) {}

  PlanarTriangulation run() {
    insert_points();
    insert_edges();
    if (!result_.conflicts.empty() || cdt_.dimension() < 2) return std::move(result_);
    problem_.even_odd ? mark_by_parity() : mark_by_holes();
    number_pieces();
    return std::move(result_);
  }

 private:
  void insert_points() {
    Face hint;
    for (std::uint32_t i = 0; i < problem_.points.size(); ++i) {
      const std::size_t before = cdt_.number_of_vertices();
      const Vertex v = cdt_.insert(Cdt::Point(problem_.points[i][0], problem_.points[i][1]), hint);
      if (cdt_.number_of_vertices() > before) v->info() = i;
      vertices_.push_back(v);
      hint = v->face();
    }
  }

  void insert_edges() {
    for (std::uint32_t e = 0; e < problem_.edges.size(); ++e) {
      const auto [a, b] = problem_.edges[e].ends;
      const Vertex va = vertices_[a], vb = vertices_[b];
      if (va->info() != a || vb->info() != b) {
        result_.conflicts.push_back({e, va->info() != a ? a : b});
        continue;
      }
      try {
        cdt_.insert_constraint(va, vb);
      } catch (const Cdt::Intersection_of_constraints_exception&) {
        result_.conflicts.push_back({e, kUnset});
        return;  // The triangulation is no longer valid.
      }
      Face face;
      int i = 0;
      if (!cdt_.is_edge(va, vb, face, i)) {
        result_.conflicts.push_back({e, kUnset});
        continue;
      }
      edge_of_ends_[key(va, vb)] = e;
    }
  }

  static std::uint64_t key(const Vertex& a, const Vertex& b) {
    const std::uint32_t i = a->info(), j = b->info();
    return i < j ? (std::uint64_t{i} << 32U) | j : (std::uint64_t{j} << 32U) | i;
  }

  /// The given edge opposite to corner i of a face; null for one that is not given.
  [[nodiscard]] const PlanarEdge* given_edge(const Face& face, int i) const {
    if (!face->is_constrained(i)) return nullptr;
    const auto it = edge_of_ends_.find(key(face->vertex(Cdt::cw(i)), face->vertex(Cdt::ccw(i))));
    return it == edge_of_ends_.end() ? nullptr : &problem_.edges[it->second];
  }

  void mark_by_parity() {
    std::vector<Face> stack = {cdt_.infinite_face()};
    stack.back()->info() = {false, true, kUnset};
    while (!stack.empty()) {
      const Face face = stack.back();
      stack.pop_back();
      for (int i = 0; i < 3; ++i) {
        const Face next = face->neighbor(i);
        if (next->info().reached) continue;
        const PlanarEdge* edge = given_edge(face, i);
        const bool crosses = edge != nullptr && edge->n_outline % 2 == 1;
        next->info() = {face->info().inside != crosses, true, kUnset};
        stack.push_back(next);
      }
    }
  }

  void mark_by_holes() {
    flood_outside(cdt_.infinite_face());
    for (const Vec<2>& hole : problem_.holes) {
      const Face face = cdt_.locate(Cdt::Point(hole[0], hole[1]));
      if (face != nullptr && !cdt_.is_infinite(face)) flood_outside(face);
    }
  }

  void flood_outside(const Face& start) {
    std::vector<Face> stack = {start};
    start->info().inside = false;
    while (!stack.empty()) {
      const Face face = stack.back();
      stack.pop_back();
      for (int i = 0; i < 3; ++i) {
        const Face next = face->neighbor(i);
        const PlanarEdge* edge = given_edge(face, i);
        if (!next->info().inside || (edge != nullptr && (edge->n_outline > 0 || edge->inner))) continue;
        next->info().inside = false;
        stack.push_back(next);
      }
    }
  }

  void number_pieces() {
    for (auto start = cdt_.finite_faces_begin(); start != cdt_.finite_faces_end(); ++start) {
      if (!start->info().inside || start->info().piece != kUnset) continue;
      const std::uint32_t piece = result_.n_pieces++;
      std::vector<Face> stack = {start};
      start->info().piece = piece;
      while (!stack.empty()) {
        const Face face = stack.back();
        stack.pop_back();
        result_.triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
        result_.triangle_piece.push_back(piece);
        for (int i = 0; i < 3; ++i) {
          const Face next = face->neighbor(i);
          if (face->is_constrained(i) || !next->info().inside || next->info().piece != kUnset) continue;
          next->info().piece = piece;
          stack.push_back(next);
        }
      }
    }
  }

  const PlanarProblem& problem_;
  Cdt cdt_;
  std::vector<Vertex> vertices_;
  std::unordered_map<std::uint64_t, std::uint32_t> edge_of_ends_;
  PlanarTriangulation result_;
};

}  // namespace

PlanarTriangulation triangulate_plane(const PlanarProblem& problem) { return Builder(problem).run(); }

}  // namespace voropack::domain_impl
