#include "coarsening/space_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "coarsening/completion.h"
#include "coarsening/fine_mesh.h"
#include "coarsening/initial_spacing.h"
#include "coarsening/level_epsilon.h"
#include "coarsening/level_packer.h"
#include "coarsening/prolongation.h"
#include "coarsening/surface_distance.h"
#include "coarsening/surface_domain.h"
#include "geom/box_tree.h"
#include "spheres/packing_problem.h"
#include "voropack/delaunay.h"

namespace voropack {

namespace {

constexpr double kLipschitz = 0.25;  ///< If the user gives none.
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Surfaces are tried with this many times the drift that all of the region's volume change allows, and with ever less
/// until volumes are kept.
constexpr double kMostAllowance = 16;
constexpr double kLessAllowance = 0.7;
/// What is more than this part of the volume change that is allowed has been refused at some places.
constexpr double kVolumeUse = 0.95;
/// So often f shrinks on one level where simplices are long or leave room.
constexpr int kMaxRounds = 2;
/// Hierarchies built to find growths for given numbers of vertices, and how near they are to come: within this part
/// below.
constexpr int kMaxHierarchies = 10;
constexpr double kNearEnough = 0.05;

/// The minimum of Lipschitz functions, each of which grows from one center.
class Caps {
 public:
  Caps(std::vector<SpacingCap<3>> caps, double slope) : caps_(std::move(caps)), slope_(slope) {
    std::vector<Box<3>> boxes;
    std::vector<double> values;
    for (const SpacingCap<3>& cap : caps_) {
      boxes.emplace_back(cap.center, cap.center);
      values.push_back(cap.value - slope * cap.radius);
    }
    tree_ = BoxTree<3>(boxes, values);
  }
  [[nodiscard]] double operator()(const Vec<3>& x, double bound) const {
    return tree_.minimize(x, slope_, bound, [&](std::uint32_t i) {
      return caps_[i].value + slope_ * std::max(0.0, distance(x, caps_[i].center) - caps_[i].radius);
    });
  }

 private:
  std::vector<SpacingCap<3>> caps_;
  double slope_;
  BoxTree<3> tree_;
};

/// For each point, half the distance to the nearest other one.
std::vector<double> half_distances(const std::vector<Vec<3>>& points) {
  std::vector<Box<3>> boxes;
  for (const Vec<3>& x : points) boxes.emplace_back(x, x);
  const BoxTree<3> tree(boxes);
  std::vector<double> half(points.size());
  parallel_for(points.size(), [&](std::size_t i) {
    half[i] = 0.5 * tree.minimize(points[i], 1, kInfinity,
                                  [&](std::uint32_t j) { return j == i ? kInfinity : distance(points[i], points[j]); });
  });
  return half;
}

/// Growths of levels for given numbers of vertices. How a number falls with the logarithm of the growth is learned from
/// one hierarchy to the next; as if levels did not depend on each other, which holds better the nearer they are.
class GrowthSearch {
 public:
  GrowthSearch(std::size_t n_finest, const std::vector<std::size_t>& wished) : wished_(wished) {
    for (const std::size_t n : wished)
      log_growth_.push_back(std::log(static_cast<double>(n_finest) / static_cast<double>(n)) / kInside);
    exponent_.assign(wished.size(), kInside);
    keep_growing();
  }

  /// From each level to the next one.
  [[nodiscard]] std::vector<double> growth() const {
    std::vector<double> result;
    double before = 0;
    for (const double value : log_growth_) result.push_back(std::exp(value - std::exchange(before, value)));
    return result;
  }

  /// How far the worst level is below its number, as a part of it; more than 1 if one is above.
  [[nodiscard]] double miss(const std::vector<std::size_t>& found) const {
    double below = 0, above = 0;
    for (std::size_t i = 0; i < wished_.size(); ++i) {
      const double part = static_cast<double>(found[i]) / static_cast<double>(wished_[i]);
      below = std::max(below, 1 - part);
      above = std::max(above, part - 1);
    }
    return above > 0 ? 1 + above : below;
  }

  void learn(const std::vector<std::size_t>& found) {
    std::vector<double> log_found;
    for (const std::size_t n : found) log_found.push_back(std::log(static_cast<double>(n)));
    const std::vector<double> tried = log_growth_;
    for (std::size_t i = 0; i < wished_.size(); ++i) {
      if (!tried_.empty() && std::abs(tried[i] - tried_[i]) > kLeastStep)
        exponent_[i] = std::clamp((log_found_[i] - log_found[i]) / (tried[i] - tried_[i]), kLeastExponent, kInside);
      log_growth_[i] +=
          (log_found[i] - std::log((1 - 0.5 * kNearEnough) * static_cast<double>(wished_[i]))) / exponent_[i];
    }
    keep_growing();
    tried_ = tried;
    log_found_ = std::move(log_found);
  }

