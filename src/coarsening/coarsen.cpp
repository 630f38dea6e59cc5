#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "base/place_text.h"
#include "coarsening/completion.h"
#include "coarsening/fine_mesh.h"
#include "coarsening/level_boundary.h"
#include "coarsening/level_packer.h"
#include "coarsening/prolongation.h"
#include "coarsening/require_delaunay.h"
#include "coarsening/spacing_limit.h"
#include "geom/box_tree.h"
#include "geom/circumcenter.h"
#include "voropack/coarsening.h"
#include "voropack/delaunay.h"
#include "voropack/spacing.h"

namespace voropack {

namespace {

/// So often f shrinks on one level before the mesh is given up: it has got to the finest mesh's by then.
constexpr int kMaxRounds = 60;
/// The same with a boundary that has no finer vertices to fall back to.
constexpr int kMaxOwnRounds = 20;
constexpr double kMaxGrowth = 1e6;  ///< More changes nothing: f is what its Lipschitz condition and the domain allow.
constexpr int kBisections = 14;     ///< Growth to about 0.1 %.

void check_options(const CoarseningOptions& options) {
  const auto refuse = [](const char* name, double value, const char* range) {
    throw OptionError(Fault{.id = "coarsen.bad_option",
                            .message = fmt::format("{} is {}", name, value),
                            .fix = fmt::format("give a number {}.", range)});
  };
  if (options.levels < 1) refuse("the number of levels", options.levels, "from 1 on");
  if (!(options.growth > 1 && std::isfinite(options.growth))) refuse("the growth factor", options.growth, "above 1");
  if (!(options.lipschitz > 0 && options.lipschitz < 1))
    refuse("the Lipschitz constant", options.lipschitz, "in (0, 1)");
  for (std::size_t i = 0; i < options.target_vertices.size(); ++i)
    if (const std::size_t n = options.target_vertices[i]; n == 0 || (i > 0 && n >= options.target_vertices[i - 1]))
      refuse("a number of vertices", static_cast<double>(n), "that is less than that of the next finer level");
  if (!options.target_vertices.empty() && options.quasi_uniform)
    throw OptionError(Fault{.id = "coarsen.bad_option",
                            .message = "numbers of vertices are given, and a spacing that is not to be chosen freely",
                            .fix = "give only one of the two"});
}

template <int D>
class Coarsener {
 public:
  Coarsener(const Mesh<D>& mesh, MeshDomain<D> place, std::vector<LevelBoundary<D>> boundaries,
            const CoarseningOptions& options, Observer& observer)
      : options_(options), observer_(observer), boundaries_(std::move(boundaries)) {
    add_ground(mesh, {std::move(place), {}});
    for (const LevelBoundary<D>& boundary : boundaries_) add_ground(mesh, place_in_boundary(mesh, boundary));
    ground_ = grounds_.back().get();
    is_kept_.resize(mesh.points.size(), 0);
    fitted_.resize(mesh.points.size(), std::numeric_limits<double>::infinity());
  }

  CoarseningHierarchy<D> run() {
    std::vector<PackedLevel<D>> packed = pack_levels();
    CoarseningHierarchy<D> hierarchy;
    observer_.begin_stage("coarsening");
    for (std::size_t i = 0; i < packed.size(); ++i) {
      observer_.check_cancelled();
      ground_ = grounds_[ground_of(i)].get();
      hierarchy.levels.push_back(make_level(std::move(packed[i])));
      if (ground_of(i) > 0)
        hierarchy.levels.back().boundary_distance = boundary_distance(ground_->fine.mesh, hierarchy.levels.back().mesh);
    }
    link_levels(hierarchy);
    for (std::size_t k = 0; k < boundaries_.size(); ++k)
      boundaries_[k].domain = std::move(grounds_[k + 1]->fine.place.domain);
    hierarchy.boundaries = std::move(boundaries_);
    hierarchy.domain = std::move(grounds_[0]->fine.place.domain);
    return hierarchy;
  }

 private:
  using Field = IdVector<VertexId, double>;

