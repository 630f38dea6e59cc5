// Coarsening beyond the boundary: level by level from the coarsest one up, packed, then improved.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random.h"
#include "coarsening/improve_level.h"
#include "coarsening/level_epsilon.h"
#include "coarsening/planar_packer.h"
#include "coarsening/prolongation.h"
#include "coarsening/require_delaunay.h"
#include "coarsening/space_hierarchy.h"
#include "voropack/coarsening.h"
#include "voropack/error.h"

namespace voropack {

namespace {

constexpr double kMaxGrowth = 1000;      // More changes nothing: f is what its Lipschitz condition allows.
constexpr double kLipschitz = 0.1;       // If the user gives none.
constexpr double kMaxLipschitz = 0.7;    // Beyond, shapes are not worth having.
constexpr double kLipschitzStep = 1.25;  // What the constant is raised by where growth does not suffice.
constexpr int kBisections = 12;          // Growth to about 0.2 %.
constexpr double kRestartSpread = 0.1;   // Restarts vary the growth by this, as far as the number of vertices allows.
/// f shrinks by this before vertices of a packing move, or they could not.
constexpr double kRoomToMove = 0.8;
/// An improvement may take away vertices down to this part of the wished number.
constexpr double kFewestVertices = 0.85;

[[noreturn]] void throw_bad_option(const std::string& message, const std::string& fix) {
  throw OptionError(Fault{.id = "coarsen.bad_option", .message = message, .fix = fix});
}

void check_options(const BeyondBoundaryOptions& o) {
  if (o.levels < 1) throw_bad_option(fmt::format("levels is {}", o.levels), "take at least 1");
  if (!(o.growth > 1)) throw_bad_option(fmt::format("growth is {}", o.growth), "take more than 1");
  if (o.lipschitz && !(*o.lipschitz > 0 && *o.lipschitz < 1))
    throw_bad_option(fmt::format("the Lipschitz constant is {}", *o.lipschitz), "take a number between 0 and 1");
  if (o.restarts < 1) throw_bad_option(fmt::format("restarts is {}", o.restarts), "take at least 1");
  if (o.trials < 0) throw_bad_option(fmt::format("trials is {}", o.trials), "take at least 0");
  if (!(o.max_area_change > 0 && o.max_area_change < 1))
    throw_bad_option(fmt::format("max_area_change is {}", o.max_area_change), "take a number between 0 and 1");
  if (!(o.feature_angle_deg > 0 && o.feature_angle_deg <= 180))
    throw_bad_option(fmt::format("the feature angle is {}", o.feature_angle_deg), "take 180 degrees or less");
  if (!o.target_vertices.empty() && o.target_vertices.back() == 0)
    throw_bad_option("a level is to have 0 vertices", "take at least 1");
  for (std::size_t i = 1; i < o.target_vertices.size(); ++i)
    if (o.target_vertices[i] >= o.target_vertices[i - 1])
      throw_bad_option("the numbers of vertices do not fall from level to level", "give them from fine to coarse");
}

class Hierarchy {
 public:
  Hierarchy(const Mesh<2>& mesh, const BeyondBoundaryOptions& options, Observer& observer)
      : mesh_(mesh),
        options_(options),
        observer_(observer),
        fine_(find_chains(mesh, options.feature_angle_deg)),
        packer_(mesh, fine_, options.initial, observer) {}

  std::vector<SimplifiedLevel<2>> build() {
    const std::size_t n_levels =
        options_.target_vertices.empty() ? static_cast<std::size_t>(options_.levels) : options_.target_vertices.size();
    std::vector<SimplifiedLevel<2>> levels(n_levels);
    for (std::size_t i = n_levels; i-- > 0;) {
      observer_.progress(n_levels - 1 - i, n_levels);
      std::size_t n_exchanges = 0;
      PlanarPacking packed = make_level(i, n_exchanges);
      levels[i] = finish(packed);
      levels[i].n_exchanges = n_exchanges;
      bound_ = std::move(packed.spacing);
      rungs_ = std::move(packed.rungs);
      kept_.clear();
      for (const VertexId v : levels[i].finest_vertex) kept_.push_back(v.value());
    }
    leave_out_where_nothing_is_gained(levels);
    for (std::size_t i = 0; i < levels.size(); ++i) link_level<2>(mesh_, i == 0 ? nullptr : &levels[i - 1], levels[i]);
    return levels;
  }

