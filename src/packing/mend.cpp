#include "packing/mend.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/random.h"
#include "geom/circumcenter.h"
#include "packing/stretched.h"
#include "spheres/movable_mesh.h"

namespace voropack {

namespace {

/// Where no move gains any more, so many times a move is made that loses something, and kept if more is gained after
/// it.
constexpr int kKicks = 100;
constexpr double kMostLoss = 3;
/// Places that are tried for a new sphere, and for each one that moves.
constexpr int kPlaces = 32;
/// A move has to lower the cost by this much: else moves might follow each other for ever.
constexpr double kLeastGain = 0.01;
/// Corners of so many simplices around a stretched one may leave.
constexpr std::size_t kNear = 12;
/// Circumcenters that one move may let in.
constexpr std::size_t kMostFollowers = 4;

template <int D>
class Mender {
 public:
  using Mesh = MovableMesh<D>;

  Mender(const Packing<D>& packing, std::size_t n_boundary, const PackingProblem<D>& problem,
         const Incidence<D>& incidence, const Observer& observer)
      : n_boundary_(n_boundary),
        problem_(problem),
        observer_(observer),
        mesh_({packing.center.begin(), packing.center.end()}, packing.triangulation),
        carrier_(packing.carrier.begin(), packing.carrier.end()),
        pairs_(incidence),
        spheres_(problem.bounds.center(), problem.spacing.lipschitz, packing.radius[SphereId(0)]),
        balls_(problem.bounds.center()),
        is_gone_(packing.center.size(), 0),
        random_(problem.seed) {
    for (const SphereId s : ids(packing.center)) spheres_.add({packing.center[s], packing.radius[s]});
    for (const Ball<D>& b : problem.balls) balls_.add(b);
  }

  /// Returns how many stretched simplices are left.
  std::size_t run() {
    descend(0);
    for (int kick = 0; kick < kKicks && !stretched().empty(); ++kick) {
      const Mender before = *this;
      const std::uint32_t s = stretched()[random_.bits() % stretched().size()];
      if (kick % 2 == 0)
        improve(s, -kMostLoss);
      else
        refill(s);
      descend(static_cast<std::uint32_t>(before.mesh_.size()));
      if (cost_of(stretched()) < cost_of(before.stretched_)) continue;
      const Random next = random_;
      restore(before);
      random_ = next;
    }
    // A sphere that has left may have been what kept a circumcenter farther away from being added.
    while (let_in_followers(0, mesh_.size()) > 0) {
      settle();
      descend(0);
    }
    return stretched().size();
  }

  /// Puts the spheres that there are now in the place of the packing's.
  void export_to(Packing<D>& packing) const {
    Triangulation<D> triangulation = mesh_.to_triangulation();
    std::vector<std::uint32_t> number(is_gone_.size(), 0);
    Packing<D> result;
    for (std::uint32_t v = 0; v < is_gone_.size(); ++v) {
      if (is_gone_[v] != 0) continue;
      number[v] = static_cast<std::uint32_t>(result.center.size());
      result.center.push_back(mesh_.points()[v]);
      result.radius.push_back(spheres_[v].radius);
      result.carrier.push_back(carrier_[v]);
    }
    for (auto& simplex : triangulation.simplices)
      for (std::uint32_t& v : simplex) v = number[v];
    packing.center = std::move(result.center);
    packing.radius = std::move(result.radius);
    packing.carrier = std::move(result.carrier);
    packing.triangulation = std::move(triangulation);
  }

 private:
  /// Moves that gain, until there are none for simplices from `first` on.
  void descend(std::uint32_t first) {
    for (bool has_moved = true; has_moved;) {
      has_moved = false;
      for (const std::uint32_t s : std::vector(stretched()))
        if (s >= first && mesh_[s].is_alive && improve(s, kLeastGain)) has_moved = true;
    }
  }

