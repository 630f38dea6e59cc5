#include "coarsening/completion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "geom/box_tree.h"
#include "geom/circumcenter.h"
#include "geom/kernel.h"
#include "geom/polytope_distance.h"
#include "mesh/parallel_rows.h"
#include "packing/stretched.h"
#include "spheres/packing_problem.h"
#include "spheres/region_labels.h"
#include "spheres/sphere_set.h"

namespace voropack {

namespace {

/// Each round mends what the one before has left or made. Some three are needed.
constexpr int kMaxRounds = 20;
/// How much f shrinks where no vertex of the finest mesh fills a hole.
constexpr double kShrink = 0.7;
/// What rounding may make of a length.
constexpr double kSlack = 1e-9;

template <int D>
class Completer {
 public:
  Completer(const FineMesh<D>& fine, double lipschitz, PackedLevel<D>& level, const Observer& observer)
      : fine_(fine),
        lipschitz_(lipschitz),
        level_(level),
        packing_(level.packing),
        observer_(observer),
        balls_(protecting_balls(fine.place.domain, level.packing)) {
    is_used_.resize(fine.mesh.points.size(), 0);
    for (const VertexId v : level.vertex) is_used_[v.value()] = 1;
  }

  std::vector<SpacingCap<D>> run() {
    const std::vector<ProtectedFace<D>> faces = protected_faces(fine_.place.domain, packing_);
    kernel_.insert(packing_.center.raw());
    std::vector<SpacingCap<D>> gaps;
    for (int round = 0;; ++round) {
      observer_.check_cancelled();
      build_tree();
      find_adjacent();
      labels_ = label_regions<D>(kernel_, faces);
      raise_radii();
      find_slope();
      Wanted wanted = find_wanted();
      gaps = std::move(wanted.gaps);
      if (round == kMaxRounds || !insert(wanted.vertices)) break;
    }
    if (labels_.missing_faces.empty() && labels_.leaking_faces.empty())
      packing_.triangulation = export_triangulation(kernel_, labels_.region);
    return gaps;
  }

 private:
  struct Wanted {
    std::vector<VertexId> vertices;   ///< Of the finest mesh.
    std::vector<SpacingCap<D>> gaps;  ///< Balls of the simplices that want one.
  };

  void find_adjacent() {
    const auto corners = [&](std::size_t slot) { return kernel_.corners(static_cast<std::uint32_t>(slot)); };
    const auto is_finite = [&](std::size_t slot) { return kernel_.is_finite(static_cast<std::uint32_t>(slot)); };
    const std::size_t n = packing_.center.size();
    if constexpr (D == 2)
      adjacent_ = adjacent_in_plane<SphereId>(
          n, kernel_.n_slots(), corners,
          [&](std::size_t slot) { return kernel_.neighbors(static_cast<std::uint32_t>(slot)); }, is_finite);
    else
      adjacent_ = adjacent_values<SphereId>(n, kernel_.n_slots(), corners, is_finite, along_curve_);
    gap_.resize(adjacent_.values.size());
    parallel_for(n, [&](std::size_t i) {
      const SphereId s(along_curve_[i]);
      std::uint64_t k = adjacent_.offsets[s.value()];
      for (const SphereId t : adjacent_[s]) gap_[k++] = distance(packing_.center[s], packing_.center[t]);
    });
  }

  void build_tree() {
    std::vector<std::uint32_t> sphere_of(fine_.mesh.points.size(), kNoHint);
    std::vector<Box<D>> boxes;
    for (const SphereId s : ids(packing_.center)) {
      sphere_of[level_.vertex[s.value()].value()] = s.value();
      boxes.emplace_back(packing_.center[s], packing_.center[s]);
    }
    along_curve_.clear();
    for (const std::uint32_t v : fine_.curve)
      if (sphere_of[v] != kNoHint) along_curve_.push_back(sphere_of[v]);
    tree_ = BoxTree<D>::along_curve(along_curve_, boxes);
  }

