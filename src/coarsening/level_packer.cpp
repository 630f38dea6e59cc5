#include "coarsening/level_packer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "base/parallel.h"
#include "coarsening/vertex_groups.h"
#include "geom/circumcenter.h"
#include "geom/kernel.h"
#include "geom/wall_locator.h"
#include "packing/tied_polygons.h"
#include "spheres/packing_problem.h"
#include "spheres/region_labels.h"
#include "spheres/sphere_set.h"

namespace voropack {

namespace {

/// How much f shrinks where a protecting ball is not empty.
constexpr double kShrink = 0.7;

template <int D>
class LevelPacker {
 public:
  LevelPacker(const FineMesh<D>& fine, const IdVector<VertexId, double>& f, const std::vector<std::uint8_t>& is_kept,
              const Observer& observer)
      : fine_(fine),
        domain_(fine.place.domain),
        f_(f),
        is_kept_(is_kept),
        observer_(observer),
        spheres_(domain_.box.center(), 0.5, f[fine.point_vertices.empty() ? VertexId(0) : fine.point_vertices[0]]),
        kept_spheres_(spheres_),
        balls_(domain_.box.center()) {
    for (const VertexId v : ids(f)) {
      if (is_kept[v.value()] == 0) continue;
      kept_.push_back(v);
      kept_spheres_.add({point(v), f[v]});
    }
  }

  PackedLevel<D> run() {
    for (const VertexId v : fine_.point_vertices) add(v);
    add_segments();
    if constexpr (D == 3) add_facets();
    // A coarser level with another boundary may have vertices inside that are in this one's protecting balls.
    std::vector<VertexId> kept;
    for (const VertexId v : fine_.interior)
      if (is_kept_[v.value()] != 0) kept.push_back(v);
    join_all(kept);
    find_intruders();
    if (result_.faults.empty()) add_interior();
    return std::move(result_);
  }

 private:
  [[nodiscard]] const Vec<D>& point(VertexId v) const { return fine_.mesh.points[v]; }

  /// One on the boundary.
  void add(VertexId v) {
    Packing<D>& packing = result_.packing;
    packing.center.push_back(point(v));
    packing.radius.push_back(f_[v]);
    result_.vertex.push_back(v);
    sphere_of_[v] = packing.carrier.push_back(fine_.place.carrier[v]);
    spheres_.add({point(v), f_[v]});
  }

  /// True if no sphere overlaps that of v, but for those across a sharp feature: neither those that are there nor those
  /// that a coarser level will bring.
  [[nodiscard]] bool fits(VertexId v) const {
    const auto overlaps = [&](const Ball<D>& other, PolytopeId carrier) {
      return SphereSet<D>::overlap(other, point(v), f_[v]) &&
             !fine_.incidence.form_sharp_feature(fine_.place.carrier[v], carrier);
    };
    return !spheres_.visit_near(point(v), f_[v], [&](std::uint32_t s) {
      return overlaps(spheres_[s], result_.packing.carrier[SphereId(s)]);
    }) && !kept_spheres_.visit_near(point(v), f_[v], [&](std::uint32_t s) {
      return overlaps(kept_spheres_[s], fine_.place.carrier[kept_[s]]);
    });
  }
  [[nodiscard]] bool fits_beside(VertexId v, VertexId w) const {
    const double sum = (f_[v] + f_[w]) * (1 - kPackingSlack);
    return distance_sq(point(v), point(w)) >= sum * sum;
  }

  void add_segments() {
    for (const SegmentId s : ids(domain_.segments)) {
      const auto row = fine_.place.segment_chains[s];
      std::vector<std::size_t> chosen = {0};
      for (std::size_t i = 1; i < row.size(); ++i) {
        if (i + 1 < row.size() && is_kept_[row[i].value()] == 0) continue;
        fill_gap(row, chosen.back(), i, chosen);
        chosen.push_back(i);
      }
      for (std::size_t k = 1; k + 1 < chosen.size(); ++k) add(row[chosen[k]]);
      for (std::size_t k = 0; k + 1 < chosen.size(); ++k) {
        const VertexId a = row[chosen[k]], b = row[chosen[k + 1]];
        result_.packing.subsegments.push_back({{sphere_of_.at(a), sphere_of_.at(b)}, PolytopeId(s)});
        balls_.add({0.5 * (point(a) + point(b)), 0.5 * distance(point(a), point(b))});
      }
    }
  }