  /// Takes away some spheres around simplex s, and fills the room with others.
  void refill(std::uint32_t s) {
    const Shape<D> shape = shape_of<D>(mesh_.corners(s));
    std::vector<Move> leaving = leavers(s);
    std::ranges::sort(leaving, {},
                      [&](const Move& m) { return distance_sq(mesh_.points()[*m.leaves], shape.edge_middle); });
    const auto first = static_cast<std::uint32_t>(mesh_.size());
    const std::size_t n = std::min<std::size_t>(leaving.size(), 2 + random_.bits() % 6);
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t at = leaving[i].at;
      const auto has_it = [&](std::uint32_t t) {
        return mesh_[t].is_alive && std::ranges::find(mesh_[t].corner, *leaving[i].leaves) != mesh_[t].corner.end();
      };
      for (std::uint32_t t = first; t < mesh_.size() && !has_it(at); ++t) at = t;
      if (has_it(at) && mesh_.remove(*leaving[i].leaves, at)) is_gone_[*leaving[i].leaves] = 1;
    }
    if (mesh_.size() == first) return;
    for (int i = 0; i < 2 * kPlaces; ++i) insert(place(shape, i, {}), static_cast<std::uint32_t>(mesh_.size() - 1));
    let_in_followers(first, mesh_.size());
    settle();
  }

  void restore(const Mender& before) {
    mesh_ = before.mesh_;
    carrier_ = before.carrier_;
    spheres_ = before.spheres_;
    is_gone_ = before.is_gone_;
    stretched_ = before.stretched_;
    n_looked_at_ = before.n_looked_at_;
  }

  [[nodiscard]] double cost_of(const std::vector<std::uint32_t>& simplices) const {
    double sum = 0;
    for (const std::uint32_t s : simplices) sum += cost(s);
    return sum;
  }

  struct Move {
    std::optional<std::uint32_t> leaves;  ///< A vertex,
    std::uint32_t at = 0;                 ///< and a simplex that has it.
    std::optional<Vec<D>> comes;
    double gain = 0;
  };

  const std::vector<std::uint32_t>& stretched() {
    for (; n_looked_at_ < mesh_.size(); ++n_looked_at_)
      if (mesh_[n_looked_at_].is_alive && cost(n_looked_at_) > 0) stretched_.push_back(n_looked_at_);
    std::erase_if(stretched_, [&](std::uint32_t s) { return !mesh_[s].is_alive; });
    return stretched_;
  }

  /// 0 for a simplex that may stay as it is.
  [[nodiscard]] double cost(std::uint32_t s) const {
    const Shape<D> shape = shape_of<D>(mesh_.corners(s));
    if (!shape.exceeds(kRadiusEdge)) return 0;
    const auto& corner = mesh_[s].corner;
    std::array<PolytopeId, D + 1> carriers;
    for (std::size_t i = 0; i <= D; ++i) carriers[i] = carrier_[corner[i]];
    const double bound = pairs_.ratio_bound(carriers);
    return shape.exceeds(bound) ? 1 + std::log(std::sqrt(shape.radius_sq / shape.shortest_sq) / bound) : 0;
  }

  [[nodiscard]] bool is_free(std::uint32_t v) const { return v >= n_boundary_; }

  [[nodiscard]] bool overlaps(const Vec<D>& x, double radius) const {
    for (std::size_t k = 0; k < new_radius_.size(); ++k)
      if (SphereSet<D>::overlap({mesh_.points()[spheres_.size() + k], new_radius_[k]}, x, radius)) return true;
    return spheres_.visit_near(
        x, radius, [&](std::uint32_t v) { return is_gone_[v] == 0 && SphereSet<D>::overlap(spheres_[v], x, radius); });
  }

  bool insert(const Vec<D>& x, std::uint32_t near) {
    if (!is_finite(x) || !problem_.bounds.contains(x)) return false;
    if (balls_.forbids(x)) return false;
    const double radius = problem_.spacing.at(x);
    if (overlaps(x, radius) || !mesh_.insert(x, near)) return false;
    new_radius_.push_back(radius);
    carrier_.push_back(
        PolytopeId(D, static_cast<std::size_t>(mesh_[static_cast<std::uint32_t>(mesh_.size() - 1)].region)));
    return true;
  }