  void make_radii_lipschitz() {
    const std::vector<double>& before = packing_.radius.raw();
    tree_.set_values(before);
    std::vector<double> after = before;
    // A sphere inside overlaps none. Only those with a radius below (1 - b) / (1 + b) of its own can be too small.
    const auto only_below = [&](std::uint32_t s) {
      const bool may_overlap = packing_.carrier[SphereId(s)].dimension < D;
      return may_overlap ? before[s] : (1 - lipschitz_) / (1 + lipschitz_) * (1 + kSlack) * before[s];
    };
    // Mostly there is none for a row of spheres along the curve.
    constexpr std::size_t kRow = 32;
    parallel_for((after.size() + kRow - 1) / kRow,
                 [&](std::size_t number) {
                   const std::span row =
                       std::span(along_curve_).subspan(number * kRow, std::min(kRow, after.size() - number * kRow));
                   Box<D> box;
                   double below = 0, largest = 0;
                   for (const std::uint32_t s : row) {
                     box.add(packing_.center[SphereId(s)]);
                     below = std::max(below, only_below(s));
                     largest = std::max(largest, before[s]);
                   }
                   bool is_near = false;
                   tree_.for_each_below(
                       [&](const auto& node) {
                         return !is_near && node.value < below &&
                                node.value + lipschitz_ * (1 - kSlack) * box_distance(node.box, box) < largest;
                       },
                       [&](std::uint32_t) { is_near = true; });
                   if (!is_near) return;
                   for (const std::uint32_t s : row) after[s] = lipschitz_radius(SphereId(s), only_below(s));
                 },
                 16);
    packing_.radius.raw() = std::move(after);
  }

  /// What spheres with radii below `below` leave of that of s.
  [[nodiscard]] double lipschitz_radius(SphereId s, double below) const {
    const Vec<D>& x = packing_.center[s];
    double least = packing_.radius[s];
    tree_.for_each_below(
        [&](const auto& node) {
          return node.value < below && node.value + lipschitz_ * std::sqrt(node.box.distance_sq(x)) < least;
        },
        [&](std::uint32_t t) {
          const SphereId other(t);
          least = std::min(least, packing_.radius[other] + lipschitz_ * distance(x, packing_.center[other]));
        });
    return least;
  }

  /// Vertices are where the finest mesh has some, so that there is often more room than f asks for: the radii take it,
  /// one after the other, as far as they stay Lipschitz.
  void raise_radii() {
    constexpr int kPasses = 2;
    const std::vector<Room> rooms = find_rooms();
    const std::vector<std::array<SphereId, 2>> beyond = spheres_in_the_way(rooms);
    for (int pass = 0; pass < kPasses; ++pass) {
      auto next = beyond.begin();
      for (const SphereId s : ids(packing_.radius)) {
        const auto first = next;
        while (next != beyond.end() && (*next)[0] == s) ++next;
        if (rooms[s.value()].most <= packing_.radius[s]) continue;
        double room = rooms[s.value()].most;
        for_each_adjacent(s, [&](SphereId t, double gap) { room = std::min(room, room_beside(s, t, gap)); });
        for (auto it = first; it != next; ++it)
          room = std::min(room, room_beside(s, (*it)[1], distance_between(s, (*it)[1])));
        packing_.radius[s] = std::max(packing_.radius[s], room);
      }
    }
    make_radii_lipschitz();
  }

  struct Room {
    double most;        ///< However much slopes may come to allow, adjacent spheres do not overlap.
    double nearest_sq;  ///< The nearest center, whatever it is a neighbor by.
  };

  /// What has sharp neighbors only stays as it is.
  [[nodiscard]] std::vector<Room> find_rooms() const {
    std::vector<Room> rooms(packing_.center.size());
    parallel_for(rooms.size(), [&](std::size_t i) {
      const SphereId s(along_curve_[i]);
      double room = std::numeric_limits<double>::infinity(), nearest = room;
      for_each_adjacent(s, [&](SphereId t, double gap) {
        nearest = std::min(nearest, gap);
        if (!are_sharp(s, t)) room = std::min(room, gap - packing_.radius[t]);
      });
      const double radius = packing_.radius[s];
      rooms[s.value()] = {std::isfinite(room) ? std::max(room, radius) : radius, nearest * nearest};
    });
    return rooms;
  }

