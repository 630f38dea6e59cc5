#include "dual/shape_points.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "geom/circumcenter.h"
#include "geom/predicates.h"
#include "geom/tolerance.h"
#include "mesh/faces.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Points farther apart than this, relative to the simplex, do not coincide; nearer ones are tested exactly.
constexpr double kNear = 1e-9;

template <int D>
std::array<Vec<D>, D + 1> corners(const Mesh<D>& mesh, SimplexId s) {
  std::array<Vec<D>, D + 1> p;
  for (std::size_t k = 0; k <= D; ++k) p[k] = mesh.points[mesh.simplex_vertices[s][k]];
  return p;
}

bool on_sphere(const std::array<Vec<2>, 3>& p, const Vec<2>& e) { return in_circumball(p[0], p[1], p[2], e) == 0; }
bool on_sphere(const std::array<Vec<3>, 4>& p, const Vec<3>& e) {
  return in_circumball(p[0], p[1], p[2], p[3], e) == 0;
}

bool on_diametral_sphere(const std::array<Vec<2>, 2>& f, const Vec<2>& e) {
  return in_diametral_ball(f[0], f[1], e) == 0;
}
bool on_diametral_sphere(const std::array<Vec<3>, 3>& f, const Vec<3>& e) {
  return in_diametral_ball(f[0], f[1], f[2], e) == 0;
}

template <int D>
std::array<Vec<D>, D> face_positions(const Mesh<D>& mesh, SimplexId s, int i) {
  std::array<Vec<D>, D> p;
  const std::array<VertexId, D> face = face_vertices(mesh, s, i);
  for (std::size_t k = 0; k < D; ++k) p[k] = mesh.points[face[k]];
  return p;
}

Vec<2> wall_position(const std::array<Vec<2>, 2>& p) { return 0.5 * (p[0] + p[1]); }
Vec<3> wall_position(const std::array<Vec<3>, 3>& p) { return triangle_circumcenter(p[0], p[1], p[2]); }

}  // namespace

template <int D>
ShapePoints<D>::ShapePoints(const Mesh<D>& mesh) {
  list_walls(mesh);
  find_creases(mesh);
  place(mesh);
  merge_coinciding(mesh);
}

template <int D>
void ShapePoints<D>::list_walls(const Mesh<D>& mesh) {
  const auto key = [](SimplexId s, int i) { return s.value() * std::uint64_t{D + 1} + static_cast<unsigned>(i); };
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    for (int i = 0; i <= D; ++i) {
      if (!neighbor_in_region(mesh, s, i).is_none()) continue;
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
      if (!t.is_none() && mesh.simplex_region[t] < mesh.simplex_region[s]) continue;
      const auto wall = static_cast<std::uint32_t>(walls_.size());
      walls_.push_back({s, i});
      sides_.push_back({key(s, i), wall});
      if (!t.is_none()) sides_.push_back({key(t, mirror_corner(mesh, s, t, i)), wall});
      if constexpr (D == 3) {
        const std::array<VertexId, 3> f = face_vertices(mesh, s, i);
        for (std::size_t k = 0; k < 3; ++k) {
          const auto [a, b] = std::minmax(f[k], f[(k + 1) % 3]);
          wall_edges_.push_back({a, b});
        }
      }
    }
  }
  std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
  std::sort(wall_edges_.begin(), wall_edges_.end());
  wall_edges_.erase(std::unique(wall_edges_.begin(), wall_edges_.end()), wall_edges_.end());
}

template <int D>
void ShapePoints<D>::place(const Mesh<D>& mesh) {
  positions_ = mesh.points.raw();
  first_midpoint_ = positions_.size();
  for (const auto& [a, b] : wall_edges_) positions_.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
  first_wall_ = positions_.size();
  for (const Wall& wall : walls_) positions_.push_back(wall_position(face_positions(mesh, wall.simplex, wall.corner)));
  first_simplex_ = positions_.size();
  const std::size_t n = first_simplex_ + mesh.simplex_vertices.size();
  if (n > std::numeric_limits<std::uint32_t>::max()) {
    throw LimitError(Fault{.id = "dual.too_many_points",
                           .message = std::to_string(n) + " corner points of cells exceed 32-bit numbers",
                           .fix = "mesh the domain in parts"});
  }
  positions_.reserve(n);
  for (const SimplexId s : ids(mesh.simplex_vertices)) positions_.push_back(circumcenter<D>(corners(mesh, s)));
}

