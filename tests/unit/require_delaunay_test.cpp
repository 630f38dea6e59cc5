// The check that a mesh is Delaunay against exact predicates at every simplex and face.
#include "coarsening/require_delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "geom/predicates.h"
#include "support/point_sets.h"
#include "voropack/delaunay.h"
#include "voropack/error.h"

namespace voropack {
namespace {

template <int D>
Mesh<D> mesh_of(const std::vector<Vec<D>>& points) {
  const Triangulation<D> t = delaunay_triangulation<D>(points);
  Mesh<D> mesh;
  for (const Vec<D>& x : points) mesh.points.push_back(x);
  for (std::size_t s = 0; s < t.simplices.size(); ++s) {
    std::array<VertexId, D + 1> corners;
    std::array<SimplexId, D + 1> neighbors;
    for (std::size_t i = 0; i <= D; ++i) {
      corners[i] = VertexId(t.simplices[s][i]);
      if (t.neighbors[s][i] != Triangulation<D>::kNoNeighbor) neighbors[i] = SimplexId(t.neighbors[s][i]);
    }
    mesh.simplex_vertices.push_back(corners);
    mesh.simplex_neighbors.push_back(neighbors);
  }
  return mesh;
}

template <int D>
int side(const std::array<Vec<D>, D + 1>& x) {
  if constexpr (D == 2)
    return orientation(x[0], x[1], x[2]);
  else
    return orientation(x[0], x[1], x[2], x[3]);
}

template <int D>
bool holds(const std::array<Vec<D>, D + 1>& x, const Vec<D>& y) {
  if constexpr (D == 2)
    return in_circumball(x[0], x[1], x[2], y) > 0;
  else
    return in_circumball(x[0], x[1], x[2], x[3], y) > 0;
}

/// No simplex is turned over, and no corner of a neighbor is on the wrong side of a face or in the circumball.
template <int D>
bool is_delaunay(const Mesh<D>& mesh) {
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    std::array<Vec<D>, D + 1> x;
    for (std::size_t i = 0; i <= D; ++i) x[i] = mesh.points[mesh.simplex_vertices[s][i]];
    if (side<D>(x) <= 0) return false;
    for (std::size_t i = 0; i <= D; ++i) {
      const SimplexId t = mesh.simplex_neighbors[s][i];
      if (t.is_none()) continue;
      for (const VertexId v : mesh.simplex_vertices[t]) {
        const auto& corners = mesh.simplex_vertices[s];
        if (std::find(corners.begin(), corners.end(), v) != corners.end()) continue;
        std::array<Vec<D>, D + 1> beyond = x;
        beyond[i] = mesh.points[v];
        if (holds<D>(x, mesh.points[v]) || side<D>(beyond) >= 0) return false;
      }
    }
  }
  return true;
}

template <int D>
bool is_accepted(const Mesh<D>& mesh) {
  try {
    require_delaunay(mesh);
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(error.id(), "coarsen.not_delaunay");
    return false;
  }
}

/// One vertex after the other is moved a little, by up to 10^-16 of the size of the mesh: down to where only exact
/// arithmetic can tell.
template <int D>
void accepts_what_is_delaunay(const std::vector<Vec<D>>& points, int least_accepted, int least_refused) {
  Random random(1);
  int n_accepted = 0, n_refused = 0;
  for (const double scale : {1.0, 1e-30, 1e40}) {
    std::vector<Vec<D>> scaled = points;
    for (Vec<D>& x : scaled) x *= scale;
    const Mesh<D> mesh = mesh_of<D>(scaled);
    EXPECT_TRUE(is_accepted(mesh)) << scale;
    for (int k = 0; k < 200; ++k) {
      Mesh<D> moved = mesh;
      Vec<D>& x = moved.points[VertexId(random.bits() % points.size())];
      const double most = scale * std::pow(10.0, -16 * random.unit());
      for (int axis = 0; axis < D; ++axis) x[axis] += most * (random.unit() - 0.5);
      const bool expected = is_delaunay(moved);
      EXPECT_EQ(is_accepted(moved), expected) << scale << " " << k;
      ++(expected ? n_accepted : n_refused);
    }
  }
  EXPECT_GE(n_accepted, least_accepted);
  EXPECT_GE(n_refused, least_refused);
}

/// Every cell has its corners on a sphere.
template <int D>
std::vector<Vec<D>> grid_points(int n) {
  std::vector<Vec<D>> points;
  for (int number = 0; number < (D == 2 ? n * n : n * n * n); ++number) {
    Vec<D> x;
    for (int axis = 0, rest = number; axis < D; ++axis, rest /= n) x[axis] = static_cast<double>(rest % n) / n;
    points.push_back(x);
  }
  return points;
}

TEST(RequireDelaunay, AcceptsWhatIsDelaunayInThePlane) {
  accepts_what_is_delaunay<2>(test::random_points<2>(60, 2), 300, 30);
  accepts_what_is_delaunay<2>(grid_points<2>(6), 5, 300);  // What moves leaves a circle.
}
TEST(RequireDelaunay, AcceptsWhatIsDelaunayInSpace) {
  accepts_what_is_delaunay<3>(test::random_points<3>(60, 2), 300, 30);
  accepts_what_is_delaunay<3>(grid_points<3>(4), 5, 300);
}

}  // namespace
}  // namespace voropack
