#include "fem/conditions.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "geom/quadrature.h"
#include "mesh/faces.h"
#include "solve/faults.h"

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

double& entry(SparseMatrix& matrix, VertexId row, VertexId column) {
  const auto begin = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row.value()]);
  const auto end = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row.value() + std::size_t{1}]);
  return matrix.values[static_cast<std::size_t>(std::lower_bound(begin, end, column.value()) - matrix.columns.begin())];
}

}  // namespace

template <int D>
Conditions<D>::Conditions(const Mesh<D>& mesh, const std::map<int, BoundaryCondition<D>>& conditions)
    : mesh_(mesh), conditions_(conditions) {
  std::map<std::array<VertexId, D>, int> hull;  // The region behind each face.
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i)
      if (mesh.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none())
        hull.emplace(sorted<D>(face_vertices(mesh, s, i)), mesh.simplex_region[s]);
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    const auto found = hull.find(sorted<D>(mesh.boundary_vertices[b]));
    if (found == hull.end()) continue;
    faces_[mesh.boundary_marker[b]].push_back({b, found->second});
    marker_area_[mesh.boundary_marker[b]] += measure(corners_of(b));
  }
  std::set<int> inside;
  for (const auto& [marker, condition] : conditions)
    if (!faces_.contains(marker)) inside.insert(marker);
  if (!inside.empty()) inner_ = build_boundary_areas(mesh, inside);
  for (const PatchId p : ids(inner_.patch_marker))
    if (is_inner(p)) marker_area_[inner_.patch_marker[p]] += inner_.patch_area[p];
  std::set<int> known;
  for (const auto& [marker, area] : marker_area_) known.insert(marker);
  for (const auto& [marker, condition] : conditions) check_marker(marker, known);
}

template <int D>
std::array<Vec<D>, D> Conditions<D>::corners_of(BoundaryId b) const {
  std::array<Vec<D>, D> p;
  for (std::size_t i = 0; i < D; ++i) p[i] = mesh_.points[mesh_.boundary_vertices[b][i]];
  return p;
}

template <int D>
void Conditions<D>::for_each_point(BoundaryId b, const auto& visit) const {
  const std::array<Vec<D>, D> p = corners_of(b);
  for (const QuadraturePoint<D - 1>& q : kQuadrature<D - 1>) visit(q.barycentric, q.at(p), measure(p) * q.weight);
}

template <int D>
const BoundaryCondition<D>* Conditions<D>::condition_of(int marker) const {
  const auto found = conditions_.find(marker);
  return found == conditions_.end() ? nullptr : &found->second;
}

template <int D>
FaceTerms<D> Conditions<D>::face_terms(BoundaryId b, const BoundaryCondition<D>& condition) const {
  FaceTerms<D> terms;
  if (const auto* const robin = std::get_if<Robin<D>>(&condition)) {
    for_each_point(b, [&](const auto& hat, const Vec<D>& x, double weight) {
      const double transfer = weight * value_of<D>(robin->transfer, x);
      const double outside = value_of<D>(robin->outside, x);
      for (std::size_t i = 0; i < D; ++i) {
        terms.inflow[i] += transfer * outside * hat[i];
        for (std::size_t j = 0; j < D; ++j) terms.transfer[i][j] += transfer * (hat[i] * hat[j]);
      }
    });
    return terms;
  }
  BoundaryValue<D> density = 0.0;
  if (const auto* const neumann = std::get_if<Neumann<D>>(&condition)) density = neumann->inflow;
  if (const auto* const rate = std::get_if<Rate<D>>(&condition))
    density = rate->total / marker_area_.at(mesh_.boundary_marker[b]);
  for_each_point(b, [&](const auto& hat, const Vec<D>& x, double weight) {
    for (std::size_t i = 0; i < D; ++i) terms.inflow[i] += weight * value_of<D>(density, x) * hat[i];
  });
  return terms;
}

/// Inside the domain: on patches, as control volumes do.
template <int D>
PatchTerm Conditions<D>::patch_term(PatchId p, const BoundaryCondition<D>& condition) const {
  const double area = inner_.patch_area[p];
  if (const auto* const neumann = std::get_if<Neumann<D>>(&condition))
    return {.inflow = area * value_of<D>(neumann->inflow, inner_.patch_centroid[p])};
  if (const auto* const rate = std::get_if<Rate<D>>(&condition))
    return {.inflow = area * (rate->total / marker_area_.at(inner_.patch_marker[p]))};
  if (const auto* const robin = std::get_if<Robin<D>>(&condition)) {
    const Vec<D>& x = mesh_.points[inner_.patch_vertex[p]];
    const double transfer = area * value_of<D>(robin->transfer, x);
    return {.inflow = transfer * value_of<D>(robin->outside, x), .transfer = transfer};
  }
  return {.is_fixed = true};
}

