#include "spheres/active_cells.h"

#include <cmath>

#include "base/parallel.h"
#include "base/random.h"
#include "spheres/independent_set.h"

namespace voropack {

namespace {

/// Down to this depth of the tree subtrees are worth a task of their own.
constexpr int kParallelDepth = 3;
/// Darts are thrown in this many groups (measured: fewer make the conflict graph dense, more give the threads little to
/// do at a time).
constexpr std::uint32_t kDartGroups = 16;
/// A cell this much finer than the bounds means that the spacing function is broken.
constexpr int kMaxDepth = 28;

/// The largest f over the centers of a coarse grid of the bounds: the plateau of f where it has one.
template <int K>
double largest_spacing(const PackingProblem<K>& problem) {
  if (const auto f = problem.spacing.constant_on(problem.bounds)) return *f;
  constexpr int n = K == 3 ? 12 : 16;
  std::size_t total = 1;
  for (int k = 0; k < K; ++k) total *= n;
  double largest = 0;
  for (std::size_t i = 0; i < total; ++i) {
    Vec<K> x;
    std::size_t rest = i;
    for (int k = 0; k < K; ++k) {
      x[k] = problem.bounds.lo[k] +
             (static_cast<double>(rest % n) + 0.5) / n * (problem.bounds.hi[k] - problem.bounds.lo[k]);
      rest /= n;
    }
    if (problem.region_of(x) < 0) continue;
    largest = std::max(largest, problem.spacing.at(x));
  }
  return largest > 0 ? largest : problem.spacing.at(problem.bounds.center());
}

/// The point of the box nearest to x.
template <int K>
Vec<K> clamped(Vec<K> x, const Box<K>& box) {
  for (int k = 0; k < K; ++k) x[k] = std::clamp(x[k], box.lo[k], box.hi[k]);
  return x;
}

/// Appends the balls of `stack` from `begin` on that `is_near` to it again.
template <int K, class IsNear>
void push_again(std::vector<Ball<K>>& stack, std::size_t begin, IsNear&& is_near) {
  const std::size_t end = stack.size();
  stack.resize(2 * end - begin);
  // Written whether near or not, and counted if near: nothing branches.
  std::size_t n = end;
  for (std::size_t i = begin; i < end; ++i) {
    stack[n] = stack[i];
    n += is_near(stack[i]) ? 1 : 0;
  }
  stack.resize(n);
}

}  // namespace

template <int K>
ActiveCells<K>::ActiveCells(const PackingProblem<K>& problem, bool lattice, const Observer& observer)
    : ActiveCells(problem, lattice, largest_spacing(problem), observer) {}

template <int K>
ActiveCells<K>::ActiveCells(const PackingProblem<K>& problem, bool lattice, double largest, const Observer& observer)
    : problem_(problem),
      observer_(observer),
      origin_(problem.bounds.lo),
      spheres_(problem.bounds.center(), problem.spacing.lipschitz, largest),
      balls_(problem.bounds.center()) {
  for (int k = 0; k < K; ++k) side_ = std::max(side_, problem.bounds.hi[k] - problem.bounds.lo[k]);
  if constexpr (K > 1) {
    // Halved again and again, the root's side becomes the widest that a leaf may have where f is largest.
    const double leaf = 2 * largest / std::sqrt(static_cast<double>(K)) * (1 - 1e-9);
    side_ = std::ldexp(leaf, std::max(0, static_cast<int>(std::ceil(std::log2(side_ * (1 + 1e-6) / leaf)))));
    origin_ = problem.bounds.center();
    for (int k = 0; k < K; ++k) origin_[k] -= side_ / 2;
    if (lattice) lattice_.emplace(problem.bounds.center(), problem.plateau.value_or(largest), largest, problem.seed);
  }
  for (const Ball<K>& s : problem.fixed) spheres_.add(s);
  for (const Ball<K>& s : problem.foreign) spheres_.add(s);
  for (const Ball<K>& b : problem.balls) balls_.add(b);

  Obstacles all{spheres_.spheres(), problem.balls};
  Harvest harvest;
  subdivide({{}, 0, K > 1 ? kMixed : 0}, all, {0, 0}, harvest);
  cells_ = std::move(harvest.cells);
  place_lattice(harvest.points);
}

template <int K>
double ActiveCells<K>::side(int level) const {
  return side_ / static_cast<double>(std::int64_t{1} << level);  // Exact, as ldexp, without the call.
}

template <int K>
double ActiveCells<K>::spacing_near(const Vec<K>& x) const {
  return problem_.spacing.at(clamped(x, problem_.bounds));
}

template <int K>
Box<K> ActiveCells<K>::box_of(const Cell& cell) const {
  const double s = side(cell.level);
  Box<K> box;
  for (int k = 0; k < K; ++k) {
    const auto i = cell.index[static_cast<std::size_t>(k)];
    box.lo[k] = origin_[k] + s * i;
    box.hi[k] = origin_[k] + s * (i + 1);
  }
  return box;
}

template <int K>
auto ActiveCells<K>::children(const Cell& cell) -> std::array<Cell, std::size_t{1} << K> {
  std::array<Cell, std::size_t{1} << K> result;
  for (std::size_t c = 0; c < result.size(); ++c) {
    result[c] = {cell.index, cell.level + 1, cell.region, cell.constant, cell.least};
    for (std::size_t k = 0; k < K; ++k) result[c].index[k] = 2 * cell.index[k] + static_cast<std::int32_t>(c >> k & 1U);
  }
  return result;
}

/// Finds out whether walls pass through the cell, and if not, which region holds it.
template <int K>
void ActiveCells<K>::locate(Cell& cell, const Box<K>& box) const {
  if (!cell.is_mixed() || problem_.meets_wall(box)) return;
  cell.region = problem_.region_of(box.center());
}

template <int K>
void ActiveCells<K>::Obstacles::push_near(const Mark& parent, const Box<K>& box, double f_max) {
  push_again(spheres, parent.spheres, [&](const Ball<K>& s) {
    const double reach = s.radius + f_max;
    return box.distance_sq(s.center) < reach * reach;
  });
  push_again(balls, parent.balls, [&](const Ball<K>& b) {
    const double reach = b.radius * (1 + kBallMargin);
    return box.distance_sq(b.center) <= reach * reach;
  });
}

/// As SphereSet::covers and BallSet::covers, on the obstacles from `begin` on.
template <int K>
bool ActiveCells<K>::is_covered(const Obstacles& obstacles, const Mark& begin, const Vec<K>& m, double r,
                                double f) const {
  for (std::size_t i = begin.spheres; i < obstacles.spheres.size(); ++i) {
    const Ball<K>& s = obstacles.spheres[i];
    const double reach = s.radius + f - (1 + problem_.spacing.lipschitz) * r;
    if (reach > 0 && distance_sq(m, s.center) < reach * reach) return true;
  }
  for (std::size_t i = begin.balls; i < obstacles.balls.size(); ++i) {
    const Ball<K>& b = obstacles.balls[i];
    const double room = b.radius - r;
    if (room > 0 && distance_sq(m, b.center) < room * room) return true;
  }
  return false;
}

template <int K>
void ActiveCells<K>::subdivide(const Cell& cell, Obstacles& obstacles, const Mark& parent, Harvest& out) const {
  const Box<K> box = box_of(cell);
  if (!box.overlaps(problem_.bounds)) return;
  Cell here = cell;
  // What a cell has outside the bounds is outside every region.
  if (here.constant == 0)
    here.constant =
        problem_.spacing.constant_on({clamped(box.lo, problem_.bounds), clamped(box.hi, problem_.bounds)}).value_or(0);
  const bool is_constant = here.constant > 0;
  const Vec<K> m = box.center();
  const double r = 0.5 * box.diagonal(), f = is_constant ? here.constant : spacing_near(m),
               b = problem_.spacing.lipschitz;
  const double f_lo = is_constant ? f : f - b * r, f_hi = is_constant ? f : f + b * r;
  here.least = f_lo;
  const Mark mine = obstacles.mark();
  obstacles.push_near(parent, box, f_hi);
  if (!is_covered(obstacles, mine, m, r, f)) {
    locate(here, box);
    if (here.is_mixed() || here.region >= 0) open(here, box, {f, f_lo, f_hi}, obstacles, mine, out);
  }
  obstacles.pop_to(mine);
}

/// The class of the plateau's lattice if that serves f at the corners of a cell, too. Bounds of f by its Lipschitz
/// constant would end the lattice where f begins to grow; its points are tested one by one here, and need none.
template <int K>
std::optional<int> ActiveCells<K>::class_beside_plateau(const Box<K>& box) const {
  if (!problem_.plateau) return std::nullopt;
  const double lo = *problem_.plateau;
  std::optional<int> cls;
  for (std::size_t c = 0; c < std::size_t{1} << K; ++c) {
    Vec<K> corner = box.lo;
    for (int k = 0; k < K; ++k)
      if ((c >> k & 1U) != 0) corner[k] = box.hi[k];
    const double f = spacing_near(corner);
    if (f < lo) return std::nullopt;
    cls = lattice_->class_for(lo, f);
    if (!cls) return std::nullopt;
  }
  return cls;
}

/// Harvests a cell that is not covered and not outside, or its children.
template <int K>
void ActiveCells<K>::open(const Cell& cell, const Box<K>& box, const Range& f, Obstacles& obstacles, const Mark& mine,
                          Harvest& out) const {
  const bool is_leaf = side(cell.level) <= 2 * f.center / std::sqrt(static_cast<double>(K)) || cell.level >= kMaxDepth;
  const bool is_clear = !cell.is_mixed() && obstacles.mark() == mine;
  std::optional<int> cls;
  if constexpr (K > 1)
    if (lattice_ && f.lo > 0 && (is_leaf || is_clear)) cls = lattice_->class_for(f.lo, f.hi);
  const bool free = cls && is_clear && !problem_.breaks_far_rule(box.center(), 2 * f.hi + 0.5 * box.diagonal());
  if constexpr (K > 1) {
    if (lattice_ && is_leaf && !cls) cls = class_beside_plateau(box);
    if (cls && (is_leaf || free))
      lattice_->visit(*cls, box, [&](const Vec<K>& x) {
        out.points.push_back({x, *cls, cell.is_mixed() ? kNoRegion : cell.region, free, cell.constant});
      });
    // Where an obstacle keeps a lattice point away from a free cell, the circumcenters fill the gap.
    if (free) return;
  }
  if (is_leaf) {
    out.cells.push_back(cell);
    return;
  }
  const auto parts = children(cell);
  if (cell.level >= kParallelDepth) {
    for (const Cell& child : parts) subdivide(child, obstacles, mine, out);
    return;
  }
  observer_.check_cancelled();
  std::vector<Harvest> harvests(parts.size());
  parallel_for(
      parts.size(),
      [&](std::size_t i) {
        Obstacles own = obstacles.from(mine);
        subdivide(parts[i], own, {0, 0}, harvests[i]);
      },
      1);
  std::size_t n_cells = out.cells.size(), n_points = out.points.size();
  for (const Harvest& h : harvests) {
    n_cells += h.cells.size();
    n_points += h.points.size();
  }
  out.cells.reserve(n_cells);
  out.points.reserve(n_points);
  for (Harvest& h : harvests) {
    out.cells.insert(out.cells.end(), h.cells.begin(), h.cells.end());
    out.points.insert(out.points.end(), h.points.begin(), h.points.end());
    h = Harvest{};
  }
}

/// The region of x in a cell, or a negative number where x is outside.
template <int K>
int ActiveCells<K>::region_at(const Cell& cell, const Vec<K>& x) const {
  return cell.is_mixed() ? problem_.region_of(x) : cell.region;
}

/// Coarsest class first. Points of one class never conflict with each other, so those that pass the tests against what
/// is there before their class all join.
template <int K>
void ActiveCells<K>::place_lattice(const std::vector<LatticePoint>& points) {
  int last = -1;
  for (const LatticePoint& p : points) last = std::max(last, p.cls);
  for (int cls = 0; cls <= last; ++cls) {
    std::vector<std::uint32_t> members;
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (points[i].cls == cls) members.push_back(i);
    std::vector<Ball<K>> balls(members.size());
    std::vector<int> regions(members.size(), kNoRegion);
    parallel_for(members.size(), [&](std::size_t i) {
      if constexpr (K > 1) {
        const LatticePoint& p = points[members[i]];
        balls[i] = {p.position, spacing_at(p.position, p.constant)};
        const bool admitted =
            p.free && cls == 0 ? true : problem_.admits(spheres_, balls_, p.position, balls[i].radius);
        if (admitted) regions[i] = p.region != kNoRegion ? p.region : problem_.region_of(p.position);
      }
    });
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (regions[i] < 0) continue;
      spheres_.add(balls[i]);
      regions_.push_back(regions[i]);
    }
  }
}

