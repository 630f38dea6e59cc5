// The laws of the control volumes on small meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>

#include "base/parallel.h"
#include "support/allow_threads.h"
#include "support/delaunay_mesh.h"
#include "voropack/dual.h"
#include "voropack/error.h"

namespace voropack {
namespace {

using test::delaunay_mesh;
using test::perturbed_grid;

template <int D>
std::map<int, double> volume_sums(const ControlVolumes<D>& volumes) {
  std::map<int, double> sums;
  for (const CellId c : ids(volumes.cell_volume)) sums[volumes.cell_region[c]] += volumes.cell_volume[c];
  return sums;
}

int halves(const Vec<3>& x) { return x[0] < 0.5 ? 7 : 3; }

/// sum_j A_ij n_ij, which is minus the outward area of the part of the cell's boundary that lies on the hull.
template <int D>
IdVector<VertexId, Vec<D>> closure_defects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes) {
  IdVector<VertexId, Vec<D>> sum(mesh.points.size());
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const Vec<D> flux = volumes.face_area[f] / volumes.face_edge_length[f] * (mesh.points[j] - mesh.points[i]);
    sum[i] += flux;
    sum[j] -= flux;
  }
  return sum;
}

bool inside(const Vec<3>& p) {
  for (int k = 0; k < 3; ++k)
    if (p[k] == 0 || p[k] == 1) return false;
  return true;
}

TEST(Dual, VolumesSumToTheCube) {
  for (const double eps : {0.0, 1e-14, 1e-6, 1e-2}) {
    const auto volumes = build_control_volumes(delaunay_mesh(perturbed_grid<3>(4, eps)));
    EXPECT_NEAR(volume_sums(volumes)[1], 1.0, 1e-13) << "eps " << eps;
    for (const double v : volumes.cell_volume) EXPECT_GT(v, 0);
    for (const double a : volumes.face_area) EXPECT_GT(a, 0);
    EXPECT_EQ(volumes.cell_vertex.size(), 125U);
  }
}

TEST(Dual, VolumesSumToTheSquare) {
  for (const double eps : {0.0, 1e-14, 1e-6, 0.1}) {
    const auto volumes = build_control_volumes(delaunay_mesh(perturbed_grid<2>(8, eps)));
    EXPECT_NEAR(volume_sums(volumes)[1], 1.0, 1e-13) << "eps " << eps;
    for (const double a : volumes.face_area) EXPECT_GT(a, 0);
  }
}

TEST(Dual, VolumesSumToEachRegion) {
  for (const double eps : {0.0, 1e-10, 1e-2}) {
    const auto volumes = build_control_volumes(delaunay_mesh<3>(perturbed_grid<3>(4, eps, 1, true), halves));
    EXPECT_NEAR(volume_sums(volumes)[7], 0.5, 1e-13);
    EXPECT_NEAR(volume_sums(volumes)[3], 0.5, 1e-13);
    // The 25 vertices of the interface have two cells.
    EXPECT_EQ(volumes.cell_vertex.size(), 125U + 25U);
  }
}

TEST(Dual, CellsAndFacesAreSorted) {
  const auto volumes = build_control_volumes(delaunay_mesh<3>(perturbed_grid<3>(4, 1e-2, 1, true), halves));
  for (std::size_t c = 1; c < volumes.cell_vertex.size(); ++c) {
    EXPECT_LT(std::tie(volumes.cell_vertex[CellId(c - 1)], volumes.cell_region[CellId(c - 1)]),
              std::tie(volumes.cell_vertex[CellId(c)], volumes.cell_region[CellId(c)]));
  }
  for (const DualFaceId f : ids(volumes.face_area)) {
    EXPECT_LT(volumes.face_vertices[f][0], volumes.face_vertices[f][1]);
    if (f.value() == 0) continue;
    const DualFaceId before(f.value() - 1);
    EXPECT_LT(std::tie(volumes.face_vertices[before], volumes.face_region[before]),
              std::tie(volumes.face_vertices[f], volumes.face_region[f]));
  }
}

TEST(Dual, CellsInsideAreClosed) {
  for (const double eps : {0.0, 1e-13, 1e-2}) {
    const auto mesh = delaunay_mesh(perturbed_grid<3>(5, eps));
    const auto defects = closure_defects(mesh, build_control_volumes(mesh));
    for (const VertexId v : ids(mesh.points)) {
      if (inside(mesh.points[v])) {
        EXPECT_LT(norm(defects[v]), 1e-13);
      }
    }
  }
}

TEST(Dual, LinearFunctionsHaveNoFluxDefectInside) {
  // The scheme is exact for linear functions: sum_j A_ij (u_i - u_j) / h_ij = 0, whatever the slivers.
  const auto u = [](const Vec<3>& x) { return 3 + x[0] - 2 * x[1] + 5 * x[2]; };
  const auto mesh = delaunay_mesh(perturbed_grid<3>(4, 1e-12));
  const auto volumes = build_control_volumes(mesh);
  IdVector<VertexId, double> flux(mesh.points.size());
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const double q = volumes.face_area[f] / volumes.face_edge_length[f] * (u(mesh.points[i]) - u(mesh.points[j]));
    flux[i] += q;
    flux[j] -= q;
  }
  for (const VertexId v : ids(mesh.points)) {
    if (inside(mesh.points[v])) {
      EXPECT_NEAR(flux[v], 0, 1e-12);
    }
  }
}

