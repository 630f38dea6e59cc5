#include "unused_vertices.h"

#include <fmt/format.h>

#include <algorithm>

namespace voropack::app {

namespace {

constexpr std::size_t kMostListed = 10;

/// Calls visit with each list of corners.
template <class MeshType, class Visit>
void for_each_corners(MeshType& mesh, Visit&& visit) {
  for (auto& corners : mesh.simplex_vertices) visit(corners);
  for (auto& corners : mesh.boundary_vertices) visit(corners);
  for (auto& corners : mesh.segment_edges) visit(corners);
}

/// Leaves the values of used vertices. What is absent stays absent.
template <class T>
void select(const IdVector<VertexId, VertexId>& old_to_new, IdVector<VertexId, T>& values) {
  if (values.empty()) return;
  IdVector<VertexId, T> selected;
  for (const VertexId v : ids(old_to_new))
    if (!old_to_new[v].is_none()) selected.push_back(values[v]);
  values = std::move(selected);
}

}  // namespace

template <int D>
std::vector<VertexId> unused_vertices(const Mesh<D>& mesh) {
  IdVector<VertexId, char> is_used(mesh.points.size(), 0);
  for_each_corners(mesh, [&](const auto& corners) {
    for (const VertexId v : corners) is_used[v] = 1;
  });
  std::vector<VertexId> unused;
  for (const VertexId v : ids(mesh.points))
    if (is_used[v] == 0) unused.push_back(v);
  return unused;
}

template <int D>
Mesh<D> without(Mesh<D> mesh, const std::vector<VertexId>& unused) {
  if (unused.empty()) return mesh;
  IdVector<VertexId, VertexId> old_to_new(mesh.points.size());
  std::size_t n = 0;
  for (const VertexId v : ids(mesh.points))
    if (!std::binary_search(unused.begin(), unused.end(), v)) old_to_new[v] = VertexId(n++);
  for_each_corners(mesh, [&](auto& corners) {
    for (VertexId& v : corners) v = old_to_new[v];
  });
  select(old_to_new, mesh.points);
  select(old_to_new, mesh.vertex_spacing);
  select(old_to_new, mesh.vertex_marker);
  select(old_to_new, mesh.vertex_carrier_dimension);
  return mesh;
}

std::string unused_in_words(const std::vector<VertexId>& unused) {
  std::string text = unused.size() == 1 ? "1 vertex" : fmt::format("{} vertices", unused.size());
  text += " of no simplex: ";
  for (std::size_t i = 0; i < std::min(kMostListed, unused.size()); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", unused[i].value());
  return text + (unused.size() > kMostListed ? ", ..." : "") + " (counted from 0)";
}

template std::vector<VertexId> unused_vertices(const Mesh<2>&);
template std::vector<VertexId> unused_vertices(const Mesh<3>&);
template Mesh<2> without(Mesh<2>, const std::vector<VertexId>&);
template Mesh<3> without(Mesh<3>, const std::vector<VertexId>&);

}  // namespace voropack::app
