#include "domain/attach.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "geom/polytope_distance.h"

namespace voropack::domain_impl {

namespace {

/// Edges of the sheet's facets that occur an odd number of times: the outline of all of them together.
std::vector<std::array<Vec<2>, 2>> outline_of(const Complex<3>& complex, const Sheet& sheet) {
  std::map<std::uint64_t, std::pair<std::array<Index, 2>, bool>> edges;
  for (const Index f : sheet.facets)
    for (const auto& corners : complex.facets[f].polygons)
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Index a = corners[i], b = corners[(i + 1) % corners.size()];
        auto& [ends, odd] = edges[Complex<3>::key(a, b)];
        ends = {a, b};
        odd = !odd;
      }
  std::vector<std::array<Vec<2>, 2>> outline;
  for (const auto& [key, edge] : edges)
    if (edge.second)
      outline.push_back(
          {sheet.frame.to_plane(complex.points[edge.first[0]]), sheet.frame.to_plane(complex.points[edge.first[1]])});
  return outline;
}

/// Whether x is inside of the outline or within `reach` of it.
bool is_in(const std::vector<std::array<Vec<2>, 2>>& outline, const Vec<2>& x, double reach) {
  bool inside = false;
  for (const auto& [a, b] : outline) {
    if (distance_to_segment(x, a, b) <= reach) return true;
    if ((a[1] > x[1]) == (b[1] > x[1])) continue;
    if (x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

}  // namespace

Attacher::Attacher(const Complex<3>& complex) : complex_(complex) {
  std::vector<Box<3>> boxes;
  boxes.reserve(complex.points.size());
  for (const Vec<3>& x : complex.points) boxes.emplace_back(x, x);
  tree_ = AabbTree<3>(std::move(boxes));
}

void Attacher::attach(Sheet& sheet, double reach) const {
  Box<3> box;
  for (const Index p : sheet.points) box.add(complex_.points[p]);
  box.inflate(reach);
  std::vector<Index> found;
  tree_.visit_overlaps(box, [&](Index p) {
    if (std::abs(sheet.frame.height(complex_.points[p])) > reach) return;
    if (!std::binary_search(sheet.points.begin(), sheet.points.end(), p)) found.push_back(p);
  });
  if (found.empty()) return;
  const auto outline = outline_of(complex_, sheet);
  std::erase_if(found, [&](Index p) { return !is_in(outline, sheet.frame.to_plane(complex_.points[p]), reach); });
  sheet.points.insert(sheet.points.end(), found.begin(), found.end());
  std::sort(sheet.points.begin(), sheet.points.end());
}

}  // namespace voropack::domain_impl