  /// A boundary, which vertices are where on it, and what it allows f to be: b-Lipschitz, and small where polytopes are
  /// near to each other.
  struct Ground {
    Ground(const Mesh<D>& mesh, PlacedMesh<D> placed, const CoarseningOptions& options, Observer& observer)
        : fine(mesh, std::move(placed.place), options, std::move(placed.is_outside)),
          spacing(build_spacing<D>(fine.place.domain, {}, {.gradation = std::min(options.lipschitz, 0.4)}, observer)) {}
    FineMesh<D> fine;
    Spacing<D> spacing;
    std::vector<SpacingCap<D>> caps;
    std::optional<SpacingLimit<D>> limit;  ///< The spacing with the caps.
  };

  void add_ground(const Mesh<D>& mesh, PlacedMesh<D> placed) {
    grounds_.push_back(std::make_unique<Ground>(mesh, std::move(placed), options_, observer_));
    ground_ = grounds_.back().get();
    find_limit();
  }

  /// Of level i + 1: the last boundary that is given for it or a finer level, or the mesh's own.
  [[nodiscard]] std::size_t ground_of(std::size_t i) const {
    std::size_t k = 0;
    while (k < boundaries_.size() && static_cast<std::size_t>(boundaries_[k].level) <= i + 1) ++k;
    return k;
  }

  [[nodiscard]] const FineMesh<D>& fine() const { return ground_->fine; }

  void find_limit() {
    ground_->limit.emplace(fine(),
                           ground_->caps.empty() ? ground_->spacing : ground_->spacing.with_caps(ground_->caps));
  }

  /// growth^i f_0, made Lipschitz, for i = 1 .. levels.
  [[nodiscard]] std::vector<Field> grown_spacings() const {
    observer_.check_cancelled();
    if (!options_.quasi_uniform)
      return grown_lipschitz(fine().edges, options_.lipschitz, fine().initial, options_.growth,
                             static_cast<std::size_t>(options_.levels));
    std::vector<Field> fields;
    Field f = fine().floor;
    const double least = *std::min_element(fine().floor.begin(), fine().floor.end());
    for (int i = 1; i <= options_.levels; ++i) {
      for (double& value : f) value = std::max(value, std::pow(options_.growth, i) * least);
      fields.push_back(f);
    }
    return fields;
  }

  /// Level 1 first.
  std::vector<PackedLevel<D>> pack_levels() {
    observer_.begin_stage("packing");
    std::vector<PackedLevel<D>> levels = options_.target_vertices.empty() ? pack_growing() : pack_numbers();
    leave_out_where_nothing_is_gained(levels);
    return levels;
  }

  /// Where lattices of vertices fit f badly, a level may have hardly fewer vertices than the next finer one, and a
  /// still coarser one many fewer; in the end the boundary allows nothing more. Levels with boundaries of their own
  /// keep their numbers: there the first one of that kind ends coarsening.
  void leave_out_where_nothing_is_gained(std::vector<PackedLevel<D>>& levels) const {
    double before = static_cast<double>(fine().mesh.points.size());
    std::vector<PackedLevel<D>> gaining;
    for (PackedLevel<D>& level : levels) {
      const auto n = static_cast<double>(level.vertex.size());
      if (n > kLeastGain * before) {
        if (!boundaries_.empty()) break;
        continue;
      }
      before = n;
      gaining.push_back(std::move(level));
    }
    levels = std::move(gaining);
  }

  std::vector<PackedLevel<D>> pack_growing() {
    const std::vector<Field> grown = grown_spacings();
    std::vector<PackedLevel<D>> levels(grown.size());
    for (std::size_t i = grown.size(); i-- > 0;) {
      enter_level(i);
      levels[i] = pack_one(grown[i]);
      levels[i].growth = std::pow(options_.growth, static_cast<double>(i + 1));
      keep(levels[i]);
    }
    return levels;
  }