template <int K>
void ActiveCells<K>::throw_darts(double least_yield) {
  try_in_cells(kDartGroups, least_yield, [&](const Cell& cell, const Box<K>& box, std::uint64_t hash) {
    Vec<K> x;
    for (int k = 0; k < K; ++k) {
      hash = mix64(hash + 0x9e3779b97f4a7c15ULL);
      x[k] = box.lo[k] + to_unit(hash) * side(cell.level);
    }
    return x;
  });
}

template <int K>
void ActiveCells<K>::try_centers() {
  try_in_cells(1, 0, [&](const Cell&, const Box<K>& box, std::uint64_t) { return box.center(); });
}

/// Group by group: most positions of the later groups meet a sphere that is there already, which is cheaper than a
/// rival.
template <int K>
template <class Position>
void ActiveCells<K>::try_in_cells(std::uint32_t n_groups, double least_yield, Position&& position) {
  ++round_;
  std::vector<std::uint64_t> hashes(cells_.size());
  parallel_for(cells_.size(), [&](std::size_t i) { hashes[i] = hash_of(cells_[i]); });
  std::vector<std::uint32_t> begin(n_groups + 1, 0), order(cells_.size());
  for (const std::uint64_t h : hashes) ++begin[h % n_groups + 1];
  for (std::uint32_t g = 0; g < n_groups; ++g) begin[g + 1] += begin[g];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t i = 0; i < cells_.size(); ++i) order[next[hashes[i] % n_groups]++] = i;
  for (std::uint32_t g = 0; g < n_groups; ++g) {
    observer_.check_cancelled();
    std::vector<Candidate> candidates(begin[g + 1] - begin[g]);
    parallel_for(
        candidates.size(),
        [&](std::size_t k) {
          const std::uint32_t i = order[begin[g] + k];
          candidates[k] = candidate_at(cells_[i], position(cells_[i], box_of(cells_[i]), hashes[i]), hashes[i]);
        },
        256);
    std::erase_if(candidates, [](const Candidate& c) { return c.region < 0; });
    const std::size_t before = spheres_.size();
    join(candidates);
    if (static_cast<double>(spheres_.size() - before) < least_yield * (begin[g + 1] - begin[g])) break;
  }
}

