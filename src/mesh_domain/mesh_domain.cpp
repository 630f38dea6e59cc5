#include "voropack/mesh_domain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "geom/tolerance.h"
#include "mesh/extent.h"
#include "mesh/faces.h"
#include "mesh_domain/boundary_complex.h"
#include "mesh_domain/boundary_zone.h"

namespace voropack {

namespace {

/// How far the seed of a hole lies off its border, relative to the nearest edge or face.
constexpr double kSeedOffset = 1e-3;

template <int D>
class DomainMaker {
 public:
  explicit DomainMaker(const Mesh<D>& mesh) : mesh_(mesh), zone_(mesh) {
    Box<D> box;
    for (const Vec<D>& x : mesh.points) box.add(x);
    tolerance_ = absolute_tolerance(box, kOnTolerance);
    complex_ = find_boundary_complex(mesh, zone_, tolerance_);
  }

  MeshDomain<D> run(Observer& observer) {
    DomainInput<D> input;
    add_points(input);
    add_segments(input);
    if constexpr (D == 3) add_facets(input);
    add_region_seeds(input);
    add_hole_seeds(input);
    DomainOptions options;
    options.merge_coplanar = false;
    options.merge_distance = 0;
    MeshDomain<D> result;
    result.domain = build_domain(input, options, observer);
    take_coordinates(result.domain);
    find_carriers(result);
    return result;
  }

 private:
  void add_points(DomainInput<D>& input) {
    for (const VertexId v : complex_.corners) {
      point_of_[v] = static_cast<std::uint32_t>(input.points.size());
      input.points.push_back(mesh_.points[v]);
      input.point_markers.push_back(mesh_.vertex_marker.empty() ? 0 : mesh_.vertex_marker[v]);
    }
  }

  void add_segments(DomainInput<D>& input) {
    for (const BoundaryChain& chain : complex_.chains)
      input.segments.push_back(
          {{point_of_.at(chain.vertices.front()), point_of_.at(chain.vertices.back())}, chain.marker, std::nullopt});
  }

  void add_facets(DomainInput<3>& input) requires(D == 3) {
    std::set<VertexId> loose(complex_.corners.begin(), complex_.corners.end());
    for (const BoundaryChain& chain : complex_.chains)
      for (const VertexId v : chain.vertices) loose.erase(v);
    for (const BoundaryPatch& patch : complex_.patches) {
      typename DomainInput<3>::Facet facet;
      facet.marker = patch.marker;
      for (const std::vector<VertexId>& cycle : cycles_of(patch.outline)) {
        std::vector<std::uint32_t> polygon;
        for (const VertexId v : cycle)
          if (const auto it = point_of_.find(v); it != point_of_.end()) polygon.push_back(it->second);
        facet.polygons.push_back(std::move(polygon));
        if (turns_clockwise(cycle, patch.normal)) facet.holes.push_back(beside(cycle, patch));
      }
      std::set<std::array<std::uint32_t, 2>> inner;
      for (const auto& [a, b] : patch.inner_feature_edges) inner.insert(chain_ends(a, b));
      for (const auto& ends : inner) facet.polygons.push_back({ends[0], ends[1]});
      if (!loose.empty())
        for (const auto& face : patch.faces)
          for (const VertexId v : face)
            if (loose.erase(v) > 0) facet.polygons.push_back({point_of_.at(v)});
      input.facets.push_back(std::move(facet));
    }
  }

  /// Directed edges as closed walks that pass no vertex twice.
  static std::vector<std::vector<VertexId>> cycles_of(const std::vector<std::array<VertexId, 2>>& edges) {
    std::multimap<VertexId, VertexId> next;
    for (const auto& [a, b] : edges) next.emplace(a, b);
    std::vector<std::vector<VertexId>> cycles;
    while (!next.empty()) {
      std::vector<VertexId> walk = {next.begin()->first};
      std::map<VertexId, std::size_t> place = {{walk[0], 0}};
      for (;;) {
        const auto it = next.find(walk.back());
        if (it == next.end()) break;
        const VertexId v = it->second;
        next.erase(it);
        const auto seen = place.find(v);
        if (seen == place.end()) {
          place[v] = walk.size();
          walk.push_back(v);
          continue;
        }
        const auto begin = walk.begin() + static_cast<std::ptrdiff_t>(seen->second);
        cycles.emplace_back(begin, walk.end());
        for (auto w = begin + 1; w != walk.end(); ++w) place.erase(*w);
        walk.erase(begin + 1, walk.end());
        if (walk.size() == 1 && next.find(walk[0]) == next.end()) break;
      }
    }
    return cycles;
  }

