#include "spheres/pack_interior.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/circumcenter.h"
#include "geom/kernel.h"
#include "spheres/active_cells.h"
#include "spheres/independent_set.h"
#include "spheres/region_labels.h"

namespace voropack {

namespace {

/// When fewer darts join, a circumcenter is the cheaper way to the next sphere (measured: a dart costs about a
/// fifteenth of it).
constexpr double kLeastYield = 0.06;

/// Adds circumcenters to a packing until none can be added: Voronoi maximality.
template <int K>
class Completion {
 public:
  Completion(const PackingProblem<K>& problem, ActiveCells<K>& cells, const Observer& observer)
      : problem_(problem),
        cells_(cells),
        observer_(observer),
        least_radius_(2 * (1 - kPackingSlack) / (1 + problem.spacing.lipschitz)) {}

  /// False if a protected face is missing.
  bool triangulate() {
    const auto n = static_cast<std::uint32_t>(cells_.spheres().size() - problem_.foreign.size());
    std::vector<Vec<K>> points(n);
    for (std::uint32_t v = 0; v < n; ++v) points[v] = sphere(v).center;
    timed([&] {
      kernel_.insert(points);
      labels_ = label_regions<K>(kernel_, problem_.faces);
    });
    return labels_.missing_faces.empty() && labels_.leaking_faces.empty();
  }

  void complete() {
    std::vector<std::uint32_t> slots = kernel_.take_created();
    for (std::uint64_t round = 0; !slots.empty(); ++round) {
      observer_.check_cancelled();
      created_.clear();
      add_circumcenters(slots, round);
      slots.swap(created_);
    }
  }

  void export_to(PackedInterior<K>& out) {
    out.broken_faces = labels_.missing_faces;
    out.broken_faces.insert(out.broken_faces.end(), labels_.leaking_faces.begin(), labels_.leaking_faces.end());
    if (out.broken_faces.empty()) timed([&] { out.triangulation = export_triangulation(kernel_, labels_.region); });
    out.triangulation_s = triangulation_s_;
  }

 private:
  struct Candidate {
    Ball<K> sphere;
    int region;
    std::uint32_t near;  ///< A vertex near to it.
    double openness;     ///< Circumradius over f: how much room there is.
  };

  void add_circumcenters(const std::vector<std::uint32_t>& slots, std::uint64_t round) {
    constexpr std::size_t kBlock = 4096;
    std::vector<std::vector<Candidate>> found((slots.size() + kBlock - 1) / kBlock);
    parallel_for(
        found.size(),
        [&](std::size_t block) {
          for (std::size_t i = block * kBlock; i < std::min(slots.size(), (block + 1) * kBlock); ++i)
            consider(slots[i], found[block]);
        },
        1);
    std::vector<Candidate> candidates;
    for (const auto& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
    if (candidates.empty()) return;
    insert(candidates, round);
  }

  void consider(std::uint32_t slot, std::vector<Candidate>& out) const {
    if (labels_.region[slot] < 0 || !kernel_.is_finite(slot)) return;
    const auto corners = kernel_.corners(slot);
    std::array<Vec<K>, K + 1> points;
    double largest = 0, shortest_sq = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i <= K; ++i) {
      const Ball<K>& s = sphere(corners[i]);
      points[i] = s.center;
      largest = std::max(largest, s.radius);
      for (std::size_t j = 0; j < i; ++j) shortest_sq = std::min(shortest_sq, distance_sq(points[i], points[j]));
    }
    Vec<K> c = fast_circumcenter(points);
    // f(c) >= largest - b radius: most simplices are too small whatever f is there, and need no evaluation of it.
    const double radius_sq = distance_sq(c, points[0]), least = least_radius_ * largest;
    if (radius_sq < least * least) return;
    if (!is_finite(c) || !problem_.bounds.contains(c)) return;
    const double radius = std::sqrt(radius_sq);
    double f = problem_.spacing.at(c);
    if (radius < f + largest) return;
    // The ball around c is empty and large: what blocks c is mostly a protecting ball.
    if (cells_.balls().forbids(c)) {
      const std::optional<Vec<K>> beside = radius_sq > shortest_sq ? beside_balls(c, radius) : std::nullopt;
      if (!beside || problem_.region_of(*beside) != labels_.region[slot]) return;
      c = *beside;
      f = problem_.spacing.at(c);
    }
    if (problem_.jitter > 0) {
      std::uint64_t h = hash_words(problem_.seed, corners[0], corners[1], corners[2]);
      for (int k = 0; k < K; ++k) c[k] += problem_.jitter * f * (2 * to_unit(h = mix64(h)) - 1);
      f = problem_.spacing.at(c);
    }
    if (!problem_.admits(cells_.spheres(), cells_.balls(), c, f)) return;
    out.push_back({{c, f}, labels_.region[slot], corners[0], radius / f});
  }

