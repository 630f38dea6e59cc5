// A picture of a 2D mesh with its Voronoi cells.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/svg_contours.h"
#include "io/svg_path.h"
#include "voropack/io.h"

namespace voropack {

using io::Frame;
using io::kPictureSize;
using io::Path;

namespace {

/// Muted fills, apart also in grey and for colour-blind readers (after Paul Tol's "light" scheme).
constexpr std::array<const char*, 8> kRegionFills = {"#d7e3ef", "#f3e2c7", "#d9ead3", "#efd9dd",
                                                     "#e2daee", "#f1eec9", "#cfe8e6", "#e3e3e0"};

/// Chains edges into polylines so that each vertex is written about once.
void add_chains(Path& path, const IdVector<VertexId, Vec<2>>& points, std::vector<std::array<VertexId, 2>> edges) {
  std::sort(edges.begin(), edges.end());
  std::vector<bool> used(edges.size(), false);
  const auto next_from = [&](VertexId v) {
    auto it = std::lower_bound(edges.begin(), edges.end(), std::array{v, VertexId(std::size_t{0})});
    for (; it != edges.end() && (*it)[0] == v; ++it) {
      const auto i = static_cast<std::size_t>(it - edges.begin());
      if (!used[i]) return i;
    }
    return edges.size();
  };
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    path.move_to(points[edges[first][0]]);
    for (std::size_t i = first; i < edges.size(); i = next_from(edges[i][1])) {
      used[i] = true;
      path.line_to(points[edges[i][1]]);
    }
  }
}

std::vector<std::array<VertexId, 2>> simplex_edges(const Mesh<2>& mesh) {
  std::vector<std::array<VertexId, 2>> edges;
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& c = mesh.simplex_vertices[s];
    for (std::size_t i = 0; i < 3; ++i) {
      const SimplexId neighbor = mesh.simplex_neighbors[s][i];
      if (neighbor.is_none() || s < neighbor) edges.push_back({c[(i + 1) % 3], c[(i + 2) % 3]});
    }
  }
  return edges;
}

}  // namespace

void write_svg(const Mesh<2>& mesh, const CellShapes<2>& shapes, const ControlVolumes<2>& volumes,
               const std::filesystem::path& path) {
  Box<2> box;
  for (const Vec<2>& p : mesh.points) box.add(p);
  for (const Vec<2>& p : shapes.points) box.add(p);
  const Frame frame(box);

  std::map<int, Path> cells;  // By region, in the order of its id: the same picture each time.
  for (const CellId c : ids<CellId>(shapes.cell_faces.size())) {
    Path& cell = cells.try_emplace(volumes.cell_region[c], frame).first->second;
    bool is_first = true;
    for (const std::uint32_t point : shapes.cell_faces[c]) {
      is_first ? cell.move_to(shapes.points[point]) : cell.line_to(shapes.points[point]);
      is_first = false;
    }
    cell.close();
  }
  Path simplices(frame), boundary(frame);
  add_chains(simplices, mesh.points, simplex_edges(mesh));
  add_chains(boundary, mesh.points, mesh.boundary_vertices.raw());

  // Lines get thinner with the edges, so that a fine mesh does not turn black.
  const double n = std::max<double>(1, static_cast<double>(mesh.points.size()));
  const double line = std::clamp(kPictureSize / std::sqrt(n) * 0.04, 1.0, 24.0);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{2:.0f}\" height=\"{3:.0f}\" "
      "stroke-linejoin=\"round\" stroke-linecap=\"round\" fill=\"none\">\n<title>{4} vertices, {5} triangles, {6} "
      "Voronoi cells</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      frame.width, frame.height, frame.width / 10, frame.height / 10, mesh.points.size(), mesh.simplex_vertices.size(),
      shapes.cell_faces.size());
  std::size_t color = 0;
  for (const auto& [region, cell] : cells)
    svg += fmt::format("<path id=\"region{}\" fill=\"{}\" stroke=\"#51708f\" stroke-width=\"{:.1f}\" d=\"{}\"/>\n",
                       region, kRegionFills[color++ % kRegionFills.size()], line, cell.data());
  svg += fmt::format(
      "<path id=\"simplices\" stroke=\"#8c8c8c\" stroke-opacity=\".7\" stroke-width=\"{:.1f}\" d=\"{}\"/>\n",
      0.5 * line, simplices.data());
  svg += fmt::format("<path id=\"boundary\" stroke=\"#1c2b3a\" stroke-width=\"{:.1f}\" d=\"{}\"/>\n", 2.5 * line,
                     boundary.data());
  svg += "</svg>\n";
  write_text(svg, path);
}

void write_svg(const Mesh<2>& mesh, const NamedArray& colors, const std::filesystem::path& path) {
  const auto fail = [&](std::string message, std::string fix) {
    throw OptionError(Fault{.id = "io.bad_array",
                            .message = fmt::format("the array '{}' {}", colors.name, message),
                            .fix = std::move(fix)});
  };
  if (colors.values.size() != mesh.points.size())
    fail(fmt::format("has {} values for {} vertices", colors.values.size(), mesh.points.size()),
         "give each vertex one number");
  for (const double value : colors.values)
    if (!std::isfinite(value)) fail("has a value that is not finite", "correct it");
  Box<2> box;
  for (const Vec<2>& p : mesh.points) box.add(p);
  const Frame frame(box);
  const io::ColorScale scale(colors.values);
  Path boundary(frame);
  add_chains(boundary, mesh.points, mesh.boundary_vertices.raw());
  const double width = frame.width + io::kColorBarWidth;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{2:.0f}\" height=\"{3:.0f}\" "
      "stroke-linejoin=\"round\" stroke-linecap=\"round\" fill=\"none\">\n<title>{4} on {5} vertices</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      width, frame.height, width / 10, frame.height / 10, io::escaped(colors.name), mesh.points.size());
  svg += io::contour_bands(mesh, colors.values, scale, frame);
  svg += fmt::format("<path id=\"boundary\" stroke=\"#1c2b3a\" stroke-width=\"24\" d=\"{}\"/>\n", boundary.data());
  svg += io::color_bar(colors.name, scale, frame) + "</svg>\n";
  write_text(svg, path);
}

}  // namespace voropack
