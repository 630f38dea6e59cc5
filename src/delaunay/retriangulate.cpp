// The vertices of a mesh, triangulated anew, with the regions and markers that it had.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geom/predicates.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "voropack/delaunay.h"

namespace voropack {

namespace {

[[noreturn]] void fail(std::string message, std::vector<double> position = {}) {
  throw InputError(Fault{.id = "mesh.boundary_lost",
                         .message = std::move(message),
                         .fix = "mesh the domain again (voropack mesh): its boundary is not Delaunay",
                         .position = std::move(position)});
}

/// The Delaunay triangulation of the vertices that simplices use; regions are not known yet.
template <int D>
Mesh<D> triangulate_vertices(const Mesh<D>& old) {
  std::vector<std::uint8_t> is_used(old.points.size());
  for (const auto& corners : old.simplex_vertices)
    for (const VertexId v : corners) is_used[v.value()] = 1;
  std::vector<Vec<D>> points;
  std::vector<VertexId> vertex;
  for (const VertexId v : ids(old.points))
    if (is_used[v.value()] != 0) {
      points.push_back(old.points[v]);
      vertex.push_back(v);
    }
  Mesh<D> mesh;
  mesh.points = old.points;
  mesh.vertex_spacing = old.vertex_spacing;
  mesh.vertex_marker = old.vertex_marker;
  mesh.vertex_carrier_dimension = old.vertex_carrier_dimension;
  for (const auto& simplex : delaunay_triangulation(points).simplices) {
    std::array<VertexId, D + 1> corners;
    for (std::size_t i = 0; i <= D; ++i) corners[i] = vertex[simplex[i]];
    mesh.simplex_vertices.push_back(corners);
  }
  mesh.simplex_region.resize(mesh.simplex_vertices.size());
  build_neighbors(mesh);
  return mesh;
}

/// The faces of a mesh with the simplices on both of their sides. Side 0 is that of a simplex that sees the face's
/// vertices, sorted, in even order.
template <int D>
class FaceTable {
 public:
  explicit FaceTable(const Mesh<D>& mesh) : table_((D + 1) * mesh.simplex_vertices.size()) {
    for (const SimplexId s : ids(mesh.simplex_vertices))
      for (int i = 0; i <= D; ++i) {
        const auto [face, side] = sorted_face(mesh, s, i);
        std::uint32_t index = table_.insert(face, static_cast<std::uint32_t>(sides_.size()));
        if (index == table_.kAbsent) {
          index = static_cast<std::uint32_t>(sides_.size());
          sides_.push_back({SimplexId::none(), SimplexId::none()});
        }
        sides_[index][side] = s;
      }
  }

  /// The simplices beside a face, or null if it is not there.
  [[nodiscard]] const std::array<SimplexId, 2>* find(const std::array<VertexId, D>& face) const {
    const std::uint32_t index = table_.find(face);
    return index == table_.kAbsent ? nullptr : &sides_[index];
  }

  /// The face opposite to corner i, sorted, and the side of it that s is on.
  static std::pair<std::array<VertexId, D>, std::size_t> sorted_face(const Mesh<D>& mesh, SimplexId s, int i) {
    std::array<VertexId, D> face = face_vertices(mesh, s, i);
    const bool is_odd = sort_vertices(face);
    return {face, is_odd ? 1U : 0U};
  }

