#include "coarsening/planar_packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "base/random.h"
#include "coarsening/fine_mesh.h"
#include "coarsening/initial_spacing.h"
#include "geom/hilbert.h"
#include "geom/predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// The simplified boundary may leave out features of this many times f where that is needed for it to conform.
constexpr double kMaxDeviation = 8;
/// A vertex where a chain turns by more than this is packed before those between such vertices.
constexpr double kCornerTurn = std::numbers::pi / 4;
/// A vertex where it turns by more than this is the tip of a wedge.
constexpr double kTipTurn = std::numbers::pi / 2;
/// How near to touching a chosen sphere a candidate is counted as its neighbor, relative to the sum of the radii.
constexpr double kFrontReach = 1.6;
/// Keys of candidates vary by up to this from seed to seed.
constexpr double kKeyJitter = 0.15;

[[noreturn]] void throw_not_conforming(const ChainedMesh& fine, std::uint32_t vertex) {
  const Vec<2>& x = fine.points[vertex];
  throw InputError(
      Fault{.id = "coarsen.not_conforming",
            .message = fmt::format("the boundary of the mesh does not conform near ({}, {}), and no coarser "
                                   "boundary there does",
                                   x[0], x[1]),
            .fix = "mesh the domain anew",
            .position = {x[0], x[1]}});
}

/// How much the polygon turns at a place; 0 where it is straight or ends.
double turn(const ChainedMesh& fine, const ChainPlace& place) {
  const VertexChain& chain = fine.chains[place.chain];
  const std::size_t n = chain.vertices.size(), k = place.position;
  if (!chain.is_closed && (k == 0 || k + 1 == n)) return 0;
  const Vec<2> x = fine.points[chain.vertices[k]];
  const Vec<2> u = x - fine.points[chain.vertices[(k + n - 1) % n]], v = fine.points[chain.vertices[(k + 1) % n]] - x;
  return std::abs(std::atan2(cross(u, v), dot(u, v)));
}

}  // namespace

struct PlanarPacker::State {
  explicit State(const ChainedMesh& fine) : level(fine) {}
  ConformingLevel level;
  std::vector<double> reduction;  ///< [fine vertices] of f_0.
  std::vector<double> f;
  std::vector<std::uint8_t> is_blocked;
  std::vector<std::uint32_t> rungs;  ///< Vertices of ladders but for their tips.
  std::vector<std::uint8_t> is_kept;
  std::vector<std::size_t> n_kept;  ///< [chains]
};

PlanarPacker::PlanarPacker(const Mesh<2>& mesh, const ChainedMesh& fine, InitialSpacing initial, Observer& observer)
    : fine_(&fine), observer_(&observer) {
  VertexSpacing spacing = initial_spacing(mesh, build_edge_graph(mesh), initial);
  initial_ = std::move(spacing.initial.raw());
  nearest_ = std::move(spacing.nearest.raw());
  std::vector<Box<2>> boxes;
  for (const Vec<2>& x : fine.points) boxes.emplace_back(x, x);
  tree_ = BoxTree<2>(boxes, initial_);
  find_anchor_gaps();
}

void PlanarPacker::find_anchor_gaps() {
  std::vector<std::uint32_t> anchors;
  std::vector<Box<2>> boxes;
  for (std::uint32_t v = 0; v < fine_->points.size(); ++v)
    if (fine_->is_anchor[v] != 0) {
      anchors.push_back(v);
      boxes.emplace_back(fine_->points[v], fine_->points[v]);
    }
  anchor_gap_.assign(fine_->points.size(), std::numeric_limits<double>::infinity());
  const BoxTree<2> tree(boxes);
  for (const std::uint32_t v : anchors) {
    const Vec<2>& x = fine_->points[v];
    double nearest_sq = std::numeric_limits<double>::infinity();
    tree.for_each([&](const Box<2>& box) { return box.distance_sq(x) < nearest_sq; },
                  [&](std::uint32_t i) {
                    if (anchors[i] != v) nearest_sq = std::min(nearest_sq, distance_sq(x, fine_->points[anchors[i]]));
                  });
    anchor_gap_[v] = 0.5 * std::sqrt(nearest_sq);
  }
}

