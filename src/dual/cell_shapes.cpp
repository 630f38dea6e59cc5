// The cells as polygons and polyhedra, from the rings of simplices around vertices and edges.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <tuple>

#include "dual/shape_points.h"
#include "mesh/faces.h"
#include "mesh/incidence.h"
#include "voropack/dual.h"

namespace voropack {

namespace {

/// Finds the cell of a vertex in a region.
class CellIndex {
 public:
  template <int D>
  explicit CellIndex(const ControlVolumes<D>& volumes) : first_(volumes.sites.size()), region_(volumes.cell_region) {
    for (std::size_t c = volumes.cell_vertex.size(); c-- > 0;) first_[volumes.cell_vertex[CellId(c)]] = CellId(c);
  }
  [[nodiscard]] CellId find(VertexId v, int region) const {
    CellId c = first_[v];
    while (region_[c] != region) ++c;
    return c;
  }

 private:
  IdVector<VertexId, CellId> first_;
  const IdVector<CellId, int>& region_;
};

/// Drops points that repeat their predecessor, cyclically.
void drop_repeats(std::vector<std::uint32_t>& polygon) {
  polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
  while (polygon.size() > 1 && polygon.back() == polygon.front()) polygon.pop_back();
}

template <int D>
std::size_t corner_of(const Mesh<D>& mesh, SimplexId s, VertexId v) {
  std::size_t k = 0;
  while (mesh.simplex_vertices[s][k] != v) ++k;
  return k;
}

/// Keeps only the points that are used, in the order of their numbers.
template <int D>
void compact_points(const std::vector<Vec<D>>& positions, std::vector<std::uint32_t>& uses, CellShapes<D>& shapes) {
  std::vector<std::uint32_t> new_number(positions.size(), 0);
  for (const std::uint32_t p : uses) new_number[p] = 1;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    if (new_number[p] == 0) continue;
    new_number[p] = static_cast<std::uint32_t>(shapes.points.size());
    shapes.points.push_back(positions[p]);
  }
  for (std::uint32_t& p : uses) p = new_number[p];
}

// ---- Polygons ----

/// Simplex s at vertex i, whose other corners are `from` and `to` in counterclockwise order.
struct Corner2 {
  SimplexId s;
  std::size_t from, to;  ///< Corners of s.
};

Corner2 corner_at(const Mesh<2>& mesh, SimplexId s, VertexId i) {
  const std::size_t own = corner_of(mesh, s, i);
  return {s, (own + 1) % 3, (own + 2) % 3};
}

/// Appends the part of i's polygon that the simplices connected with `start` make. False if a simplex before `start`
/// is among them: then that one has made it already.
bool append_fan(const Mesh<2>& mesh, const ShapePoints<2>& points, VertexId i, SimplexId start,
                std::vector<std::uint32_t>& polygon) {
  Corner2 c = corner_at(mesh, start, i);
  bool closed = false;
  while (true) {  // Clockwise to the wall.
    const SimplexId t = neighbor_in_region(mesh, c.s, static_cast<int>(c.to));
    if (t.is_none()) break;
    if (t < start) return false;
    c = corner_at(mesh, t, i);
    if (t == start) {
      closed = true;
      break;
    }
  }
  if (!closed) {
    polygon.push_back(points.site(i));
    polygon.push_back(points.wall(c.s, static_cast<int>(c.to)));
  }
  const SimplexId first = c.s;
  while (true) {
    if (c.s < start) return false;
    polygon.push_back(points.simplex(c.s));
    const SimplexId t = neighbor_in_region(mesh, c.s, static_cast<int>(c.from));
    if (t.is_none()) {
      polygon.push_back(points.wall(c.s, static_cast<int>(c.from)));
      break;
    }
    if (t == first) break;
    c = corner_at(mesh, t, i);
  }
  return true;
}

// ---- Polyhedra ----

/// Simplex s at edge (i, j), with its other corners k, l so that (i, j, k, l) is positively oriented: seen from j, k
/// comes before l counterclockwise.
struct Corner3 {
  SimplexId s;
  std::size_t k, l;  ///< Corners of s.
};

Corner3 corner_at(const Mesh<3>& mesh, SimplexId s, VertexId i, VertexId j) {
  const std::size_t a = corner_of(mesh, s, i), b = corner_of(mesh, s, j);
  std::size_t k = 0;
  while (k == a || k == b) ++k;
  const std::size_t l = 6 - a - b - k;
  // Parity of the permutation (a, b, k, l) with k < l.
  const int inversions = (a > b) + (a > k) + (a > l) + (b > k) + (b > l);
  return inversions % 2 == 0 ? Corner3{s, k, l} : Corner3{s, l, k};
}

/// The dual face of edge (i, j) that the simplices connected with `start` make, counterclockwise seen from j. Empty if
/// a simplex before `start` is among them.
void trace_dual_face(const Mesh<3>& mesh, const ShapePoints<3>& points, VertexId i, VertexId j, SimplexId start,
                     std::vector<std::uint32_t>& polygon) {
  polygon.clear();
  Corner3 c = corner_at(mesh, start, i, j);
  bool closed = false;
  while (true) {  // Clockwise to the wall.
    const SimplexId t = neighbor_in_region(mesh, c.s, static_cast<int>(c.l));
    if (t.is_none()) break;
    if (t < start) return;
    c = corner_at(mesh, t, i, j);
    if (t == start) {
      closed = true;
      break;
    }
  }
  if (!closed) {
    if (points.is_crease(i, j)) polygon.push_back(points.midpoint(i, j));
    polygon.push_back(points.wall(c.s, static_cast<int>(c.l)));
  }
  const SimplexId first = c.s;
  while (true) {
    if (c.s < start) {
      polygon.clear();
      return;
    }
    polygon.push_back(points.simplex(c.s));
    const SimplexId t = neighbor_in_region(mesh, c.s, static_cast<int>(c.k));
    if (t.is_none()) {
      polygon.push_back(points.wall(c.s, static_cast<int>(c.k)));
      break;
    }
    if (t == first) break;
    c = corner_at(mesh, t, i, j);
  }
  drop_repeats(polygon);
}

class PolyhedronBuilder {
 public:
  PolyhedronBuilder(const Mesh<3>& mesh, const ControlVolumes<3>& volumes)
      : mesh_(mesh), points_(mesh), cells_(volumes), n_cells_(volumes.cell_vertex.size()) {}

