#include "io/mesh_assembly.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <limits>

#include "base/parallel.h"
#include "geom/predicates.h"
#include "io/source.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"

namespace voropack::io {

namespace {

template <std::size_t K>
std::string element_text(const Listing<K>& listing, std::string_view kind, std::size_t i) {
  std::string text = fmt::format("{} {} (vertices", kind, i + listing.first_number);
  for (const VertexId v : listing.vertices[i]) text += ' ' + std::to_string(v.value() + listing.first_vertex);
  return text + ')';
}

template <std::size_t K>
[[noreturn]] void fail_at(const Listing<K>& listing, std::size_t i, std::string id, std::string message,
                          std::string fix) {
  io::fail(listing.file, std::move(id), std::move(message), std::move(fix),
           listing.lines.empty() ? std::nullopt : std::optional(listing.lines[i]));
}

/// Takes the simplices out for which `is_out` is not 0.
template <std::size_t K>
void remove_entries(Listing<K>& listing, const std::vector<std::uint8_t>& is_out) {
  const auto remove_from = [&](auto& values) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (is_out[i] == 0) values[kept++] = values[i];
    values.resize(kept);
  };
  remove_from(listing.vertices);
  remove_from(listing.markers);
  remove_from(listing.lines);
}

/// Makes every simplex positive. Leaves flat ones out, or throws mesh.flat_simplex.
template <int D>
void orient(const Mesh<D>& mesh, Listing<D + 1>& simplices, FlatSimplices flat) {
  std::vector<std::uint8_t> is_flat(simplices.vertices.size());
  parallel_for(simplices.vertices.size(), [&](std::size_t s) {
    auto& c = simplices.vertices[s];
    int sign = 0;
    if constexpr (D == 2)
      sign = orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]]);
    else
      sign = orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    if (sign < 0) std::swap(c[D - 1], c[D]);
    if (sign == 0) is_flat[s] = 1;
  });
  const auto first_flat = static_cast<std::size_t>(std::find(is_flat.begin(), is_flat.end(), 1) - is_flat.begin());
  if (first_flat == is_flat.size()) return;
  if (flat == FlatSimplices::kLeaveOut) return remove_entries(simplices, is_flat);
  fail_at(simplices, first_flat, "mesh.flat_simplex",
          element_text(simplices, D == 2 ? "triangle" : "tetrahedron", first_flat) +
              (D == 2 ? " has zero area" : " has zero volume"),
          "remove it, move one of its vertices, or triangulate the points anew (--redelaunay)");
}

/// Which entries of a listing occur in the mesh, and whether the mesh has nothing of the kind that is not listed.
struct Occurrence {
  std::vector<std::uint8_t> found;
  bool lists_all = true;
};

/// `for_each(s, visit)` calls visit(set of K vertices) for each face or edge of simplex s that is to be looked up.
template <std::size_t K, class ForEach>
Occurrence find_occurrences(std::size_t n_vertices, std::size_t n_simplices, const Listing<K>& listing,
                            const VertexSetTable<K>& table, const ForEach& for_each) {
  Occurrence occurrence;
  occurrence.found.assign(listing.vertices.size(), 0);
  // Most sets have a vertex that is in no listed one: this spares the look-up.
  std::vector<std::uint8_t> is_listed(n_vertices, 0);
  for (const auto& set : listing.vertices)
    for (const VertexId v : set) is_listed[v.value()] = 1;
  std::atomic<bool> lists_all = true;
  parallel_for(n_simplices, [&](std::size_t s) {
    for_each(SimplexId(s), [&](const std::array<VertexId, K>& set) {
      std::uint32_t index = table.kAbsent;
      if (std::all_of(set.begin(), set.end(), [&](VertexId v) { return is_listed[v.value()] != 0; }))
        index = table.find(set);
      if (index != table.kAbsent)
        std::atomic_ref<std::uint8_t>(occurrence.found[index]).store(1, std::memory_order_relaxed);
      else
        lists_all.store(false, std::memory_order_relaxed);
    });
  });
  occurrence.lists_all = lists_all;
  return occurrence;
}

template <std::size_t K>
VertexSetTable<K> make_table(const Listing<K>& listing, std::string_view kind) {
  VertexSetTable<K> table(listing.vertices.size());
  for (std::size_t i = 0; i < listing.vertices.size(); ++i) {
    const std::uint32_t earlier = table.insert(listing.vertices[i], static_cast<std::uint32_t>(i));
    if (earlier != table.kAbsent)
      fail_at(
          listing, i, fmt::format("io.duplicate_{}", kind),
          fmt::format("{} is the same as {} {}", element_text(listing, kind, i), kind, earlier + listing.first_number),
          "list it once");
  }
  return table;
}