std::vector<double> PlanarPacker::spacing(const PackingWish& wish, const std::vector<double>& reduction) const {
  const std::size_t n = fine_->points.size();
  std::vector<double> f(n);
  // The tree knows f_0: growth f_0 with slope L is growth times f_0 with slope L / growth.
  const double slope = wish.lipschitz / wish.growth;
  for (std::size_t v = 0; v < n; ++v) {
    const Vec<2>& x = fine_->points[v];
    f[v] = wish.growth * tree_.minimize(x, slope, initial_[v], [&](std::uint32_t q) {
      return initial_[q] + slope * distance(x, fine_->points[q]);
    });
  }
  // Where f has to be smaller than that, it is so around, too.
  std::vector<Box<2>> boxes;
  std::vector<double> values;
  for (std::size_t v = 0; v < n; ++v) {
    double value = std::min(f[v], anchor_gap_[v]);
    if (!reduction.empty() && reduction[v] < 1)
      value = std::min(value, std::max(reduction[v] * wish.growth * initial_[v], nearest_[v]));
    if (!wish.bound.empty()) value = std::min(value, wish.bound[v]);
    if (value >= f[v]) continue;
    boxes.emplace_back(fine_->points[v], fine_->points[v]);
    values.push_back(value);
  }
  const BoxTree<2> smaller(boxes, values);
  for (std::size_t v = 0; v < n; ++v)
    f[v] = smaller.minimize(fine_->points[v], wish.lipschitz, f[v], [&](std::uint32_t q) {
      return values[q] + wish.lipschitz * distance(fine_->points[v], boxes[q].lo);
    });
  return f;
}

double PlanarPacker::overlap(const PlanarPacking& packed, std::uint32_t vertex,
                             std::optional<std::uint32_t> other) const {
  const double radius = packed.radius[vertex];
  const Vec<2>& x = fine_->points[vertex];
  double largest = 0;
  for_each_near(x, 2 * packed.spacing[vertex] / (1 - packed.lipschitz), [&](std::uint32_t p) {
    if (p == vertex || p == other || !packed.level.has(p)) return;
    largest = std::max(largest, 1 - distance(fine_->points[p], x) / (radius + packed.radius[p]));
  });
  return largest;
}

void PlanarPacker::block_around(std::uint32_t q, double lipschitz, State& state) const {
  state.is_blocked[q] = 1;
  const double f = state.f[q];
  for_each_near(fine_->points[q], 2 * f / (1 - lipschitz), [&](std::uint32_t p) {
    if (distance(fine_->points[p], fine_->points[q]) < f + state.f[p]) state.is_blocked[p] = 1;
  });
}

std::vector<std::uint32_t> PlanarPacker::boundary_order(const PackingWish& wish) const {
  std::vector<std::pair<double, std::uint32_t>> corners;
  std::vector<std::uint32_t> order;
  for (std::uint32_t v = 0; v < fine_->points.size(); ++v) {
    if (fine_->is_anchor[v] != 0) {
      order.push_back(v);
      continue;
    }
    for (const ChainPlace& place : fine_->places[VertexId(std::size_t{v})])
      if (const double angle = turn(*fine_, place); angle > kCornerTurn) corners.push_back({-angle, v});
  }
  std::sort(corners.begin(), corners.end());
  for (const auto& corner : corners) order.push_back(corner.second);
  for (std::size_t c = 0; c < fine_->chains.size(); ++c) {
    const auto& vertices = fine_->chains[c].vertices;
    const std::size_t n = vertices.size();
    // From a corner on, or from anywhere.
    const std::uint64_t dice = hash_words(wish.seed, c);
    const bool is_backward = (dice >> 40U & 1U) != 0;
    std::size_t start = wish.seed == 0 || !fine_->chains[c].is_closed ? 0 : dice % n;
    for (std::size_t k = 0; k < n && wish.seed == 0; ++k)
      if (turn(*fine_, {static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(k)}) > kCornerTurn) start = k;
    for (std::size_t k = 0; k < n; ++k) order.push_back(vertices[(is_backward ? start + n - k : start + k) % n]);
  }
  return order;
}

bool PlanarPacker::pack_boundary(const PackingWish& wish, State& state) const {
  state.level = ConformingLevel(*fine_);
  state.level.max_area_change = wish.max_area_change;
  state.rungs.assign(wish.rungs.begin(), wish.rungs.end());
  state.f = spacing(wish, state.reduction);
  state.is_blocked.assign(fine_->points.size(), 0);
  for (const std::uint32_t v : wish.kept) state.level.choose(v);
  for (const std::uint32_t v : wish.kept) block_around(v, wish.lipschitz, state);
  choose_tips(wish, state);
  for (const std::uint32_t v : boundary_order(wish)) {
    if (state.level.has(v) || (state.is_blocked[v] != 0 && fine_->is_anchor[v] == 0)) continue;
    state.level.choose(v);
    block_around(v, wish.lipschitz, state);
  }
  // What encloses something needs enough vertices to do so.
  for (std::size_t c = 0; c < fine_->chains.size(); ++c) {
    const VertexChain& chain = fine_->chains[c];
    if (state.level.n_chosen(c) >= chain.min_vertices()) continue;
    bool is_reduced = false;
    for (const std::uint32_t v : chain.vertices) is_reduced = reduce(v, wish, state) || is_reduced;
    if (!is_reduced) throw_not_conforming(*fine_, chain.vertices.front());
    return false;
  }
  return mend_boundary(wish, state);
}