/// A word that depends on the round and the cell alone.
template <int K>
std::uint64_t ActiveCells<K>::hash_of(const Cell& cell) const {
  std::uint64_t hash = problem_.seed + (round_ << 32U) + static_cast<std::uint64_t>(cell.level);
  for (const std::int32_t k : cell.index) hash = mix64(hash ^ static_cast<std::uint32_t>(k));
  return hash;
}

/// Its region is negative where x is not admissible.
template <int K>
auto ActiveCells<K>::candidate_at(const Cell& cell, const Vec<K>& x, std::uint64_t priority) const -> Candidate {
  Candidate c{{x, 0}, kNoRegion, priority};
  if (!problem_.bounds.contains(x)) return c;
  // Where f varies, its lower bound spares most evaluations.
  if (cell.constant == 0 && cell.least > 0 && spheres_.conflicts(x, cell.least)) return c;
  c.sphere.radius = spacing_at(x, cell.constant);
  if (problem_.admits(spheres_, balls_, x, c.sphere.radius)) c.region = region_at(cell, x);
  return c;
}

template <int K>
void ActiveCells<K>::join(const std::vector<Candidate>& candidates) {
  std::vector<Ball<K>> balls;
  std::vector<std::uint64_t> priority;
  for (const Candidate& c : candidates) {
    balls.push_back(c.sphere);
    priority.push_back(c.priority);
  }
  const std::vector<std::uint8_t> joins = independent_set(balls, priority, problem_.spacing.lipschitz);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (joins[i] == 0) continue;
    spheres_.add(candidates[i].sphere);
    regions_.push_back(candidates[i].region);
  }
}