  [[nodiscard]] bool turns_clockwise(const std::vector<VertexId>& cycle, const Vec<3>& normal) const requires(D == 3) {
    Vec<3> area;
    const Vec<3> origin = mesh_.points[cycle[0]];
    for (std::size_t i = 1; i + 1 < cycle.size(); ++i)
      area += cross(mesh_.points[cycle[i]] - origin, mesh_.points[cycle[i + 1]] - origin);
    return dot(area, normal) < 0;
  }

  /// A point beside the longest edge of a cycle, to its right: out of the patch.
  [[nodiscard]] Vec<3> beside(const std::vector<VertexId>& cycle, const BoundaryPatch& patch) const requires(D == 3) {
    Vec<3> best;
    double longest = 0;
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const Vec<3> a = mesh_.points[cycle[i]], b = mesh_.points[cycle[(i + 1) % cycle.size()]];
      const double length = distance(a, b);
      if (length <= longest) continue;
      longest = length;
      const Vec<3> outward = cross(b - a, patch.normal);
      best = 0.5 * (a + b) + (kSeedOffset * length / norm(outward)) * outward;
    }
    return best;
  }

  /// The ends, as points of the input, of the chain that an edge is a part of.
  std::array<std::uint32_t, 2> chain_ends(VertexId a, VertexId b) {
    if (chain_of_edge_.empty())
      for (std::uint32_t c = 0; c < complex_.chains.size(); ++c) {
        const std::vector<VertexId>& row = complex_.chains[c].vertices;
        for (std::size_t i = 0; i + 1 < row.size(); ++i)
          chain_of_edge_[{std::min(row[i], row[i + 1]), std::max(row[i], row[i + 1])}] = c;
      }
    const BoundaryChain& chain = complex_.chains[chain_of_edge_.at({std::min(a, b), std::max(a, b)})];
    return {point_of_.at(chain.vertices.front()), point_of_.at(chain.vertices.back())};
  }

  /// One seed in each part of the mesh that boundary faces enclose: in a large simplex.
  void add_region_seeds(DomainInput<D>& input) const {
    for (const Part& part : find_parts()) {
      Vec<D> center;
      for (const VertexId v : mesh_.simplex_vertices[part.large]) center += mesh_.points[v] / (D + 1.0);
      input.region_seeds.push_back({center, mesh_.simplex_region[part.large], std::nullopt});
    }
  }

  struct Part {
    SimplexId first;
    SimplexId large;  ///< The largest of some, or of all if they are few.
    double size = 0;  ///< Of that one.
    int n_measured = 0;
  };

  /// The face of a simplex opposite to a corner.
  struct Crossing {
    SimplexId simplex;
    int corner;
  };

  /// In the order of their first simplices.
  ///
  /// All simplices around a vertex off the walls are in one part, and only those between walls stand for themselves. So
  /// only across faces with all corners on walls it has to be seen whether there is one.
  [[nodiscard]] std::vector<Part> find_parts() const {
    const std::size_t n = mesh_.points.size();
    const auto is_off = [&](VertexId v) { return zone_.is_on[v.value()] == 0; };
    const std::vector<Crossing> crossings = faces_on_walls(is_off);
    std::map<SimplexId, std::uint32_t> between_walls;
    for (const Crossing& crossing : crossings)
      if (std::ranges::none_of(mesh_.simplex_vertices[crossing.simplex], is_off))
        between_walls.emplace(crossing.simplex, static_cast<std::uint32_t>(n + between_walls.size()));
    const auto member = [&](SimplexId s) {
      const auto& corners = mesh_.simplex_vertices[s];
      const auto off = std::ranges::find_if(corners, is_off);
      return off != corners.end() ? off->value() : between_walls.at(s);
    };
    DisjointSets sets(n + between_walls.size());
    parallel_for(mesh_.simplex_vertices.size(), [&](std::size_t s) {
      const auto& corners = mesh_.simplex_vertices[SimplexId(s)];
      const auto first = std::ranges::find_if(corners, is_off);
      for (auto v = first; v != corners.end(); ++v)
        if (v != first && is_off(*v)) sets.join(first->value(), v->value());
    });
    for (const auto& [s, corner] : crossings) {
      const SimplexId t = neighbor_in_region(mesh_, s, corner);
      const bool is_wall = zone_.faces.find(face_vertices<D>(mesh_, s, corner)) != zone_.faces.kAbsent;
      if (!t.is_none() && !is_wall) sets.join(member(s), member(t));
    }
    return list_parts([&](SimplexId s) { return sets.find(member(s)); });
  }