bool PlanarPacker::reduce(std::uint32_t v, const PackingWish& wish, State& state) const {
  if (state.reduction.empty()) state.reduction.assign(fine_->points.size(), 1);
  // f may be smaller than growth f_0 already, by its Lipschitz condition.
  const double now = std::min(state.f[v], wish.growth * initial_[v] * state.reduction[v]);
  if (now <= nearest_[v]) return false;
  state.reduction[v] = 0.5 * now / (wish.growth * initial_[v]);
  return true;
}

void PlanarPacker::choose_tips(const PackingWish& wish, State& state) const {
  for (std::uint32_t c = 0; c < fine_->chains.size(); ++c)
    for (std::uint32_t k = 0; k < fine_->chains[c].vertices.size(); ++k)
      if (turn(*fine_, {c, k}) > kTipTurn) choose_tip({c, k}, wish, state);
}

void PlanarPacker::choose_tip(const ChainPlace& tip, const PackingWish& wish, State& state) const {
  const auto& vertices = fine_->chains[tip.chain].vertices;
  const std::size_t n = vertices.size();
  // How far a side goes: round a closed chain, to the end of an open one.
  const bool is_closed = fine_->chains[tip.chain].is_closed;
  const std::size_t n_left = is_closed ? n : n - tip.position, n_right = is_closed ? n : tip.position + 1;
  const std::uint32_t a = vertices[tip.position];
  if (!state.level.has(a) && state.is_blocked[a] != 0) return;
  const auto at = [&](std::size_t steps, bool is_forward) {
    return vertices[(tip.position + (is_forward ? steps : n - steps)) % n];
  };
  const auto is_free = [&](std::uint32_t v, std::uint32_t before) {
    return state.is_blocked[v] == 0 && fine_->is_anchor[v] == 0 &&
           distance(fine_->points[v], fine_->points[before]) >= state.f[v] + state.f[before];
  };
  const auto in_ball = [&](std::uint32_t u, std::uint32_t v, std::uint32_t w) {
    return in_diametral_ball(fine_->points[u], fine_->points[v], fine_->points[w]) > 0;
  };
  // Rungs of a ladder from the tip to where the wedge is wide enough. Neither vertex of a rung may lie in the ball of
  // an edge of the other side. Of the pairs that conform, the nearest one that is free, and of those the best match.
  std::vector<std::uint32_t> ladder = {a};
  std::uint32_t left = a, right = a;
  std::size_t next_left = 1, next_right = 1;
  for (std::size_t i = next_left; i < n_left && i + next_right < n; ++i) {
    const std::uint32_t b = at(i, true);
    if (state.level.has(b)) break;
    if (!is_free(b, left)) continue;
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = next_right; j < n_right && i + j < n; ++j) {
      const std::uint32_t c = at(j, false);
      if (state.level.has(c)) break;
      if (!is_free(c, right) || in_ball(left, b, c) || in_ball(right, c, b)) continue;
      const double mismatch = std::abs(distance_sq(fine_->points[c], fine_->points[left]) -
                                       distance_sq(fine_->points[b], fine_->points[right]));
      if (mismatch >= least) continue;
      least = mismatch;
      best = j;
    }
    if (!best) continue;
    left = b;
    right = at(*best, false);
    next_left = i + 1;
    next_right = *best + 1;
    ladder.insert(ladder.end(), {left, right});
    if (distance(fine_->points[left], fine_->points[right]) >= state.f[left] + state.f[right]) break;
  }
  if (ladder.size() == 1) return;
  for (const std::uint32_t v : ladder)
    if (!state.level.has(v)) state.level.choose(v);
  for (const std::uint32_t v : ladder) block_around(v, wish.lipschitz, state);
  state.rungs.insert(state.rungs.end(), ladder.begin() + 1, ladder.end());
}