/// Calls visit(s, i) for every face of the mesh once: opposite to corner i of simplex s.
template <int D, class Visit>
void visit_faces(const Mesh<D>& mesh, SimplexId s, const Visit& visit) {
  for (int i = 0; i <= D; ++i) {
    const SimplexId neighbor = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
    if (neighbor.is_none() || s < neighbor) visit(i, neighbor);
  }
}

template <int D>
void assemble_boundary(Mesh<D>& mesh, const Listing<D>& boundary) {
  const char* const kind = D == 2 ? "edge" : "face";
  const VertexSetTable<D> table = make_table(boundary, kind);
  const Occurrence occurrence = find_occurrences<D>(
      mesh.points.size(), mesh.simplex_vertices.size(), boundary, table, [&](SimplexId s, const auto& visit) {
        visit_faces<D>(mesh, s, [&](int i, SimplexId) { visit(boundary_face<D>(mesh.simplex_vertices[s], i)); });
      });

  // Hull faces and interfaces, listed or not.
  std::vector<std::uint8_t> must_be_kept(boundary.vertices.size(), 0);
  std::vector<std::array<VertexId, D>> unlisted;
  for (const SimplexId s : ids(mesh.simplex_vertices))
    visit_faces<D>(mesh, s, [&](int i, SimplexId neighbor) {
      if (!neighbor.is_none() && mesh.simplex_region[neighbor] == mesh.simplex_region[s]) return;
      const auto face = boundary_face<D>(mesh.simplex_vertices[s], i);
      const std::uint32_t index = table.find(face);
      if (index == table.kAbsent)
        unlisted.push_back(face);
      else
        must_be_kept[index] = 1;
    });

  for (std::size_t i = 0; i < boundary.vertices.size(); ++i) {
    const int marker = boundary.markers.empty() ? 0 : boundary.markers[i];
    if (occurrence.lists_all && marker == 0 && must_be_kept[i] == 0) continue;
    mesh.boundary_vertices.push_back(boundary.vertices[i]);
    mesh.boundary_marker.push_back(marker);
  }
  for (const auto& face : unlisted) {
    mesh.boundary_vertices.push_back(face);
    mesh.boundary_marker.push_back(0);
  }
}

void assemble_segments(Mesh<3>& mesh, const Listing<2>& segments) {
  const VertexSetTable<2> table = make_table(segments, "edge");
  const Occurrence occurrence = find_occurrences<2>(mesh.points.size(), mesh.simplex_vertices.size(), segments, table,
                                                    [&](SimplexId s, const auto& visit) {
                                                      const auto& corners = mesh.simplex_vertices[s];
                                                      for (std::size_t i = 0; i < corners.size(); ++i)
                                                        for (std::size_t j = i + 1; j < corners.size(); ++j)
                                                          visit({corners[i], corners[j]});
                                                    });
  for (std::size_t i = 0; i < segments.vertices.size(); ++i) {
    const int marker = segments.markers.empty() ? 0 : segments.markers[i];
    if (occurrence.lists_all && marker == 0) continue;
    mesh.segment_edges.push_back(segments.vertices[i]);
    mesh.segment_edge_marker.push_back(marker);
  }
}

}  // namespace

template <int D>
void assemble_mesh(Mesh<D>& mesh, Listing<D + 1> simplices, const Listing<D>& boundary, const Listing<2>& segments,
                   FlatSimplices flat) {
  orient<D>(mesh, simplices, flat);
  mesh.simplex_region = IdVector<SimplexId, int>(
      simplices.markers.empty() ? std::vector<int>(simplices.vertices.size(), 1) : std::move(simplices.markers));
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, D + 1>>(std::move(simplices.vertices));
  try {
    build_neighbors(mesh);
  } catch (const InputError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults) fault.file = simplices.file;
    throw InputError(std::move(faults));
  }
  assemble_boundary<D>(mesh, boundary);
  if constexpr (D == 3) assemble_segments(mesh, segments);
}

template void assemble_mesh<2>(Mesh<2>&, Listing<3>, const Listing<2>&, const Listing<2>&, FlatSimplices);
template void assemble_mesh<3>(Mesh<3>&, Listing<4>, const Listing<3>&, const Listing<2>&, FlatSimplices);

}  // namespace voropack::io
