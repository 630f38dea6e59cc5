#include "delaunay/wall_patches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "geom/aabb_tree.h"
#include "geom/tolerance.h"

namespace voropack {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

template <int D>
double position_tolerance(const Mesh<D>& mesh) {
  Box<D> box;
  for (const Vec<D>& x : mesh.points) box.add(x);
  return absolute_tolerance(box, kOnTolerance);
}

/// The patch of one listed face.
template <int D>
WallPatch<D> patch_of_face(const Mesh<D>& mesh, const FaceTable<D>& faces, BoundaryId b) {
  WallPatch<D> patch;
  patch.faces = {mesh.boundary_vertices[b]};
  patch.marker = mesh.boundary_marker[b];
  const auto [key, front] = seen_face<D>(patch.faces[0]);
  const auto* const sides = faces.find(key);
  if (sides == nullptr) return patch;
  for (const std::size_t behind : {0U, 1U})
    if (const SimplexId s = sides->simplex[front ^ behind]; !s.is_none()) patch.region[behind] = mesh.simplex_region[s];
  return patch;
}

template <int D>
void turn(WallPatch<D>& patch) {
  for (auto& face : patch.faces) std::swap(face[0], face[1]);
  std::swap(patch.region[0], patch.region[1]);
}

/// Joins patches of one face to larger ones.
class PatchJoiner {
 public:
  PatchJoiner(const Mesh<3>& mesh, std::vector<WallPatch<3>> singles)
      : mesh_(mesh), singles_(std::move(singles)), tolerance_(position_tolerance(mesh)) {
    list_edges();
  }

  std::vector<WallPatch<3>> run() {
    std::vector<std::uint32_t> largest_first(singles_.size());
    std::iota(largest_first.begin(), largest_first.end(), 0U);
    std::stable_sort(largest_first.begin(), largest_first.end(),
                     [&](std::uint32_t f, std::uint32_t g) { return norm_sq(normal(f)) > norm_sq(normal(g)); });
    std::vector<WallPatch<3>> patches;
    is_taken_.assign(singles_.size(), 0);
    for (const std::uint32_t f : largest_first)
      if (is_taken_[f] == 0) patches.push_back(grow(f));
    return patches;
  }

 private:
  using Edge = std::array<VertexId, 2>;

  /// An edge of a face, ascending.
  struct Side {
    Edge edge;
    std::uint32_t face;
  };

  static Edge edge_of(VertexId a, VertexId b) { return a < b ? Edge{a, b} : Edge{b, a}; }

  /// across_[f][i] is the other face at the edge from corner i to the next, if a patch may go on there.
  void list_edges() {
    std::vector<Edge> segments;
    for (const auto& [a, b] : mesh_.segment_edges) segments.push_back(edge_of(a, b));
    std::sort(segments.begin(), segments.end());
    std::vector<Side> sides;
    for (std::uint32_t f = 0; f < singles_.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i) sides.push_back({edge_of(corner(f, i), corner(f, (i + 1) % 3)), f});
    std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
    across_.assign(singles_.size(), {kNone, kNone, kNone});
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
      if (end - begin != 2 || std::binary_search(segments.begin(), segments.end(), sides[begin].edge)) continue;
      link(sides[begin], sides[begin + 1]);
      link(sides[begin + 1], sides[begin]);
    }
  }

  void link(const Side& from, const Side& to) {
    for (std::size_t i = 0; i < 3; ++i)
      if (edge_of(corner(from.face, i), corner(from.face, (i + 1) % 3)) == from.edge) across_[from.face][i] = to.face;
  }

