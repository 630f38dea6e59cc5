// The invariants of Mesh, one function for each.
#include <fmt/format.h>

#include "geom/predicates.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "voropack/error.h"
#include "voropack/mesh.h"

namespace voropack {

namespace {

template <std::size_t K>
std::string vertices_text(const std::array<VertexId, K>& vertices) {
  std::string text;
  for (const VertexId v : vertices) text += (text.empty() ? "(" : ", ") + std::to_string(v.value());
  return text + ")";
}

template <int D>
std::string find_size_fault(const Mesh<D>& mesh) {
  const std::size_t n = mesh.points.size();
  const auto differs = [](std::string_view name, std::size_t size, std::size_t wanted) {
    return size == wanted ? std::string() : fmt::format("{} has {} entries instead of {}", name, size, wanted);
  };
  const auto differs_if_present = [&](std::string_view name, std::size_t size) {
    return size == 0 ? std::string() : differs(name, size, n);
  };
  for (const std::string& fault :
       {differs("simplex_neighbors", mesh.simplex_neighbors.size(), mesh.simplex_vertices.size()),
        differs("simplex_region", mesh.simplex_region.size(), mesh.simplex_vertices.size()),
        differs("boundary_marker", mesh.boundary_marker.size(), mesh.boundary_vertices.size()),
        differs("segment_edge_marker", mesh.segment_edge_marker.size(), mesh.segment_edges.size()),
        differs_if_present("vertex_spacing", mesh.vertex_spacing.size()),
        differs_if_present("vertex_marker", mesh.vertex_marker.size()),
        differs_if_present("vertex_carrier_dimension", mesh.vertex_carrier_dimension.size())})
    if (!fault.empty()) return fault;
  for (const VertexId v : ids(mesh.points))
    if (!is_finite(mesh.points[v])) return fmt::format("vertex {} (counted from 0) is not finite", v.value());
  for (const VertexId v : ids(mesh.vertex_carrier_dimension))
    if (mesh.vertex_carrier_dimension[v] > D)
      return fmt::format("vertex {} (counted from 0) has the carrier dimension {}", v.value(),
                         mesh.vertex_carrier_dimension[v]);
  return {};
}

template <int D>
int simplex_orientation(const Mesh<D>& mesh, const std::array<VertexId, D + 1>& c) {
  if constexpr (D == 2)
    return orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]]);
  else
    return orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
}

template <int D>
std::string find_simplex_fault(const Mesh<D>& mesh) {
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& corners = mesh.simplex_vertices[s];
    for (const VertexId v : corners)
      if (v.value() >= mesh.points.size())
        return fmt::format("simplex {} (counted from 0) has the corner {} of {} vertices", s.value(), v.value(),
                           mesh.points.size());
    // A repeated corner makes it flat.
    if (simplex_orientation<D>(mesh, corners) <= 0)
      return fmt::format("simplex {} (counted from 0) with vertices {} is not positively oriented", s.value(),
                         vertices_text(corners));
  }
  return {};
}

template <int D>
std::string find_neighbor_fault(const Mesh<D>& mesh) {
  Mesh<D> rebuilt;
  rebuilt.points = mesh.points;
  rebuilt.simplex_vertices = mesh.simplex_vertices;
  try {
    build_neighbors(rebuilt);
  } catch (const InputError& error) {
    return error.faults().front().message;
  }
  for (const SimplexId s : ids(mesh.simplex_neighbors))
    for (std::size_t i = 0; i <= D; ++i)
      if (mesh.simplex_neighbors[s][i] != rebuilt.simplex_neighbors[s][i])
        return fmt::format("simplex_neighbors of simplex {} is wrong opposite to corner {} (both counted from 0)",
                           s.value(), i);
  return {};
}

template <int D>
std::string find_boundary_fault(const Mesh<D>& mesh) {
  VertexSetTable<D> listed(mesh.boundary_vertices.size());
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    for (const VertexId v : mesh.boundary_vertices[b])
      if (v.value() >= mesh.points.size())
        return fmt::format("boundary simplex {} (counted from 0) has the corner {} of {} vertices", b.value(),
                           v.value(), mesh.points.size());
    if (listed.insert(mesh.boundary_vertices[b], b.value()) != listed.kAbsent)
      return fmt::format("boundary simplex {} (counted from 0) with vertices {} is listed twice", b.value(),
                         vertices_text(mesh.boundary_vertices[b]));
  }
  std::vector<bool> is_face(mesh.boundary_vertices.size(), false);
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    for (int i = 0; i <= D; ++i) {
      const auto face = boundary_face<D>(mesh.simplex_vertices[s], i);
      const std::uint32_t index = listed.find(face);
      if (index != listed.kAbsent) {
        is_face[index] = true;
        continue;
      }
      const SimplexId neighbor = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      if (neighbor.is_none())
        return fmt::format("the hull face {} of simplex {} (counted from 0) is not listed in boundary_vertices",
                           vertices_text(face), s.value());
      if (mesh.simplex_region[neighbor] != mesh.simplex_region[s])
        return fmt::format(
            "the interface {} of simplices {} and {} (counted from 0) is not listed in boundary_vertices",
            vertices_text(face), s.value(), neighbor.value());
    }
  }
  for (const BoundaryId b : ids(mesh.boundary_vertices))
    if (!is_face[b.value()])
      return fmt::format("boundary simplex {} (counted from 0) with vertices {} is not a face of any simplex",
                         b.value(), vertices_text(mesh.boundary_vertices[b]));
  return {};
}

template <int D>
std::string find_segment_fault(const Mesh<D>& mesh) {
  if (D == 2 && !mesh.segment_edges.empty()) return "segment_edges is not empty in 2D";
  VertexSetTable<2> listed(mesh.segment_edges.size());
  for (const EdgeId e : ids(mesh.segment_edges))
    if (listed.insert(mesh.segment_edges[e], e.value()) != listed.kAbsent)
      return fmt::format("segment edge {} (counted from 0) with vertices {} is listed twice", e.value(),
                         vertices_text(mesh.segment_edges[e]));
  std::vector<bool> is_edge(mesh.segment_edges.size(), false);
  for (const auto& corners : mesh.simplex_vertices)
    for (std::size_t i = 0; i <= D; ++i)
      for (std::size_t j = i + 1; j <= D; ++j) {
        const std::uint32_t index = listed.find({corners[i], corners[j]});
        if (index != listed.kAbsent) is_edge[index] = true;
      }
  for (const EdgeId e : ids(mesh.segment_edges))
    if (!is_edge[e.value()])
      return fmt::format("segment edge {} (counted from 0) with vertices {} is not an edge of any simplex", e.value(),
                         vertices_text(mesh.segment_edges[e]));
  return {};
}

}  // namespace

template <int D>
std::string find_mesh_fault(const Mesh<D>& mesh) {
  // Later checks rely on earlier ones.
  for (const auto check : {&find_size_fault<D>, &find_simplex_fault<D>, &find_neighbor_fault<D>,
                           &find_boundary_fault<D>, &find_segment_fault<D>}) {
    std::string fault = check(mesh);
    if (!fault.empty()) return fault;
  }
  return {};
}

template std::string find_mesh_fault<2>(const Mesh<2>&);
template std::string find_mesh_fault<3>(const Mesh<3>&);

}  // namespace voropack
