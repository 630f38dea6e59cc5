#include "coarsening/level_boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "base/place_text.h"
#include "geom/box_tree.h"
#include "geom/polytope_distance.h"
#include "geom/tolerance.h"
#include "geom/wall_locator.h"
#include "voropack/error.h"

namespace voropack {

namespace {

template <int D>
Walls<D> walls_of(const Domain<D>& domain) {
  Walls<D> walls;
  const auto sides = [&](std::size_t wall) {
    std::array<int, 2> regions;
    for (std::size_t k = 0; k < 2; ++k) {
      const RegionId r = domain.wall_regions[wall][k];
      regions[k] = r.is_none() ? Walls<D>::kOutside : static_cast<int>(r.value());
    }
    return regions;
  };
  if constexpr (D == 2) {
    for (const SegmentId s : ids(domain.segments)) {
      const auto [a, b] = domain.segments[s];
      walls.simplices.push_back({domain.points[a], domain.points[b]});
      walls.regions.push_back(sides(s.value()));
    }
  } else {
    for (const FacetId f : ids(domain.facet_frame))
      for (const auto& [a, b, c] : domain.facet_triangles[f]) {
        walls.simplices.push_back({domain.points[a], domain.points[b], domain.points[c]});
        walls.regions.push_back(sides(f.value()));
      }
  }
  return walls;
}

template <int D>
class Placer {
 public:
  Placer(const Mesh<D>& mesh, const LevelBoundary<D>& boundary) : mesh_(mesh), level_(boundary.level) {
    out_.place.domain = boundary.domain;
    out_.place.carrier.resize(mesh.points.size(), PolytopeId(D, 0));
    out_.is_outside.assign(mesh.points.size(), 0);
    std::vector<Box<D>> boxes;
    Box<D> all = domain().box;
    for (const Vec<D>& x : mesh.points) {
      boxes.emplace_back(x, x);
      all.add(x);
    }
    tree_ = BoxTree<D>(boxes);
    tolerance_ = absolute_tolerance(all, kOnTolerance);
  }

  PlacedMesh<D> run() {
    place_points();
    place_segments();
    if constexpr (D == 3) place_facets();
    // Points are on segments and facets, too; they come last to win.
    for (const SegmentId s : ids(domain().segments))
      for (const VertexId v : out_.place.segment_chains[s]) out_.place.carrier[v] = PolytopeId(s);
    for (const PointId p : ids(vertex_of_)) out_.place.carrier[vertex_of_[p]] = PolytopeId(p);
    find_outside();
    return std::move(out_);
  }

 private:
  [[nodiscard]] Domain<D>& domain() { return out_.place.domain; }

  void place_points() {
    std::vector<Fault> faults;
    for (const PointId p : ids(domain().points)) {
      Vec<D>& x = domain().points[p];
      VertexId nearest = VertexId::none();
      double least_sq = tolerance_ * tolerance_;
      for_each_near(Box<D>(x, x), [&](VertexId v) {
        const double d = distance_sq(x, mesh_.points[v]);
        if (d <= least_sq) least_sq = d, nearest = v;
      });
      if (nearest.is_none()) {
        if (faults.size() < kMaxFaults)
          faults.push_back(
              Fault{.id = "coarsen.level_boundary",
                    .message = fmt::format("the boundary of level {} has a point at {}, where the mesh has no vertex",
                                           level_, place_text(x)),
                    .fix = "take vertices of the mesh as points of the coarser boundary.",
                    .file = domain().file,
                    .position = {x.coord.begin(), x.coord.end()}});
      } else {
        x = mesh_.points[nearest];
      }
      vertex_of_.push_back(nearest);
    }
    if (!faults.empty()) throw InputError(std::move(faults));
  }

  void place_segments() {
    for (const SegmentId s : ids(domain().segments)) {
      const Vec<D> a = domain().points[domain().segments[s][0]], b = domain().points[domain().segments[s][1]];
      std::vector<std::pair<double, VertexId>> row;
      Box<D> box(a, a);
      box.add(b);
      for_each_near(box, [&](VertexId v) {
        const Vec<D>& x = mesh_.points[v];
        if (distance_to_segment(x, a, b) <= tolerance_) row.push_back({dot(x - a, b - a), v});
      });
      std::sort(row.begin(), row.end());
      std::vector<VertexId> chain;
      for (const auto& [at, v] : row) chain.push_back(v);
      out_.place.segment_chains.push_row(chain);
    }
  }