  std::vector<PackedLevel<D>> pack_numbers() {
    std::vector<PackedLevel<D>> levels(options_.target_vertices.size());
    double most = kMaxGrowth;
    for (std::size_t i = levels.size(); i-- > 0;) {
      enter_level(i);
      levels[i] = pack_number(options_.target_vertices[i], most);
      most = levels[i].growth;
      keep(levels[i]);
    }
    return levels;
  }

  /// By bisection of the growth up to `most`. f has to shrink at other places for each growth: only those of the result
  /// stay.
  PackedLevel<D> pack_number(std::size_t n_wanted, double most) {
    const std::vector<SpacingCap<D>> caps_before = ground_->caps;
    std::vector<SpacingCap<D>> caps;
    const auto pack = [&](double growth) {
      ground_->caps = caps_before;
      find_limit();
      Field f = fine().initial;
      for (double& value : f) value *= growth;
      make_lipschitz(fine().edges, options_.lipschitz, f);
      PackedLevel<D> level = pack_one(f);
      level.growth = growth;
      return level;
    };
    PackedLevel<D> best = pack(most);
    caps = ground_->caps;
    double low = 0, high = std::log(most);
    for (int k = 0; k < kBisections && best.vertex.size() < n_wanted; ++k) {
      const double middle = 0.5 * (low + high);
      PackedLevel<D> level = pack(std::exp(middle));
      const std::size_t n = level.vertex.size();
      (n <= n_wanted ? high : low) = middle;
      if (n > n_wanted || n < best.vertex.size()) continue;
      best = std::move(level);
      caps = ground_->caps;
    }
    ground_->caps = std::move(caps);
    find_limit();
    return best;
  }

  /// Where the boundary is not that of the coarser level, its points and the vertices that are kept need room.
  void enter_level(std::size_t i) {
    Ground* const coarser = ground_;
    ground_ = grounds_[ground_of(i)].get();
    if (ground_ == coarser) return;
    std::vector<VertexId> present;
    for (const VertexId v : ids(fitted_)) {
      if (is_kept_[v.value()] == 0) continue;
      if (!fine().is_outside.empty() && fine().is_outside[v.value()] != 0) throw_outside(i, v);
      present.push_back(v);
    }
    std::vector<VertexId> added;
    for (const VertexId v : fine().point_vertices)
      if (is_kept_[v.value()] == 0) added.push_back(v);
    present.insert(present.end(), added.begin(), added.end());
    make_room(added, present);
  }

  /// Half the distance to the nearest one for those of `added`, what is left for those around.
  void make_room(const std::vector<VertexId>& added, const std::vector<VertexId>& present) {
    std::vector<Box<D>> boxes;
    for (const VertexId v : present) boxes.emplace_back(fine().mesh.points[v], fine().mesh.points[v]);
    const BoxTree<D> tree(boxes);
    const double size = fine().place.domain.diameter();
    for (const VertexId v : added) {
      const Vec<D>& x = fine().mesh.points[v];
      double nearest = size;
      tree.for_each([&](const Box<D>& box) { return box.distance_sq(x) < nearest * nearest; },
                    [&](std::uint32_t k) {
                      if (present[k] != v) nearest = std::min(nearest, distance(x, fine().mesh.points[present[k]]));
                    });
      const double radius = 0.5 * nearest;
      ground_->caps.push_back({x, 0, radius, std::nullopt});
      for (const VertexId w : present) {
        if (w == v || is_kept_[w.value()] == 0) continue;
        const double room = distance(x, fine().mesh.points[w]) - radius;
        if (room < fitted_[w]) ground_->caps.push_back({fine().mesh.points[w], 0, fitted_[w] = room, std::nullopt});
      }
    }
    find_limit();
  }

  [[noreturn]] void throw_outside(std::size_t i, VertexId v) const {
    const Vec<D>& x = fine().mesh.points[v];
    throw InputError(Fault{
        .id = "coarsen.level_boundary",
        .message =
            fmt::format("a vertex of level {} lies outside of the boundary of level {}, which is finer", i + 2, i + 1),
        .fix = "let boundaries of coarser levels lie within those of finer ones.",
        .file = fine().place.domain.file,
        .position = {x.coord.begin(), x.coord.end()}});
  }