  template <class Visit>
  void for_each_adjacent(SphereId s, Visit&& visit) const {
    for (std::uint64_t k = adjacent_.offsets[s.value()]; k < adjacent_.offsets[s.value() + 1]; ++k)
      visit(adjacent_.values[k], gap_[k]);
  }
  [[nodiscard]] double distance_between(SphereId s, SphereId t) const {
    return distance(packing_.center[s], packing_.center[t]);
  }

  /// Pairs of spheres, both ways and ascending, that are not adjacent, but might get to overlap while radii rise to the
  /// most they can be.
  ///
  /// Those with no larger a radius lie in a ball about its center, twice as large. All vertices in there are found
  /// along edges that do not leave it: each has a neighbor that is nearer to the center. Mostly there is nothing to
  /// find. Where s and t are not adjacent, the ball with the diameter st holds a neighbor u of s, which sees st at no
  /// acute angle: |st|^2 >= |su|^2 + |ut|^2 >= g_s^2 + g_t^2, with the distances g from the nearest neighbors. So
  /// spheres with m_t <= m_s overlap only if 4 m_s^2 > g_s^2; and if no m exceeds g, which takes a sharp feature, only
  /// if (m_s + m_t)^2 > g_s^2 + m_t^2, hence 3 m_s^2 > g_s^2.
  [[nodiscard]] std::vector<std::array<SphereId, 2>> spheres_in_the_way(const std::vector<Room>& rooms) const {
    const std::size_t n = rooms.size();
    bool is_crowded = false;
    for (const Room& room : rooms) is_crowded |= room.most * room.most > room.nearest_sq;
    const double factor = (is_crowded ? 4 : 3) * (1 + kSlack);
    struct Search {
      std::vector<std::uint32_t> mark;
      std::vector<SphereId> queue;
    };
    tbb::enumerable_thread_specific<Search> searches([&] {
      return Search{std::vector<std::uint32_t>(n, kNoHint), {}};
    });
    using Pairs = std::vector<std::array<SphereId, 2>>;
    const auto search = [&](SphereId s, Pairs& pairs) {
      const double mine = rooms[s.value()].most, reach = 2 * mine * (1 + kSlack);
      auto& [mark, queue] = searches.local();
      queue.clear();
      mark[s.value()] = s.value();
      for_each_adjacent(s, [&](SphereId t, double gap) {
        mark[t.value()] = s.value();
        if (gap < reach) queue.push_back(t);
      });
      for (std::size_t k = 0; k < queue.size(); ++k)
        for (const SphereId t : adjacent_[queue[k]]) {
          if (std::exchange(mark[t.value()], s.value()) == s.value()) continue;
          const double gap = distance_between(s, t), theirs = rooms[t.value()].most;
          if (gap < reach) queue.push_back(t);
          if (gap < mine + theirs && theirs <= mine) pairs.insert(pairs.end(), {{s, t}, {t, s}});
        }
    };
    Pairs all = parallel_reduce_ordered(
        n, 4096, Pairs{},
        [&](std::size_t begin, std::size_t end) {
          Pairs pairs;
          for (std::size_t i = begin; i < end; ++i)
            if (const Room& room = rooms[along_curve_[i]]; factor * room.most * room.most > room.nearest_sq)
              search(SphereId(along_curve_[i]), pairs);
          return pairs;
        },
        [](Pairs some, const Pairs& more) {
          some.insert(some.end(), more.begin(), more.end());
          return some;
        });
    std::sort(all.begin(), all.end());
    return all;
  }

  [[nodiscard]] bool are_sharp(SphereId s, SphereId t) const {
    return packing_.carrier[s].dimension < D && packing_.carrier[t].dimension < D &&
           fine_.incidence.form_sharp_feature(packing_.carrier[s], packing_.carrier[t]);
  }

  /// How large the radius at s may be for the sake of t.
  [[nodiscard]] double room_beside(SphereId s, SphereId t, double gap) const {
    const double slope_allows = packing_.radius[t] + lipschitz_ * gap;
    if (are_sharp(s, t)) return slope_allows;
    return std::min(slope_allows, gap - packing_.radius[t]);
  }