std::vector<double> PlanarPacker::radii(const State& state) const {
  std::vector<double> radius = state.f;
  std::vector<std::uint8_t> is_rung(fine_->points.size(), 0);
  for (const std::uint32_t v : state.rungs) is_rung[v] = state.level.has(v) ? 1 : 0;
  for (const std::uint32_t v : state.rungs) {
    if (!state.level.has(v)) continue;
    for_each_near(fine_->points[v], 2 * state.f[v], [&](std::uint32_t u) {
      if (u != v && is_rung[u] != 0)
        radius[v] = std::min(radius[v], 0.5 * distance(fine_->points[u], fine_->points[v]));
    });
  }
  return radius;
}

bool PlanarPacker::mend(const ConformingLevel::Fault& fault, bool is_last_resort, State& state) const {
  const ConformingLevel& level = state.level;
  const VertexChain& chain = fine_->chains[fault.from.chain];
  const std::array<std::optional<std::uint32_t>, 3> suspects = {fault.culprit, chain.vertices[fault.from.position],
                                                                chain.vertices[fault.to]};
  std::optional<std::uint32_t> best;
  double best_deviation = is_last_resort ? std::numeric_limits<double>::infinity() : kMaxDeviation;
  for (const auto& v : suspects) {
    if (!v || state.is_kept[*v] != 0 || !fine_->on_boundary(*v) || !level.may_drop(*v)) continue;
    const ChainPlace place = fine_->places[VertexId(std::size_t{*v})][0];
    const VertexChain& own = fine_->chains[place.chain];
    const std::uint32_t before = level.previous(place), after = level.next(place);
    double deviation = chain_deviation(*fine_, own, before, after) / state.f[*v];
    // The next coarser level is free of faults, and goes at least as far.
    if (state.n_kept[place.chain] >= own.min_vertices()) deviation = std::min(deviation, 0.5 * kMaxDeviation);
    if (deviation >= best_deviation) continue;
    best_deviation = deviation;
    best = v;
  }
  if (best) state.level.drop(*best);
  return best.has_value();
}

bool PlanarPacker::reduce_edge(const ChainPlace& from, const PackingWish& wish, State& state) const {
  const auto& vertices = fine_->chains[from.chain].vertices;
  const std::size_t to = state.level.next(from);
  bool is_reduced = reduce(vertices[from.position], wish, state);
  for (std::size_t k = from.position; k != to;) {
    k = (k + 1) % vertices.size();
    is_reduced = reduce(vertices[k], wish, state) || is_reduced;
  }
  if (is_reduced) return true;
  // Vertices around may still be in the way of those between its ends.
  const Vec<2>&x = fine_->points[vertices[from.position]], &y = fine_->points[vertices[to]];
  for_each_near(0.5 * (x + y), distance(x, y), [&](std::uint32_t v) {
    if (fine_->on_boundary(v)) is_reduced = reduce(v, wish, state) || is_reduced;
  });
  return is_reduced;
}

bool PlanarPacker::reduce_area_change(const PackingWish& wish, State& state) const {
  // The edges that cut off most: all that cut off at least half as much as the worst one.
  std::vector<std::pair<double, ChainPlace>> edges;
  double largest = 0;
  state.level.for_each_edge([&](const ChainPlace& place) {
    const double area = chain_area(*fine_, fine_->chains[place.chain], place.position, state.level.next(place));
    edges.push_back({std::abs(area), place});
    largest = std::max(largest, std::abs(area));
  });
  bool is_reduced = false;
  for (const auto& [area, place] : edges)
    if (area > 0 && area >= 0.5 * largest) is_reduced = reduce_edge(place, wish, state) || is_reduced;
  return is_reduced;
}

bool PlanarPacker::free_misplaced(State& state) const {
  bool is_freed = false;
  for (const std::uint32_t v : state.level.misplaced_vertices()) {
    std::optional<std::uint32_t> nearest;
    double least_sq = std::numeric_limits<double>::infinity();
    state.level.for_each_edge([&](const ChainPlace& place) {
      const std::uint32_t b = fine_->chains[place.chain].vertices[place.position];
      if (state.is_kept[b] != 0 || !state.level.may_drop(b)) return;
      const double gap_sq = distance_sq(fine_->points[v], fine_->points[b]);
      if (gap_sq >= least_sq) return;
      least_sq = gap_sq;
      nearest = b;
    });
    if (!nearest) continue;
    state.level.drop(*nearest);
    is_freed = true;
  }
  return is_freed;
}

