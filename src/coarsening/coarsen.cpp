#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "coarsening/completion.h"
#include "coarsening/fine_mesh.h"
#include "coarsening/level_packer.h"
#include "coarsening/prolongation.h"
#include "geom/circumcenter.h"
#include "voropack/coarsening.h"
#include "voropack/delaunay.h"
#include "voropack/spacing.h"

namespace voropack {

namespace {

/// So often f shrinks on one level before the mesh is given up: it has got to the finest mesh's by then.
constexpr int kMaxRounds = 60;
/// A level with more than this part of the vertices of the next finer one is none.
constexpr double kLeastGain = 0.95;
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
  Coarsener(const Mesh<D>& mesh, const CoarseningOptions& options, Observer& observer)
      : options_(options),
        observer_(observer),
        fine_(mesh, domain_of(mesh, observer), options),
        spacing_(feature_spacing(fine_.place.domain)) {
    find_limit(spacing_);
    is_kept_.resize(mesh.points.size(), 0);
    fitted_.resize(mesh.points.size(), std::numeric_limits<double>::infinity());
  }

  CoarseningHierarchy<D> run() {
    std::vector<PackedLevel<D>> packed = pack_levels();
    CoarseningHierarchy<D> hierarchy;
    observer_.begin_stage("coarsening");
    for (PackedLevel<D>& level : packed) {
      observer_.check_cancelled();
      hierarchy.levels.push_back(make_level(std::move(level)));
    }
    link_levels(hierarchy);
    hierarchy.domain = std::move(fine_.place.domain);
    return hierarchy;
  }

 private:
  using Field = IdVector<VertexId, double>;

  /// What the domain allows f to be: b-Lipschitz, and small where polytopes are near to each other.
  Spacing<D> feature_spacing(const Domain<D>& domain) const {
    SpacingOptions spacing;
    spacing.gradation = std::min(options_.lipschitz, 0.4);
    return build_spacing<D>(domain, {}, spacing, observer_);
  }

  void find_limit(const Spacing<D>& spacing) {
    limit_.resize(fine_.mesh.points.size());
    parallel_for(limit_.size(), [&](std::size_t v) { limit_[VertexId(v)] = spacing(fine_.mesh.points[VertexId(v)]); });
  }

  /// growth^i f_0, made Lipschitz, for i = 1 .. levels.
  [[nodiscard]] std::vector<Field> grown_spacings() const {
    std::vector<Field> fields;
    Field f = options_.quasi_uniform ? fine_.floor : fine_.initial;
    const double least = *std::min_element(fine_.floor.begin(), fine_.floor.end());
    for (int i = 1; i <= options_.levels; ++i) {
      observer_.check_cancelled();
      if (options_.quasi_uniform) {
        for (double& value : f) value = std::max(value, std::pow(options_.growth, i) * least);
      } else {
        for (double& value : f) value *= options_.growth;
        make_lipschitz(fine_.mesh, fine_.neighbors, options_.lipschitz, f);
      }
      fields.push_back(f);
    }
    return fields;
  }

  /// Level 1 first.
  std::vector<PackedLevel<D>> pack_levels() {
    observer_.begin_stage("packing");
    std::vector<PackedLevel<D>> levels = options_.target_vertices.empty() ? pack_growing() : pack_numbers();
    // The boundary ends coarsening.
    std::size_t before = fine_.mesh.points.size();
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const std::size_t n = levels[i].vertex.size();
      if (static_cast<double>(n) > kLeastGain * static_cast<double>(before)) {
        levels.resize(i);
        break;
      }
      before = n;
    }
    return levels;
  }

  std::vector<PackedLevel<D>> pack_growing() {
    const std::vector<Field> grown = grown_spacings();
    std::vector<PackedLevel<D>> levels(grown.size());
    for (std::size_t i = grown.size(); i-- > 0;) {
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
      levels[i] = pack_number(options_.target_vertices[i], most);
      most = levels[i].growth;
      keep(levels[i]);
    }
    return levels;
  }