template <int K>
bool ActiveCells<K>::is_covered(Cell& cell) const {
  const Box<K> box = box_of(cell);
  const Vec<K> m = box.center();
  const double r = 0.5 * box.diagonal(), b = problem_.spacing.lipschitz;
  // The lower bound of the parent spares most evaluations.
  if (cell.constant == 0 && cell.least > 0 && spheres_.covers(m, r, cell.least, b)) return true;
  const double f = cell.constant > 0 ? cell.constant : spacing_near(m);
  cell.least = std::max(cell.least, f - b * r);
  if (spheres_.covers(m, r, f, b) || balls_.covers(m, r)) return true;
  return problem_.breaks_far_rule(m, 2 * (f - b * r) - r);  // Then every point of the cell is nearer than 2 f.
}

template <int K>
void ActiveCells<K>::split() {
  constexpr std::size_t kBlock = 1024;
  std::vector<std::vector<Cell>> parts((cells_.size() + kBlock - 1) / kBlock);
  parallel_for(
      parts.size(),
      [&](std::size_t block) {
        observer_.check_cancelled();
        for (std::size_t i = block * kBlock; i < std::min(cells_.size(), (block + 1) * kBlock); ++i) {
          for (Cell child : children(cells_[i])) {
            const Box<K> box = box_of(child);
            if (!box.overlaps(problem_.bounds) || is_covered(child)) continue;
            locate(child, box);
            if (child.is_mixed() || child.region >= 0) parts[block].push_back(child);
          }
        }
      },
      1);
  cells_.clear();
  for (const auto& part : parts) cells_.insert(cells_.end(), part.begin(), part.end());
}

template <int K>
double ActiveCells<K>::openness() const {
  return parallel_reduce_ordered(
      cells_.size(), 4096, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double worst = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const Box<K> box = box_of(cells_[i]);
          worst = std::max(worst, 0.5 * box.diagonal() / spacing_near(box.center()));
        }
        return worst * (1 + problem_.spacing.lipschitz);
      },
      [](double a, double b) { return std::max(a, b); });
}

template class ActiveCells<1>;
template class ActiveCells<2>;
template class ActiveCells<3>;

}  // namespace voropack