 private:
  [[nodiscard]] PackingWish wish(std::size_t i) const {
    PackingWish w;
    w.growth = std::pow(options_.growth, static_cast<double>(i + 1));
    w.lipschitz = options_.lipschitz.value_or(kLipschitz);
    w.kept = kept_;
    w.bound = bound_;
    w.rungs = rungs_;
    w.order = options_.order;
    w.max_area_change = options_.max_area_change;
    return w;
  }

  /// What bounds the change of areas may allow no fewer vertices.
  void leave_out_where_nothing_is_gained(std::vector<SimplifiedLevel<2>>& levels) const {
    std::size_t before = mesh_.points.size();
    std::erase_if(levels, [&](const SimplifiedLevel<2>& level) {
      return level.mesh.points.size() >= std::exchange(before, std::min(before, level.mesh.points.size()));
    });
  }

  /// The packing that comes closest to a number of vertices from below; the smallest one if there is none below.
  [[nodiscard]] PlanarPacking pack_number(PackingWish w, std::size_t n_wanted) const {
    std::optional<PlanarPacking> best;
    for (; !best || best->level.n_vertices() > n_wanted; w.lipschitz *= kLipschitzStep) {
      if (best && w.lipschitz > kMaxLipschitz) break;
      w.growth = kMaxGrowth;
      PlanarPacking packed = packer_.pack(w);
      if (!best || packed.level.n_vertices() < best->level.n_vertices()) best = std::move(packed);
      if (best->level.n_vertices() <= n_wanted) break;
    }
    double low = 0, high = std::log(kMaxGrowth);
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (low + high);
      w.growth = std::exp(middle);
      PlanarPacking packed = packer_.pack(w);
      const std::size_t n = packed.level.n_vertices();
      (n <= n_wanted ? high : low) = middle;
      if (n <= n_wanted && n >= best->level.n_vertices()) best = std::move(packed);
    }
    return std::move(*best);
  }

  /// The best of several packings, each improved.
  [[nodiscard]] PlanarPacking make_level(std::size_t i, std::size_t& n_exchanges) const {
    PackingWish w = wish(i);
    std::optional<std::size_t> n_wanted;
    if (!options_.target_vertices.empty()) n_wanted = options_.target_vertices[i];
    PlanarPacking best = n_wanted ? pack_number(w, *n_wanted) : packer_.pack(w);
    const double growth = best.growth;
    w.lipschitz = best.lipschitz;
    n_exchanges = improve(i, 0, best);
    double quality = worst_quality(best.level);
    for (int k = 1; k < options_.restarts; ++k) {
      w.seed = hash_words(options_.seed, std::uint64_t{i}, static_cast<std::uint64_t>(k)) | 1U;
      if (n_wanted) w.growth = growth * (1 + kRestartSpread * (to_unit(w.seed) - 0.2));
      PlanarPacking other = packer_.pack(w);
      if (n_wanted && other.level.n_vertices() > *n_wanted) continue;
      const std::size_t n = improve(i, static_cast<std::uint64_t>(k), other);
      const double q = worst_quality(other.level);
      if (q <= quality) continue;
      quality = q;
      n_exchanges = n;
      best = std::move(other);
    }
    return best;
  }

  std::size_t improve(std::size_t i, std::uint64_t restart, PlanarPacking& packed) const {
    if (options_.improvement == LocalImprovement::kNone) return 0;
    const std::size_t n = options_.target_vertices.empty() ? packed.level.n_vertices() : options_.target_vertices[i];
    ImprovementWish w;
    w.kept = kept_;
    w.min_vertices = static_cast<std::size_t>(kFewestVertices * static_cast<double>(n));
    w.max_vertices = n;
    w.seed = hash_words(options_.seed, std::uint64_t{i}, restart);
    w.trials = static_cast<std::size_t>(options_.trials);
    w.is_packing_kept = options_.improvement == LocalImprovement::kPacked;
    packed.level.max_area_change = options_.max_area_change;
    if (w.is_packing_kept) shrink(packed, kRoomToMove);
    return improve_level(packer_, w, packed, observer_);
  }

  /// A packing for f is one for any smaller f.
  static void shrink(PlanarPacking& packed, double factor) {
    packed.growth *= factor;
    packed.lipschitz *= factor;
    for (auto* const values : {&packed.spacing, &packed.radius})
      for (double& value : *values) value *= factor;
  }

