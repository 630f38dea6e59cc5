#include "io/mesh_assembly.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
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

/// "1 simplex was ..." or "3 simplices were ...".
std::string simplices_were(std::size_t n, std::string_view what) {
  return fmt::format("{} {} {}", n, n == 1 ? "simplex was" : "simplices were", what);
}

/// Makes every simplex positive. Leaves flat ones out, or throws mesh.flat_simplex.
template <int D>
void orient(const Mesh<D>& mesh, Listing<D + 1>& simplices, FaultySimplices faulty, Observer& observer) {
  const std::size_t n = simplices.vertices.size();
  std::vector<std::int8_t> sign(n);
  parallel_for(n, [&](std::size_t s) {
    auto& c = simplices.vertices[s];
    if constexpr (D == 2)
      sign[s] = static_cast<std::int8_t>(orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]]));
    else
      sign[s] = static_cast<std::int8_t>(
          orientation(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]));
    if (sign[s] < 0) std::swap(c[D - 1], c[D]);
  });
  const auto first_flat = static_cast<std::size_t>(std::find(sign.begin(), sign.end(), 0) - sign.begin());
  if (faulty == FaultySimplices::kRefuse && first_flat < n)
    fail_at(simplices, first_flat, "mesh.flat_simplex",
            element_text(simplices, D == 2 ? "triangle" : "tetrahedron", first_flat) +
                (D == 2 ? " has zero area" : " has zero volume"),
            "remove it, move one of its vertices, or triangulate the points anew (--redelaunay)");
  if (faulty == FaultySimplices::kRefuse) return;
  const auto count = [&](int wanted) { return static_cast<std::size_t>(std::count(sign.begin(), sign.end(), wanted)); };
  // Some programs count corners the other way round; what differs from most may be inverted.
  if (const std::size_t n_turned = std::min(count(1), count(-1)); n_turned > 0)
    observer.log(LogLevel::kInfo,
                 fmt::format("{} of {} simplices had another orientation than the others, and {} turned", n_turned, n,
                             n_turned == 1 ? "was" : "were"));
  if (first_flat == n) return;
  observer.log(LogLevel::kWarning, simplices_were(count(0), "flat, and left out"));
  std::vector<std::uint8_t> is_flat(n);
  for (std::size_t s = 0; s < n; ++s) is_flat[s] = sign[s] == 0 ? 1 : 0;
  remove_entries(simplices, is_flat);
}

/// Of simplices with the same corners the first one stays.
template <std::size_t K>
void leave_duplicates_out(Listing<K>& simplices, Observer& observer) {
  const std::size_t n = simplices.vertices.size();
  std::vector<std::pair<std::array<VertexId, K>, std::size_t>> sorted(n);
  parallel_for(n, [&](std::size_t s) {
    sorted[s] = {simplices.vertices[s], s};
    std::sort(sorted[s].first.begin(), sorted[s].first.end());
  });
  parallel_sort(sorted.begin(), sorted.end());
  std::vector<std::uint8_t> is_out(n);
  std::size_t n_out = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (sorted[i].first != sorted[i - 1].first) continue;
    is_out[sorted[i].second] = 1;
    ++n_out;
  }
  if (n_out == 0) return;
  observer.log(LogLevel::kWarning, simplices_were(n_out, "listed before, and left out"));
  remove_entries(simplices, is_out);
}

/// Neighbors across faces of two simplices, whether these lie on its two sides or overlap. False if three share one.
template <int D>
bool link_overlapping(Mesh<D>& mesh, Observer& observer) {
  struct Side {
    SimplexId simplex;
    int corner;
    bool is_odd;
    bool is_paired = false;
  };
  mesh.simplex_neighbors.clear();
  for (std::size_t s = 0; s < mesh.simplex_vertices.size(); ++s) {
    mesh.simplex_neighbors.push_back({});
    mesh.simplex_neighbors.back().fill(SimplexId::none());
  }
  VertexSetTable<D> table((D + 1) * mesh.simplex_vertices.size());
  std::vector<Side> first;
  std::size_t n_overlaps = 0;
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i) {
      auto face = face_vertices(mesh, s, i);
      const bool is_odd = sort_vertices(face);
      const std::uint32_t known = table.insert(face, static_cast<std::uint32_t>(first.size()));
      if (known == table.kAbsent) {
        first.push_back({s, i, is_odd});
        continue;
      }
      Side& other = first[known];
      if (other.is_paired) return false;
      other.is_paired = true;
      mesh.simplex_neighbors[s][static_cast<std::size_t>(i)] = other.simplex;
      mesh.simplex_neighbors[other.simplex][static_cast<std::size_t>(other.corner)] = s;
      if (is_odd == other.is_odd) ++n_overlaps;
    }
  observer.log(LogLevel::kWarning,
               fmt::format("simplices overlap at {} face{}", n_overlaps, n_overlaps == 1 ? "" : "s"));
  return true;
}

/// Faults get the file's name.
template <int D>
void link_simplices(Mesh<D>& mesh, const std::string& file, FaultySimplices faulty, Observer& observer) {
  try {
    build_neighbors(mesh);
  } catch (const InputError& error) {
    if (faulty == FaultySimplices::kAccept && link_overlapping(mesh, observer)) return;
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults) {
      fault.file = file;
      if (faulty == FaultySimplices::kRefuse) fault.fix += ", or triangulate the points anew (--redelaunay)";
    }
    throw InputError(std::move(faults));
  }
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
                   FaultySimplices faulty, Observer& observer) {
  orient<D>(mesh, simplices, faulty, observer);
  if (faulty == FaultySimplices::kAccept) leave_duplicates_out(simplices, observer);
  mesh.simplex_region = IdVector<SimplexId, int>(
      simplices.markers.empty() ? std::vector<int>(simplices.vertices.size(), 1) : std::move(simplices.markers));
  mesh.simplex_vertices = IdVector<SimplexId, std::array<VertexId, D + 1>>(std::move(simplices.vertices));
  link_simplices(mesh, simplices.file, faulty, observer);
  assemble_boundary<D>(mesh, boundary);
  if constexpr (D == 3) assemble_segments(mesh, segments);
}

template void assemble_mesh<2>(Mesh<2>&, Listing<3>, const Listing<2>&, const Listing<2>&, FaultySimplices, Observer&);
template void assemble_mesh<3>(Mesh<3>&, Listing<4>, const Listing<3>&, const Listing<2>&, FaultySimplices, Observer&);

}  // namespace voropack::io