  /// The patch in the plane of face f.
  WallPatch<3> grow(std::uint32_t f) {
    const Vec<3> origin = mesh_.points[corner(f, 0)], up = normal(f);
    const double reach = tolerance_ * norm(up);
    const auto is_in_plane = [&](std::uint32_t g) {
      return std::ranges::all_of(singles_[g].faces[0],
                                 [&](VertexId v) { return std::abs(dot(up, mesh_.points[v] - origin)) <= reach; });
    };
    WallPatch<3> patch;
    patch.region = singles_[f].region;
    patch.marker = singles_[f].marker;
    std::vector<std::uint32_t> queue = {f};
    is_taken_[f] = 1;
    for (std::size_t k = 0; k < queue.size(); ++k) {
      patch.faces.push_back(singles_[queue[k]].faces[0]);
      for (const std::uint32_t g : across_[queue[k]]) {
        if (g == kNone || is_taken_[g] != 0 || singles_[g].marker != patch.marker || !is_in_plane(g)) continue;
        if (dot(normal(g), up) < 0) turn(singles_[g]);
        // Faces that lie on each other, around the gap of a flat simplex, look to opposite sides.
        if (singles_[g].region != patch.region) continue;
        is_taken_[g] = 1;
        queue.push_back(g);
      }
    }
    if (!patch.region[0]) turn(patch);
    return patch;
  }

  [[nodiscard]] VertexId corner(std::uint32_t f, std::size_t i) const { return singles_[f].faces[0][i]; }
  [[nodiscard]] Vec<3> normal(std::uint32_t f) const {
    const Vec<3>& a = mesh_.points[corner(f, 0)];
    return cross(mesh_.points[corner(f, 1)] - a, mesh_.points[corner(f, 2)] - a);
  }

  const Mesh<3>& mesh_;
  std::vector<WallPatch<3>> singles_;
  double tolerance_;
  std::vector<std::array<std::uint32_t, 3>> across_;
  std::vector<std::uint8_t> is_taken_;
};

std::vector<WallPatch<2>> join_patches(const Mesh<2>&, std::vector<WallPatch<2>> singles) {
  for (WallPatch<2>& patch : singles)
    if (!patch.region[0]) turn(patch);
  return singles;
}
std::vector<WallPatch<3>> join_patches(const Mesh<3>& mesh, std::vector<WallPatch<3>> singles) {
  return PatchJoiner(mesh, std::move(singles)).run();
}

/// Tells whether a triangle lies in the polygon of a patch, where both are tiled by triangles of the same vertices.
template <int D>
class PatchGeometry;

template <>
class PatchGeometry<2> {
 public:
  PatchGeometry(const Mesh<2>&, const std::vector<WallPatch<2>>&) {}
  /// No edge but a patch's own.
  [[nodiscard]] static bool covers(std::uint32_t, const std::array<VertexId, 2>&) { return false; }
  [[nodiscard]] static bool is_flat(std::uint32_t, const std::array<VertexId, 3>&) { return false; }
};

template <>
class PatchGeometry<3> {
 public:
  PatchGeometry(const Mesh<3>& mesh, const std::vector<WallPatch<3>>& patches)
      : mesh_(mesh), tolerance_(position_tolerance(mesh)) {
    std::vector<Box<3>> boxes;
    for (std::uint32_t p = 0; p < patches.size(); ++p) {
      origin_.push_back(mesh.points[patches[p].faces[0][0]]);
      up_.push_back(normal(patches[p].faces[0]));
      for (const auto& face : patches[p].faces) {
        faces_.push_back({p, face});
        Box<3> box;
        for (const VertexId v : face) box.add(mesh.points[v]);
        boxes.push_back(box);
      }
    }
    tree_ = AabbTree<3>(std::move(boxes));
  }

  /// Whether all corners are in the plane of patch p.
  [[nodiscard]] bool is_flat(std::uint32_t p, const std::array<VertexId, 4>& simplex) const {
    const double reach = tolerance_ * norm(up_[p]);
    return std::ranges::all_of(
        simplex, [&](VertexId v) { return std::abs(dot(up_[p], mesh_.points[v] - origin_[p])) <= reach; });
  }