  /// A place near c outside of all protecting balls, up to this far away. Balls beside walls are larger than the
  /// spheres there; so what they keep from being added is large beside its edges, but mostly there is room a little
  /// farther away from the wall.
  [[nodiscard]] std::optional<Vec<K>> beside_balls(const Vec<K>& c, double reach) const {
    constexpr int kMostBalls = 3;
    Vec<K> x = c;
    for (int i = 0; i <= kMostBalls && distance_sq(x, c) < reach * reach; ++i) {
      Ball<K> holding;
      const auto& balls = cells_.balls();
      const bool is_held = balls.visit_holding(x, kBallMargin, [&](std::uint32_t b) {
        holding = balls[b];
        return true;
      });
      if (!is_held) return problem_.bounds.contains(x) ? std::optional(x) : std::nullopt;
      const double away = distance(x, holding.center);
      if (!(away > 0)) return std::nullopt;
      x = holding.center + (holding.radius * (1 + kBallMargin) / away) * (x - holding.center);
    }
    return std::nullopt;
  }

  /// Adds the time that `work` takes to that of the triangulation.
  template <class Work>
  void timed(Work&& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    triangulation_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  /// The sphere of a vertex of the kernel. Foreign spheres, between the fixed and the new ones, are no vertices.
  [[nodiscard]] const Ball<K>& sphere(std::uint32_t vertex) const {
    return cells_.spheres()[vertex < problem_.fixed.size() ? vertex : vertex + problem_.foreign.size()];
  }

  /// The roomiest first: a packing that starts with its largest holes needs fewest spheres.
  void insert(const std::vector<Candidate>& candidates, std::uint64_t round) {
    std::vector<Ball<K>> balls;
    std::vector<std::uint64_t> priority;
    for (const Candidate& c : candidates) {
      balls.push_back(c.sphere);
      const auto room = static_cast<std::uint64_t>(std::max(0.0, 1e6 * (8 - c.openness)));
      priority.push_back((room << 24U) | (hash_words(problem_.seed, round, priority.size()) >> 40U));
    }
    const std::vector<std::uint8_t> joins = independent_set(balls, priority, problem_.spacing.lipschitz);
    const std::uint32_t first = kernel_.n_vertices();
    std::vector<Vec<K>> points;
    std::vector<std::uint32_t> hints;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (joins[i] == 0) continue;
      cells_.spheres().add(candidates[i].sphere);
      cells_.regions().push_back(candidates[i].region);
      points.push_back(candidates[i].sphere.center);
      hints.push_back(candidates[i].near);
    }
    timed([&] {
      kernel_.insert(points, hints);
      relabel(first);
    });
  }

  /// A new simplex has a new vertex as a corner and lies in that vertex's region: protecting balls keep cavities from
  /// crossing walls.
  void relabel(std::uint32_t first_new_vertex) {
    labels_.region.resize(kernel_.n_slots(), Walls<K>::kOutside);
    created_ = kernel_.take_created();
    for (const std::uint32_t slot : created_) {
      int region = Walls<K>::kOutside;
      for (const std::uint32_t v : kernel_.corners(slot))
        if (v >= first_new_vertex && v != kInfiniteVertex) region = cells_.regions()[v - problem_.fixed.size()];
      labels_.region[slot] = region;
    }
  }