  /// Those with no corner off the walls.
  template <class IsOff>
  [[nodiscard]] std::vector<Crossing> faces_on_walls(IsOff&& is_off) const {
    return zone_.template collect<Crossing>([&](SimplexId s, std::vector<Crossing>& out) {
      const auto& corners = mesh_.simplex_vertices[s];
      const auto n_off = std::ranges::count_if(corners, is_off);
      for (int i = 0; i <= D; ++i)
        if (n_off == 0 || is_off(corners[static_cast<std::size_t>(i)])) out.push_back({s, i});
    });
  }

  /// part_of(simplex) is some number that all simplices of a part have.
  template <class PartOf>
  [[nodiscard]] std::vector<Part> list_parts(PartOf&& part_of) const {
    constexpr int kMeasuredInBlock = 64;
    using Parts = std::map<std::uint32_t, Part>;
    const auto take = [](Part& part, const Part& other) {
      if (part.first.is_none()) part.first = other.first;
      if (part.large.is_none() || other.size > part.size) part.large = other.large, part.size = other.size;
      part.n_measured += other.n_measured;
    };
    const Parts all = parallel_reduce_ordered(
        mesh_.simplex_vertices.size(), 65536, Parts{},
        [&](std::size_t begin, std::size_t end) {
          Parts parts;
          std::uint32_t number = 0;
          Part* part = nullptr;  // Mostly that of the simplex before.
          for (std::size_t i = begin; i < end; ++i) {
            const SimplexId s(i);
            if (const std::uint32_t other = part_of(s); part == nullptr || other != number)
              part = &parts[number = other];
            if (part->n_measured < kMeasuredInBlock) take(*part, {s, s, measure(s), 1});
          }
          return parts;
        },
        [&](Parts some, const Parts& more) {
          for (const auto& [number, part] : more) take(some[number], part);
          return some;
        });
    std::vector<Part> sorted;
    for (const auto& [number, part] : all) sorted.push_back(part);
    std::ranges::sort(sorted, {}, &Part::first);
    return sorted;
  }

  [[nodiscard]] double measure(SimplexId s) const {
    const auto& v = mesh_.simplex_vertices[s];
    const Vec<D> a = mesh_.points[v[0]], u = mesh_.points[v[1]] - a, w = mesh_.points[v[2]] - a;
    if constexpr (D == 2)
      return cross(u, w);
    else
      return dot(u, cross(w, mesh_.points[v[3]] - a));
  }

  /// One seed in each void: hull faces that are joined at their ridges and enclose a negative volume surround one.
  void add_hole_seeds(DomainInput<D>& input) const {
    struct HullFace {
      std::array<VertexId, D> vertices;
    };
    const auto hull = zone_.template collect<HullFace>([&](SimplexId s, std::vector<HullFace>& faces) {
      for (int i = 0; i <= D; ++i)
        if (mesh_.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none())
          faces.push_back({boundary_face<D>(mesh_.simplex_vertices[s], i)});
    });
    DisjointSets shells(hull.size());
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    IdVector<VertexId, std::uint32_t> last(mesh_.points.size(), kNone);
    for (std::uint32_t f = 0; f < hull.size(); ++f)
      for (const VertexId v : hull[f].vertices)
        if (const std::uint32_t before = std::exchange(last[v], f); before != kNone) shells.join(before, f);
    std::map<std::uint32_t, double> volume;
    std::map<std::uint32_t, std::pair<double, Vec<D>>> seed;
    const Vec<D> origin = mesh_.points[VertexId(0)];
    for (std::uint32_t f = 0; f < hull.size(); ++f) {
      const std::uint32_t root = shells.find(f);
      const Vec<D> a = mesh_.points[hull[f].vertices[0]], b = mesh_.points[hull[f].vertices[1]];
      Vec<D> outward, center;
      for (const VertexId v : hull[f].vertices) center += mesh_.points[v] / static_cast<double>(D);
      if constexpr (D == 2)
        outward = {b[1] - a[1], a[0] - b[0]};
      else
        outward = cross(b - a, mesh_.points[hull[f].vertices[2]] - a);
      volume[root] += dot(center - origin, outward);
      auto& [size, place] = seed[root];
      if (const double mine = norm(outward); mine > size) {
        size = mine;
        place = center + (kSeedOffset * std::pow(mine, 1.0 / (D - 1)) / mine) * outward;
      }
    }
    for (const auto& [root, sum] : volume)
      if (sum < 0) input.hole_seeds.push_back(seed.at(root).second);
  }