  void undo(const typename Mesh::Mark& mark) {
    mesh_.undo(mark);
    new_radius_.resize(mark.n_points - spheres_.size());
    carrier_.resize(mark.n_points, PolytopeId());
  }

  /// Lets in the circumcenters of simplices from `first` on that are free, so that the packing stays maximal;
  /// no more once there are `most`. Returns how many.
  std::size_t let_in_followers(std::uint32_t first, std::size_t most) {
    std::size_t n = 0;
    for (std::uint32_t s = first; s < mesh_.size(); ++s) {
      if (!mesh_[s].is_alive) continue;
      const Shape<D> shape = shape_of<D>(mesh_.corners(s));
      double largest = 0;
      for (const std::uint32_t v : mesh_[s].corner) largest = std::max(largest, radius_of(v));
      const double radius = std::sqrt(shape.radius_sq);
      if (radius < 2 * largest * (1 - kPackingSlack) / (1 + problem_.spacing.lipschitz)) continue;
      if (!is_finite(shape.center) || !problem_.bounds.contains(shape.center)) continue;
      if (radius < problem_.spacing.at(shape.center) + largest) continue;
      if (!insert(shape.center, s)) continue;
      if (++n >= most) break;
    }
    return n;
  }

  [[nodiscard]] double radius_of(std::uint32_t v) const {
    return v < spheres_.size() ? spheres_[v].radius : new_radius_[v - spheres_.size()];
  }

  /// What has been gained since then.
  [[nodiscard]] double gain_since(const typename Mesh::Mark& mark) const {
    double gain = 0;
    for (const std::uint32_t s : mesh_.killed_since(mark))
      if (s < mark.n_simplices) gain += cost(s);
    for (auto s = static_cast<std::uint32_t>(mark.n_simplices); s < mesh_.size(); ++s)
      if (mesh_[s].is_alive) gain -= cost(s);
    return gain;
  }

  [[nodiscard]] Vec<D> direction() {
    for (;;) {
      Vec<D> x;
      for (int k = 0; k < D; ++k) x[k] = 2 * random_.unit() - 1;
      if (norm_sq(x) <= 1 && norm_sq(x) > 0.01) return x / norm(x);
    }
  }

  /// Some place near simplex s: beside its shortest edge, anywhere in its ball, or around a vertex that leaves.
  Vec<D> place(const Shape<D>& shape, int i, std::optional<std::uint32_t> leaving) {
    const double length = std::sqrt(shape.shortest_sq), radius = std::sqrt(shape.radius_sq);
    if (leaving && i % 2 == 0) return mesh_.points()[*leaving] + 2 * random_.unit() * radius_of(*leaving) * direction();
    if (i % 4 == 3) return shape.center + std::cbrt(random_.unit()) * radius * direction();
    return shape.edge_middle + (0.8 + 2.4 * random_.unit()) * length * direction();
  }

  /// Tries places for a new sphere after what has changed since `before`.
  void try_places(std::uint32_t s, const Shape<D>& shape, const typename Mesh::Mark& before, Move move, Move& best) {
    const std::uint32_t near = mesh_[s].is_alive ? s : static_cast<std::uint32_t>(mesh_.size() - 1);
    for (int i = 0; i < kPlaces; ++i) {
      const Vec<D> x = place(shape, i, move.leaves);
      if (!move.leaves && distance_sq(x, shape.center) >= shape.radius_sq) continue;
      const auto here = mesh_.mark();
      if (!insert(x, near)) continue;
      if (let_in_followers(static_cast<std::uint32_t>(before.n_simplices), kMostFollowers) < kMostFollowers) {
        move.gain = gain_since(before);
        move.comes = x;
        if (move.gain > best.gain) best = move;
      }
      undo(here);
    }
  }