  CellShapes<3> build() {
    add_dual_faces();
    add_wall_faces();
    compact_points(points_.positions(), shapes_.face_points.values, shapes_);
    list_cell_faces();
    return std::move(shapes_);
  }

 private:
  /// `polygon` is counterclockwise seen from outside of the cell `inside`. It is stored as seen from outside of the
  /// first of its cells.
  void add_face(std::vector<std::uint32_t> polygon, CellId inside, CellId outside) {
    if (polygon.size() < 3) return;
    if (!outside.is_none() && outside < inside) {
      std::reverse(polygon.begin(), polygon.end());
      std::swap(inside, outside);
    }
    shapes_.face_points.push_row(polygon);
    face_cells_.push_back({inside, outside});
  }

  void add_dual_faces() {
    const Csr<VertexId, SimplexId> vertex_simplices =
        invert_incidence<VertexId>(mesh_.simplex_vertices, mesh_.points.size());
    std::vector<std::uint32_t> polygon;
    for (const VertexId i : ids(mesh_.points)) {
      for (const SimplexId s : vertex_simplices[i]) {
        for (const VertexId j : mesh_.simplex_vertices[s]) {
          if (j <= i) continue;
          trace_dual_face(mesh_, points_, i, j, s, polygon);
          const int region = mesh_.simplex_region[s];
          if (!polygon.empty()) add_face(polygon, cells_.find(i, region), cells_.find(j, region));
        }
      }
    }
  }

  /// The part of a wall triangle that is nearest to its corner v; `next` and `previous` are the other corners, in
  /// counterclockwise order seen from outside.
  struct Sector {
    VertexId v;
    CellId inside, outside;
    VertexId next, previous;
    std::uint32_t center;  ///< The circumcenter of the wall.
    friend bool operator<(const Sector& a, const Sector& b) {
      return std::tie(a.v, a.inside, a.outside, a.next) < std::tie(b.v, b.inside, b.outside, b.next);
    }
  };

  /// A cell's face on a wall: the sectors around its site that lie in one plane, joined. One by one they would overlap
  /// where triangles are obtuse.
  void add_wall_faces() {
    std::vector<Sector> sectors;
    for (const auto& wall : points_.walls()) {
      std::array<VertexId, 3> f = face_vertices(mesh_, wall.simplex, wall.corner);
      std::swap(f[1], f[2]);  // Counterclockwise seen from outside.
      const SimplexId t = mesh_.simplex_neighbors[wall.simplex][static_cast<std::size_t>(wall.corner)];
      const int region = mesh_.simplex_region[wall.simplex];
      for (std::size_t k = 0; k < 3; ++k)
        sectors.push_back({f[k], cells_.find(f[k], region),
                           t.is_none() ? CellId::none() : cells_.find(f[k], mesh_.simplex_region[t]), f[(k + 1) % 3],
                           f[(k + 2) % 3], points_.wall(wall.simplex, wall.corner)});
    }
    std::sort(sectors.begin(), sectors.end());
    for (std::size_t begin = 0, end = 0; begin < sectors.size(); begin = end) {
      const Sector& first = sectors[begin];
      while (end < sectors.size() && sectors[end].v == first.v && sectors[end].inside == first.inside &&
             sectors[end].outside == first.outside)
        ++end;
      join_sectors({sectors.data() + begin, sectors.data() + end});
    }
  }