 private:
  VertexSetTable<D> table_;
  std::vector<std::array<SimplexId, 2>> sides_;
};

template <int D>
std::string face_text(const std::array<VertexId, D>& face) {
  std::string text = D == 2 ? "edge" : "face";
  for (const VertexId v : face) text += fmt::format(" {}", v.value());
  return text;
}

/// Gives regions to the simplices of `mesh`: from old simplices on the same side of a common face, then from neighbors
/// across faces that are no boundary. None for what is outside.
template <int D>
std::vector<std::optional<int>> find_regions(const Mesh<D>& mesh, const Mesh<D>& old, const FaceTable<D>& old_faces) {
  VertexSetTable<D> walls(old.boundary_vertices.size());
  for (const BoundaryId b : ids(old.boundary_vertices)) walls.insert(old.boundary_vertices[b], b.value());
  std::vector<std::optional<int>> region(mesh.simplex_vertices.size());
  std::vector<SimplexId> queue;
  const auto assign = [&](SimplexId s, int wanted, const std::array<VertexId, D>& face) {
    std::optional<int>& known = region[s.value()];
    if (known && *known != wanted) {
      const Vec<D>& x = mesh.points[face[0]];
      fail(fmt::format("regions {} and {} meet at {}, where no old face separates them", *known, wanted,
                       face_text<D>(face)),
           {x.coord.begin(), x.coord.end()});
    }
    if (known) return;
    known = wanted;
    queue.push_back(s);
  };
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const auto [face, side] = FaceTable<D>::sorted_face(mesh, s, i);
      const auto* const beside = old_faces.find(face);
      if (beside != nullptr && !(*beside)[side].is_none()) assign(s, old.simplex_region[(*beside)[side]], face);
    }
  while (!queue.empty()) {
    const SimplexId s = queue.back();
    queue.pop_back();
    for (int i = 0; i <= D; ++i) {
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      const auto face = face_vertices(mesh, s, i);
      if (!t.is_none() && walls.find(face) == walls.kAbsent) assign(t, *region[s.value()], face);
    }
  }
  return region;
}

/// Keeps the simplices that have a region.
template <int D>
void take_inside(Mesh<D>& mesh, const std::vector<std::optional<int>>& region) {
  std::size_t kept = 0;
  for (std::size_t s = 0; s < region.size(); ++s) {
    if (!region[s]) continue;
    mesh.simplex_vertices[SimplexId(kept)] = mesh.simplex_vertices[SimplexId(s)];
    mesh.simplex_region[SimplexId(kept++)] = *region[s];
  }
  mesh.simplex_vertices.resize(kept);
  mesh.simplex_region.resize(kept);
  build_neighbors(mesh);
}

/// The old faces that are there again, and every other end of a region with marker 0.
template <int D>
void set_boundary(Mesh<D>& mesh, const Mesh<D>& old) {
  const FaceTable<D> faces(mesh);
  VertexSetTable<D> listed(old.boundary_vertices.size());
  for (const BoundaryId b : ids(old.boundary_vertices)) {
    const auto& face = old.boundary_vertices[b];
    if (faces.find(face) == nullptr) {
      if (old.boundary_marker[b] == 0) continue;  // Beside a gap, or found by the volumes.
      const Vec<D>& x = old.points[face[0]];
      fail(fmt::format("{} with marker {} is not in the Delaunay triangulation", face_text<D>(face),
                       old.boundary_marker[b]),
           {x.coord.begin(), x.coord.end()});
    }
    listed.insert(face, b.value());
    const auto& [a, c] = *faces.find(face);
    const bool ends_region = a.is_none() || c.is_none() || mesh.simplex_region[a] != mesh.simplex_region[c];
    if (old.boundary_marker[b] == 0 && !ends_region) continue;
    mesh.boundary_vertices.push_back(face);
    mesh.boundary_marker.push_back(old.boundary_marker[b]);
  }
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      if (!t.is_none() && (t < s || mesh.simplex_region[t] == mesh.simplex_region[s])) continue;
      const auto face = boundary_face<D>(mesh.simplex_vertices[s], i);
      if (listed.find(face) != listed.kAbsent) continue;
      mesh.boundary_vertices.push_back(face);
      mesh.boundary_marker.push_back(0);
    }
}

void set_segments(Mesh<2>&, const Mesh<2>&) {}
void set_segments(Mesh<3>& mesh, const Mesh<3>& old) {
  VertexSetTable<2> wanted(old.segment_edges.size());
  for (const EdgeId e : ids(old.segment_edges)) wanted.insert(old.segment_edges[e], e.value());
  IdVector<EdgeId, std::uint8_t> is_there(old.segment_edges.size());
  for (const auto& corners : mesh.simplex_vertices)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (const std::uint32_t e = wanted.find({corners[i], corners[j]}); e != wanted.kAbsent) is_there[EdgeId(e)] = 1;
  for (const EdgeId e : ids(is_there)) {
    if (is_there[e] != 0) continue;
    const auto [a, b] = old.segment_edges[e];
    const Vec<3>& x = old.points[a];
    fail(fmt::format("segment edge {} {} is not in the Delaunay triangulation", a.value(), b.value()),
         {x.coord.begin(), x.coord.end()});
  }
  mesh.segment_edges = old.segment_edges;
  mesh.segment_edge_marker = old.segment_edge_marker;
}

template <int D>
std::map<int, double> region_volumes(const Mesh<D>& mesh) {
  std::map<int, double> volume;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    const Vec<D> a = mesh.points[c[1]] - mesh.points[c[0]], b = mesh.points[c[2]] - mesh.points[c[0]];
    if constexpr (D == 2)
      volume[mesh.simplex_region[s]] += 0.5 * cross(a, b);
    else
      volume[mesh.simplex_region[s]] += dot(cross(a, b), mesh.points[c[3]] - mesh.points[c[0]]) / 6;
  }
  return volume;
}

/// Boundaries without marker are checked by what they enclose.
template <int D>
void check_volumes(const Mesh<D>& mesh, const Mesh<D>& old) {
  constexpr double kSame = 1e-9;  // Far above rounding, and far below one simplex in a million.
  const auto now = region_volumes(mesh), before = region_volumes(old);
  for (const auto& [region, volume] : before) {
    const auto found = now.find(region);
    const double other = found == now.end() ? 0 : found->second;
    if (!(std::abs(other - volume) <= kSame * volume))
      fail(fmt::format("region {} had the volume {:.10g} and would have {:.10g}", region, volume, other));
  }
}

}  // namespace

template <int D>
Mesh<D> retriangulate(const Mesh<D>& old, Observer& observer) {
  observer.begin_stage("delaunay");
  Mesh<D> mesh = triangulate_vertices(old);
  observer.check_cancelled();
  take_inside(mesh, find_regions(mesh, old, FaceTable<D>(old)));
  set_boundary(mesh, old);
  set_segments(mesh, old);
  check_volumes(mesh, old);
  return mesh;
}

template Mesh<2> retriangulate(const Mesh<2>&, Observer&);
template Mesh<3> retriangulate(const Mesh<3>&, Observer&);

}  // namespace voropack
