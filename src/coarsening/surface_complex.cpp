#include "coarsening/surface_complex.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "geom/distance.h"
#include "geom/predicates.h"
#include "geom/tolerance.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"

namespace voropack {

namespace {

class SurfaceFinder {
 public:
  SurfaceFinder(const Mesh<3>& mesh, const SurfaceWish& wish) : mesh_(mesh), wish_(wish) {}

  SurfaceComplex run() {
    number_vertices();
    find_regions();
    add_triangles();
    number_patches();
    find_curves();
    if (wish_.merge_markers) merge_markers();
    return std::move(out_);
  }

 private:
  static constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] std::uint32_t place(VertexId v) const { return place_[v.value()]; }

  void number_vertices() {
    std::vector<std::uint8_t> is_used(mesh_.points.size(), 0);
    for (const auto& face : mesh_.boundary_vertices)
      for (const VertexId v : face) is_used[v.value()] = 1;
    for (const auto& edge : mesh_.segment_edges)
      for (const VertexId v : edge) is_used[v.value()] = 1;
    if (!mesh_.vertex_carrier_dimension.empty())
      for (const auto& corners : mesh_.simplex_vertices)
        for (const VertexId v : corners)
          if (mesh_.vertex_carrier_dimension[v] < 3) is_used[v.value()] = 1;
    place_.assign(mesh_.points.size(), kAbsent);
    for (const VertexId v : ids(mesh_.points)) {
      if (is_used[v.value()] == 0) continue;
      place_[v.value()] = static_cast<std::uint32_t>(out_.vertex.size());
      out_.vertex.push_back(v);
      out_.points.push_back(mesh_.points[v]);
    }
  }

  void find_regions() {
    std::map<int, double> volumes;
    for (const SimplexId s : ids(mesh_.simplex_vertices)) {
      const auto& c = mesh_.simplex_vertices[s];
      const Vec<3> o = mesh_.points[c[0]];
      volumes[mesh_.simplex_region[s]] +=
          dot(mesh_.points[c[1]] - o, cross(mesh_.points[c[2]] - o, mesh_.points[c[3]] - o)) / 6;
    }
    for (const auto& [id, volume] : volumes) {
      out_.region_id.push_back(id);
      out_.region_volume.push_back(volume);
    }
    out_.region_boundary_area.assign(volumes.size(), 0);
  }

  [[nodiscard]] int region_index(int id) const {
    return static_cast<int>(std::lower_bound(out_.region_id.begin(), out_.region_id.end(), id) -
                            out_.region_id.begin());
  }

  void add_triangles() {
    VertexSetTable<3> table(mesh_.boundary_vertices.size());
    for (const BoundaryId f : ids(mesh_.boundary_vertices)) {
      const auto& face = mesh_.boundary_vertices[f];
      SurfaceTriangle t{{place(face[0]), place(face[1]), place(face[2])}, {kNoRegion, kNoRegion}, 0, 0};
      if (!mesh_.boundary_marker.empty()) t.marker = mesh_.boundary_marker[f];
      if (table.insert(face, static_cast<std::uint32_t>(out_.triangles.size())) == VertexSetTable<3>::kAbsent)
        out_.triangles.push_back(t);
    }
    for (const SimplexId s : ids(mesh_.simplex_vertices))
      for (int i = 0; i < 4; ++i) {
        const std::array<VertexId, 3> face = face_vertices<3>(mesh_, s, i);
        if (std::ranges::any_of(face, [&](VertexId v) { return place(v) == kAbsent; })) continue;
        const std::uint32_t t = table.find(face);
        if (t == VertexSetTable<3>::kAbsent) continue;
        const auto& c = out_.triangles[t].corners;
        const Vec<3>& apex = mesh_.points[mesh_.simplex_vertices[s][static_cast<std::size_t>(i)]];
        const bool is_along = orientation(out_.points[c[0]], out_.points[c[1]], out_.points[c[2]], apex) > 0;
        out_.triangles[t].regions[is_along ? 0 : 1] = region_index(mesh_.simplex_region[s]);
      }
    for (SurfaceTriangle& t : out_.triangles) {
      if (t.regions[0] < t.regions[1]) {
        std::swap(t.regions[0], t.regions[1]);
        std::swap(t.corners[1], t.corners[2]);
      }
      const double area = 0.5 * norm(normal_of(t));
      for (const int r : t.regions)
        if (r != kNoRegion) out_.region_boundary_area[static_cast<std::size_t>(r)] += area;
    }
  }

  [[nodiscard]] Vec<3> normal_of(const SurfaceTriangle& t) const {
    const Vec<3>& a = out_.points[t.corners[0]];
    return cross(out_.points[t.corners[1]] - a, out_.points[t.corners[2]] - a);
  }