 private:
  static constexpr double kInside = 3;         // Where the boundary is far.
  static constexpr double kLeastExponent = 1;  // So that a level that the boundary holds up does not run away.
  static constexpr double kLeastStep = 1e-3;
  static constexpr double kLeastGrowth = 0.02;  // Logarithms.

  void keep_growing() {
    double before = 0;
    for (double& value : log_growth_) before = value = std::max(value, before + kLeastGrowth);
  }

  const std::vector<std::size_t>& wished_;
  std::vector<double> log_growth_, exponent_;  ///< By level.
  std::vector<double> tried_, log_found_;      ///< Of the hierarchy before.
};

class SpaceHierarchy {
 public:
  SpaceHierarchy(const Mesh<3>& mesh, const BeyondBoundaryOptions& options, Observer& observer)
      : mesh_(mesh),
        options_(options),
        observer_(observer),
        lipschitz_(options.lipschitz.value_or(kLipschitz)),
        surface_(find_surface(mesh, {options.feature_angle_deg, options.merge_markers})),
        vertex_region_(regions_of_vertices()),
        edges_(build_edge_graph(mesh)),
        initial_(initial_spacing(mesh, edges_, options.initial).initial) {}

  std::vector<SimplifiedLevel<3>> build() {
    if (surface_.triangles.empty()) return {};
    std::vector<SimplifiedLevel<3>> levels =
        options_.target_vertices.empty()
            ? make_levels(std::vector<double>(static_cast<std::size_t>(options_.levels), options_.growth))
            : make_numbers();
    end_where_nothing_is_gained(levels);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      link_level<3>(mesh_, i == 0 ? nullptr : &levels[i - 1], levels[i]);
      levels[i].boundary_distance = surface_distance(mesh_, levels[i].mesh);
    }
    return levels;
  }

 private:
  using Field = IdVector<VertexId, double>;

  /// What is known of a level before the vertices inside are chosen.
  struct Plan {
    double growth = 1;  ///< From the finest mesh.
    LevelSurface surface;
    double volume_change = 0;
    Field spacing;  ///< growth f_0, made Lipschitz.
    /// [n_vertices] 2: may be an inner vertex of this level and keeps its distance from the surfaces of all finer ones;
    /// 1: lies in its region on this level and all finer ones, and in no protecting ball.
    std::vector<std::uint8_t> admission;
  };

  [[nodiscard]] std::vector<int> regions_of_vertices() const {
    std::vector<int> region(mesh_.points.size(), kNoRegion);
    for (const SimplexId s : ids(mesh_.simplex_vertices))
      for (const VertexId v : mesh_.simplex_vertices[s]) region[v.value()] = mesh_.simplex_region[s];
    for (const VertexId v : surface_.vertex) region[v.value()] = kNoRegion;
    for (int& r : region)
      if (r != kNoRegion)
        r = static_cast<int>(std::lower_bound(surface_.region_id.begin(), surface_.region_id.end(), r) -
                             surface_.region_id.begin());
    return region;
  }

  /// Levels 1, 2, ...: entry i of `growth` is what f grows by from level i to level i + 1.
  std::vector<SimplifiedLevel<3>> make_levels(const std::vector<double>& growth) {
    find_spacings(growth);
    simplify_surfaces();
    find_inner_vertices();
    std::vector<SimplifiedLevel<3>> levels(plans_.size());
    is_kept_.assign(mesh_.points.size(), 0);
    for (std::size_t i = plans_.size(); i-- > 0;) {
      observer_.progress(plans_.size() - 1 - i, plans_.size());
      observer_.check_cancelled();
      levels[i] = make_level(i);
      for (const VertexId v : levels[i].finest_vertex) is_kept_[v.value()] = 1;
    }
    return levels;
  }

  /// The hierarchy with the wished numbers of vertices, or as near below as a few attempts come; where there are none
  /// below, the nearest above.
  std::vector<SimplifiedLevel<3>> make_numbers() {
    const std::vector<std::size_t>& wished = options_.target_vertices;
    GrowthSearch search(mesh_.points.size(), wished);
    std::vector<SimplifiedLevel<3>> best;
    std::vector<std::size_t> found_before;
    double least_miss = kInfinity;
    for (int k = 0; k < kMaxHierarchies && least_miss > kNearEnough; ++k) {
      std::vector<SimplifiedLevel<3>> levels = make_levels(search.growth());
      std::vector<std::size_t> found;
      for (const SimplifiedLevel<3>& level : levels) found.push_back(level.mesh.points.size());
      if (found == found_before) break;  // What the boundary allows.
      found_before = found;
      const double miss = search.miss(found);
      search.learn(found);
      if (miss < least_miss) {
        least_miss = miss;
        best = std::move(levels);
      }
    }
    return best;
  }