  /// The free vertices of simplex s and around it, each with a simplex that has it.
  [[nodiscard]] std::vector<Move> leavers(std::uint32_t s) const {
    std::vector<Move> result;
    const auto add = [&](std::uint32_t t) {
      for (const std::uint32_t v : mesh_[t].corner)
        if (is_free(v) && std::ranges::none_of(result, [&](const Move& m) { return *m.leaves == v; }))
          result.push_back({v, t, {}, 0});
    };
    std::vector<std::uint32_t> near = {s};
    for (std::size_t k = 0; k < near.size() && near.size() < kNear; ++k)
      for (const std::uint32_t t : mesh_[near[k]].neighbor)
        if (t != Mesh::kNone && std::ranges::find(near, t) == near.end()) near.push_back(t);
    for (const std::uint32_t t : near) add(t);
    return result;
  }

  /// Makes the move that gains most for simplex s, if one gains more than that.
  bool improve(std::uint32_t s, double least_gain) {
    observer_.check_cancelled();
    const Shape<D> shape = shape_of<D>(mesh_.corners(s));
    const double all = cost(s);
    Move best;
    best.gain = least_gain;
    const auto before = mesh_.mark();
    try_places(s, shape, before, {}, best);
    if (best.gain < all)
      for (const Move& leaver : leavers(s)) {
        if (!mesh_.remove(*leaver.leaves, leaver.at)) continue;
        is_gone_[*leaver.leaves] = 1;
        const auto removed = mesh_.mark();
        if (let_in_followers(static_cast<std::uint32_t>(before.n_simplices), kMostFollowers) < kMostFollowers) {
          Move move = leaver;
          move.gain = gain_since(before);
          if (move.gain > best.gain) best = move;
        }
        undo(removed);
        try_places(s, shape, before, leaver, best);
        undo(before);
        is_gone_[*leaver.leaves] = 0;
      }
    if (!best.leaves && !best.comes) return false;
    carry_out(best, s);
    return true;
  }

  void carry_out(const Move& move, std::uint32_t s) {
    const auto before = mesh_.mark();
    if (move.leaves) {
      mesh_.remove(*move.leaves, move.at);
      is_gone_[*move.leaves] = 1;
    }
    if (move.comes) insert(*move.comes, mesh_[s].is_alive ? s : static_cast<std::uint32_t>(mesh_.size() - 1));
    let_in_followers(static_cast<std::uint32_t>(before.n_simplices), kMostFollowers);
    settle();
  }

  /// Makes what has been changed final.
  void settle() {
    for (const double radius : new_radius_) {
      spheres_.add({mesh_.points()[spheres_.size()], radius});
      is_gone_.push_back(0);
    }
    new_radius_.clear();
    mesh_.commit();
  }

  std::size_t n_boundary_;
  const PackingProblem<D>& problem_;
  const Observer& observer_;
  Mesh mesh_;
  std::vector<PolytopeId> carrier_;  ///< By vertex.
  SharpPairs<D> pairs_;
  SphereSet<D> spheres_;            ///< By vertex, but for those that a trial has added.
  std::vector<double> new_radius_;  ///< Of these.
  BallSet<D> balls_;
  std::vector<std::uint8_t> is_gone_;     ///< By vertex.
  std::vector<std::uint32_t> stretched_;  ///< Among the simplices below n_looked_at_; some may be gone.
  std::uint32_t n_looked_at_ = 0;
  Random random_;
};

}  // namespace

template <int D>
std::size_t mend_stretched(Packing<D>& packing, std::size_t n_boundary, const PackingProblem<D>& problem,
                           const Incidence<D>& incidence, const Observer& observer) {
  Mender<D> mender(packing, n_boundary, problem, incidence, observer);
  const std::size_t n_left = mender.run();
  mender.export_to(packing);
  return n_left;
}

template std::size_t mend_stretched(Packing<2>&, std::size_t, const PackingProblem<2>&, const Incidence<2>&,
                                    const Observer&);
template std::size_t mend_stretched(Packing<3>&, std::size_t, const PackingProblem<3>&, const Incidence<3>&,
                                    const Observer&);

}  // namespace voropack
