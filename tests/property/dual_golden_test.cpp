// The meshes of Figure 3 against the figures of an independent prototype.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "support/shared_data.h"
#include "voropack/dual.h"
#include "voropack/io.h"
#include "voropack/quality.h"

namespace voropack {
namespace {

class GoldenCube : public testing::TestWithParam<const char*> {};

TEST_P(GoldenCube, HasThePrototypesFigures) {
  const auto node = test::shared_data(std::string("../reference/golden/") + GetParam() + ".node");
  if (!node) GTEST_SKIP() << "no shared reference data";
  const auto mesh = std::get<Mesh<3>>(read_mesh(*node));
  auto json_path = *node;
  std::ifstream file(json_path.replace_extension(".json"));
  const auto golden = nlohmann::json::parse(file);
  const auto volumes = build_control_volumes(mesh);
  const auto quality = measure_quality(mesh, volumes);

  EXPECT_EQ(quality.n_simplices, golden["ntet"].get<double>());
  EXPECT_EQ(volumes.cell_vertex.size(), golden["nused"].get<double>());
  EXPECT_NEAR(quality.volume_sum, golden["vol"].get<double>(), 1e-13);
  EXPECT_NEAR(quality.domain_volume, golden["vol"].get<double>(), 1e-13);
  EXPECT_EQ(quality.n_negative_faces, 0U);
  EXPECT_EQ(volumes.face_area.size() + volumes.n_zero_areas, golden["nedges"].get<std::size_t>());
  double area_sum = 0;
  for (const double area : volumes.face_area) area_sum += area;
  EXPECT_NEAR(area_sum, golden["sumA"].get<double>(), 1e-12 * area_sum);
  EXPECT_NEAR(quality.radius_edge.max, golden["radius_edge"].get<double>(), 1e-12);
  EXPECT_NEAR(quality.dihedral_deg->min, golden["mindih"].get<double>(), 1e-9);

  // The smallest area of an edge with an end inside the cube.
  double least = std::numeric_limits<double>::infinity();
  const auto inside = [&](VertexId v) {
    const auto& x = mesh.points[v].coord;
    return std::all_of(x.begin(), x.end(), [](double c) { return c > 0 && c < 1; });
  };
  for (const DualFaceId f : ids(volumes.face_area)) {
    const auto [i, j] = volumes.face_vertices[f];
    if (inside(i) || inside(j)) least = std::min(least, volumes.face_area[f]);
  }
  const double expected = golden["minA_int"].get<double>();
  EXPECT_NEAR(least, expected, 1e-14 + 1e-6 * expected);
}

INSTANTIATE_TEST_SUITE_P(Figure3, GoldenCube,
                         testing::Values("cube_n4_eps0.01_s0", "cube_n4_eps0.0001_s0", "cube_n8_eps0.01_s0"));

}  // namespace
}  // namespace voropack