bool PlanarPacker::mend_boundary(const PackingWish& wish, State& state) const {
  for (;;) {
    observer_->check_cancelled();
    const auto faults = state.level.boundary_faults();
    if (faults.empty()) {
      const bool is_sound = state.level.settle_boundary();
      if (is_sound && state.level.area_change() <= wish.max_area_change) return true;
      if (!is_sound && free_misplaced(state)) continue;
      if (reduce_area_change(wish, state)) return false;
      if (is_sound) return true;
      throw_not_conforming(*fine_, 0);
    }
    bool is_mended = false, is_reduced = false;
    for (const auto& fault : faults) {
      const std::uint32_t a = fine_->chains[fault.from.chain].vertices[fault.from.position];
      // An earlier one may have mended this one, too.
      if (!state.level.has(a) || state.level.next(fault.from) != fault.to) continue;
      if (fault.culprit && !state.level.has(*fault.culprit)) continue;
      if (mend(fault, false, state)) {
        is_mended = true;
        continue;
      }
      bool is_helped = reduce_edge(fault.from, wish, state);
      if (fault.culprit) is_helped = reduce(*fault.culprit, wish, state) || is_helped;
      if (!is_helped && !(is_mended = mend(fault, true, state))) throw_not_conforming(*fine_, a);
      is_reduced = is_reduced || is_helped;
    }
    if (is_reduced) return false;
  }
}

void PlanarPacker::pack_interior(const PackingWish& wish, State& state) const {
  struct Candidate {
    double key;
    std::uint32_t vertex;
    bool operator<(const Candidate& other) const { return key != other.key ? key > other.key : vertex > other.vertex; }
  };
  const std::size_t n = fine_->points.size();
  std::priority_queue<Candidate> queue;
  // How near to touching the two nearest spheres are: candidates in a corner between two others come first.
  std::vector<std::array<double, 2>> gaps(n, {kFrontReach, kFrontReach});
  const auto jitter = [&](std::uint32_t v) {
    return wish.seed == 0 ? 0.0 : kKeyJitter * to_unit(hash_words(wish.seed, v));
  };
  const auto reach_from = [&](std::uint32_t q) {
    if (wish.order != CoarseningOrder::kFront) return;
    const double f = state.f[q];
    const double slope = std::min(kFrontReach * wish.lipschitz, 0.5);
    for_each_near(fine_->points[q], 2 * kFrontReach * f / (1 - slope), [&](std::uint32_t p) {
      if (state.is_blocked[p] != 0) return;
      const double gap = distance(fine_->points[p], fine_->points[q]) / (f + state.f[p]);
      if (gap >= gaps[p][1]) return;
      gaps[p] = gap < gaps[p][0] ? std::array{gap, gaps[p][0]} : std::array{gaps[p][0], gap};
      queue.push({gaps[p][0] + gaps[p][1] + jitter(p), p});
    });
  };
  Box<2> box;
  for (const Vec<2>& x : fine_->points) box.add(x);
  for (std::uint32_t v = 0; v < n; ++v) {
    if (state.level.has(v)) reach_from(v);
    if (fine_->on_boundary(v)) state.is_blocked[v] = 1;
    if (state.is_blocked[v] != 0) continue;
    switch (wish.order) {
      case CoarseningOrder::kFront:
        queue.push({2 * kFrontReach + jitter(v), v});
        break;
      case CoarseningOrder::kCurve:
        queue.push({static_cast<double>(hilbert_key<2>(fine_->points[v], box)), v});
        break;
      case CoarseningOrder::kRandom:
        queue.push({to_unit(hash_words(wish.seed, v)), v});
        break;
    }
  }
  while (!queue.empty()) {
    const std::uint32_t v = queue.top().vertex;
    queue.pop();
    if (state.is_blocked[v] != 0) continue;
    state.is_blocked[v] = 1;
    if (!state.level.exchange(std::nullopt, v, [](double) { return true; })) continue;
    block_around(v, wish.lipschitz, state);
    reach_from(v);
  }
}

PlanarPacking PlanarPacker::pack(const PackingWish& wish) const {
  State state(*fine_);
  state.is_kept.assign(fine_->points.size(), 0);
  state.n_kept.assign(fine_->chains.size(), 0);
  for (const std::uint32_t v : wish.kept) {
    state.is_kept[v] = 1;
    for (const ChainPlace& place : fine_->places[VertexId(std::size_t{v})]) ++state.n_kept[place.chain];
  }
  while (!pack_boundary(wish, state)) observer_->check_cancelled();
  pack_interior(wish, state);
  std::vector<double> radius = radii(state);
  return {std::move(state.level), std::move(state.f), std::move(radius),
          std::move(state.rungs), wish.growth,        wish.lipschitz};
}

}  // namespace voropack