  /// Facets are flat up to the tolerance, so that the domain may have moved points by so much; vertices stay where they
  /// are.
  void take_coordinates(Domain<D>& domain) const {
    bool same = domain.points.size() == complex_.corners.size() && domain.segments.size() == complex_.chains.size() &&
                (D == 2 || domain.facet_frame.size() == complex_.patches.size());
    for (std::size_t i = 0; same && i < complex_.corners.size(); ++i)
      same = distance(domain.points[PointId(i)], mesh_.points[complex_.corners[i]]) <= tolerance_;
    if (!same)
      throw InputError(Fault{.id = "mesh.boundary",
                             .message = "the boundary of the mesh is no piecewise linear system: polytopes of it touch "
                                        "or overlap without common vertices",
                             .fix = "make the mesh conform to its boundary; `voropack check` names the places"});
    for (std::size_t i = 0; i < complex_.corners.size(); ++i)
      domain.points[PointId(i)] = mesh_.points[complex_.corners[i]];
    domain.merge.reset();
  }

  void find_carriers(MeshDomain<D>& result) const {
    IdVector<VertexId, PolytopeId>& carrier = result.carrier;
    carrier.resize(mesh_.points.size(), PolytopeId(D, 0));
    for (std::size_t f = 0; f < complex_.patches.size(); ++f)
      for (const auto& face : complex_.patches[f].faces)
        for (const VertexId v : face) carrier[v] = PolytopeId(2, f);
    std::map<std::array<PointId, 2>, const BoundaryChain*> chain_of;
    for (const BoundaryChain& chain : complex_.chains) {
      const PointId a(point_of_.at(chain.vertices.front())), b(point_of_.at(chain.vertices.back()));
      chain_of[{std::min(a, b), std::max(a, b)}] = &chain;
    }
    for (const SegmentId s : ids(result.domain.segments)) {
      const auto [a, b] = result.domain.segments[s];
      std::vector<VertexId> row = chain_of.at({std::min(a, b), std::max(a, b)})->vertices;
      if (point_of_.at(row.front()) != a.value()) std::reverse(row.begin(), row.end());
      for (const VertexId v : row) carrier[v] = PolytopeId(s);
      result.segment_chains.push_row(row);
    }
    for (std::size_t p = 0; p < complex_.corners.size(); ++p) carrier[complex_.corners[p]] = PolytopeId(PointId(p));
  }

  const Mesh<D>& mesh_;
  BoundaryZone<D> zone_;
  double tolerance_ = 0;  ///< How far vertices may be off a polytope that they are on.
  BoundaryComplex<D> complex_;
  std::map<VertexId, std::uint32_t> point_of_;  ///< Of the corners.
  std::map<std::array<VertexId, 2>, std::uint32_t> chain_of_edge_;
};

}  // namespace

template <int D>
MeshDomain<D> domain_of(const Mesh<D>& mesh, Observer& observer) {
  observer.begin_stage("domain");
  check_extent(mesh);
  return DomainMaker<D>(mesh).run(observer);
}

template MeshDomain<2> domain_of(const Mesh<2>&, Observer&);
template MeshDomain<3> domain_of(const Mesh<3>&, Observer&);

}  // namespace voropack
