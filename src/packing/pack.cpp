#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "base/place_text.h"
#include "base/random.h"
#include "packing/boundary.h"
#include "packing/budget.h"
#include "packing/incidence.h"
#include "packing/mend.h"
#include "packing/stretched.h"
#include "spheres/pack_interior.h"
#include "voropack/packing.h"

namespace voropack {

namespace {

/// So often f shrinks around stretched simplices; then the mesh with the fewest is taken, and the certificate names
/// them.
constexpr int kStretchedRounds = 3;
/// Nor does f shrink once more if the mesh has grown to so many times the size of the best one, or has so many times
/// its stretched simplices: some corners are the same at every scale.
constexpr std::size_t kMostGrowth = 3, kMostStretched = 2;
/// Nor if they are more than one in so many: what makes that many is nothing that single spheres or a smaller f would
/// mend.
constexpr std::size_t kFewStretched = 20;

/// Walls of the domain with the regions on their sides.
WallLocator<2> locator_of(const Domain<2>& domain) {
  Walls<2> walls;
  for (const SegmentId s : ids(domain.segments)) {
    walls.simplices.push_back({domain.points[domain.segments[s][0]], domain.points[domain.segments[s][1]]});
    walls.regions.push_back(regions_of_wall(domain.wall_regions[s.value()]));
  }
  return WallLocator<2>(std::move(walls));
}

WallLocator<3> locator_of(const Domain<3>& domain) {
  Walls<3> walls;
  for (const FacetId f : ids(domain.facet_frame))
    for (const auto& t : domain.facet_triangles[f]) {
      walls.simplices.push_back({domain.points[t[0]], domain.points[t[1]], domain.points[t[2]]});
      walls.regions.push_back(regions_of_wall(domain.wall_regions[f.value()]));
    }
  return WallLocator<3>(std::move(walls));
}

template <int D>
PackingProblem<D> interior_problem(const Domain<D>& domain, const Spacing<D>& spacing,
                                   const BoundaryPacking<D>& boundary, const WallLocator<D>& walls,
                                   const PackingOptions& options, int attempt) {
  const Packing<D>& packing = boundary.packing;
  PackingProblem<D> problem;
  problem.bounds = domain.box;
  for (const SphereId s : ids(packing.center)) problem.fixed.push_back({packing.center[s], packing.radius[s]});
  for (const Ball<D>& ball : boundary.balls) problem.balls.push_back(grown_by_blur(ball, domain.box));
  problem.faces = protected_faces(domain, packing);
  problem.walls = &walls;
  problem.spacing = {[&spacing](const Vec<D>& x) { return spacing(x); },
                     [&spacing](const Box<D>& box) { return spacing.constant_on(box); }, spacing.lipschitz()};
  problem.form = options.form;
  problem.interior = options.interior;
  problem.epsilon = options.epsilon;
  problem.seed = attempt == 0 ? hash_words(options.seed, D) : hash_words(options.seed, D, attempt);
  return problem;
}

template <int D>
void append_interior(Packing<D>& packing, PackedInterior<D>&& interior) {
  for (std::size_t i = 0; i < interior.spheres.size(); ++i) {
    packing.center.push_back(interior.spheres[i].center);
    packing.radius.push_back(interior.spheres[i].radius);
    packing.carrier.push_back(PolytopeId(D, static_cast<std::size_t>(interior.regions[i])));
  }
  packing.triangulation = std::move(interior.triangulation);
  packing.triangulation_s = interior.triangulation_s;
}

/// Has caps name facets in place of traces.
template <int D>
void name_given(std::vector<SpacingCap<D>>& caps, const Incidence<D>& incidence) {
  for (SpacingCap<D>& cap : caps)
    if (cap.between)
      for (PolytopeId& p : *cap.between) p = incidence.given(p);
}

/// What is on traces is on their facets; they were a means only.
template <int D>
void drop_traces(Packing<D>& packing, const Incidence<D>& incidence) {
  if (!incidence.has_traces()) return;
  std::erase_if(packing.subsegments, [&](const auto& s) { return incidence.given(s.carrier) != s.carrier; });
  for (PolytopeId& carrier : packing.carrier) carrier = incidence.given(carrier);
  std::vector<SphereId> order;
  for (const SphereId s : ids(packing.center)) order.push_back(s);
  std::ranges::stable_sort(order, {}, [&](SphereId s) { return packing.carrier[s].dimension; });
  std::vector<std::uint32_t> position(order.size());
  Packing<D> sorted;
  for (const SphereId s : order) {
    position[s.value()] = static_cast<std::uint32_t>(sorted.center.size());
    sorted.center.push_back(packing.center[s]);
    sorted.radius.push_back(packing.radius[s]);
    sorted.carrier.push_back(packing.carrier[s]);
  }
  packing.center = std::move(sorted.center);
  packing.radius = std::move(sorted.radius);
  packing.carrier = std::move(sorted.carrier);
  for (auto& s : packing.subsegments)
    for (SphereId& i : s.spheres) i = SphereId(position[i.value()]);
  for (auto& s : packing.subfacets)
    for (SphereId& i : s.spheres) i = SphereId(position[i.value()]);
  for (auto& s : packing.triangulation.simplices)
    for (std::uint32_t& i : s) i = position[i];
}

/// True if, under cap b, f is everywhere at most `slack` times what cap a allows.
template <int D>
bool is_covered(const SpacingCap<D>& a, const SpacingCap<D>& b, double lipschitz, double slack) {
  const double beyond = std::max(0.0, a.radius + distance(a.center, b.center) - b.radius);
  return b.value + lipschitz * beyond <= slack * a.value;
}

/// Adds caps that shrink f further than those already there by more than a fifth, and drops those that no longer
/// matter. Many balls fail in one place, and one cap mends them all. Returns what it has added.
template <int D>
std::vector<SpacingCap<D>> add_caps(std::vector<SpacingCap<D>>& caps, std::vector<SpacingCap<D>> more,
                                    double lipschitz) {
  constexpr double kEnough = 1.25;
  std::stable_sort(more.begin(), more.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  std::vector<SpacingCap<D>> added;
  for (const SpacingCap<D>& cap : more)
    if (std::none_of(added.begin(), added.end(), [&](const auto& b) { return is_covered(cap, b, lipschitz, kEnough); }))
      added.push_back(cap);
  std::erase_if(caps, [&](const auto& cap) {
    return std::any_of(added.begin(), added.end(), [&](const auto& b) { return is_covered(cap, b, lipschitz, 1); });
  });
  caps.insert(caps.end(), added.begin(), added.end());
  return added;
}

/// The verify-and-adapt loop.
template <int D>
class AdaptivePacker {
 public:
  AdaptivePacker(const KeptVertices<D>& kept, const Domain<D>& domain, const Spacing<D>& spacing,
                 const PackingOptions& options, Observer& observer)
      : spacing_(spacing),
        options_(options),
        observer_(observer),
        budget_(domain, options),
        walls_(locator_of(domain)),
        protection_(domain, kept) {}

  Packing<D> run() {
    budget_.check_ahead(spacing_);
    SegmentPacker<D> segments(options_, observer_);
    std::vector<SpacingCap<D>> lowered;  // By the round before.
    for (int round = 0; round <= options_.max_repairs; ++round) {
      observer_.check_cancelled();
      const Spacing<D> f = caps_.empty() ? spacing_ : spacing_.with_caps(caps_);
      if (round > 0 && !best_) budget_.check_again(f, n_boundary_);
      protection_.add_traces(f);
      BoundaryPacking<D> boundary = pack_boundary<D>(f, lowered, protection_, segments, options_, observer_);
      n_boundary_ = boundary.packing.center.size();
      if (best_ && n_boundary_ > kMostGrowth * best_->n_boundary) break;
      name_given(boundary.faults, protection_.incidence);
      name_given(boundary.tied, protection_.incidence);
      if (boundary.faults.empty() && !boundary.protects_more && fill_interior(boundary, f, round)) break;
      observer_.log(LogLevel::kInfo,
                    fmt::format("round {}: f shrinks at {} places; {} fans, {} books and {} corners are protected",
                                round + 1, boundary.faults.size(), protection_.fans.all().size(),
                                protection_.books.all().size(), protection_.corners.size()));
      lowered = add_caps(caps_, std::move(boundary.faults), spacing_.lipschitz());
    }
    if (best_) return std::move(best_->packing);
    throw InternalError(
        Fault{.id = "packing.not_conforming",
              .message = fmt::format("after {} rounds of shrinking f some protecting balls still hold a point, the "
                                     "last one near {}",
                                     options_.max_repairs, place_text(caps_.back().center)),
              .fix = "report this with the input; a smaller --feature-factor may help meanwhile",
              .position = {caps_.back().center.coord.begin(), caps_.back().center.coord.end()}});
  }

 private:
  /// A packing whose protecting balls are all empty.
  struct Conforming {
    Packing<D> packing;
    std::size_t n_stretched = 0, n_simplices = 0, n_boundary = 0;
  };

  /// True if that ends the loop; else with the faults of the mesh.
  bool fill_interior(BoundaryPacking<D>& boundary, const Spacing<D>& f, int round) {
    std::vector<SpacingCap<D>> all_caps = caps_;
    all_caps.insert(all_caps.end(), boundary.tied.begin(), boundary.tied.end());
    const Spacing<D> tied = all_caps.empty() ? spacing_ : spacing_.with_caps(all_caps);
    if (!best_) budget_.check_again(tied, n_boundary_);
    if (!add_kept_interior(boundary, tied)) return false;
    n_fixed_ = boundary.packing.center.size();
    PackingProblem<D> problem =
        interior_problem(protection_.domain(), tied, boundary, walls_, options_, stretched_rounds_);
    problem.plateau = budget_.plateau();
    PackedInterior<D> interior = pack_interior(problem, false, observer_);
    if (!interior.broken_faces.empty()) {
      const std::size_t first = boundary.balls.size() - problem.faces.size();
      const auto& walls_of_balls = wall_simplices(boundary.packing);
      for (const std::uint32_t i : interior.broken_faces)
        boundary.faults.push_back(repair_cap(boundary.balls[first + i].center, boundary.balls[first + i].radius, f,
                                             walls_of_balls[i].carrier, walls_of_balls[i].carrier));
      return false;
    }
    add_interior(problem, std::move(interior), boundary);
    const std::size_t n_simplices = boundary.packing.triangulation.simplices.size();
    const std::size_t n_stretched = boundary.faults.size();
    observer_.log(LogLevel::kInfo, fmt::format("round {}: all balls are empty; {} of {} simplices are stretched",
                                               round + 1, n_stretched, n_simplices));
    if (!best_ || n_stretched < best_->n_stretched) {
      best_ = Conforming{std::move(boundary.packing), n_stretched, n_simplices, n_boundary_};
      best_->packing.repairs = std::move(all_caps);
      best_->packing.repair_rounds = round;
      drop_traces(best_->packing, protection_.incidence);
    }
    const std::size_t many = many_stretched(best_->packing);
    const std::size_t too_many = std::max<std::size_t>(kFewStretched, kMostStretched * best_->n_stretched);
    if (n_stretched == 0 || n_stretched > many || n_stretched > too_many ||
        n_simplices > kMostGrowth * best_->n_simplices || ++stretched_rounds_ > kStretchedRounds)
      return true;
    // Free spheres behind a corner are near to each other at any f: then others are tried, from another seed.
    std::erase_if(boundary.faults, [&](const SpacingCap<D>& cap) {
      return protection_.narrow_corners(cap.center, cap.radius, f) || protection_.is_at_corner(cap.center, cap.radius);
    });
    return false;
  }

  /// False, with a fault, if one that has to stay lies in a protecting ball.
  bool add_kept_interior(BoundaryPacking<D>& boundary, const Spacing<D>& f) {
    const KeptCenters<D>& kept = protection_.kept;
    if (kept.empty()) return true;
    Packing<D>& packing = boundary.packing;
    const Box<D>& box = protection_.domain().box;
    BallSet<D> balls(box.center());
    for (const Ball<D>& b : boundary.balls) balls.add(grown_by_blur(b, box));
    SphereSet<D> spheres(box.center(), f.lipschitz(), packing.radius[SphereId(0)]);
    if (!kept.all_stay())
      for (const SphereId s : ids(packing.center)) spheres.add({packing.center[s], packing.radius[s]});
    std::vector<std::optional<Ball<D>>> holding(kept.inside().size());
    std::vector<double> radius(kept.inside().size());
    parallel_for(kept.inside().size(), [&](std::size_t i) {
      const Vec<D>& x = kept.inside()[i].center;
      radius[i] = f(x);
      balls.visit_holding(x, kBallMargin, [&](std::uint32_t b) {
        if (kept.all_stay() && !is_inside_ball(packing, b, x)) return false;
        holding[i] = boundary.balls[b];
        return true;
      });
    });
    for (std::size_t i = 0; i < kept.inside().size(); ++i) {
      const auto& [x, region] = kept.inside()[i];
      const PolytopeId carrier(D, region.value());
      if (kept.all_stay()) {
        if (holding[i])
          boundary.faults.push_back(repair_cap(holding[i]->center, holding[i]->radius, f, carrier, carrier));
      } else {
        if (holding[i] || spheres.conflicts(x, radius[i])) continue;
        spheres.add({x, radius[i]});
      }
      packing.center.push_back(x);
      packing.radius.push_back(radius[i]);
      packing.carrier.push_back(carrier);
    }
    return boundary.faults.empty();
  }

  [[nodiscard]] static std::size_t many_stretched(const Packing<D>& packing) {
    return std::max(kFewStretched, packing.triangulation.simplices.size() / kFewStretched);
  }

  /// Adds the interior, and as faults its stretched simplices that no mending has removed.
  void add_interior(const PackingProblem<D>& problem, PackedInterior<D>&& interior, BoundaryPacking<D>& boundary) {
    append_interior(boundary.packing, std::move(interior));
    const Incidence<D>& incidence = protection_.incidence;
    boundary.faults = stretched_simplices(boundary.packing, incidence);
    if (boundary.faults.empty() || boundary.faults.size() > many_stretched(boundary.packing)) return;
    observer_.log(LogLevel::kInfo, fmt::format("{} simplices are stretched", boundary.faults.size()));
    mend_stretched(boundary.packing, n_fixed_, problem, incidence, observer_);
    boundary.faults = stretched_simplices(boundary.packing, incidence);
  }

  const Spacing<D>& spacing_;
  const PackingOptions& options_;
  Observer& observer_;
  Budget<D> budget_;
  WallLocator<D> walls_;
  Protection<D> protection_;
  std::vector<SpacingCap<D>> caps_;
  std::size_t n_boundary_ = 0;
  std::size_t n_fixed_ = 0;  ///< Of the boundary and kept ones.
  int stretched_rounds_ = 0;
  std::optional<Conforming> best_;
};

}  // namespace

template <int D>
Packing<D> pack(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options, Observer& observer) {
  return pack_around(KeptVertices<D>{}, domain, spacing, options, observer);
}

template <int D>
Packing<D> pack_around(const KeptVertices<D>& kept, const Domain<D>& domain, const Spacing<D>& spacing,
                       const PackingOptions& options, Observer& observer) {
  observer.begin_stage("packing");
  return AdaptivePacker<D>(kept, domain, spacing, options, observer).run();
}

template <int D>
std::string find_packing_fault(const Packing<D>& packing, const Domain<D>& domain, const Spacing<D>& spacing) {
  const Spacing<D> f = packing.repairs.empty() ? spacing : spacing.with_caps(packing.repairs);
  const Incidence<D> incidence(domain);
  SphereSet<D> set(domain.box.center(), spacing.lipschitz(), packing.radius[SphereId(0)]);
  for (const SphereId s : ids(packing.center)) {
    if (packing.radius[s] != f(packing.center[s])) return fmt::format("sphere {}: its radius is not f", s.value());
    const bool overlaps = set.visit_near(packing.center[s], packing.radius[s], [&](std::uint32_t t) {
      return SphereSet<D>::overlap(set[t], packing.center[s], packing.radius[s]) &&
             !incidence.form_sharp_feature(packing.carrier[s], packing.carrier[SphereId(t)]);
    });
    if (overlaps) return fmt::format("sphere {} overlaps another", s.value());
    set.add({packing.center[s], packing.radius[s]});
  }
  const BallSet<D> balls = protecting_balls(domain, packing);
  for (const SphereId s : ids(packing.center))
    if (balls.visit_holding(packing.center[s], -kBallMargin, [](std::uint32_t) { return true; }))
      return fmt::format("sphere {}: its center lies in a protecting ball", s.value());
  return {};
}

template Packing<2> pack(const Domain<2>&, const Spacing<2>&, const PackingOptions&, Observer&);
template Packing<3> pack(const Domain<3>&, const Spacing<3>&, const PackingOptions&, Observer&);
template Packing<2> pack_around(const KeptVertices<2>&, const Domain<2>&, const Spacing<2>&, const PackingOptions&,
                                Observer&);
template Packing<3> pack_around(const KeptVertices<3>&, const Domain<3>&, const Spacing<3>&, const PackingOptions&,
                                Observer&);
template std::string find_packing_fault(const Packing<2>&, const Domain<2>&, const Spacing<2>&);
template std::string find_packing_fault(const Packing<3>&, const Domain<3>&, const Spacing<3>&);

}  // namespace voropack
