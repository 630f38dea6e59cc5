#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "geom/box_tree.h"
#include "geom/polytope_distance.h"
#include "geom/tolerance.h"
#include "voropack/error.h"
#include "voropack/mesh_domain.h"

namespace voropack {

namespace {

/// The regions of mesh and domain may differ in size by this, relative to the region: by what boundaries may be off.
constexpr double kMeasureTolerance = 1e-4;

template <int D>
std::string text_of(const Vec<D>& x) {
  return fmt::format("({})", fmt::join(x.coord, ", "));
}

/// A tree over some of the vertices.
template <int D>
struct VertexTree {
  std::vector<VertexId> vertices;
  BoxTree<D> tree;

  VertexTree(const Mesh<D>& mesh, std::vector<VertexId> some) : vertices(std::move(some)) {
    std::vector<Box<D>> boxes;
    boxes.reserve(vertices.size());
    for (const VertexId v : vertices) boxes.emplace_back(mesh.points[v], mesh.points[v]);
    tree = BoxTree<D>(boxes);
  }

  template <class Visit>
  void for_each_near(Box<D> around, double reach, Visit&& visit) const {
    around.inflate(reach);
    tree.for_each([&](const Box<D>& box) { return box.overlaps(around); },
                  [&](std::uint32_t i) { visit(vertices[i]); });
  }
};

template <int D>
std::vector<VertexId> boundary_vertices(const Mesh<D>& mesh) {
  std::vector<std::uint8_t> is_on(mesh.points.size(), 0);
  for (const auto& face : mesh.boundary_vertices)
    for (const VertexId v : face) is_on[v.value()] = 1;
  for (const auto& edge : mesh.segment_edges)
    for (const VertexId v : edge) is_on[v.value()] = 1;
  std::vector<VertexId> vertices;
  for (const VertexId v : ids(mesh.points))
    if (is_on[v.value()] != 0) vertices.push_back(v);
  return vertices;
}

template <int D>
class Placer {
 public:
  Placer(const Mesh<D>& mesh, Domain<D> domain, double tolerance)
      : mesh_(mesh), boundary_(mesh, boundary_vertices(mesh)), tolerance_(tolerance) {
    result_.domain = std::move(domain);
    result_.carrier.resize(mesh.points.size(), PolytopeId(D, 0));
    tolerance_ += absolute_tolerance(result_.domain.box, kOnTolerance);
  }

  MeshDomain<D> run() {
    check_regions();
    find_points();
    if constexpr (D == 3) place_on_facets();
    place_on_segments();
    for (const PointId p : ids(vertex_of_)) result_.carrier[vertex_of_[p]] = PolytopeId(p);
    check_boundary();
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& message, const Vec<D>* x = nullptr) const {
    throw InputError(fault(message, x));
  }
  [[nodiscard]] Fault fault(const std::string& message, const Vec<D>* x) const {
    Fault fault{.id = "mesh.other_domain",
                .message = message,
                .fix = "give the domain that the mesh is one of; --merge-distance D if its boundary is off by up to D.",
                .file = result_.domain.file};
    if (x != nullptr) fault.position = {x->coord.begin(), x->coord.end()};
    return fault;
  }

  /// Where the mesh says on polytopes of which dimension its vertices are, it is believed.
  [[nodiscard]] bool may_be_on(VertexId v, int dimension) const {
    return mesh_.vertex_carrier_dimension.empty() || mesh_.vertex_carrier_dimension[v] == dimension;
  }

  [[nodiscard]] double measure(SimplexId s) const {
    const auto& v = mesh_.simplex_vertices[s];
    const Vec<D> a = mesh_.points[v[0]], u = mesh_.points[v[1]] - a, w = mesh_.points[v[2]] - a;
    if constexpr (D == 2)
      return cross(u, w) / 2;
    else
      return dot(u, cross(w, mesh_.points[v[3]] - a)) / 6;
  }

  void check_regions() const {
    using Measures = std::map<int, double>;
    const Measures mine = parallel_reduce_ordered(
        mesh_.simplex_vertices.size(), 65536, Measures{},
        [&](std::size_t begin, std::size_t end) {
          Measures sums;
          for (std::size_t s = begin; s < end; ++s) sums[mesh_.simplex_region[SimplexId(s)]] += measure(SimplexId(s));
          return sums;
        },
        [](Measures all, const Measures& some) {
          for (const auto& [region, sum] : some) all[region] += sum;
          return all;
        });
    Measures theirs;
    for (const RegionId r : ids(result_.domain.region_id))
      theirs[result_.domain.region_id[r]] += result_.domain.region_measure[r];
    for (const auto& [region, sum] : theirs) {
      const auto it = mine.find(region);
      const double own = it == mine.end() ? 0 : it->second;
      if (!(std::abs(own - sum) <= kMeasureTolerance * sum))
        refuse(fmt::format("region {} has the measure {:.6g} in the domain and {:.6g} in the mesh", region, sum, own));
    }
    for (const auto& [region, sum] : mine)
      if (!theirs.contains(region)) refuse(fmt::format("region {} of the mesh is none of the domain's", region));
  }