template <int D>
void ShapePoints<D>::merge_coinciding(const Mesh<D>& mesh) {
  parent_.resize(positions_.size());
  for (std::size_t p = 0; p < parent_.size(); ++p) parent_[p] = static_cast<std::uint32_t>(p);
  const auto center = [&](SimplexId s) { return static_cast<std::uint32_t>(first_simplex_ + s.value()); };
  // An exact test for points that are near to each other, and equality for what rounding has made one.
  const auto coincide = [&](std::uint32_t a, std::uint32_t b, double size_sq, auto&& exactly) {
    if (positions_[a] == positions_[b]) return true;
    return distance_sq(positions_[a], positions_[b]) < kNear * kNear * size_sq && exactly();
  };
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const std::array<Vec<D>, D + 1> p = corners(mesh, s);
    const double size_sq = distance_sq(p[0], p[1]);
    for (int i = 0; i <= D; ++i) {
      const auto corner = static_cast<std::size_t>(i);
      const SimplexId t = neighbor_in_region(mesh, s, i);
      if (t.is_none()) {
        const std::uint32_t wall = wall_number(s, i);
        if (coincide(center(s), wall, size_sq,
                     [&] { return on_diametral_sphere(face_positions(mesh, s, i), p[corner]); }))
          merge(center(s), wall);
      } else if (s < t) {
        const auto mirror = static_cast<std::size_t>(mirror_corner(mesh, s, t, i));
        const Vec<D>& below = mesh.points[mesh.simplex_vertices[t][mirror]];
        if (coincide(center(s), center(t), size_sq, [&] { return on_sphere(p, below); })) merge(center(s), center(t));
      }
    }
  }
  if constexpr (D == 3) {
    for (const Wall& wall : walls_) {
      const std::array<VertexId, 3> f = face_vertices(mesh, wall.simplex, wall.corner);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec<3>&a = mesh.points[f[k]], &b = mesh.points[f[(k + 1) % 3]], &c = mesh.points[f[(k + 2) % 3]];
        const std::uint32_t number = wall_number(wall.simplex, wall.corner);
        const std::uint32_t middle = midpoint_number(f[k], f[(k + 1) % 3]);
        if (coincide(number, middle, distance_sq(a, b), [&] { return in_diametral_ball(a, b, c) == 0; }))
          merge(number, middle);
      }
    }
  }
  for (std::size_t p = 0; p < parent_.size(); ++p) parent_[p] = root(static_cast<std::uint32_t>(p));
}

template <int D>
std::uint32_t ShapePoints<D>::root(std::uint32_t p) const {
  while (parent_[p] != p) p = parent_[p];
  return p;
}

template <int D>
void ShapePoints<D>::merge(std::uint32_t a, std::uint32_t b) {
  a = root(a);
  b = root(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

template <int D>
std::uint32_t ShapePoints<D>::wall_number(SimplexId s, int i) const {
  const std::uint64_t key = s.value() * std::uint64_t{D + 1} + static_cast<unsigned>(i);
  const auto side = std::lower_bound(sides_.begin(), sides_.end(), key,
                                     [](const Side& x, std::uint64_t value) { return x.key < value; });
  return static_cast<std::uint32_t>(first_wall_ + side->wall);
}

template <int D>
std::size_t ShapePoints<D>::wall_edge_index(VertexId a, VertexId b) const {
  const std::array<VertexId, 2> edge{std::min(a, b), std::max(a, b)};
  return static_cast<std::size_t>(std::lower_bound(wall_edges_.begin(), wall_edges_.end(), edge) - wall_edges_.begin());
}

template <int D>
std::uint32_t ShapePoints<D>::midpoint_number(VertexId a, VertexId b) const {
  return static_cast<std::uint32_t>(first_midpoint_ + wall_edge_index(a, b));
}

/// An edge is no crease if exactly two walls meet there, between the same regions and in one plane, and it is no part
/// of a segment.
template <int D>
void ShapePoints<D>::find_creases(const Mesh<D>& mesh) {
  if constexpr (D == 3) {
    constexpr std::uint32_t kNone = 0xffffffffU;
    is_crease_.assign(wall_edges_.size(), 1);
    std::vector<std::uint32_t> n_walls(wall_edges_.size(), 0), first(wall_edges_.size(), kNone);
    const auto unit_normal = [&](std::uint32_t w) {
      const auto p = face_positions(mesh, walls_[w].simplex, walls_[w].corner);
      const Vec<3> n = cross(p[1] - p[0], p[2] - p[0]);
      return n / norm(n);
    };
    const auto regions = [&](std::uint32_t w) {
      const SimplexId s = walls_[w].simplex;
      const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(walls_[w].corner)];
      return std::pair(mesh.simplex_region[s], t.is_none() ? std::optional<int>() : mesh.simplex_region[t]);
    };
    for (std::uint32_t w = 0; w < walls_.size(); ++w) {
      const auto f = face_vertices(mesh, walls_[w].simplex, walls_[w].corner);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t e = wall_edge_index(f[k], f[(k + 1) % 3]);
        if (++n_walls[e] == 1) first[e] = w;
        const bool flat = n_walls[e] == 2 && regions(first[e]) == regions(w) &&
                          dot(unit_normal(first[e]), unit_normal(w)) > 0 &&
                          norm(cross(unit_normal(first[e]), unit_normal(w))) < kCoplanarAngle;
        is_crease_[e] = flat ? 0 : 1;
      }
    }
    for (const auto& [a, b] : mesh.segment_edges) {
      const std::size_t e = wall_edge_index(a, b);
      if (e < wall_edges_.size() && wall_edges_[e] == std::array{std::min(a, b), std::max(a, b)}) is_crease_[e] = 1;
    }
  }
}

template class ShapePoints<2>;
template class ShapePoints<3>;

}  // namespace voropack
