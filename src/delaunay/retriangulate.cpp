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

#include "delaunay/face_table.h"
#include "delaunay/wall_patches.h"
#include "mesh/extent.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "voropack/delaunay.h"

namespace voropack {

namespace {

[[noreturn]] void fail(std::string message, std::vector<double> position = {}) {
  throw InputError(Fault{.id = "mesh.boundary_lost",
                         .message = std::move(message),
                         .fix = "mesh the domain again (voropack mesh)",
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

template <int D>
std::string face_text(const std::array<VertexId, D>& face) {
  std::string text = D == 2 ? "edge" : "face";
  for (const VertexId v : face) text += fmt::format(" {}", v.value());
  return text + " (counted from 0)";
}

template <int D>
[[noreturn]] void fail_at_face(const Mesh<D>& mesh, const std::array<VertexId, D>& face, const std::string& what) {
  const Vec<D>& x = mesh.points[face[0]];
  fail(face_text<D>(face) + what, {x.coord.begin(), x.coord.end()});
}

/// Faces of the new triangulation that tile the old boundary.
template <int D>
class Walls {
 public:
  struct Wall {
    std::array<VertexId, D> vertices;
    std::array<std::optional<int>, 2> region;  ///< By side (SeenFace). Nothing where no old simplex says.
    int marker = 0;
  };

  /// Takes the old faces of a patch without marker that are there where others are not: gaps of flat simplices come and
  /// go, and what else is lost is noticed by the volumes.
  Walls(const Mesh<D>& mesh, const std::vector<WallPatch<D>>& patches) : table_(0) {
    const FaceTable<D> faces(mesh);
    const auto tiles = tile_patches(mesh, patches);
    std::size_t n_most = 0;
    for (const WallPatch<D>& patch : patches) n_most += patch.faces.size();
    table_ = VertexSetTable<D>(n_most);
    for (std::size_t p = 0; p < patches.size(); ++p) {
      if (!tiles[p].empty())
        for (const auto& face : tiles[p]) add(face, patches[p]);
      else
        add_remains(mesh, faces, patches[p]);
    }
  }

  /// Null if the face is no wall.
  [[nodiscard]] const Wall* find(const std::array<VertexId, D>& face) const {
    const std::uint32_t index = table_.find(face);
    return index == table_.kAbsent ? nullptr : &walls_[index];
  }
  [[nodiscard]] const std::vector<Wall>& all() const { return walls_; }

 private:
  void add_remains(const Mesh<D>& mesh, const FaceTable<D>& faces, const WallPatch<D>& patch) {
    for (const auto& face : patch.faces) {
      const bool is_there = faces.find(face) != nullptr;
      if (is_there) add(face, patch);
      if (!is_there && patch.marker != 0)
        fail_at_face<D>(mesh, face,
                        fmt::format(" with marker {} is not in the Delaunay triangulation{}", patch.marker,
                                    D == 2 ? "" : ", nor do other faces tile the flat part of the boundary around it"));
    }
  }

  /// Faces beside the gap of a flat simplex may be walls of two patches.
  void add(const std::array<VertexId, D>& face, const WallPatch<D>& patch) {
    const std::uint32_t known = table_.insert(face, static_cast<std::uint32_t>(walls_.size()));
    if (known == table_.kAbsent) walls_.push_back({face, {}, 0});
    Wall& wall = known == table_.kAbsent ? walls_.back() : walls_[known];
    if (wall.marker == 0) wall.marker = patch.marker;
    const std::size_t front = seen_face<D>(face).side;
    for (const std::size_t behind : {0U, 1U})
      if (patch.region[behind]) wall.region[front ^ behind] = patch.region[behind];
  }

  VertexSetTable<D> table_;
  std::vector<Wall> walls_;
};

/// Gives regions to the simplices of `mesh`: beside walls from what was on the same side of them, then from neighbors
/// across faces that are no walls. None for what is outside.
template <int D>
std::vector<std::optional<int>> find_regions(const Mesh<D>& mesh, const Walls<D>& walls) {
  std::vector<std::optional<int>> region(mesh.simplex_vertices.size());
  std::vector<SimplexId> queue;
  const auto assign = [&](SimplexId s, int wanted, const std::array<VertexId, D>& face) {
    std::optional<int>& known = region[s.value()];
    if (known && *known != wanted)
      fail_at_face<D>(
          mesh, face,
          fmt::format(": regions {} and {} meet there, where no face of the mesh separates them", *known, wanted));
    if (known) return;
    known = wanted;
    queue.push_back(s);
  };
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const auto [face, side] = seen_face<D>(face_vertices(mesh, s, i));
      const auto* const wall = walls.find(face);
      if (wall != nullptr && wall->region[side]) assign(s, *wall->region[side], face);
    }
  while (!queue.empty()) {
    const SimplexId s = queue.back();
    queue.pop_back();
    for (int i = 0; i <= D; ++i) {
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      const auto face = face_vertices(mesh, s, i);
      if (!t.is_none() && walls.find(face) == nullptr) assign(t, *region[s.value()], face);
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

/// The walls, and every other end of a region with marker 0.
template <int D>
void set_boundary(Mesh<D>& mesh, const Walls<D>& walls) {
  const FaceTable<D> faces(mesh);
  for (const auto& wall : walls.all()) {
    const auto* const sides = faces.find(wall.vertices);
    if (sides == nullptr) continue;  // Nothing is left beside it.
    const auto [a, b] = sides->simplex;
    const bool ends_region = a.is_none() || b.is_none() || mesh.simplex_region[a] != mesh.simplex_region[b];
    if (wall.marker == 0 && !ends_region) continue;
    mesh.boundary_vertices.push_back(wall.vertices);
    mesh.boundary_marker.push_back(wall.marker);
  }
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      if (!t.is_none() && (t < s || mesh.simplex_region[t] == mesh.simplex_region[s])) continue;
      const auto face = boundary_face<D>(mesh.simplex_vertices[s], i);
      if (walls.find(face) != nullptr) continue;
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
    fail(fmt::format("segment edge {} {} (counted from 0) is not in the Delaunay triangulation", a.value(), b.value()),
         {x.coord.begin(), x.coord.end()});
  }
  mesh.segment_edges = old.segment_edges;
  mesh.segment_edge_marker = old.segment_edge_marker;
}

/// The volume that each region's boundary encloses: the faces of exactly one simplex of it. Overlapping simplices
/// inside do not disturb it.
template <int D>
std::map<int, double> region_volumes(const Mesh<D>& mesh, const FaceTable<D>& faces) {
  std::map<int, double> volume;
  if (mesh.simplex_vertices.empty()) return volume;
  const Vec<D> origin = mesh.points[mesh.simplex_vertices[SimplexId(0)][0]];
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      const auto face = face_vertices(mesh, s, i);
      const auto* const sides = faces.find(face);
      const auto [t, u] = sides->simplex;
      const bool is_interface = !t.is_none() && !u.is_none() && mesh.simplex_region[t] != mesh.simplex_region[u];
      if (sides->n_simplices > 1 && !is_interface) continue;
      const Vec<D> a = mesh.points[face[0]] - origin, b = mesh.points[face[1]] - origin;
      double cone = 0;
      if constexpr (D == 2)
        cone = cross(a, b) / 2;
      else
        cone = dot(cross(b, a), mesh.points[face[2]] - origin) / 6;
      volume[mesh.simplex_region[s]] += cone;
    }
  return volume;
}

/// Boundaries without marker are checked by what they enclose.
template <int D>
void check_volumes(const Mesh<D>& mesh, const Mesh<D>& old, const FaceTable<D>& old_faces) {
  constexpr double kSame = 1e-9;  // Far above rounding, and far below one simplex in a million.
  const auto now = region_volumes(mesh, FaceTable<D>(mesh)), before = region_volumes(old, old_faces);
  for (const auto& [region, volume] : before) {
    const auto found = now.find(region);
    const double other = found == now.end() ? 0 : found->second;
    if (!(std::abs(other - volume) <= kSame * volume))
      fail(
          fmt::format("region {} had the volume {:.10g} and would have {:.10g}: not all faces that bound it are in the "
                      "mesh, or in the Delaunay triangulation",
                      region, volume, other));
  }
}

}  // namespace

template <int D>
Mesh<D> retriangulate(const Mesh<D>& old, Observer& observer) {
  observer.begin_stage("delaunay");
  check_extent(old);
  Mesh<D> mesh = triangulate_vertices(old);
  observer.check_cancelled();
  const FaceTable<D> old_faces(old);
  const Walls<D> walls(mesh, find_wall_patches(old, old_faces));
  take_inside(mesh, find_regions(mesh, walls));
  set_boundary(mesh, walls);
  set_segments(mesh, old);
  check_volumes(mesh, old, old_faces);
  return mesh;
}

template Mesh<2> retriangulate(const Mesh<2>&, Observer&);
template Mesh<3> retriangulate(const Mesh<3>&, Observer&);

}  // namespace voropack