TEST(Dual, TheExactGridHasCubesAndCountsItsZeroAreas) {
  const int n = 4;
  const auto mesh = delaunay_mesh(perturbed_grid<3>(n, 0));
  const auto volumes = build_control_volumes(mesh);
  // Only the edges of the grid have a dual face: 3 n (n+1)^2; all diagonals of squares and cubes have none.
  EXPECT_EQ(volumes.face_area.size(), 300U);
  EXPECT_GT(volumes.n_zero_areas, 0U);
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    const Vec<3> m = 0.5 * (mesh.points[i] + mesh.points[j]);
    double expected = 1.0 / (n * n);
    for (int k = 0; k < 3; ++k)
      if (m[k] == 0 || m[k] == 1) expected *= 0.5;
    EXPECT_DOUBLE_EQ(volumes.face_area[f], expected);
  }
}

TEST(Dual, RigidMotionsAndScalesLeaveTheAreas) {
  const auto mesh = delaunay_mesh(perturbed_grid<3>(3, 1e-2));
  const auto reference = build_control_volumes(mesh);
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (const double scale : {1e-60, 1e-6, 1.0, 1e6, 1e60}) {
    auto moved = mesh;
    for (Vec<3>& p : moved.points) p = scale * Vec<3>{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2] + 0.25};
    const auto volumes = build_control_volumes(moved);
    std::map<std::array<VertexId, 2>, double> areas;
    for (const DualFaceId f : ids(volumes.face_area)) areas[volumes.face_vertices[f]] = volumes.face_area[f];
    for (const DualFaceId f : ids(reference.face_area)) {
      const double h = reference.face_edge_length[f];
      EXPECT_NEAR(areas[reference.face_vertices[f]] / (scale * scale), reference.face_area[f], 1e-11 * h * h);
    }
  }
}

// Cocircular points leave double precision undecided: the way through more digits must follow the scale too.
TEST(Dual, ScalesLeaveTheAreasOfCocircularPointsInThePlane) {
  const auto unit = delaunay_mesh(perturbed_grid<2>(4, 0));
  for (const double scale : {1e-3, 1e3, 1e12}) {
    Mesh<2> scaled = unit;
    for (Vec<2>& x : scaled.points) x = scale * Vec<2>{0.6 * x[0] - 0.8 * x[1], 0.8 * x[0] + 0.6 * x[1]};
    const ControlVolumes<2> volumes = build_control_volumes(scaled);
    EXPECT_NEAR(volume_sums(volumes).at(1), scale * scale, 1e-12 * scale * scale);
  }
}

TEST(Dual, AnyNumberOfThreadsGivesTheSameBytes) {
  const test::AllowThreads allow(8);
  const auto mesh = delaunay_mesh<3>(perturbed_grid<3>(12, 1e-2, 1, true), halves);
  ControlVolumes<3> one, eight;
  run_with_threads(1, [&] { one = build_control_volumes(mesh); });
  run_with_threads(8, [&] { eight = build_control_volumes(mesh); });
  EXPECT_EQ(one.face_vertices, eight.face_vertices);
  EXPECT_EQ(one.cell_vertex, eight.cell_vertex);
  EXPECT_EQ(one.n_exact_evaluations, eight.n_exact_evaluations);
  const auto same_bytes = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
  };
  EXPECT_TRUE(same_bytes(one.face_area, eight.face_area));
  EXPECT_TRUE(same_bytes(one.cell_volume, eight.cell_volume));
}

TEST(Dual, AnInternalFacetOfOneRegionChangesNothing) {
  auto mesh = delaunay_mesh<3>(perturbed_grid<3>(4, 1e-2, 1, true), halves);
  for (int& region : mesh.simplex_region) region = 1;  // The interface stays listed as an internal facet.
  const auto volumes = build_control_volumes(mesh);
  EXPECT_EQ(volumes.cell_vertex.size(), 125U);
  auto bare = mesh;
  bare.boundary_vertices.clear();
  bare.boundary_marker.clear();
  EXPECT_EQ(volumes.face_area, build_control_volumes(bare).face_area);
}

TEST(Dual, AFlatSimplexIsAnInputError) {
  Mesh<2> mesh;
  for (const Vec<2>& p : {Vec<2>{0, 0}, Vec<2>{1, 0}, Vec<2>{2, 0}}) mesh.points.push_back(p);
  mesh.simplex_vertices.push_back({VertexId(0), VertexId(1), VertexId(2)});
  mesh.simplex_region.push_back(1);
  test::connect(mesh);
  try {
    build_control_volumes(mesh);
    FAIL() << "accepted a flat triangle";
  } catch (const InputError& error) {
    EXPECT_EQ(error.id(), "mesh.degenerate_simplex");
    EXPECT_FALSE(error.faults().front().fix.empty());
  }
}

TEST(Dual, StopsWhenAsked) {
  struct Stop : Observer {
    bool cancelled() const override { return true; }
  } stop;
  const auto mesh = delaunay_mesh(perturbed_grid<3>(2, 0.01));
  EXPECT_THROW(build_control_volumes(mesh, stop), Cancelled);
}

}  // namespace
}  // namespace voropack