  void find_points() {
    std::vector<Fault> faults;
    std::optional<VertexTree<D>> all;  // A point inside a region is on no face.
    for (const PointId p : ids(result_.domain.points)) {
      Vec<D>& x = result_.domain.points[p];
      VertexId nearest = nearest_vertex(boundary_, x);
      if (nearest.is_none()) {
        if (!all) {
          std::vector<VertexId> every;
          for (const VertexId v : ids(mesh_.points)) every.push_back(v);
          all.emplace(mesh_, std::move(every));
        }
        nearest = nearest_vertex(*all, x);
      }
      if (!nearest.is_none())
        x = mesh_.points[nearest];
      else if (faults.size() < kMaxFaults)
        faults.push_back(
            fault(fmt::format("the domain has a point at {}, where the mesh has no vertex", text_of(x)), &x));
      vertex_of_.push_back(nearest);
    }
    if (!faults.empty()) throw InputError(std::move(faults));
  }

  [[nodiscard]] VertexId nearest_vertex(const VertexTree<D>& tree, const Vec<D>& x) const {
    VertexId nearest = VertexId::none();
    double least_sq = tolerance_ * tolerance_;
    tree.for_each_near(Box<D>(x, x), tolerance_, [&](VertexId v) {
      const double d = distance_sq(x, mesh_.points[v]);
      if (d <= least_sq && may_be_on(v, 0)) least_sq = d, nearest = v;
    });
    return nearest;
  }

  void place_on_segments() {
    for (const SegmentId s : ids(result_.domain.segments)) {
      const auto [p, q] = result_.domain.segments[s];
      const Vec<D> a = result_.domain.points[p], b = result_.domain.points[q];
      std::vector<std::pair<double, VertexId>> row;
      Box<D> box(a, a);
      box.add(b);
      boundary_.for_each_near(box, tolerance_, [&](VertexId v) {
        const Vec<D>& x = mesh_.points[v];
        if (v != vertex_of_[p] && v != vertex_of_[q] && may_be_on(v, 1) && distance_to_segment(x, a, b) <= tolerance_)
          row.push_back({dot(x - a, b - a), v});
      });
      std::sort(row.begin(), row.end());
      std::vector<VertexId> chain = {vertex_of_[p]};
      for (const auto& [at, v] : row) {
        chain.push_back(v);
        result_.carrier[v] = PolytopeId(s);
      }
      chain.push_back(vertex_of_[q]);
      result_.segment_chains.push_row(chain);
    }
  }

  /// On the nearest one, where several are near.
  void place_on_facets() requires(D == 3) {
    const Domain<3>& domain = result_.domain;
    std::vector<double> least(mesh_.points.size(), tolerance_);
    for (const FacetId f : ids(domain.facet_frame))
      for (const auto& [p, q, r] : domain.facet_triangles[f]) {
        const Vec<3> a = domain.points[p], b = domain.points[q], c = domain.points[r];
        Box<3> box(a, a);
        box.add(b);
        box.add(c);
        boundary_.for_each_near(box, tolerance_, [&](VertexId v) {
          if (!may_be_on(v, 2)) return;
          const double d = distance_to_triangle(mesh_.points[v], a, b, c);
          if (d > least[v.value()]) return;
          least[v.value()] = d;
          result_.carrier[v] = PolytopeId(f);
        });
      }
  }

  void check_boundary() const {
    for (const VertexId v : boundary_.vertices)
      if (result_.carrier[v].dimension == D)
        refuse(fmt::format("the boundary of the mesh has a vertex at {}, which is not on that of the domain",
                           text_of(mesh_.points[v])),
               &mesh_.points[v]);
  }

  const Mesh<D>& mesh_;
  VertexTree<D> boundary_;
  double tolerance_;
  IdVector<PointId, VertexId> vertex_of_;
  MeshDomain<D> result_;
};

}  // namespace

template <int D>
MeshDomain<D> place_in_domain(const Mesh<D>& mesh, Domain<D> domain, double tolerance, Observer& observer) {
  observer.begin_stage("domain");
  return Placer<D>(mesh, std::move(domain), tolerance).run();
}

template MeshDomain<2> place_in_domain(const Mesh<2>&, Domain<2>, double, Observer&);
template MeshDomain<3> place_in_domain(const Mesh<3>&, Domain<3>, double, Observer&);

}  // namespace voropack
