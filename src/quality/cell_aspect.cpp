#include "quality/cell_aspect.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "mesh/faces.h"
#include "mesh/incidence.h"
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
    bisectors_.clear();
    walls_.clear();
    for (const SimplexId s : simplices) add_simplex(v, s);
    if (!walls_.empty()) corners_.push_back(Vec<D>{});
    const double outer = smallest_enclosing_ball<D>(corners_).radius;
    walls_.insert(walls_.end(), bisectors_.begin(), bisectors_.end());
    double inner = largest_inscribed_ball<D>(walls_, outer).radius;
    // At a corner that is so far from convex that no point sees all walls: the largest ball of any one simplex's part.
    if (!(inner > kThinBall * outer)) {
      for (const SimplexId s : simplices) inner = std::max(inner, ball_in_simplex(v, s, outer));
    }
    const double ratio = outer / inner;
    return ratio > 0 ? ratio : std::numeric_limits<double>::infinity();  // Also for NaN.
  }

 private:
  static constexpr double kThinBall = 1e-6;

  void add_simplex(VertexId v, SimplexId s) {
    corners_.push_back(figures_.circumcenter[s] - site_);
    const unsigned walls = figures_.walls[s];
    for (int i = 0; i <= D; ++i) {
      const VertexId apex = mesh_.simplex_vertices[s][static_cast<std::size_t>(i)];
      if (apex == v) continue;
      add_bisector(apex);
      if ((walls >> static_cast<unsigned>(i) & 1U) != 0) add_wall(v, s, i);
    }
  }

  /// A face at v where the region ends.
  void add_wall(VertexId v, SimplexId s, int i) {
    const std::array<Vec<D>, D> face = positions(s, i);
    corners_.push_back(face_circumcenter(face) - site_);
    if constexpr (D == 3) {
      for (const VertexId w : face_vertices(mesh_, s, i))
        if (w != v) corners_.push_back(0.5 * (mesh_.points[w] - site_));
    }
    walls_.push_back(wall(face));
  }

  [[nodiscard]] std::array<Vec<D>, D> positions(SimplexId s, int i) const {
    std::array<Vec<D>, D> face;
    const std::array<VertexId, D> vertices = face_vertices(mesh_, s, i);
    for (std::size_t k = 0; k < D; ++k) face[k] = mesh_.points[vertices[k]];
    return face;
  }

  static HalfSpace<D> wall(const std::array<Vec<D>, D>& face) {
    const Vec<D> normal = outward_normal(face);
    return {normal / norm(normal), 0.0};
  }

  void add_bisector(VertexId w) {
    if (seen_by_[w] == cell_) return;
    seen_by_[w] = cell_;
    const Vec<D> edge = mesh_.points[w] - site_;
    const double length = norm(edge);
    bisectors_.push_back({edge / length, 0.5 * length});
  }

  double ball_in_simplex(VertexId v, SimplexId s, double size) {
    std::vector<HalfSpace<D>> part = bisectors_;
    for (int i = 0; i <= D; ++i)
      if (mesh_.simplex_vertices[s][static_cast<std::size_t>(i)] != v) part.push_back(wall(positions(s, i)));
    return largest_inscribed_ball<D>(part, size).radius;
  }

  const Mesh<D>& mesh_;
  const SimplexFigures<D>& figures_;
  CellId cell_;
  Vec<D> site_;
  std::vector<Vec<D>> corners_;
  std::vector<HalfSpace<D>> walls_, bisectors_;
  IdVector<VertexId, CellId> seen_by_;  ///< The last cell that has a bisector with this vertex.
};

}  // namespace

template <int D>
std::vector<double> cell_aspects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                                 const SimplexFigures<D>& figures, Observer& observer) {
  constexpr std::size_t kBlock = 2048;
  const Csr<VertexId, SimplexId> vertex_simplices =
      invert_incidence<VertexId>(mesh.simplex_vertices, mesh.points.size());
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
                   std::span<const SimplexId> simplices = std::as_const(vertex_simplices)[v];
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

template std::vector<double> cell_aspects(const Mesh<2>&, const ControlVolumes<2>&, const SimplexFigures<2>&,
                                          Observer&);
template std::vector<double> cell_aspects(const Mesh<3>&, const ControlVolumes<3>&, const SimplexFigures<3>&,
                                          Observer&);

}  // namespace voropack