  /// Appends the vertices of the row between `begin` and `end` that are chosen: as many as fit one after the other, at
  /// about equal distances in units of f if they fit so.
  void fill_gap(std::span<const VertexId> row, std::size_t begin, std::size_t end, std::vector<std::size_t>& chosen) {
    std::vector<std::size_t> greedy;
    std::size_t last = begin;
    for (std::size_t i = begin + 1; i < end; ++i) {
      if (!fits_beside(row[i], row[last]) || !fits_beside(row[i], row[end]) || !fits(row[i])) continue;
      greedy.push_back(i);
      last = i;
    }
    if (greedy.empty()) return;
    std::vector<std::size_t> even = spread(row, begin, end, greedy.size());
    bool fits_all = !even.empty();
    for (std::size_t k = 0; fits_all && k < even.size(); ++k)
      fits_all = fits_beside(row[even[k]], row[k == 0 ? begin : even[k - 1]]) && fits(row[even[k]]);
    fits_all = fits_all && fits_beside(row[even.back()], row[end]);
    const std::vector<std::size_t>& best = fits_all ? even : greedy;
    chosen.insert(chosen.end(), best.begin(), best.end());
  }

  /// `n` vertices that cut the row into parts of about equal measure ds / f; nothing if the row has too few.
  [[nodiscard]] std::vector<std::size_t> spread(std::span<const VertexId> row, std::size_t begin, std::size_t end,
                                                std::size_t n) const {
    std::vector<double> measure = {0};
    for (std::size_t i = begin + 1; i <= end; ++i)
      measure.push_back(measure.back() +
                        2 * distance(point(row[i]), point(row[i - 1])) / (f_[row[i]] + f_[row[i - 1]]));
    std::vector<std::size_t> result;
    std::size_t i = begin;
    for (std::size_t k = 1; k <= n; ++k) {
      const double target = measure.back() * static_cast<double>(k) / static_cast<double>(n + 1);
      while (i + 1 < end && measure[i + 1 - begin] <= target) ++i;
      if (i + 1 < end && target - measure[i - begin] > measure[i + 1 - begin] - target) ++i;
      if (i == begin || (!result.empty() && result.back() == i)) return {};
      result.push_back(i);
    }
    return result;
  }

  void add_facets() requires(D == 3) {
    for (const FacetId f : ids(domain_.facet_frame)) {
      if (f.value() % 1024 == 0) observer_.check_cancelled();
      fill_facet(f);
    }
    for (const FacetId f : ids(domain_.facet_frame)) triangulate_facet(f);
  }

  void fill_facet(FacetId f) requires(D == 3) {
    const auto candidates = fine_.facet_vertices[f];
    if (candidates.empty()) return;
    for (const VertexId v : candidates)
      if (is_kept_[v.value()] != 0) add(v);
    const PlaneFrame& frame = domain_.facet_frame[f];
    Walls<2> walls;
    for (const SegmentId s : domain_.facet_segments[f]) {
      const auto [a, b] = domain_.segments[s];
      walls.simplices.push_back({frame.to_plane(domain_.points[a]), frame.to_plane(domain_.points[b])});
      walls.regions.push_back({0, 0});
    }
    const WallLocator<2> borders(std::move(walls));
    // The far rule holds as far as the finest mesh keeps it.
    const auto is_far = [&](VertexId v) {
      return f_[v] <= fine_.floor[v] || !borders.is_near(frame.to_plane(point(v)), 2 * f_[v]);
    };
    for (const VertexId v : candidates)
      if (is_kept_[v.value()] == 0 && !balls_.forbids(point(v)) && is_far(v) && fits(v)) add(v);
  }

