#include <gtest/gtest.h>

#include "support/shared_data.h"
#include "support/small_meshes.h"
#include "support/temporary_folder.h"
#include "voropack/io.h"

namespace voropack {
namespace {

using test::square_mesh;
using test::TemporaryFolder;
using test::two_tetrahedra;

template <int D>
Mesh<D> read_as(const std::filesystem::path& path) {
  return std::get<Mesh<D>>(read_mesh(path));
}

TEST(NodeMesh, RoundTripKeepsAllButCarrierDimensions) {
  const TemporaryFolder folder;
  Mesh<2> square = square_mesh();
  write_mesh(square, folder / "square.node");
  square.vertex_carrier_dimension.clear();
  EXPECT_EQ(read_as<2>(folder / "square.node"), square);

  Mesh<3> pair = two_tetrahedra();
  write_mesh(pair, folder / "new" / "folder" / "pair.node");
  pair.vertex_carrier_dimension.clear();
  EXPECT_EQ(read_as<3>(folder / "new" / "folder" / "pair.node"), pair);
}

TEST(NodeMesh, ReadsTheAirfoil) {
  const auto path = test::shared_data("airfoil/airfoil.node");
  if (!path) GTEST_SKIP() << "shared data is absent";
  const Mesh<2> mesh = read_as<2>(*path);
  EXPECT_EQ(mesh.points.size(), 4253U);
  EXPECT_EQ(mesh.simplex_vertices.size(), 8034U);
  EXPECT_EQ(mesh.boundary_vertices.size(), 476U);
  EXPECT_EQ(find_mesh_fault(mesh), "");
}

TEST(VtuMesh, RoundTripKeepsEverything) {
  const TemporaryFolder folder;
  write_mesh(square_mesh(), folder / "square.vtu");
  EXPECT_EQ(read_as<2>(folder / "square.vtu"), square_mesh());
  write_mesh(two_tetrahedra(), folder / "pair.vtu");
  EXPECT_EQ(read_as<3>(folder / "pair.vtu"), two_tetrahedra());
}

}  // namespace
}  // namespace voropack
