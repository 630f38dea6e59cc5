#include "quality/cell_aspect.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "mesh/faces.h"
#include "quality/cell_balls.h"

namespace voropack {

namespace {

Vec<2> face_circumcenter(const std::array<Vec<2>, 2>& p) { return 0.5 * (p[0] + p[1]); }
Vec<3> face_circumcenter(const std::array<Vec<3>, 3>& p) { return triangle_circumcenter(p[0], p[1], p[2]); }

/// Not normalized; points out of the simplex of which the face is (kFaceCorners).
Vec<2> outward_normal(const std::array<Vec<2>, 2>& p) { return {p[1][1] - p[0][1], p[0][0] - p[1][0]}; }
Vec<3> outward_normal(const std::array<Vec<3>, 3>& p) { return cross(p[2] - p[0], p[1] - p[0]); }

/// One cell, relative to its site.
template <int D>
class Cell {
 public:
  Cell(const Mesh<D>& mesh, const SimplexFigures<D>& figures)
      : mesh_(mesh), figures_(figures), seen_by_(mesh.points.size()) {}

  /// R/r of the part of v's cell that the simplices cover; they are those around v in one region.
  double aspect(CellId cell, VertexId v, std::span<const SimplexId> simplices) {
    cell_ = cell;
    site_ = mesh_.points[v];
    corners_.clear();
    walls_.clear();
    for (const SimplexId s : simplices) add_corners(v, s);
    if (!walls_.empty()) corners_.push_back(Vec<D>{}.coord);
    const double outer = smallest_enclosing_ball<D>(corners_).radius;
    find_bisectors(v, simplices);
    double inner = ball_within(walls_, outer);
    // At a corner that is so far from convex that no point sees all walls: the largest ball of any one simplex's part.
    if (!(inner > kThinBall * outer)) {
      for (const SimplexId s : simplices) inner = std::max(inner, ball_within(sides(v, s), outer));
    }
    const double ratio = outer / inner;
    return ratio > 0 ? ratio : std::numeric_limits<double>::infinity();  // Also for NaN.
  }

 private:
  static constexpr double kThinBall = 1e-6;

  void add_corners(VertexId v, SimplexId s) {
    std::array<double, D> corner = figures_.circumcenter[s];
    for (std::size_t k = 0; k < D; ++k) corner[k] -= site_.coord[k];
    corners_.push_back(corner);
    const unsigned walls = figures_.walls[s];
    for (int i = 0; walls != 0 && i <= D; ++i)
      if ((walls >> static_cast<unsigned>(i) & 1U) != 0 && mesh_.simplex_vertices[s][static_cast<std::size_t>(i)] != v)
        add_wall(v, s, i);
  }

  /// A face at v where the region ends.
  void add_wall(VertexId v, SimplexId s, int i) {
    const std::array<Vec<D>, D> face = positions(s, i);
    corners_.push_back((face_circumcenter(face) - site_).coord);
    if constexpr (D == 3) {
      for (const VertexId w : face_vertices(mesh_, s, i))
        if (w != v) corners_.push_back((0.5 * (mesh_.points[w] - site_)).coord);
    }
    walls_.push_back(wall(face));
  }

  [[nodiscard]] std::array<Vec<D>, D> positions(SimplexId s, int i) const {
    std::array<Vec<D>, D> face;
    const std::array<VertexId, D> vertices = face_vertices(mesh_, s, i);
    for (std::size_t k = 0; k < D; ++k) face[k] = mesh_.points[vertices[k]];
    return face;
  }

  /// The normal of the half-space that has the face, and with it the site, on its boundary.
  static Vec<D> wall(const std::array<Vec<D>, D>& face) {
    const Vec<D> normal = outward_normal(face);
    return normal / norm(normal);
  }

  void find_bisectors(VertexId v, std::span<const SimplexId> simplices) {
    const std::size_t n = find_neighbors(v, simplices);
    neighbors_[n] = neighbors_[n - 1];  // For a last pair of one.
    bisectors_.clear();
    for (std::size_t k = 0; k < n; k += 2) {
      const Vec<D>&first = mesh_.points[neighbors_[k]], &second = mesh_.points[neighbors_[k + 1]];
      std::array<Lanes, D + 1> row;
      Lanes length_sq = 0.0;
      for (std::size_t i = 0; i < D; ++i) {
        row[i] = Lanes(first.coord[i], second.coord[i]) - Lanes(site_.coord[i]);
        length_sq = length_sq + square(row[i]);
      }
      const Lanes length = sqrt(length_sq), scale = Lanes(1.0) / length;
      for (std::size_t i = 0; i < D; ++i) row[i] = row[i] * scale;
      row[D] = Lanes(0.5) * length;
      bisectors_.push_back(row);
    }
  }