  void find_spacings(const std::vector<double>& growth) {
    plans_.clear();
    Field f = initial_;
    double product = 1;
    for (const double g : growth) {
      observer_.check_cancelled();
      for (double& value : f) value *= g;
      make_lipschitz(edges_, lipschitz_, f);
      Plan& plan = plans_.emplace_back();
      plan.growth = product *= g;
      plan.spacing = f;
    }
  }

  void simplify_surfaces() {
    SurfaceSimplifier simplifier(surface_, options_.max_area_change);
    std::vector<double> f(surface_.vertex.size());
    for (Plan& plan : plans_) {
      observer_.check_cancelled();
      for (std::size_t v = 0; v < f.size(); ++v) f[v] = plan.spacing[surface_.vertex[v]];
      simplifier = simplify(simplifier, f);
      plan.surface = simplifier.surface();
      plan.volume_change = simplifier.volume_change();
    }
  }

  /// As far as volumes allow it without deciding what comes last.
  [[nodiscard]] SurfaceSimplifier simplify(const SurfaceSimplifier& before, const std::vector<double>& f) const {
    for (double allowance = kMostAllowance;; allowance *= kLessAllowance) {
      SurfaceSimplifier result = before;
      result.simplify(f, allowance);
      if (allowance <= 1 || result.volume_change() <= kVolumeUse * options_.max_area_change) return result;
    }
  }

  [[nodiscard]] std::vector<Vec<3>> points_of(const LevelSurface& surface) const {
    std::vector<Vec<3>> points;
    for (const std::uint32_t v : surface.vertices) points.push_back(surface_.points[v]);
    return points;
  }

  /// Level by level, from the finest one: what one surface forbids, it forbids on all coarser levels.
  void find_inner_vertices() {
    std::vector<std::uint8_t> admission(mesh_.points.size(), 2);
    for (Plan& plan : plans_) {
      observer_.check_cancelled();
      const std::vector<Vec<3>> points = points_of(plan.surface);
      const std::vector<double> half = half_distances(points);
      std::vector<SpacingCap<3>> room;
      SphereSet<3> spheres(points[0], 0.5, half[0]);
      for (std::size_t p = 0; p < points.size(); ++p) room.push_back({points[p], 0, half[p], std::nullopt});
      const Caps caps(std::move(room), lipschitz_);
      for (std::size_t p = 0; p < points.size(); ++p)
        spheres.add({points[p], caps(points[p], plan.spacing[surface_.vertex[plan.surface.vertices[p]]])});
      const WallLocator<3> locator(walls_of_surface(surface_, plan.surface));
      BallSet<3> balls =
          protecting_balls(domain_of_surface(surface_, plan.surface), packing_of_surface(surface_, plan.surface));
      for (const Ball<3>& ball : edge_balls_of_surface(surface_, plan.surface)) balls.add(ball);
      parallel_for(admission.size(), [&](std::size_t i) {
        if (admission[i] == 0) return;
        const Vec<3>& x = mesh_.points[VertexId(i)];
        if (vertex_region_[i] == kNoRegion || balls.forbids(x) || locator.region(x) != vertex_region_[i])
          admission[i] = 0;
        else if (admission[i] == 2 && spheres.conflicts(x, caps(x, plan.spacing[VertexId(i)])))
          admission[i] = 1;
      });
      plan.admission = admission;
    }
  }

  [[nodiscard]] FineMesh<3> fine_mesh_of(const Plan& plan) const {
    MeshDomain<3> place;
    place.domain = domain_of_surface(surface_, plan.surface);
    place.carrier.resize(mesh_.points.size(), PolytopeId(3, 0));
    for (std::size_t p = 0; p < plan.surface.vertices.size(); ++p)
      place.carrier[surface_.vertex[plan.surface.vertices[p]]] = PolytopeId(0, p);
    std::vector<std::uint8_t> is_outside(mesh_.points.size());
    for (std::size_t v = 0; v < is_outside.size(); ++v) is_outside[v] = plan.admission[v] == 0 ? 1 : 0;
    CoarseningOptions options;
    options.initial = options_.initial;
    options.order = options_.order;
    options.seed = options_.seed;
    return FineMesh<3>(mesh_, std::move(place), options, std::move(is_outside));
  }

