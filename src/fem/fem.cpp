#include "voropack/fem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "geom/quadrature.h"
#include "mesh/faces.h"
#include "solve/faults.h"
#include "solve/floating_parts.h"
#include "voropack/boundary_areas.h"

namespace voropack {

namespace {

template <int D>
double value_of(const BoundaryValue<D>& value, const Vec<D>& x) {
  if (const auto* const constant = std::get_if<double>(&value)) return *constant;
  return std::get<std::function<double(const Vec<D>&)>>(value)(x);
}

template <int D>
std::array<VertexId, D> sorted(std::array<VertexId, D> face) {
  std::sort(face.begin(), face.end());
  return face;
}

/// The measure of a segment or triangle.
double measure(const std::array<Vec<2>, 2>& p) { return distance(p[0], p[1]); }
double measure(const std::array<Vec<3>, 3>& p) { return 0.5 * norm(cross(p[1] - p[0], p[2] - p[0])); }

/// The conditions of a problem, added to a system.
template <int D>
class Conditions {
 public:
  Conditions(const Mesh<D>& mesh, const std::map<int, BoundaryCondition<D>>& conditions, LinearSystem& system)
      : mesh_(mesh), system_(system) {
    std::set<std::array<VertexId, D>> hull;
    for (const SimplexId s : ids(mesh.simplex_vertices))
      for (int i = 0; i <= D; ++i)
        if (mesh.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none())
          hull.insert(sorted<D>(face_vertices(mesh, s, i)));
    for (const BoundaryId b : ids(mesh.boundary_vertices))
      if (hull.contains(sorted<D>(mesh.boundary_vertices[b]))) faces_[mesh.boundary_marker[b]].push_back(b);
    std::set<int> inside;
    for (const auto& [marker, condition] : conditions)
      if (!faces_.contains(marker)) inside.insert(marker);
    if (!inside.empty()) inner_ = build_boundary_areas(mesh, inside);
    std::set<int> known(inner_.patch_marker.begin(), inner_.patch_marker.end());
    for (const auto& [marker, faces] : faces_) known.insert(marker);
    for (const auto& [marker, condition] : conditions) check_marker(marker, known);
  }

  /// Markers have to be given in ascending order: the first Dirichlet value of a vertex stays.
  void add(int marker, const BoundaryCondition<D>& condition) {
    const auto faces = faces_.find(marker);
    if (faces != faces_.end()) {
      for (const BoundaryId b : faces->second) std::visit([&](const auto& c) { add(b, c); }, condition);
      return;
    }
    for (const PatchId p : ids(inner_.patch_marker))
      if (inner_.patch_marker[p] == marker) std::visit([&](const auto& c) { add(p, c); }, condition);
  }

 private:
  // Inside the domain: on patches, as control volumes do.
  void add(PatchId p, const Dirichlet<D>& condition) { fix(inner_.patch_vertex[p], condition); }
  void add(PatchId p, const Neumann<D>& condition) {
    system_.load[inner_.patch_vertex[p]] +=
        inner_.patch_area[p] * value_of<D>(condition.inflow, inner_.patch_centroid[p]);
  }
  void add(PatchId p, const Robin<D>& condition) {
    const VertexId v = inner_.patch_vertex[p];
    const double transfer = inner_.patch_area[p] * value_of<D>(condition.transfer, mesh_.points[v]);
    system_.load[v] += transfer * value_of<D>(condition.outside, mesh_.points[v]);
    system_.absorption[v] += transfer;
    entry(v, v) += transfer;
  }
  void add(PatchId p, const Rate<D>& condition) {
    double area = 0;
    for (const PatchId q : ids(inner_.patch_marker))
      if (inner_.patch_marker[q] == inner_.patch_marker[p]) area += inner_.patch_area[q];
    system_.load[inner_.patch_vertex[p]] += inner_.patch_area[p] * (condition.total / area);
  }

  void fix(VertexId v, const Dirichlet<D>& condition) {
    if (system_.is_fixed[v] != 0) return;
    system_.is_fixed[v] = 1;
    system_.fixed_value[v] = value_of<D>(condition.value, mesh_.points[v]);
  }

  void add(BoundaryId b, const Dirichlet<D>& condition) {
    for (const VertexId v : mesh_.boundary_vertices[b]) fix(v, condition);
  }

  void add(BoundaryId b, const Rate<D>& condition) {
    double area = 0;
    for (const BoundaryId other : faces_.at(mesh_.boundary_marker[b])) area += measure(corners_of(other));
    for_each_point(b, [&](const auto& q, const Vec<D>&, double weight) {
      for (std::size_t i = 0; i < D; ++i)
        system_.load[mesh_.boundary_vertices[b][i]] += weight * (condition.total / area) * q.barycentric[i];
    });
  }

  void add(BoundaryId b, const Neumann<D>& condition) {
    for_each_point(b, [&](const auto& q, const Vec<D>& x, double weight) {
      for (std::size_t i = 0; i < D; ++i)
        system_.load[mesh_.boundary_vertices[b][i]] += weight * value_of<D>(condition.inflow, x) * q.barycentric[i];
    });
  }