  /// Whether the triangle, whose corners are vertices of patch p, lies in it and turns as it does.
  [[nodiscard]] bool covers(std::uint32_t p, const std::array<VertexId, 3>& triangle) const {
    const Vec<3> own = normal(triangle);
    if (!(dot(own, up_[p]) > 0) || is_needle(triangle, own)) return false;
    const Vec<3> middle =
        (1.0 / 3) * (mesh_.points[triangle[0]] + mesh_.points[triangle[1]] + mesh_.points[triangle[2]]);
    Box<3> around;
    around.add(middle);
    around.inflate(tolerance_);
    bool is_inside = false;
    tree_.visit_overlaps(around, [&](std::uint32_t f) {
      is_inside = is_inside || (faces_[f].patch == p && holds(faces_[f].vertices, middle));
    });
    return is_inside;
  }

 private:
  struct Face {
    std::uint32_t patch;
    std::array<VertexId, 3> vertices;
  };

  [[nodiscard]] Vec<3> normal(const std::array<VertexId, 3>& face) const {
    const Vec<3>& a = mesh_.points[face[0]];
    return cross(mesh_.points[face[1]] - a, mesh_.points[face[2]] - a);
  }

  /// Vertices along a straight edge, up to rounding.
  [[nodiscard]] bool is_needle(const std::array<VertexId, 3>& face, const Vec<3>& own) const {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, distance(mesh_.points[face[i]], mesh_.points[face[(i + 1) % 3]]));
    return norm(own) <= tolerance_ * longest;
  }

  /// Whether the point, which is in the plane of the face, lies in it or on its edges.
  [[nodiscard]] bool holds(const std::array<VertexId, 3>& face, const Vec<3>& x) const {
    const Vec<3> up = normal(face);
    const double slack = -kOnTolerance * norm_sq(up);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec<3>&a = mesh_.points[face[i]], &b = mesh_.points[face[(i + 1) % 3]];
      if (dot(cross(b - a, x - a), up) < slack) return false;
    }
    return true;
  }

  const Mesh<3>& mesh_;
  double tolerance_;
  std::vector<Vec<3>> origin_, up_;  ///< By patch: its plane.
  std::vector<Face> faces_;
  AabbTree<3> tree_;
};

template <int D>
class PatchTiler {
 public:
  using Face = std::array<VertexId, D>;

  PatchTiler(const Mesh<D>& mesh, const std::vector<WallPatch<D>>& patches)
      : mesh_(mesh), patches_(patches), geometry_(mesh, patches), patches_at_(mesh.points.size()), own_(n_faces()) {
    for (std::uint32_t p = 0; p < patches.size(); ++p)
      for (const Face& face : patches[p].faces) {
        own_.insert(face, static_cast<std::uint32_t>(own_faces_.size()));
        own_faces_.push_back({p, face});
        for (const VertexId v : face)
          if (patches_at_[v.value()].empty() || patches_at_[v.value()].back() != p) patches_at_[v.value()].push_back(p);
      }
  }

  std::vector<std::vector<Face>> run() {
    tiles_.resize(patches_.size());
    for (const SimplexId s : ids(mesh_.simplex_vertices))
      for (int i = 0; i <= D; ++i) look_at(s, i);
    for (std::size_t p = 0; p < tiles_.size(); ++p)
      if (tiles_[p].size() != patches_[p].faces.size() || outline(tiles_[p]) != outline(patches_[p].faces))
        tiles_[p].clear();
    return std::move(tiles_);
  }

 private:
  struct OwnFace {
    std::uint32_t patch;
    Face vertices;
  };

  [[nodiscard]] std::size_t n_faces() const {
    return std::accumulate(patches_.begin(), patches_.end(), std::size_t{0},
                           [](std::size_t n, const WallPatch<D>& patch) { return n + patch.faces.size(); });
  }

  [[nodiscard]] bool is_on(VertexId v, std::uint32_t p) const {
    return std::binary_search(patches_at_[v.value()].begin(), patches_at_[v.value()].end(), p);
  }