  /// By bisection of the growth up to `most`. f has to shrink at other places for each growth: only those of the result
  /// stay.
  PackedLevel<D> pack_number(std::size_t n_wanted, double most) {
    const std::vector<SpacingCap<D>> caps_before = caps_;
    std::vector<SpacingCap<D>> caps;
    const auto pack = [&](double growth) {
      caps_ = caps_before;
      find_limit(spacing_.with_caps(caps_));
      Field f = fine_.initial;
      for (double& value : f) value *= growth;
      make_lipschitz(fine_.mesh, fine_.neighbors, options_.lipschitz, f);
      PackedLevel<D> level = pack_one(f);
      level.growth = growth;
      return level;
    };
    PackedLevel<D> best = pack(most);
    caps = caps_;
    double low = 0, high = std::log(most);
    for (int k = 0; k < kBisections && best.vertex.size() < n_wanted; ++k) {
      const double middle = 0.5 * (low + high);
      PackedLevel<D> level = pack(std::exp(middle));
      const std::size_t n = level.vertex.size();
      (n <= n_wanted ? high : low) = middle;
      if (n > n_wanted || n < best.vertex.size()) continue;
      best = std::move(level);
      caps = caps_;
    }
    caps_ = std::move(caps);
    find_limit(spacing_.with_caps(caps_));
    return best;
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
    for (int round = 0; round <= kMaxRounds; ++round) {
      Field f(grown.size());
      parallel_for(f.size(), [&](std::size_t i) {
        const VertexId v(i);
        f[v] = std::min(std::max(fine_.floor[v], std::min(grown[v], limit_[v])), fitted_[v]);
      });
      PackedLevel<D> level = pack_level(fine_, f, is_kept_, observer_);
      if (level.faults.empty()) {
        level.spacing = std::move(f);
        level.faults = complete_level(fine_, options_.lipschitz, level, observer_);
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
    throw InputError(Fault{.id = "coarsen.not_delaunay",
                           .message =
                               "the mesh is not boundary-conforming Delaunay: its own vertices lie in protecting "
                               "balls",
                           .fix = "make it Delaunay first (--redelaunay); `voropack check` names the places"});
  }

  void shrink(const std::vector<SpacingCap<D>>& faults) {
    observer_.log(LogLevel::kInfo, fmt::format("f shrinks at {} places", faults.size()));
    caps_.insert(caps_.end(), faults.begin(), faults.end());
    find_limit(spacing_.with_caps(caps_));
  }

  /// The largest circumradius of the finest mesh in units of f at the circumcenter.
  void find_epsilon(PackedLevel<D>& level) const {
    const Field& f = level.spacing;
    level.epsilon = parallel_reduce_ordered(
        fine_.mesh.simplex_vertices.size(), 65536, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double worst = 0;
          for (std::size_t s = begin; s < end; ++s) {
            const auto& corners = fine_.mesh.simplex_vertices[SimplexId(s)];
            std::array<Vec<D>, D + 1> x;
            double most = 0;
            for (std::size_t i = 0; i <= D; ++i) {
              x[i] = fine_.mesh.points[corners[i]];
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
    std::vector<VertexId> vertex = std::move(packed.vertex);
    const std::vector<Vec<D>> centers = packed.packing.center.raw();
    level.mesh = triangulate(fine_.place.domain, std::move(packed.packing), observer_);
    // The mesh has the same points in another order.
    const auto sorted = [](const std::vector<Vec<D>>& points) {
      std::vector<std::uint32_t> order(points.size());
      for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
      std::sort(order.begin(), order.end(),
                [&](std::uint32_t a, std::uint32_t b) { return points[a].coord < points[b].coord; });
      return order;
    };
    const std::vector<std::uint32_t> from = sorted(centers), to = sorted(level.mesh.points.raw());
    level.finest_vertex.resize(vertex.size());
    for (std::size_t i = 0; i < from.size(); ++i) level.finest_vertex[VertexId(to[i])] = vertex[from[i]];
    return level;
  }

  void link_levels(CoarseningHierarchy<D>& hierarchy) const {
    const CoarseLevel<D>* finer = nullptr;
    for (CoarseLevel<D>& level : hierarchy.levels) {
      observer_.check_cancelled();
      link_level(fine_.mesh, finer, level);
      finer = &level;
    }
  }

  const CoarseningOptions& options_;
  Observer& observer_;
  FineMesh<D> fine_;
  Spacing<D> spacing_;
  Field limit_;                        ///< What the domain and the caps allow f to be.
  std::vector<std::uint8_t> is_kept_;  ///< By vertex: whether it is in a coarser level.
  Field fitted_;                       ///< The radii of vertices that are in a coarser level.
  std::vector<SpacingCap<D>> caps_;
};

}  // namespace

template <int D>
CoarseningHierarchy<D> coarsen(const Mesh<D>& mesh, const CoarseningOptions& options, Observer& observer) {
  check_options(options);
  return Coarsener<D>(mesh, options, observer).run();
}

template CoarseningHierarchy<2> coarsen(const Mesh<2>&, const CoarseningOptions&, Observer&);
template CoarseningHierarchy<3> coarsen(const Mesh<3>&, const CoarseningOptions&, Observer&);

}  // namespace voropack
