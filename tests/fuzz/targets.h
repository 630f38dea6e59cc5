// What the fuzz targets and the mutation test run: each reader on a piece of memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "io/readers.h"
#include "voropack/error.h"

namespace voropack::fuzz {

/// A domain that a reader returns has indices in range; a mesh has all its invariants. Anything else is a fault of
/// ours.
template <int D>
bool is_sound(const DomainInput<D>& input) {
  const auto in_range = [&](std::uint32_t p) { return p < input.points.size(); };
  for (const auto& point : input.points)
    if (!is_finite(point)) return false;
  for (const auto& segment : input.segments)
    if (!in_range(segment.points[0]) || !in_range(segment.points[1])) return false;
  for (const auto& facet : input.facets)
    for (const auto& polygon : facet.polygons)
      for (const std::uint32_t p : polygon)
        if (!in_range(p)) return false;
  return true;
}

/// True if the vertices of `set` differ and some simplex has them all.
template <int D, std::size_t K>
bool occurs(const Mesh<D>& mesh, std::array<VertexId, K> set) {
  std::ranges::sort(set);
  if (std::ranges::adjacent_find(set) != set.end()) return false;
  return std::ranges::any_of(mesh.simplex_vertices, [&](const auto& corners) {
    return std::ranges::all_of(set, [&](VertexId v) { return std::ranges::find(corners, v) != corners.end(); });
  });
}

/// Every invariant holds, but for listed faces and edges that no simplex has: reading keeps them for a check to name.
template <int D>
bool is_sound(Mesh<D> mesh) {
  std::erase_if(mesh.boundary_vertices.raw(), [&](const auto& face) { return !occurs(mesh, face); });
  mesh.boundary_marker.resize(mesh.boundary_vertices.size());
  std::erase_if(mesh.segment_edges.raw(), [&](const auto& edge) { return !occurs(mesh, edge); });
  mesh.segment_edge_marker.resize(mesh.segment_edges.size());
  return find_mesh_fault(mesh).empty();
}

/// Files of a set are separated by this byte.
inline constexpr char kFileSeparator = '\x1e';

inline AnyMesh parse_mesh_set(std::string_view bytes) {
  std::vector<io::Source> files;
  for (;;) {
    const std::size_t end = bytes.find(kFileSeparator);
    files.push_back({"input", bytes.substr(0, end)});
    if (end == std::string_view::npos) break;
    bytes.remove_prefix(end + 1);
  }
  files.resize(std::max<std::size_t>(files.size(), 2));
  io::NodeMeshSources sources{files[0], files[1], {}, {}, {}};
  if (files.size() > 2) sources.face = files[2];
  if (files.size() > 3 && !files[3].bytes.empty()) sources.edge = files[3];
  if (files.size() > 4) sources.poly = files[4];
  return io::parse_node_mesh(sources, silent_observer());
}

inline io::FileContent fixed_nodes() { return {"input.node", "3 2 0 1\n1 0 0 1\n2 1 0 2\n3 0 1 3\n"}; }

/// A reader by the name of its folder in corpus/.
struct Target {
  const char* name;
  bool (*parse_is_sound)(const io::Source& source);  ///< Throws Error on bad input.
};

template <class Any>
bool any_is_sound(const Any& any) {
  return std::visit([](const auto& value) { return is_sound(value); }, any);
}

inline constexpr std::array<Target, 9> kTargets = {{
    {"poly", [](const io::Source& s) { return any_is_sound(io::parse_poly(s, fixed_nodes, silent_observer())); }},
    {"smesh", [](const io::Source& s) { return any_is_sound(io::parse_smesh(s, fixed_nodes, silent_observer())); }},
    {"node", [](const io::Source& s) { return any_is_sound(io::parse_node_domain(s, silent_observer())); }},
    {"off", [](const io::Source& s) { return is_sound(io::parse_off(s, silent_observer())); }},
    {"stl", [](const io::Source& s) { return is_sound(io::parse_stl(s, silent_observer())); }},
    {"obj", [](const io::Source& s) { return is_sound(io::parse_obj(s, silent_observer())); }},
    {"ply", [](const io::Source& s) { return is_sound(io::parse_ply(s, silent_observer())); }},
    {"mesh", [](const io::Source& s) { return any_is_sound(parse_mesh_set(s.bytes)); }},
    {"vtu", [](const io::Source& s) { return any_is_sound(io::parse_vtu(s, silent_observer())); }},
}};

/// Runs a reader: true if it returned sound data or threw InputError or LimitError with an id and a fix.
inline bool accepts_or_rejects(const Target& target, std::string_view bytes) {
  try {
    return target.parse_is_sound({"input", bytes});
  } catch (const InputError& error) {
    return !error.id().empty() && !error.faults().front().fix.empty();
  } catch (const LimitError& error) {
    return !error.id().empty() && !error.faults().front().fix.empty();
  }
}

}  // namespace voropack::fuzz