  /// The vertices of a level stay on all finer ones, with radii that are no larger.
  void keep(const PackedLevel<D>& level) {
    for (const SphereId s : ids(level.packing.radius)) {
      is_kept_[level.vertex[s.value()].value()] = 1;
      fitted_[level.vertex[s.value()]] = level.packing.radius[s];
    }
  }

  PackedLevel<D> pack_one(const Field& grown) {
    std::size_t n_before = 0;
    const int max_rounds = ground_ == grounds_[0].get() ? kMaxRounds : kMaxOwnRounds;
    for (int round = 0; round <= max_rounds; ++round) {
      Field f(grown.size());
      parallel_for(f.size(), [&](std::size_t i) {
        const VertexId v(i);
        f[v] = std::min(std::max(fine().floor[v], (*ground_->limit)(v, grown[v])), fitted_[v]);
      });
      PackedLevel<D> level = pack_level(fine(), f, is_kept_, observer_);
      if (level.faults.empty()) {
        level.spacing = std::move(f);
        level.faults = complete_level(fine(), options_.lipschitz, level, observer_);
        // Where f is that of the finest mesh all of its vertices are there, and it helps no more to shrink.
        if (!level.faults.empty() && level.vertex.size() != std::exchange(n_before, level.vertex.size())) {
          shrink(level.faults);
          continue;
        }
        if (!level.faults.empty()) find_epsilon(level);
        return level;
      }
      shrink(level.faults);
    }
    const Vec<D>& last = ground_->caps.back().center;  // A place where a ball was not empty.
    if (ground_ != grounds_[0].get())
      throw InputError(
          Fault{.id = "coarsen.level_boundary",
                .message =
                    fmt::format("protecting balls of a level's own boundary hold vertices of the same boundary, and no "
                                "vertices of the mesh lie on it to make them smaller, such as near {}",
                                place_text(last)),
                .fix = "give a boundary with more vertices of the mesh, or a level more of them.",
                .file = fine().place.domain.file,
                .position = {last.coord.begin(), last.coord.end()}});
    throw InputError(
        Fault{.id = "coarsen.not_delaunay",
              .message = fmt::format("the mesh is not boundary-conforming Delaunay: its own vertices lie in "
                                     "protecting balls, such as near {}",
                                     place_text(last)),
              .fix = "make it Delaunay first (--redelaunay); if its boundary does not conform then, mesh the "
                     "domain again (voropack mesh). `voropack check` names the places",
              .position = {last.coord.begin(), last.coord.end()}});
  }

  void shrink(const std::vector<SpacingCap<D>>& faults) {
    observer_.log(LogLevel::kInfo, fmt::format("f shrinks at {} places", faults.size()));
    ground_->caps.insert(ground_->caps.end(), faults.begin(), faults.end());
    find_limit();
  }

  /// The largest circumradius of the finest mesh in units of f at the circumcenter.
  void find_epsilon(PackedLevel<D>& level) const {
    const Field& f = level.spacing;
    level.epsilon = parallel_reduce_ordered(
        fine().mesh.simplex_vertices.size(), 65536, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double worst = 0;
          for (std::size_t s = begin; s < end; ++s) {
            const auto& corners = fine().mesh.simplex_vertices[SimplexId(s)];
            std::array<Vec<D>, D + 1> x;
            double most = 0;
            for (std::size_t i = 0; i <= D; ++i) {
              x[i] = fine().mesh.points[corners[i]];
              most = std::max(most, f[corners[i]]);
            }
            const double radius = distance(fast_circumcenter(x), x[0]);
            worst = std::max(worst, radius / (most - options_.lipschitz * radius));
          }
          return worst;
        },
        [](double a, double b) { return std::max(a, b); });
  }

