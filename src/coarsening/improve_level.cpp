#include "coarsening/improve_level.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random.h"

namespace voropack {

namespace {

class Improver {
 public:
  Improver(const PlanarPacker& packer, const ImprovementWish& wish, PlanarPacking& level, Observer& observer)
      : fine_(packer.fine()),
        packer_(packer),
        wish_(wish),
        packed_(level),
        level_(level.level),
        observer_(observer),
        random_(hash_words(wish.seed, std::uint64_t{0x1a9})) {
    is_kept_.assign(fine_.points.size(), 0);
    for (const std::uint32_t v : wish.kept) is_kept_[v] = 1;
  }

  std::size_t run() {
    constexpr std::size_t kSteps = 12;
    constexpr double kWarmest = 1.5;  // In costs: of one triangle of the quality that is the goal.
    for (std::size_t step = 0; step < kSteps; ++step) {
      // The goal follows what has been reached: some triangles cost about 1, no matter how good the level is.
      goal_deg_ = worst_quality(level_) + kGoalAbove;
      level_.set_cost({goal_deg_, kCostScale});
      temperature_ = kWarmest * (1 - static_cast<double>(step + 1) / kSteps);
      sweep(wish_.trials * level_.n_vertices() / kSteps);
    }
    return n_exchanges_;
  }

 private:
  static constexpr double kGoalAbove = 3, kCostScale = 2;
  static constexpr std::size_t kRings = 2;

  bool accept(double change) {
    if (change < 0) return change < -1e-9;
    return temperature_ > 0 && change > 0 && random_.unit() < std::exp(-change / temperature_);
  }

  std::uint32_t pick(std::size_t n) { return static_cast<std::uint32_t>(random_.bits() % n); }

  /// Tries exchanges where something is wrong: at triangles near the goal and kRings around them, which have to move
  /// together. As many for each vertex there as everywhere, were there bad triangles everywhere.
  void sweep(std::size_t n_trials) {
    for (double n_tried = 0; n_tried < static_cast<double>(n_trials);) {
      observer_.check_cancelled();
      const std::size_t n_all = find_worst();
      if (worst_.empty()) return;
      // Bad triangles more often than good ones: each batch works on a prefix of random length.
      const std::size_t batch = std::max<std::size_t>(16, worst_.size() / 8);
      for (std::size_t k = 0; k < batch; ++k) {
        const double u = random_.unit();
        const auto i = static_cast<std::size_t>(u * u * u * static_cast<double>(worst_.size()));
        const std::uint32_t slot = worst_[i].second;
        if (level_.triangulation().is_alive(slot) && level_.region(slot) >= 0) try_triangle(slot);
      }
      n_tried += static_cast<double>(batch) * static_cast<double>(n_all) / static_cast<double>(worst_.size());
    }
  }

  /// Fills worst_, the worst first; the number of all triangles.
  std::size_t find_worst() {
    const auto& t = level_.triangulation();
    worst_.clear();
    is_near_.assign(t.n_slots(), 0);
    std::size_t n_all = 0;
    const auto add = [&](std::uint32_t slot) {
      if (std::exchange(is_near_[slot], 1) == 0) worst_.push_back({level_.quality(slot), slot});
    };
    for (std::uint32_t slot = 0; slot < t.n_slots(); ++slot) {
      if (!t.is_alive(slot) || level_.region(slot) < 0) continue;
      ++n_all;
      if (level_.quality(slot) <= goal_deg_ + kGoalAbove) add(slot);
    }
    std::size_t ring_begin = 0;
    for (std::size_t ring = 0; ring < kRings; ++ring) {
      const std::size_t ring_end = worst_.size();
      for (; ring_begin < ring_end; ++ring_begin)
        for (const std::uint32_t v : t.triangle(worst_[ring_begin].second).corners)
          t.around(v, [&](std::uint32_t slot, std::size_t) {
            if (level_.region(slot) >= 0) add(slot);
          });
    }
    std::sort(worst_.begin(), worst_.end());
    return n_all;
  }

  void try_triangle(std::uint32_t slot) {
    const auto corners = level_.triangulation().triangle(slot).corners;
    const double dice = random_.unit();
    if (dice < 0.08 && level_.n_vertices() < wish_.max_vertices) return try_add(corners);
    const std::uint32_t v = corners[pick(3)];
    if (is_kept_[v] != 0 || fine_.is_anchor[v] != 0) return;
    if (dice > 0.92 && level_.n_vertices() > wish_.min_vertices) {
      if (!fine_.on_boundary(v) || level_.may_drop(v)) try_exchange(v, std::nullopt);
      return;
    }
    if (const auto in = fine_.on_boundary(v) ? chain_candidate(v) : inner_candidate(v)) try_exchange(v, *in);
  }