  void place_facets() requires(D == 3) {
    for (const FacetId f : ids(domain().facet_frame))
      for (const auto& [p, q, r] : domain().facet_triangles[f]) {
        const Vec<3> a = domain().points[p], b = domain().points[q], c = domain().points[r];
        Box<3> box(a, a);
        box.add(b);
        box.add(c);
        for_each_near(box, [&](VertexId v) {
          if (distance_to_triangle(mesh_.points[v], a, b, c) <= tolerance_) out_.place.carrier[v] = PolytopeId(f);
        });
      }
  }

  void find_outside() {
    const WallLocator<D> locator(walls_of(domain()));
    parallel_for(mesh_.points.size(), [&](std::size_t i) {
      const VertexId v(i);
      if (out_.place.carrier[v].dimension == D && locator.region(mesh_.points[v]) == Walls<D>::kOutside)
        out_.is_outside[i] = 1;
    });
  }

  template <class Visit>
  void for_each_near(const Box<D>& around, Visit&& visit) const {
    Box<D> reach = around;
    for (int k = 0; k < D; ++k) {
      reach.lo[k] -= tolerance_;
      reach.hi[k] += tolerance_;
    }
    tree_.for_each([&](const Box<D>& box) { return box.overlaps(reach); },
                   [&](std::uint32_t v) { visit(VertexId(std::size_t{v})); });
  }

  const Mesh<D>& mesh_;
  int level_;
  BoxTree<D> tree_;
  double tolerance_ = 0;
  IdVector<PointId, VertexId> vertex_of_;
  PlacedMesh<D> out_;
};

/// Of the boundary vertices of `from`, the largest distance to the boundary of `to`.
template <int D>
double one_sided_distance(const Mesh<D>& from, const Mesh<D>& to) {
  std::vector<Box<D>> boxes;
  for (const auto& face : to.boundary_vertices) {
    Box<D> box(to.points[face[0]], to.points[face[0]]);
    for (const VertexId v : face) box.add(to.points[v]);
    boxes.push_back(box);
  }
  const BoxTree<D> tree(boxes);
  const auto distance_to = [&](const Vec<D>& x, std::uint32_t i) {
    const auto& face = to.boundary_vertices[BoundaryId(std::size_t{i})];
    if constexpr (D == 2)
      return distance_to_segment(x, to.points[face[0]], to.points[face[1]]);
    else
      return distance_to_triangle(x, to.points[face[0]], to.points[face[1]], to.points[face[2]]);
  };
  double farthest = 0;
  std::vector<std::uint8_t> is_done(from.points.size(), 0);
  for (const auto& face : from.boundary_vertices)
    for (const VertexId v : face) {
      if (std::exchange(is_done[v.value()], std::uint8_t{1}) != 0) continue;
      const Vec<D>& x = from.points[v];
      double nearest = std::numeric_limits<double>::infinity();
      tree.for_each([&](const Box<D>& box) { return box.distance_sq(x) < nearest * nearest; },
                    [&](std::uint32_t i) { nearest = std::min(nearest, distance_to(x, i)); });
      farthest = std::max(farthest, nearest);
    }
  return farthest;
}

}  // namespace

template <int D>
PlacedMesh<D> place_in_boundary(const Mesh<D>& mesh, const LevelBoundary<D>& boundary) {
  return Placer<D>(mesh, boundary).run();
}

template <int D>
double boundary_distance(const Mesh<D>& a, const Mesh<D>& b) {
  return std::max(one_sided_distance(a, b), one_sided_distance(b, a));
}

template PlacedMesh<2> place_in_boundary(const Mesh<2>&, const LevelBoundary<2>&);
template PlacedMesh<3> place_in_boundary(const Mesh<3>&, const LevelBoundary<3>&);
template double boundary_distance(const Mesh<2>&, const Mesh<2>&);
template double boundary_distance(const Mesh<3>&, const Mesh<3>&);

}  // namespace voropack