  [[nodiscard]] SimplifiedLevel<2> finish(const PlanarPacking& packed) const {
    SimplifiedLevel<2> out;
    out.growth = packed.growth;
    out.lipschitz = packed.lipschitz;
    out.area_change = packed.level.area_change();
    out.boundary_distance = packed.level.boundary_distance();
    std::vector<VertexId> place(fine_.points.size());
    for (std::uint32_t v = 0; v < fine_.points.size(); ++v) {
      if (!packed.level.has(v)) continue;
      place[v] = out.finest_vertex.push_back(VertexId(std::size_t{v}));
      out.largest_overlap = std::max(out.largest_overlap, packer_.overlap(packed, v));
    }
    out.mesh = make_mesh(packed, out.finest_vertex, place);
    if (options_.improvement == LocalImprovement::kFree) take_half_distances(out.mesh);
    out.epsilon = measured_epsilon(out.mesh);
    return out;
  }

  /// The nearest vertex shares an edge, or the boundary is in between.
  static void take_half_distances(Mesh<2>& mesh) {
    std::vector<Box<2>> boxes;
    for (const Vec<2>& x : mesh.points) boxes.emplace_back(x, x);
    const BoxTree<2> tree(boxes);
    for (const VertexId v : ids(mesh.points)) {
      const Vec<2>& x = mesh.points[v];
      double nearest = std::numeric_limits<double>::infinity();
      tree.for_each([&](const Box<2>& box) { return box.distance_sq(x) < nearest * nearest; },
                    [&](std::uint32_t w) {
                      if (w != v.value()) nearest = std::min(nearest, distance(x, mesh.points[VertexId(w)]));
                    });
      mesh.vertex_spacing[v] = 0.5 * nearest;
    }
  }

  [[nodiscard]] Mesh<2> make_mesh(const PlanarPacking& packed, const IdVector<VertexId, VertexId>& finest,
                                  const std::vector<VertexId>& place) const {
    Mesh<2> out;
    for (const VertexId v : finest) {
      out.points.push_back(mesh_.points[v]);
      out.vertex_spacing.push_back(packed.radius[v.value()]);
      out.vertex_marker.push_back(mesh_.vertex_marker.empty() ? 0 : mesh_.vertex_marker[v]);
      const bool is_inner = !fine_.on_boundary(v.value()) && fine_.is_anchor[v.value()] == 0;
      out.vertex_carrier_dimension.push_back(is_inner ? 2 : 0);
    }
    const EditableTriangulation& t = packed.level.triangulation();
    std::vector<std::pair<std::array<VertexId, 3>, int>> triangles;
    for (std::uint32_t slot = 0; slot < t.n_slots(); ++slot) {
      if (!t.is_alive(slot) || packed.level.region(slot) == kOutside) continue;
      std::array<VertexId, 3> c;
      for (std::size_t k = 0; k < 3; ++k) c[k] = place[t.triangle(slot).corners[k]];
      std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
      triangles.push_back({c, fine_.region_id[static_cast<std::size_t>(packed.level.region(slot))]});
    }
    std::sort(triangles.begin(), triangles.end());
    for (const auto& [corners, region] : triangles) {
      out.simplex_vertices.push_back(corners);
      out.simplex_region.push_back(region);
    }
    packed.level.for_each_edge([&](const ChainPlace& at) {
      const VertexChain& chain = fine_.chains[at.chain];
      out.boundary_vertices.push_back(
          {place[chain.vertices[at.position]], place[chain.vertices[packed.level.next(at)]]});
      out.boundary_marker.push_back(chain.marker);
    });
    build_neighbors(out);
    return out;
  }

  const Mesh<2>& mesh_;
  const BeyondBoundaryOptions& options_;
  Observer& observer_;
  ChainedMesh fine_;
  PlanarPacker packer_;
  std::vector<std::uint32_t> kept_;   ///< The level before, which is the next coarser one,
  std::vector<double> bound_;         ///< its spacing,
  std::vector<std::uint32_t> rungs_;  ///< and its vertices beside tips.
};

}  // namespace

template <>
std::vector<SimplifiedLevel<2>> coarsen_beyond_boundary<2>(const Mesh<2>& mesh, const BeyondBoundaryOptions& options,
                                                           Observer& observer) {
  check_options(options);
  require_delaunay(mesh);
  observer.begin_stage("coarsen");
  return Hierarchy(mesh, options, observer).build();
}

template <>
std::vector<SimplifiedLevel<3>> coarsen_beyond_boundary<3>(const Mesh<3>& mesh, const BeyondBoundaryOptions& options,
                                                           Observer& observer) {
  check_options(options);
  require_delaunay(mesh);
  observer.begin_stage("coarsen");
  return make_space_hierarchy(mesh, options, observer);
}

}  // namespace voropack