  const PackingProblem<K>& problem_;
  ActiveCells<K>& cells_;
  const Observer& observer_;
  double least_radius_;  ///< Relative to the largest sphere of a simplex: no smaller circumradius leaves room.
  DelaunayKernel<K> kernel_;
  RegionLabels<K> labels_;
  std::vector<std::uint32_t> created_;
  double triangulation_s_ = 0;
};

/// Fills active cells until every ball of radius epsilon f holds a point that cannot be added.
template <int K>
void fill_to_epsilon(ActiveCells<K>& cells, const PackingProblem<K>& problem) {
  // Filtering samples finer from the start: that is what oversampling means.
  if (problem.form == PackingForm::kFiltered) cells.split();
  while (cells.size() > 0 && cells.openness() > problem.epsilon) {
    cells.throw_darts();
    cells.split();
  }
  cells.try_centers();
}

}  // namespace

template <int K>
PackedInterior<K> pack_interior(const PackingProblem<K>& problem, bool want_triangulation, const Observer& observer) {
  const bool voronoi = problem.form == PackingForm::kVoronoi;
  const bool lattice = problem.interior == Interior::kLattice && (voronoi || problem.lattice_first);
  ActiveCells<K> cells(problem, lattice, observer);
  if (voronoi && K > 1) {
    // The circumcenters find the places that are left more cheaply than further darts would.
    cells.throw_darts(kLeastYield);
  } else {
    fill_to_epsilon(cells, problem);
  }

  PackedInterior<K> result;
  if constexpr (K > 1) {
    if (voronoi || want_triangulation) {
      Completion<K> completion(problem, cells, observer);
      if (completion.triangulate() && voronoi) completion.complete();
      completion.export_to(result);
    }
  }
  const auto& all = cells.spheres().spheres();
  result.spheres.assign(all.begin() + static_cast<std::ptrdiff_t>(cells.first_new()), all.end());
  result.regions = cells.regions();
  return result;
}

std::vector<double> equidistribute(double length, const LocalSpacing<1>& spacing) {
  // The measure ds / (2 f) by the midpoint rule on steps of at most half of f: as f is Lipschitz, its relative error is
  // some 1e-4, which the test of the gaps below makes good for.
  std::vector<double> at = {0}, measure = {0};
  while (at.back() < length) {
    const double step = std::min(0.5 * spacing.at({at.back()}), length - at.back());
    const double f = spacing.at({at.back() + 0.5 * step});
    measure.push_back(measure.back() + step / (2 * f));
    at.push_back(length - at.back() <= step ? length : at.back() + step);
  }
  auto parts = static_cast<std::size_t>(std::max(1.0, std::floor(measure.back() * (1 + 1e-12))));
  for (;; --parts) {
    std::vector<double> positions = {0};
    std::size_t k = 0;
    for (std::size_t i = 1; i < parts; ++i) {
      const double target = measure.back() * static_cast<double>(i) / static_cast<double>(parts);
      while (measure[k + 1] < target) ++k;
      const double t = (target - measure[k]) / (measure[k + 1] - measure[k]);
      positions.push_back(at[k] + t * (at[k + 1] - at[k]));
    }
    positions.push_back(length);
    bool fits = true;
    for (std::size_t i = 0; fits && i + 1 < positions.size(); ++i) {
      const double sum = spacing.at({positions[i]}) + spacing.at({positions[i + 1]});
      fits = positions[i + 1] - positions[i] >= sum * (1 - kPackingSlack);
    }
    if (fits || parts == 1) return {positions.begin() + 1, positions.end() - 1};
  }
}

template PackedInterior<1> pack_interior(const PackingProblem<1>&, bool, const Observer&);
template PackedInterior<2> pack_interior(const PackingProblem<2>&, bool, const Observer&);
template PackedInterior<3> pack_interior(const PackingProblem<3>&, bool, const Observer&);

}  // namespace voropack