  /// How steep f is along the edges at most.
  void find_slope() {
    slope_ = parallel_reduce_ordered(
        packing_.center.size(), 4096, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double steepest = 0;
          for (std::size_t i = begin; i < end; ++i) {
            const SphereId s(i);
            for_each_adjacent(s, [&](SphereId t, double gap) {
              const double rise = packing_.radius[s] - packing_.radius[t];
              if (rise > steepest * gap) steepest = rise / gap;
            });
          }
          return steepest;
        },
        [](double a, double b) { return std::max(a, b); });
  }

  Wanted find_wanted() const {
    constexpr std::size_t kBlock = 4096;
    const std::size_t n = kernel_.n_slots();
    std::vector<Wanted> parts((n + kBlock - 1) / kBlock);
    parallel_for(
        parts.size(),
        [&](std::size_t block) {
          for (std::size_t slot = block * kBlock; slot < std::min(n, (block + 1) * kBlock); ++slot)
            consider(static_cast<std::uint32_t>(slot), parts[block]);
        },
        1);
    Wanted all;
    for (const Wanted& part : parts) {
      all.vertices.insert(all.vertices.end(), part.vertices.begin(), part.vertices.end());
      all.gaps.insert(all.gaps.end(), part.gaps.begin(), part.gaps.end());
    }
    return all;
  }

  void consider(std::uint32_t slot, Wanted& out) const {
    if (!kernel_.is_finite(slot) || labels_.region[slot] < 0) return;
    const auto corners = kernel_.corners(slot);
    std::array<Vec<D>, D + 1> x;
    double least = std::numeric_limits<double>::infinity(), largest = 0, shortest_sq = least;
    for (std::size_t i = 0; i <= D; ++i) {
      x[i] = packing_.center[SphereId(corners[i])];
      least = std::min(least, packing_.radius[SphereId(corners[i])]);
      largest = std::max(largest, packing_.radius[SphereId(corners[i])]);
      for (std::size_t j = 0; j < i; ++j) shortest_sq = std::min(shortest_sq, distance_sq(x[i], x[j]));
    }
    const Vec<D> c = fast_circumcenter(x);
    const double radius = distance(c, x[0]);
    // f(c) is at most `least` + slope R, and a sphere of that radius fits if it overlaps none at the corners.
    const bool is_roomy = radius > (least + slope_ * radius + largest) * (1 + kSlack);
    const bool is_long = radius * radius > kRadiusEdge * kRadiusEdge * shortest_sq;
    if (!is_roomy && !is_long) return;
    // What is in a protecting ball leaves no room, but a smaller ball would.
    const bool is_forbidden = balls_.forbids(c);
    const bool is_stretched = is_long && !has_sharp_pair<D>(packing_, fine_.incidence, corners);
    if ((!is_roomy || is_forbidden) && !is_stretched) return;
    out.gaps.push_back({c, radius, is_stretched ? 0.5 * std::sqrt(shortest_sq) : kShrink * least});
    if (is_forbidden) return;
    const VertexId v = nearest_usable(nearest_vertex(level_.vertex[corners[0]], c), c);
    if (!v.is_none()) out.vertices.push_back(v);
  }

  [[nodiscard]] bool is_usable(VertexId v) const {
    return is_used_[v.value()] == 0 && fine_.is_interior(v) && !balls_.forbids(fine_.mesh.points[v]);
  }

  /// v, or the nearest to x of those beside it; none if there is none.
  [[nodiscard]] VertexId nearest_usable(VertexId v, const Vec<D>& x) const {
    if (is_usable(v)) return v;
    VertexId best = VertexId::none();
    double least = std::numeric_limits<double>::infinity();
    for (const VertexId w : fine_.edges.neighbors[v])
      if (const double d = distance_sq(fine_.mesh.points[w], x); d < least && is_usable(w)) least = d, best = w;
    return best;
  }

