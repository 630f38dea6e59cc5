#include "coarsening/surface_distance.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "geom/box_tree.h"
#include "geom/polytope_distance.h"

namespace voropack {

namespace {

constexpr double kAccuracy = 0.02;
/// Below this part of the surface's diameter the figure is the largest one of samples.
constexpr double kLeast = 1e-2;

using Triangle = std::array<Vec<3>, 3>;

std::vector<Triangle> triangles_of(const Mesh<3>& mesh) {
  std::vector<Triangle> triangles;
  for (const auto& face : mesh.boundary_vertices)
    triangles.push_back({mesh.points[face[0]], mesh.points[face[1]], mesh.points[face[2]]});
  return triangles;
}

class DistanceTo {
 public:
  explicit DistanceTo(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
    std::vector<Box<3>> boxes;
    for (const Triangle& t : triangles_) {
      Box<3> box(t[0], t[0]);
      box.add(t[1]);
      box.add(t[2]);
      boxes.push_back(box);
    }
    tree_ = BoxTree<3>(boxes);
    if (!tree_.empty()) least_ = kLeast * tree_.nodes().front().box.diagonal();
  }

  double operator()(const Vec<3>& x) const {
    return tree_.minimize(x, 1, std::numeric_limits<double>::infinity(), [&](std::uint32_t i) {
      return distance_to_triangle(x, triangles_[i][0], triangles_[i][1], triangles_[i][2]);
    });
  }

  /// The largest distance of a point of `from` that is found; `found` is one that is known.
  [[nodiscard]] double largest(const std::vector<Triangle>& from, double found) const {
    std::vector<double> at(from.size());
    parallel_for(from.size(), [&](std::size_t i) { at[i] = (*this)(center(from[i])); });
    for (std::size_t i = 0; i < from.size(); ++i) found = std::max(found, at[i]);
    std::vector<Triangle> stack;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (is_settled(at[i], from[i], found)) continue;
      stack = {from[i]};
      while (!stack.empty()) {
        const Triangle t = stack.back();
        stack.pop_back();
        const double d = (*this)(center(t));
        found = std::max(found, d);
        if (is_settled(d, t, found)) continue;
        const Vec<3> ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]), ca = 0.5 * (t[2] + t[0]);
        stack.insert(stack.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
      }
    }
    return found;
  }

 private:
  static Vec<3> center(const Triangle& t) { return (t[0] + t[1] + t[2]) / 3.0; }
  static double radius(const Triangle& t) {
    const Vec<3> c = center(t);
    return std::max({distance(c, t[0]), distance(c, t[1]), distance(c, t[2])});
  }

  /// True if no point of t is much farther than `found`: distances change by no more than one moves.
  [[nodiscard]] bool is_settled(double at_center, const Triangle& t, double found) const {
    return at_center + radius(t) <= std::max((1 + kAccuracy) * found, least_);
  }

  std::vector<Triangle> triangles_;
  BoxTree<3> tree_;
  double least_ = 0;
};

/// Of the corners of faces.
double at_vertices(const Mesh<3>& mesh, const DistanceTo& to) {
  std::vector<VertexId> vertices;
  for (const auto& face : mesh.boundary_vertices) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<double> at(vertices.size());
  parallel_for(at.size(), [&](std::size_t i) { at[i] = to(mesh.points[vertices[i]]); });
  return at.empty() ? 0 : *std::max_element(at.begin(), at.end());
}

}  // namespace

double surface_distance(const Mesh<3>& a, const Mesh<3>& b) {
  const std::vector<Triangle> of_a = triangles_of(a), of_b = triangles_of(b);
  if (of_a.empty() || of_b.empty()) return 0;
  const DistanceTo to_a(of_a), to_b(of_b);
  return to_a.largest(of_b, to_b.largest(of_a, at_vertices(a, to_b)));
}

}  // namespace voropack