  /// The surface, the vertices of the coarser level, and then those others that fit.
  [[nodiscard]] PackedLevel<3> pack(const FineMesh<3>& fine, const Plan& plan,
                                    const std::vector<SpacingCap<3>>& faults) const {
    PackedLevel<3> level;
    level.packing = packing_of_surface(surface_, plan.surface);
    for (const std::uint32_t v : plan.surface.vertices) level.vertex.push_back(surface_.vertex[v]);
    for (const VertexId v : fine.interior)
      if (is_kept_[v.value()] != 0) add(v, 0, level);
    std::vector<SpacingCap<3>> room = faults;
    const std::vector<double> half = half_distances(level.packing.center.raw());
    for (std::size_t s = 0; s < half.size(); ++s)
      room.push_back({level.packing.center[SphereId(s)], 0, half[s], std::nullopt});
    const Caps caps(std::move(room), lipschitz_);
    level.spacing = plan.spacing;
    parallel_for(level.spacing.size(), [&](std::size_t i) {
      const VertexId v(i);
      if (plan.admission[i] != 0 || fine.place.carrier[v].dimension < 3)
        level.spacing[v] = caps(mesh_.points[v], plan.spacing[v]);
    });
    SphereSet<3> spheres(fine.place.domain.box.center(), 0.5, half[0]);
    for (std::size_t s = 0; s < half.size(); ++s) {
      const double radius = level.spacing[level.vertex[s]];
      level.packing.radius[SphereId(s)] = radius;
      spheres.add({level.packing.center[SphereId(s)], radius});
    }
    std::uint32_t hint = 0;
    for (const VertexId v : fine.interior) {
      const double f = level.spacing[v];
      if (is_kept_[v.value()] != 0 || plan.admission[v.value()] < 2 || spheres.conflicts(mesh_.points[v], f, hint))
        continue;
      add(v, f, level);
      spheres.add({mesh_.points[v], f});
    }
    return level;
  }

  void add(VertexId v, double radius, PackedLevel<3>& level) const {
    level.packing.center.push_back(mesh_.points[v]);
    level.packing.radius.push_back(radius);
    level.packing.carrier.push_back(PolytopeId(3, 0));
    level.vertex.push_back(v);
  }

  [[nodiscard]] SimplifiedLevel<3> make_level(std::size_t i) const {
    const Plan& plan = plans_[i];
    const FineMesh<3> fine = fine_mesh_of(plan);
    std::vector<SpacingCap<3>> faults;
    std::size_t n_before = 0;
    for (int round = 0;; ++round) {
      observer_.check_cancelled();
      PackedLevel<3> level = pack(fine, plan, faults);
      const std::vector<SpacingCap<3>> gaps = complete_level(fine, lipschitz_, level, observer_);
      if (gaps.empty() || round == kMaxRounds || level.vertex.size() == std::exchange(n_before, level.vertex.size()))
        return finish(i, fine.place.domain, std::move(level));
      faults.insert(faults.end(), gaps.begin(), gaps.end());
    }
  }

  [[nodiscard]] SimplifiedLevel<3> finish(std::size_t i, const Domain<3>& domain, PackedLevel<3>&& packed) const {
    const Plan& plan = plans_[i];
    SimplifiedLevel<3> level;
    level.growth = plan.growth;
    level.lipschitz = lipschitz_;
    level.area_change = plan.volume_change;
    PackingMesh<3> made = triangulate_packing(domain, std::move(packed.packing), observer_);
    level.mesh = std::move(made.mesh);
    level.finest_vertex.resize(packed.vertex.size());
    for (const SphereId s : ids(made.vertex_of_sphere)) {
      const VertexId v = made.vertex_of_sphere[s], of_finest = packed.vertex[s.value()];
      level.finest_vertex[v] = of_finest;
      if (!mesh_.vertex_marker.empty()) level.mesh.vertex_marker[v] = mesh_.vertex_marker[of_finest];
    }
    level.epsilon = measured_epsilon(level.mesh);
    return level;
  }

  void end_where_nothing_is_gained(std::vector<SimplifiedLevel<3>>& levels) const {
    std::size_t before = mesh_.points.size();
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const std::size_t n = levels[i].mesh.points.size();
      if (static_cast<double>(n) > kLeastGain * static_cast<double>(before)) {
        levels.resize(i);
        return;
      }
      before = n;
    }
  }

  const Mesh<3>& mesh_;
  const BeyondBoundaryOptions& options_;
  Observer& observer_;
  double lipschitz_;
  SurfaceComplex surface_;
  std::vector<int> vertex_region_;  ///< Of inner vertices; as in the surface.
  EdgeGraph edges_;
  Field initial_;  ///< f_0.
  std::vector<Plan> plans_;
  std::vector<std::uint8_t> is_kept_;  ///< By vertex: whether it is in a coarser level.
};

}  // namespace

std::vector<SimplifiedLevel<3>> make_space_hierarchy(const Mesh<3>& mesh, const BeyondBoundaryOptions& options,
                                                     Observer& observer) {
  return SpaceHierarchy(mesh, options, observer).build();
}

}  // namespace voropack