template <int D>
void Conditions<D>::fix(VertexId v, const Dirichlet<D>& condition, LinearSystem& system) const {
  if (system.is_fixed[v] != 0) return;
  system.is_fixed[v] = 1;
  system.fixed_value[v] = value_of<D>(condition.value, mesh_.points[v]);
}

template <int D>
void Conditions<D>::add_face(BoundaryId b, const BoundaryCondition<D>& condition, LinearSystem& system) const {
  const auto& corners = mesh_.boundary_vertices[b];
  if (const auto* const dirichlet = std::get_if<Dirichlet<D>>(&condition)) {
    for (const VertexId v : corners) fix(v, *dirichlet, system);
    return;
  }
  const FaceTerms<D> terms = face_terms(b, condition);
  for (std::size_t i = 0; i < D; ++i) {
    system.load[corners[i]] += terms.inflow[i];
    for (std::size_t j = 0; j < D; ++j) {
      if (terms.transfer[i][j] == 0) continue;
      system.absorption[corners[i]] += terms.transfer[i][j];
      entry(system.matrix, corners[i], corners[j]) += terms.transfer[i][j];
    }
  }
}

template <int D>
void Conditions<D>::add_patch(PatchId p, const BoundaryCondition<D>& condition, LinearSystem& system) const {
  const VertexId v = inner_.patch_vertex[p];
  if (const auto* const dirichlet = std::get_if<Dirichlet<D>>(&condition)) {
    fix(v, *dirichlet, system);
    return;
  }
  const PatchTerm term = patch_term(p, condition);
  system.load[v] += term.inflow;
  system.absorption[v] += term.transfer;
  entry(system.matrix, v, v) += term.transfer;
}

template <int D>
void Conditions<D>::add_to(LinearSystem& system) const {
  for (const auto& [marker, condition] : conditions_) {
    if (const auto faces = faces_.find(marker); faces != faces_.end()) {
      for (const Face& face : faces->second) add_face(face.id, condition, system);
      continue;
    }
    for (const PatchId p : ids(inner_.patch_marker))
      if (inner_.patch_marker[p] == marker) add_patch(p, condition, system);
  }
}

template <int D>
PatchFlows<D> Conditions<D>::flows(const IdVector<VertexId, double>& values) const {
  struct Sum {
    double area = 0, inflow = 0;
    bool is_fixed = false;
  };
  std::map<std::tuple<VertexId, int, int>, Sum> sums;  // Of a vertex, marker and region.
  for (const auto& [marker, faces] : faces_) {
    const BoundaryCondition<D>* const condition = condition_of(marker);
    const bool is_fixed = condition != nullptr && std::holds_alternative<Dirichlet<D>>(*condition);
    for (const Face& face : faces) {
      const FaceTerms<D> terms = condition == nullptr || is_fixed ? FaceTerms<D>{} : face_terms(face.id, *condition);
      const auto& corners = mesh_.boundary_vertices[face.id];
      for (std::size_t i = 0; i < D; ++i) {
        Sum& sum = sums[{corners[i], marker, face.region}];
        sum.is_fixed = is_fixed;
        sum.area += measure(corners_of(face.id)) / D;
        sum.inflow += terms.inflow[i];
        for (std::size_t j = 0; j < D; ++j) sum.inflow -= terms.transfer[i][j] * values[corners[j]];
      }
    }
  }
  for (const PatchId p : ids(inner_.patch_marker)) {
    if (!is_inner(p)) continue;
    const PatchTerm term = patch_term(p, *condition_of(inner_.patch_marker[p]));
    Sum& sum = sums[{inner_.patch_vertex[p], inner_.patch_marker[p], inner_.patch_region[p]}];
    sum = {inner_.patch_area[p], term.inflow - term.transfer * values[inner_.patch_vertex[p]], term.is_fixed};
  }
  PatchFlows<D> flows;
  for (const auto& [key, sum] : sums) {
    flows.boundary.patch_vertex.push_back(std::get<0>(key));
    flows.boundary.patch_marker.push_back(std::get<1>(key));
    flows.boundary.patch_region.push_back(std::get<2>(key));
    flows.boundary.patch_area.push_back(sum.area);
    flows.terms.push_back({.is_fixed = sum.is_fixed});
    flows.inflow.push_back(sum.inflow);
  }
  return flows;
}

template class Conditions<2>;
template class Conditions<3>;

}  // namespace voropack