  void try_exchange(std::optional<std::uint32_t> out, std::optional<std::uint32_t> in) {
    if (wish_.is_packing_kept && in && packer_.overlap(packed_, *in, out) > 0) return;
    if (level_.exchange(out, in, [&](double change) { return accept(change); })) ++n_exchanges_;
  }

  /// A free place of the chain between the neighbors of v.
  std::optional<std::uint32_t> chain_candidate(std::uint32_t v) {
    const ChainPlace place = fine_.places[VertexId(std::size_t{v})][0];
    const auto& vertices = fine_.chains[place.chain].vertices;
    const std::size_t n = vertices.size();
    const std::size_t from = level_.previous(place), to = level_.next(place);
    const std::size_t gap = (to + n - from) % n;
    if (gap < 3) return std::nullopt;
    const std::size_t at = (from + 1 + pick(gap - 1)) % n;
    if (at == place.position) return std::nullopt;
    return vertices[at];
  }

  std::optional<std::uint32_t> inner_candidate(std::uint32_t v) {
    double shortest_sq = std::numeric_limits<double>::infinity();
    const auto& t = level_.triangulation();
    const Vec<2>& x = fine_.points[v];
    t.around(v, [&](std::uint32_t slot, std::size_t i) {
      shortest_sq = std::min(shortest_sq, distance_sq(x, t.point(t.triangle(slot).corners[(i + 1) % 3])));
    });
    // Far moves first, near ones later on.
    return free_near(x, (0.3 + 0.5 * random_.unit()) * std::sqrt(shortest_sq), fine_.vertex_region[v]);
  }

  std::optional<std::uint32_t> free_near(const Vec<2>& x, double radius, int region) {
    std::optional<std::uint32_t> chosen;
    std::size_t count = 0;
    packer_.for_each_near(x, radius, [&](std::uint32_t p) {
      if (level_.has(p) || fine_.on_boundary(p) || fine_.vertex_region[p] != region) return;
      if (pick(++count) == 0) chosen = p;
    });
    return chosen;
  }

  void try_add(const std::array<std::uint32_t, 3>& corners) {
    // Near the circumcenter, or between two corners on a chain.
    const auto& t = level_.triangulation();
    const Vec<2>&a = t.point(corners[0]), &b = t.point(corners[1]), &c = t.point(corners[2]);
    const std::uint32_t v = corners[pick(3)];
    if (fine_.on_boundary(v) && pick(2) == 0) {
      const ChainPlace place = fine_.places[VertexId(std::size_t{v})][0];
      if (!level_.begins_edge(place)) return;
      const auto& vertices = fine_.chains[place.chain].vertices;
      const std::size_t gap = (level_.next(place) + vertices.size() - place.position) % vertices.size();
      if (gap > 1) try_exchange(std::nullopt, vertices[(place.position + 1 + pick(gap - 1)) % vertices.size()]);
      return;
    }
    const Vec<2> u = b - a, w = c - a;
    const double scale = 0.5 / cross(u, w);
    const Vec<2> offset = scale * Vec<2>{w[1] * norm_sq(u) - u[1] * norm_sq(w), u[0] * norm_sq(w) - w[0] * norm_sq(u)};
    const auto slot = level_.triangulation().slot_of(corners[0]);
    const int region = level_.region(slot);
    if (const auto in = free_near(a + offset, 0.5 * norm(offset), region)) try_exchange(std::nullopt, *in);
  }

  const ChainedMesh& fine_;
  const PlanarPacker& packer_;
  const ImprovementWish& wish_;
  PlanarPacking& packed_;
  ConformingLevel& level_;
  Observer& observer_;
  Random random_;
  std::vector<std::uint8_t> is_kept_;
  std::vector<std::pair<double, std::uint32_t>> worst_;  ///< Quality and slot.
  std::vector<std::uint8_t> is_near_;                    ///< Per slot: whether in worst_.
  double temperature_ = 0, goal_deg_ = 0;
  std::size_t n_exchanges_ = 0;
};

}  // namespace

double worst_quality(const ConformingLevel& level) {
  double worst = 60;
  const auto& t = level.triangulation();
  for (std::uint32_t slot = 0; slot < t.n_slots(); ++slot)
    if (t.is_alive(slot) && level.region(slot) >= 0) worst = std::min(worst, level.quality(slot));
  return worst;
}

std::size_t improve_level(const PlanarPacker& packer, const ImprovementWish& wish, PlanarPacking& level,
                          Observer& observer) {
  return Improver(packer, wish, level, observer).run();
}

}  // namespace voropack