  void number_patches() {
    std::map<std::array<int, 3>, std::uint32_t> number;
    for (SurfaceTriangle& t : out_.triangles) {
      const std::array<int, 3> key = {t.regions[0], t.regions[1], wish_.merge_markers ? 0 : t.marker};
      t.patch = number.try_emplace(key, static_cast<std::uint32_t>(number.size())).first->second;
    }
  }

  struct Edge {
    EdgeEnds ends;
    std::uint32_t triangle;
    friend auto operator<=>(const Edge&, const Edge&) = default;
  };

  void find_curves() {
    std::vector<Edge> edges;
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& c = out_.triangles[t].corners;
        edges.push_back({ends_of(c[i], c[(i + 1) % 3]), t});
      }
    // Listed edges, as if they had one triangle more.
    std::map<EdgeEnds, int> listed;
    for (const EdgeId e : ids(mesh_.segment_edges)) {
      const EdgeEnds ends = ends_of(place(mesh_.segment_edges[e][0]), place(mesh_.segment_edges[e][1]));
      listed.emplace(ends, mesh_.segment_edge_marker.empty() ? 0 : mesh_.segment_edge_marker[e]);
      edges.push_back({ends, kAbsent});
    }
    parallel_sort(edges.begin(), edges.end());
    std::vector<std::uint32_t> around;
    for (std::size_t i = 0; i < edges.size();) {
      around.clear();
      bool is_listed = false;
      std::size_t end = i;
      for (; end < edges.size() && edges[end].ends == edges[i].ends; ++end)
        if (edges[end].triangle == kAbsent)
          is_listed = true;
        else
          around.push_back(edges[end].triangle);
      if (is_curve(edges[i].ends, around, is_listed))
        add_curve_edge(edges[i].ends, around, is_listed ? listed.at(edges[i].ends) : 0);
      i = end;
    }
  }

  /// What is joined gets the marker that covers most of it.
  void merge_markers() {
    std::set<EdgeEnds> curves;
    for (const CurveEdge& e : out_.edges) curves.insert(e.ends);
    std::map<EdgeEnds, std::uint32_t> beside;
    DisjointSets sets(out_.triangles.size());
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& c = out_.triangles[t].corners;
        const EdgeEnds ends = ends_of(c[i], c[(i + 1) % 3]);
        if (curves.contains(ends)) continue;
        const auto [it, is_new] = beside.try_emplace(ends, t);
        if (!is_new) sets.join(it->second, t);
      }
    std::map<std::uint32_t, std::map<int, double>> areas;
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t)
      areas[sets.find(t)][out_.triangles[t].marker] += norm(normal_of(out_.triangles[t]));
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t)
      out_.triangles[t].marker =
          std::ranges::max_element(areas[sets.find(t)], {}, [](const auto& entry) { return entry.second; })->first;
  }

  [[nodiscard]] bool is_curve(const EdgeEnds& ends, const std::vector<std::uint32_t>& around, bool is_listed) const {
    if (around.size() != 2) return true;
    const SurfaceTriangle &s = out_.triangles[around[0]], &t = out_.triangles[around[1]];
    if (s.patch != t.patch) return true;
    // Both normals on the same side: the triangles pass their edge in opposite directions.
    const auto is_forward = [&](const SurfaceTriangle& triangle) {
      const auto at = static_cast<std::size_t>(std::ranges::find(triangle.corners, ends[0]) - triangle.corners.begin());
      return triangle.corners[(at + 1) % 3] == ends[1];
    };
    const Vec<3> other = is_forward(s) != is_forward(t) ? normal_of(t) : -normal_of(t);
    const double turn = angle_between(normal_of(s), other);
    return turn > wish_.feature_angle_deg * std::numbers::pi / 180 || (is_listed && turn < kCoplanarAngle);
  }

  void add_curve_edge(const EdgeEnds& ends, const std::vector<std::uint32_t>& around, int marker) {
    std::vector<std::uint32_t> key;
    for (const std::uint32_t t : around) key.push_back(out_.triangles[t].patch);
    std::sort(key.begin(), key.end());
    // Segments that bound facets go by what these are; others have nothing but their marker.
    if (around.empty() && !wish_.merge_markers) key = {kAbsent, static_cast<std::uint32_t>(marker)};
    const std::uint32_t curve = curves_.try_emplace(key, static_cast<std::uint32_t>(curves_.size())).first->second;
    out_.edges.push_back({ends, marker, curve});
  }

  const Mesh<3>& mesh_;
  const SurfaceWish& wish_;
  std::vector<std::uint32_t> place_;  ///< By vertex of the mesh.
  std::map<std::vector<std::uint32_t>, std::uint32_t> curves_;
  SurfaceComplex out_;
};

}  // namespace

SurfaceComplex find_surface(const Mesh<3>& mesh, const SurfaceWish& wish) { return SurfaceFinder(mesh, wish).run(); }

}  // namespace voropack