  /// The Delaunay triangulation of what the facet has.
  void triangulate_facet(FacetId f) requires(D == 3) {
    const PlaneFrame& frame = domain_.facet_frame[f];
    std::vector<SphereId> members;
    for (const PointId p : domain_.facet_points[f]) members.push_back(SphereId(p.value()));
    for (const SegmentId s : domain_.facet_segments[f])
      for (const VertexId v : fine_.place.segment_chains[s])
        if (const auto it = sphere_of_.find(v); it != sphere_of_.end()) members.push_back(it->second);
    for (const VertexId v : fine_.facet_vertices[f])
      if (const auto it = sphere_of_.find(v); it != sphere_of_.end()) members.push_back(it->second);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    std::map<SphereId, std::uint32_t> local;
    std::vector<Vec<2>> in_plane;
    std::vector<Vec<3>> in_space;
    for (const SphereId s : members) {
      local[s] = static_cast<std::uint32_t>(in_plane.size());
      in_plane.push_back(frame.to_plane(result_.packing.center[s]));
      in_space.push_back(result_.packing.center[s]);
    }
    DelaunayKernel<2> kernel;
    kernel.insert(in_plane);
    const RegionLabels<2> labels = label_regions<2>(kernel, borders_of(f, local));
    if (!labels.missing_faces.empty() || !labels.leaking_faces.empty()) {
      for (const SphereId s : members)
        shrink(result_.packing.center[s], result_.packing.radius[s], result_.packing.radius[s]);
      return;
    }
    Triangulation<2> plane = export_triangulation(kernel, labels.region);
    for (const TiedPolygon& polygon : settle_tied_polygons(in_plane, in_space, plane.neighbors, plane.simplices)) {
      std::vector<SphereId> corners;
      for (const std::uint32_t i : polygon.points) corners.push_back(members[i]);
      for (const std::uint32_t t : polygon.triangles) tied_with_ball_[balls_.size() + t] = corners;
    }
    for (const auto& t : plane.simplices) {
      const std::array<SphereId, 3> corners = {members[t[0]], members[t[1]], members[t[2]]};
      result_.packing.subfacets.push_back({corners, PolytopeId(f)});
      const Vec<3> c = triangle_circumcenter(in_space[t[0]], in_space[t[1]], in_space[t[2]]);
      balls_.add({c, distance(c, in_space[t[0]])});
    }
  }

  /// The subsegments in a facet, with the facet as region 0.
  [[nodiscard]] std::vector<ProtectedFace<2>> borders_of(FacetId f,
                                                         const std::map<SphereId, std::uint32_t>& local) const
      requires(D == 3) {
    std::vector<ProtectedFace<2>> faces;
    for (const SegmentId s : domain_.facet_segments[f]) {
      std::array<int, 2> sides = {Walls<2>::kOutside, Walls<2>::kOutside};
      for (const Page& page : fine_.incidence.pages_of(s))
        if (page.facet == f) sides[static_cast<std::size_t>(page.side)] = 0;
      SphereId before = SphereId::none();
      for (const VertexId v : fine_.place.segment_chains[s]) {
        const auto it = sphere_of_.find(v);
        if (it == sphere_of_.end()) continue;
        if (!before.is_none()) faces.push_back({{local.at(before), local.at(it->second)}, sides});
        before = it->second;
      }
    }
    return faces;
  }

  void shrink(const Vec<D>& center, double radius, double f) {
    result_.faults.push_back({center, radius, kShrink * f, std::nullopt});
  }

  /// Faults where a center lies in a protecting ball.
  void find_intruders() {
    const Packing<D>& packing = result_.packing;
    const std::size_t n = packing.center.size();
    std::vector<std::vector<std::uint32_t>> hits(n);
    parallel_for(n, [&](std::size_t i) {
      const SphereId s(i);
      balls_.visit_holding(packing.center[s], 0.0, [&](std::uint32_t b) {
        if (!is_corner(b, s)) hits[i].push_back(b);
        return false;
      });
    });
    for (std::size_t i = 0; i < n; ++i)
      for (const std::uint32_t b : hits[i]) {
        double least = packing.radius[SphereId(i)];
        for (const SphereId corner : corners_of(b)) least = std::min(least, packing.radius[corner]);
        shrink(balls_[b].center, 1.5 * balls_[b].radius, least);
      }
  }