  /// Their number; they and one place more are in `neighbors_`.
  std::size_t find_neighbors(VertexId v, std::span<const SimplexId> simplices) {
    // Which corner is seen for the first time cannot be predicted, so there is no branch: one that was seen before is
    // overwritten by the next.
    neighbors_.resize(std::max(neighbors_.size(), simplices.size() * (D + 1) + 1));
    std::size_t n = 0;
    seen_by_[v] = cell_;
    for (const SimplexId s : simplices) {
      for (const VertexId w : mesh_.simplex_vertices[s]) {
        neighbors_[n] = w;
        n += seen_by_[w] != cell_ ? 1U : 0U;
        seen_by_[w] = cell_;
      }
    }
    return n;
  }

  /// The radius of the largest ball within the bisectors and walls through the site.
  double ball_within(const std::vector<Vec<D>>& walls, double size) {
    if (walls.empty()) return largest_inscribed_ball<D>(bisectors_, size).radius;
    half_spaces_ = bisectors_;
    for (const Vec<D>& normal : walls) {
      std::array<double, D + 1> row{};
      std::copy(normal.coord.begin(), normal.coord.end(), row.begin());
      half_spaces_.push_back(row);
    }
    return largest_inscribed_ball<D>(half_spaces_, size).radius;
  }

  /// The walls between which the simplex lies as seen from v.
  std::vector<Vec<D>> sides(VertexId v, SimplexId s) const {
    std::vector<Vec<D>> normals;
    for (int i = 0; i <= D; ++i)
      if (mesh_.simplex_vertices[s][static_cast<std::size_t>(i)] != v) normals.push_back(wall(positions(s, i)));
    return normals;
  }

  const Mesh<D>& mesh_;
  const SimplexFigures<D>& figures_;
  CellId cell_;
  Vec<D> site_;
  PointRows<D> corners_;
  HalfSpaceRows<D> bisectors_, half_spaces_;
  std::vector<Vec<D>> walls_;           ///< Normals.
  std::vector<VertexId> neighbors_;     ///< Of the site; room for more.
  IdVector<VertexId, CellId> seen_by_;  ///< The last cell that has a bisector with this vertex.
};

}  // namespace

template <int D>
std::vector<double> cell_aspects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                                 const Csr<VertexId, SimplexId>& vertex_simplices, const SimplexFigures<D>& figures,
                                 Observer& observer) {
  constexpr std::size_t kBlock = 2048;
  const std::size_t n = volumes.cell_vertex.size();
  std::vector<double> aspects(n);
  const auto same_vertex = [&](std::size_t a, std::size_t b) {
    return volumes.cell_vertex[CellId(a)] == volumes.cell_vertex[CellId(b)];
  };
  tbb::enumerable_thread_specific<Cell<D>> cells([&] { return Cell<D>(mesh, figures); });
  parallel_for((n + kBlock - 1) / kBlock,
               [&](std::size_t block) {
                 observer.check_cancelled();
                 Cell<D>& cell = cells.local();
                 std::vector<SimplexId> in_region;
                 for (std::size_t c = block * kBlock; c < std::min(n, (block + 1) * kBlock); ++c) {
                   const VertexId v = volumes.cell_vertex[CellId(c)];
                   std::span<const SimplexId> simplices = vertex_simplices[v];
                   if ((c > 0 && same_vertex(c, c - 1)) || (c + 1 < n && same_vertex(c, c + 1))) {
                     in_region.clear();
                     for (const SimplexId s : simplices)
                       if (mesh.simplex_region[s] == volumes.cell_region[CellId(c)]) in_region.push_back(s);
                     simplices = in_region;
                   }
                   aspects[c] = cell.aspect(CellId(c), v, simplices);
                 }
               },
               1);
  return aspects;
}

template std::vector<double> cell_aspects(const Mesh<2>&, const ControlVolumes<2>&, const Csr<VertexId, SimplexId>&,
                                          const SimplexFigures<2>&, Observer&);
template std::vector<double> cell_aspects(const Mesh<3>&, const ControlVolumes<3>&, const Csr<VertexId, SimplexId>&,
                                          const SimplexFigures<3>&, Observer&);

}  // namespace voropack