  /// Downhill along the edges of the finest mesh: a Delaunay triangulation has no other minimum.
  [[nodiscard]] VertexId nearest_vertex(VertexId v, const Vec<D>& x) const {
    for (double least = distance_sq(fine_.mesh.points[v], x);;) {
      VertexId best = v;
      for (const VertexId w : fine_.edges.neighbors[v])
        if (const double d = distance_sq(fine_.mesh.points[w], x); d < least) least = d, best = w;
      if (best == v) return v;
      v = best;
    }
  }

  /// Adds vertices, but none beside another new one. False if there is none.
  bool insert(const std::vector<VertexId>& wanted) {
    const std::size_t n_before = packing_.center.size();
    tree_.set_values(std::vector<double>(n_before, 0.0));
    std::vector<Vec<D>> points;
    std::vector<std::uint32_t> hints;
    std::vector<std::uint8_t> is_taken(n_before, 0);
    SphereSet<D> added(fine_.place.domain.box.center(), lipschitz_, packing_.radius[SphereId(0)]);
    for (const VertexId v : wanted) {
      if (is_used_[v.value()] != 0) continue;
      const Vec<D>& x = fine_.mesh.points[v];
      const auto distance_to = [&](std::uint32_t s) { return distance(x, packing_.center[SphereId(s)]); };
      std::uint32_t nearest = 0;
      double gap = std::numeric_limits<double>::infinity();
      tree_.minimize(x, 1, gap, [&](std::uint32_t s) {
        const double d = distance_to(s);
        if (d < gap) gap = d, nearest = s;
        return d;
      });
      // A sphere s that overlaps the new one has r_s <= r_nearest + b (d_s + gap) and d_s < gap / 2 + r_s.
      const double near = packing_.radius[SphereId(nearest)] + gap;
      const double reach = (0.5 * gap + near + lipschitz_ * gap) / (1 - lipschitz_);
      std::vector<std::uint32_t> touched;
      tree_.for_each([&](const Box<D>& box) { return box.distance_sq(x) <= reach * reach; },
                     [&](std::uint32_t s) {
                       if (distance_to(s) < reach) touched.push_back(s);
                     });
      if (std::ranges::any_of(touched, [&](std::uint32_t s) { return is_taken[s] != 0; })) continue;
      if (added.conflicts(x, 0.5 * gap)) continue;
      added.add({x, 0.5 * gap});
      for (const std::uint32_t s : touched) {
        is_taken[s] = 1;
        double& radius = packing_.radius[SphereId(s)];
        radius = std::min(radius, distance_to(s) - 0.5 * gap);
      }
      is_used_[v.value()] = 1;
      packing_.center.push_back(x);
      packing_.radius.push_back(0.5 * gap);
      packing_.carrier.push_back(fine_.place.carrier[v]);
      level_.vertex.push_back(v);
      points.push_back(x);
      hints.push_back(nearest);
    }
    if (points.empty()) return false;
    kernel_.insert(points, hints);
    return true;
  }

  const FineMesh<D>& fine_;
  double lipschitz_;
  PackedLevel<D>& level_;
  Packing<D>& packing_;
  const Observer& observer_;
  BallSet<D> balls_;
  DelaunayKernel<D> kernel_;
  std::vector<std::uint32_t> along_curve_;  ///< The spheres, each near to the one before.
  Csr<SphereId, SphereId> adjacent_;        ///< Along the edges of the triangulation.
  std::vector<double> gap_;                 ///< The lengths of these edges.
  BoxTree<D> tree_;                         ///< Of the centers.
  RegionLabels<D> labels_;
  double slope_ = 0;                   ///< Largest measured one of the radii.
  std::vector<std::uint8_t> is_used_;  ///< By vertex of the finest mesh.
};

}  // namespace

template <int D>
std::vector<SpacingCap<D>> complete_level(const FineMesh<D>& fine, double lipschitz, PackedLevel<D>& level,
                                          const Observer& observer) {
  return Completer<D>(fine, lipschitz, level, observer).run();
}

template std::vector<SpacingCap<2>> complete_level(const FineMesh<2>&, double, PackedLevel<2>&, const Observer&);
template std::vector<SpacingCap<3>> complete_level(const FineMesh<3>&, double, PackedLevel<3>&, const Observer&);

}  // namespace voropack