  [[nodiscard]] std::span<const SphereId> corners_of(std::size_t ball) const {
    const Packing<D>& packing = result_.packing;
    if (ball < packing.subsegments.size()) return packing.subsegments[ball].spheres;
    return packing.subfacets[ball - packing.subsegments.size()].spheres;
  }

  /// Of the ball's simplex, or of the tied polygon that the simplex is a part of.
  [[nodiscard]] bool is_corner(std::size_t ball, SphereId s) const {
    if (std::ranges::count(corners_of(ball), s) > 0) return true;
    const auto tied = tied_with_ball_.find(ball);
    return tied != tied_with_ball_.end() && std::ranges::count(tied->second, s) > 0;
  }

  /// One after the other. Who joins takes out all that it overlaps, so that whoever is left may join.
  void add_interior() {
    Vacancies<D> vacancies(fine_.groups, f_);
    for (std::size_t b = 0; b < balls_.size(); ++b) vacancies.take_ball(balls_[b]);
    const Packing<D>& packing = result_.packing;
    for (const SphereId s : ids(packing.center)) vacancies.take_sphere({packing.center[s], packing.radius[s]});
    std::vector<VertexId> joined;
    for (std::size_t i = 0; i < fine_.interior.size(); ++i) {
      if (i % 65536 == 0) observer_.check_cancelled();
      const std::uint32_t number = fine_.number_in_groups[i];
      if (!vacancies.contain(number)) continue;
      vacancies.take_sphere(vacancies.sphere(number));
      joined.push_back(fine_.interior[i]);
    }
    join_all(joined);
  }

  /// What is known of them lies anywhere in memory: threads, and each processor, look for many at a time.
  void join_all(const std::vector<VertexId>& vertices) {
    Packing<D>& packing = result_.packing;
    const std::size_t n = result_.vertex.size();
    result_.vertex.insert(result_.vertex.end(), vertices.begin(), vertices.end());
    packing.center.resize(result_.vertex.size());
    packing.radius.resize(result_.vertex.size());
    packing.carrier.resize(result_.vertex.size());
    parallel_for(vertices.size(), [&](std::size_t i) {
      const VertexId v = vertices[i];
      const SphereId s(n + i);
      packing.center[s] = point(v);
      packing.radius[s] = f_[v];
      packing.carrier[s] = fine_.place.carrier[v];
    });
  }

  const FineMesh<D>& fine_;
  const Domain<D>& domain_;
  const IdVector<VertexId, double>& f_;
  const std::vector<std::uint8_t>& is_kept_;
  const Observer& observer_;
  SphereSet<D> spheres_;  ///< On the boundary.
  std::vector<VertexId> kept_;
  SphereSet<D> kept_spheres_;
  BallSet<D> balls_;                                             ///< Of the subsegments, then of the subfacets.
  std::map<VertexId, SphereId> sphere_of_;                       ///< On the boundary.
  std::map<std::size_t, std::vector<SphereId>> tied_with_ball_;  ///< The corners of its tied polygon.
  PackedLevel<D> result_;
};

}  // namespace

template <int D>
PackedLevel<D> pack_level(const FineMesh<D>& fine, const IdVector<VertexId, double>& f,
                          const std::vector<std::uint8_t>& is_kept, const Observer& observer) {
  return LevelPacker<D>(fine, f, is_kept, observer).run();
}

template PackedLevel<2> pack_level(const FineMesh<2>&, const IdVector<VertexId, double>&,
                                   const std::vector<std::uint8_t>&, const Observer&);
template PackedLevel<3> pack_level(const FineMesh<3>&, const IdVector<VertexId, double>&,
                                   const std::vector<std::uint8_t>&, const Observer&);

}  // namespace voropack
