// A coarser surface with some of the vertices of a fine one: vertices are taken away one by one, and the holes that
// they leave are triangulated anew, as long as the surface stays a part of the Delaunay triangulation of its vertices.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <span>
#include <vector>

#include "coarsening/surface_complex.h"
#include "geom/box_tree.h"

namespace voropack {

/// Where a vertex of a surface is: inside of a patch, on one curve, or where it stays on all levels.
enum class SurfacePlace : std::uint8_t { kPatch, kCurve, kAnchor };

/// What is left of a surface.
struct LevelSurface {
  std::vector<std::uint32_t> vertices;  ///< Places in the complex; ascending.
  std::vector<SurfaceTriangle> triangles;
  std::vector<CurveEdge> edges;
};

/// Invariants, which hold of the surface of a boundary-conforming Delaunay mesh and are kept:
///  1. The equatorial ball of each triangle holds no vertex of the surface but its corners, nor has one on its sphere;
///     but for cocircular vertices in its plane, between which the Delaunay kernel's rule for ties decides.
///  2. The diametral ball of each curve edge holds no vertex.
///  3. The balls of each new edge inside of a patch (edge_balls.h) hold no vertex but the corners of the two triangles.
/// So all of them are Delaunay, and nothing crosses. A patch keeps its topology, a curve its ends, closed ones enclose
/// something, no region gains or loses more than `max_volume_change` of its volume.
class SurfaceSimplifier {
 public:
  SurfaceSimplifier(const SurfaceComplex& fine, double max_volume_change);

  /// Takes away vertices, those first that are nearest to a neighbor in units of f, until neighbors are 2 f apart where
  /// that can be had. `allowance`: how far patches may move on the average, in units of `max_volume_change` times
  /// volume over area of the regions; no vertex that was taken away is farther than f / 2 from the surface, or from its
  /// curve.
  void simplify(std::span<const double> f, double allowance);

  [[nodiscard]] LevelSurface surface() const;
  /// The largest one of a region, as a part of its volume.
  [[nodiscard]] double volume_change() const;

 private:
  struct Triangle {
    SurfaceTriangle surface;
    bool is_alive = true;
    double drift = 0;                         ///< Its part of the volume that the surface passed, along the normal.
    std::vector<std::uint32_t> passengers{};  ///< Vertices taken away that are nearest to it.
  };
  struct Edge {
    CurveEdge curve;
    bool is_alive = true;
    std::vector<std::uint32_t> passengers{};
  };
  /// The part of a surface around a vertex: all around it, or between two edges of a curve.
  struct Sheet {
    std::vector<std::uint32_t> rim;  ///< Its outer vertices in order.
    std::vector<std::uint32_t> triangles;
    bool turns_along = true;  ///< The rim runs around the first triangle's normal counterclockwise.
  };
  /// What a vertex leaves behind.
  struct Patching {
    std::vector<Triangle> triangles;
    double volume = 0;  ///< Passed along the normal.
    double area = 0;
  };
  struct Wish {
    double ratio;
    int reluctance;
    std::uint32_t vertex, stamp;
    friend auto operator<=>(const Wish&, const Wish&) = default;
  };

  [[nodiscard]] const Vec<3>& point(std::uint32_t v) const { return fine_->points[v]; }
  [[nodiscard]] SurfacePlace place_of(std::uint32_t v) const;
  [[nodiscard]] bool is_on_curve(std::uint32_t v, std::uint32_t w) const;
  [[nodiscard]] bool are_adjacent(std::uint32_t v, std::uint32_t w) const;
  [[nodiscard]] bool has_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] std::uint32_t other_end(std::uint32_t edge, std::uint32_t v) const;

  void wish_for(std::uint32_t v);
  void rebuild_tree();
  bool remove(std::uint32_t v);
  [[nodiscard]] std::optional<std::vector<Sheet>> find_sheets(std::uint32_t v) const;
  [[nodiscard]] bool walk(std::uint32_t v, std::uint32_t first, std::uint32_t begin, std::uint32_t end,
                          Sheet& sheet) const;

  /// Best triangles for the hole, if there are any that keep the invariants.
  [[nodiscard]] std::optional<Patching> patch(std::uint32_t v, const Sheet& sheet, bool is_open) const;
  /// Whether the balls of all edges that are new, or have a new triangle, hold no vertex.
  [[nodiscard]] bool are_edges_fit(std::uint32_t v, const Patching& patching) const;
  /// Whether accept(w, d) is true for a vertex w of the surface at a squared distance d of at most `reach_sq` from x.
  template <class Accept>
  [[nodiscard]] bool is_any_near(const Vec<3>& x, double reach_sq, Accept&& accept) const;
  /// `t` and `s` meet at edge ab.
  [[nodiscard]] bool is_edge_fit(std::uint32_t v, const SurfaceTriangle& t, const SurfaceTriangle& s, std::uint32_t a,
                                 std::uint32_t b) const;
  [[nodiscard]] bool carry(std::uint32_t v, bool takes_vertex, const Sheet& sheet, Patching& patching) const;
  [[nodiscard]] bool allows_drift(const Sheet& sheet, Patching& patching) const;
  [[nodiscard]] bool is_empty_ball(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t gone) const;
  [[nodiscard]] bool is_empty_ball(std::uint32_t a, std::uint32_t b, std::uint32_t gone, bool is_dangling) const;
  [[nodiscard]] bool is_chosen_by_ties(std::array<std::uint32_t, 3> corners, std::vector<std::uint32_t> tied) const;

  void add_triangle(Triangle triangle);
  void kill_triangle(std::uint32_t t);

  const SurfaceComplex* fine_;
  double max_volume_change_;
  std::span<const double> f_;
  std::vector<double> room_;  ///< By region: how far its boundary may move on the average.
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<std::vector<std::uint32_t>> star_;        ///< Triangles at a vertex.
  std::vector<std::vector<std::uint32_t>> curve_star_;  ///< Curve edges at a vertex.
  std::vector<std::uint8_t> is_gone_;
  std::vector<double> region_change_;
  std::vector<std::uint32_t> stamp_;
  std::priority_queue<Wish, std::vector<Wish>, std::greater<>> queue_;
  BoxTree<3> tree_;                   ///< Of the vertices that were there when it was built.
  std::vector<std::uint32_t> treed_;  ///< These.
  std::size_t n_left_ = 0;
};

}  // namespace voropack