  /// Sectors of one site between the same cells, ascending by `next`.
  void join_sectors(std::span<const Sector> sectors) {
    std::vector<std::uint8_t> used(sectors.size(), 0);
    const auto is_start = [&](const Sector& s) { return points_.is_crease(s.v, s.next); };
    for (const bool closed : {false, true}) {  // Chains from crease to crease, then what goes all around.
      for (std::size_t i = 0; i < sectors.size(); ++i) {
        if (used[i] != 0 || (!closed && !is_start(sectors[i]))) continue;
        std::vector<std::uint32_t> polygon;
        const Sector* s = &sectors[i];
        if (!closed) polygon = {points_.site(s->v), points_.midpoint(s->v, s->next)};
        for (;;) {
          used[static_cast<std::size_t>(s - sectors.data())] = 1;
          polygon.push_back(s->center);
          if (points_.is_crease(s->v, s->previous)) {
            polygon.push_back(points_.midpoint(s->v, s->previous));
            break;
          }
          const auto after = std::find_if(sectors.begin(), sectors.end(), [&](const Sector& x) {
            return x.next == s->previous && used[static_cast<std::size_t>(&x - sectors.data())] == 0;
          });
          if (after == sectors.end()) break;
          s = &*after;
        }
        drop_repeats(polygon);
        add_face(polygon, sectors[i].inside, sectors[i].outside);
      }
    }
  }

  void list_cell_faces() {
    auto& rows = shapes_.cell_faces;
    rows.offsets.assign(n_cells_ + 2, 0);
    for (const auto& pair : face_cells_)
      for (const CellId c : pair)
        if (!c.is_none()) ++rows.offsets[c.value() + std::size_t{2}];
    for (std::size_t c = 2; c < rows.offsets.size(); ++c) rows.offsets[c] += rows.offsets[c - 1];
    rows.values.resize(rows.offsets.back());
    for (std::size_t f = 0; f < face_cells_.size(); ++f)
      for (const CellId c : face_cells_[f])
        if (!c.is_none()) rows.values[rows.offsets[c.value() + std::size_t{1}]++] = static_cast<std::uint32_t>(f);
    rows.offsets.pop_back();
  }

  const Mesh<3>& mesh_;
  ShapePoints<3> points_;
  CellIndex cells_;
  std::size_t n_cells_;
  CellShapes<3> shapes_;
  std::vector<std::array<CellId, 2>> face_cells_;  ///< [n_faces] outward of the first, inward of the second.
};

CellShapes<3> build_shapes(const Mesh<3>& mesh, const ControlVolumes<3>& volumes) {
  return PolyhedronBuilder(mesh, volumes).build();
}

CellShapes<2> build_shapes(const Mesh<2>& mesh, const ControlVolumes<2>& volumes) {
  const ShapePoints<2> points(mesh);
  const Csr<VertexId, SimplexId> vertex_simplices =
      invert_incidence<VertexId>(mesh.simplex_vertices, mesh.points.size());
  CellShapes<2> shapes;
  std::vector<std::uint32_t> polygon, fan;
  for (const CellId c : ids(volumes.cell_vertex)) {
    polygon.clear();
    const VertexId i = volumes.cell_vertex[c];
    for (const SimplexId s : vertex_simplices[i]) {
      if (mesh.simplex_region[s] != volumes.cell_region[c]) continue;
      fan.clear();
      if (append_fan(mesh, points, i, s, fan)) polygon.insert(polygon.end(), fan.begin(), fan.end());
    }
    drop_repeats(polygon);
    shapes.cell_faces.push_row(polygon);
  }
  compact_points(points.positions(), shapes.cell_faces.values, shapes);
  return shapes;
}

}  // namespace

template <int D>
CellShapes<D> build_cell_shapes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes) {
  return build_shapes(mesh, volumes);
}

template CellShapes<2> build_cell_shapes(const Mesh<2>&, const ControlVolumes<2>&);
template CellShapes<3> build_cell_shapes(const Mesh<3>&, const ControlVolumes<3>&);

}  // namespace voropack