  /// The face opposite to corner i of s, seen from s.
  void look_at(SimplexId s, int i) {
    const Face face = face_vertices(mesh_, s, i);
    if (std::ranges::any_of(face, [&](VertexId v) { return patches_at_[v.value()].empty(); })) return;
    const bool is_hull = mesh_.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none();
    // Some vertices, such as the tip of a cone, are in as many patches as there are faces around them.
    const VertexId of_fewest =
        *std::ranges::min_element(face, {}, [&](VertexId v) { return patches_at_[v.value()].size(); });
    for (const std::uint32_t p : patches_at_[of_fewest.value()]) {
      if (!std::ranges::all_of(face, [&](VertexId v) { return is_on(v, p); })) continue;
      if (geometry_.is_flat(p, mesh_.simplex_vertices[s])) continue;
      if (is_tile(p, face)) tiles_[p].push_back(face);
      if (!is_hull || patches_[p].region[0]) continue;
      // Nothing tells in front from behind, such as at the faces of a flat simplex that was left out.
      Face back = face;
      std::swap(back[0], back[1]);
      if (is_tile(p, back)) tiles_[p].push_back(back);
    }
  }

  [[nodiscard]] bool is_tile(std::uint32_t p, const Face& face) const {
    const std::uint32_t f = own_.find(face);
    if (f != own_.kAbsent && own_faces_[f].patch == p)
      return seen_face<D>(face).side == seen_face<D>(own_faces_[f].vertices).side;
    return geometry_.covers(p, face);
  }

  /// Directed edges (in the plane: ends) that no other face has the other way, sorted.
  static auto outline(const std::vector<Face>& faces) {
    using Border = std::array<VertexId, D>;
    std::vector<Border> borders;
    for (const Face& face : faces) {
      if constexpr (D == 2)
        borders.push_back(face);
      else
        for (std::size_t i = 0; i < D; ++i) borders.push_back({face[i], face[(i + 1) % D], VertexId(0)});
    }
    std::sort(borders.begin(), borders.end());
    std::vector<Border> open;
    for (const Border& border : borders) {
      Border back = border;
      std::swap(back[0], back[1]);
      if (D == 2 || !std::binary_search(borders.begin(), borders.end(), back)) open.push_back(border);
    }
    return open;
  }

  const Mesh<D>& mesh_;
  const std::vector<WallPatch<D>>& patches_;
  PatchGeometry<D> geometry_;
  std::vector<std::vector<std::uint32_t>> patches_at_;  ///< By vertex, ascending.
  VertexSetTable<D> own_;
  std::vector<OwnFace> own_faces_;
  std::vector<std::vector<Face>> tiles_;
};

}  // namespace

template <int D>
std::vector<WallPatch<D>> find_wall_patches(const Mesh<D>& mesh, const FaceTable<D>& faces) {
  std::vector<WallPatch<D>> singles;
  for (const BoundaryId b : ids(mesh.boundary_vertices)) singles.push_back(patch_of_face(mesh, faces, b));
  return join_patches(mesh, std::move(singles));
}

template <int D>
std::vector<std::vector<std::array<VertexId, D>>> tile_patches(const Mesh<D>& mesh,
                                                               const std::vector<WallPatch<D>>& patches) {
  return PatchTiler<D>(mesh, patches).run();
}

template std::vector<WallPatch<2>> find_wall_patches(const Mesh<2>&, const FaceTable<2>&);
template std::vector<WallPatch<3>> find_wall_patches(const Mesh<3>&, const FaceTable<3>&);
template std::vector<std::vector<std::array<VertexId, 2>>> tile_patches<2>(const Mesh<2>&,
                                                                           const std::vector<WallPatch<2>>&);
template std::vector<std::vector<std::array<VertexId, 3>>> tile_patches<3>(const Mesh<3>&,
                                                                           const std::vector<WallPatch<3>>&);

}  // namespace voropack