  CoarseLevel<D> make_level(PackedLevel<D>&& packed) {
    CoarseLevel<D> level;
    level.epsilon = packed.epsilon;
    level.growth = packed.growth;
    PackingMesh<D> made = triangulate_packing(fine().place.domain, std::move(packed.packing), observer_);
    level.mesh = std::move(made.mesh);
    level.finest_vertex.resize(packed.vertex.size());
    for (const SphereId s : ids(made.vertex_of_sphere))
      level.finest_vertex[made.vertex_of_sphere[s]] = packed.vertex[s.value()];
    return level;
  }

  void link_levels(CoarseningHierarchy<D>& hierarchy) const {
    const CoarseLevel<D>* finer = nullptr;
    for (CoarseLevel<D>& level : hierarchy.levels) {
      observer_.check_cancelled();
      link_level(fine().mesh, finer, level);
      finer = &level;
    }
  }

  const CoarseningOptions& options_;
  Observer& observer_;
  std::vector<LevelBoundary<D>> boundaries_;      ///< Of ground 1, 2, ...
  std::vector<std::unique_ptr<Ground>> grounds_;  ///< The first one is the mesh's own.
  Ground* ground_ = nullptr;                      ///< Of the level that is packed.
  std::vector<std::uint8_t> is_kept_;             ///< By vertex: whether it is in a coarser level.
  Field fitted_;                                  ///< The radii of vertices that are in a coarser level.
};

}  // namespace

template <int D>
void check_boundaries(const std::vector<LevelBoundary<D>>& boundaries, const CoarseningOptions& options) {
  const auto n_levels = options.target_vertices.empty() ? options.levels : std::ssize(options.target_vertices);
  for (std::size_t k = 0; k < boundaries.size(); ++k) {
    const int level = boundaries[k].level;
    if (level >= 1 && level <= n_levels && (k == 0 || boundaries[k - 1].level < level)) continue;
    throw OptionError(Fault{
        .id = "coarsen.bad_option",
        .message = fmt::format("a boundary is given for level {}, twice or beyond the {} levels", level, n_levels),
        .fix = "give each level between 1 and the last one at most one boundary."});
  }
}

template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, const CoarseningOptions& options, Observer& observer) {
  return coarsen<D>(mesh, {}, options, observer);
}

/// What can be refused before anything is done with the boundary.
template <int D>
void check_input(const Mesh<D>& mesh, std::vector<LevelBoundary<D>>& boundaries, const CoarseningOptions& options) {
  check_options(options);
  std::ranges::stable_sort(boundaries, {}, &LevelBoundary<D>::level);
  check_boundaries(boundaries, options);
  require_delaunay(mesh);
}

template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, std::vector<LevelBoundary<D>> boundaries,
                               const CoarseningOptions& options, Observer& observer) {
  check_input(mesh, boundaries, options);

  return Coarsener<D>(mesh, domain_of(mesh, observer), std::move(boundaries), options, observer).run();
}

template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, MeshDomain<D> place, std::vector<LevelBoundary<D>> boundaries,
                               const CoarseningOptions& options, Observer& observer) {
  check_input(mesh, boundaries, options);
  return Coarsener<D>(mesh, std::move(place), std::move(boundaries), options, observer).run();
}

template CoarseningHierarchy<2> coarsen(const Mesh<2>&, const CoarseningOptions&, Observer&);
template CoarseningHierarchy<3> coarsen(const Mesh<3>&, const CoarseningOptions&, Observer&);
template CoarseningHierarchy<2> coarsen(const Mesh<2>&, std::vector<LevelBoundary<2>>, const CoarseningOptions&,
                                        Observer&);
template CoarseningHierarchy<3> coarsen(const Mesh<3>&, std::vector<LevelBoundary<3>>, const CoarseningOptions&,
                                        Observer&);
template CoarseningHierarchy<2> coarsen(const Mesh<2>&, MeshDomain<2>, std::vector<LevelBoundary<2>>,
                                        const CoarseningOptions&, Observer&);
template CoarseningHierarchy<3> coarsen(const Mesh<3>&, MeshDomain<3>, std::vector<LevelBoundary<3>>,
                                        const CoarseningOptions&, Observer&);

}  // namespace voropack