  void add(BoundaryId b, const Robin<D>& condition) {
    const auto& corners = mesh_.boundary_vertices[b];
    for_each_point(b, [&](const auto& q, const Vec<D>& x, double weight) {
      const double transfer = weight * value_of<D>(condition.transfer, x);
      const double outside = value_of<D>(condition.outside, x);
      for (std::size_t i = 0; i < D; ++i) {
        system_.load[corners[i]] += transfer * outside * q.barycentric[i];
        system_.absorption[corners[i]] += transfer * q.barycentric[i];
        for (std::size_t j = 0; j < D; ++j)
          entry(corners[i], corners[j]) += transfer * (q.barycentric[i] * q.barycentric[j]);
      }
    });
  }

  void for_each_point(BoundaryId b, const auto& visit) const {
    const std::array<Vec<D>, D> p = corners_of(b);
    for (const QuadraturePoint<D - 1>& q : kQuadrature<D - 1>) visit(q, q.at(p), measure(p) * q.weight);
  }

  [[nodiscard]] std::array<Vec<D>, D> corners_of(BoundaryId b) const {
    std::array<Vec<D>, D> p;
    for (std::size_t i = 0; i < D; ++i) p[i] = mesh_.points[mesh_.boundary_vertices[b][i]];
    return p;
  }

  double& entry(VertexId row, VertexId column) {
    SparseMatrix& m = system_.matrix;
    const auto begin = m.columns.begin() + static_cast<std::ptrdiff_t>(m.offsets[row.value()]);
    const auto end = m.columns.begin() + static_cast<std::ptrdiff_t>(m.offsets[row.value() + std::size_t{1}]);
    return m.values[static_cast<std::size_t>(std::lower_bound(begin, end, column.value()) - m.columns.begin())];
  }

  const Mesh<D>& mesh_;
  LinearSystem& system_;
  std::map<int, std::vector<BoundaryId>> faces_;  ///< Of the hull, by marker.
  BoundaryAreas<D> inner_;                        ///< Patches of the other markers, and of the hull.
};

bool is_zero(const auto& coefficient) {
  const auto* const constant = std::get_if<double>(&coefficient);
  return constant != nullptr && *constant == 0;
}

}  // namespace

template <int D>
LinearSystem assemble_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem) {
  if (problem.source_integrals)
    fail_input("solve.cell_integrals",
               "integrals of the source over cells are given, which finite elements do not have",
               "give the source itself");
  const std::size_t n = mesh.points.size();
  LinearSystem system;
  system.matrix = stiffness_matrix(mesh, problem.conductivity);
  system.load = is_zero(problem.source) ? IdVector<VertexId, double>(n, 0.0) : load_vector(mesh, problem.source);
  system.absorption.resize(n);
  if (!is_zero(problem.reaction)) {
    const SparseMatrix mass = mass_matrix(mesh, problem.reaction);  // The same pattern: both list every edge.
    for (std::size_t e = 0; e < mass.values.size(); ++e) system.matrix.values[e] += mass.values[e];
    system.absorption = load_vector(mesh, problem.reaction);
  }
  system.is_fixed.resize(n);
  system.fixed_value.resize(n);
  Conditions<D> conditions(mesh, problem.conditions, system);
  for (const auto& [marker, condition] : problem.conditions) conditions.add(marker, condition);
  for (const VertexId v : ids(mesh.points))
    if (system.matrix.offsets[v.value() + std::size_t{1}] - system.matrix.offsets[v.value()] == 1)
      system.is_fixed[v] = 1;
  return system;
}

template <int D>
LinearSolution solve_fem(const Mesh<D>& mesh, const DiffusionProblem<D>& problem, const LinearOptions& options,
                         Observer& observer) {
  LinearSystem system = assemble_fem(mesh, problem);
  const auto regions_of = [&](const std::vector<VertexId>& vertices) {
    std::set<int> regions;
    for (const SimplexId s : ids(mesh.simplex_vertices))
      if (std::binary_search(vertices.begin(), vertices.end(), mesh.simplex_vertices[s][0]))
        regions.insert(mesh.simplex_region[s]);
    return regions;
  };
  const IdVector<VertexId, double> volume = load_vector<D>(mesh, 1.0);  // The integral of each hat function.
  const std::vector<FloatingPart> parts = ground_floating_parts(volume, regions_of, problem.mean, system);
  LinearSolution solution = solve_linear_system(system, options, observer);
  if (problem.mean) shift_to_mean(volume, parts, *problem.mean, solution.values);
  return solution;
}

template LinearSystem assemble_fem(const Mesh<2>&, const DiffusionProblem<2>&);
template LinearSystem assemble_fem(const Mesh<3>&, const DiffusionProblem<3>&);
template LinearSolution solve_fem(const Mesh<2>&, const DiffusionProblem<2>&, const LinearOptions&, Observer&);
template LinearSolution solve_fem(const Mesh<3>&, const DiffusionProblem<3>&, const LinearOptions&, Observer&);

}  // namespace voropack
