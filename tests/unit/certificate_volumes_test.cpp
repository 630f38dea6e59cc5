// The certificate's checks of control volumes: each tampered number is found and named.
#include <gtest/gtest.h>

#include <algorithm>

#include "geom/predicates.h"
#include "support/certificate_case.h"
#include "support/delaunay_mesh.h"

namespace voropack {
namespace {

using test::CertificateCase;

template <class Dimension>
class CertificateVolumes : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CertificateVolumes, Dimensions);

template <int D>
const CertificateCase<D>& golden() {
  static const CertificateCase<D> golden = test::golden_case<D>(4);
  return golden;
}

/// The named check fails, and says `word`.
template <int D>
void expect_rejected(const CertificateCase<D>& c, const char* name, const std::string& word) {
  const Certificate certificate = certify(c.mesh, c.volumes);
  const Certificate::Check& check = test::check_named(certificate, name);
  EXPECT_FALSE(certificate.ok);
  EXPECT_FALSE(check.ok) << test::summary(certificate);
  EXPECT_NE(check.where.find(word), std::string::npos) << word << " is not in: " << check.where;
}

TYPED_TEST(CertificateVolumes, NamesTheCellWithAWrongVolume) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.cell_volume[CellId(7)] *= 1 + 1e-6;
  expect_rejected(c, "volume_sum", "cell 7 ");
}

TYPED_TEST(CertificateVolumes, FindsWrongVolumesWhoseSumIsRight) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  const double shift = 1e-6 * c.volumes.cell_volume[CellId(7)];
  c.volumes.cell_volume[CellId(7)] += shift;
  c.volumes.cell_volume[CellId(9)] -= shift;
  expect_rejected(c, "volume_sum", "cell ");
}

TYPED_TEST(CertificateVolumes, NamesTheCellWithANegativeVolume) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.cell_volume[CellId(3)] *= -1;
  expect_rejected(c, "volume_sum", "cell 3 ");
}

TYPED_TEST(CertificateVolumes, FindsCellsOutOfOrder) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  std::swap(c.volumes.cell_vertex[CellId(3)], c.volumes.cell_vertex[CellId(4)]);
  expect_rejected(c, "volume_sum", "cell 4 ");
}

TYPED_TEST(CertificateVolumes, NamesTheFaceWithANegativeArea) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_area[DualFaceId(5)] *= -1;
  expect_rejected(c, "dual_nonnegative", "dual face 5 ");
  expect_rejected(c, "closure", "cell ");
}

TYPED_TEST(CertificateVolumes, NamesTheFaceWithAWrongArea) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_area[DualFaceId(5)] += 1e-6;
  expect_rejected(c, "dual_nonnegative", "dual face 5 ");
  expect_rejected(c, "closure", "cell ");
}

TYPED_TEST(CertificateVolumes, NamesTheEdgeWhoseFaceIsMissing) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  std::size_t largest = 0;
  for (std::size_t f = 0; f < c.volumes.face_area.size(); ++f)
    if (c.volumes.face_area[DualFaceId(f)] > c.volumes.face_area[DualFaceId(largest)]) largest = f;
  const auto edge = c.volumes.face_vertices[DualFaceId(largest)];
  const auto at = static_cast<std::ptrdiff_t>(largest);
  c.volumes.face_vertices.raw().erase(c.volumes.face_vertices.begin() + at);
  c.volumes.face_region.raw().erase(c.volumes.face_region.begin() + at);
  c.volumes.face_area.raw().erase(c.volumes.face_area.begin() + at);
  c.volumes.face_edge_length.raw().erase(c.volumes.face_edge_length.begin() + at);
  expect_rejected(c, "dual_nonnegative", "vertex " + std::to_string(edge[0].value()) + ' ');
  expect_rejected(c, "closure", "cell ");
}

TYPED_TEST(CertificateVolumes, NamesTheFaceWithAWrongEdgeLength) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_edge_length[DualFaceId(2)] *= 1.001;
  expect_rejected(c, "dual_nonnegative", "dual face 2 ");
}

TYPED_TEST(CertificateVolumes, FindsAFaceOfNoVertex) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_vertices[DualFaceId(2)][1] = VertexId(std::size_t{4'000'000});
  expect_rejected(c, "dual_nonnegative", "dual face 2 ");
}

TYPED_TEST(CertificateVolumes, FindsAFaceInARegionWithoutCell) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_region[DualFaceId(2)] = 17;
  expect_rejected(c, "closure", "no cell");
}

TYPED_TEST(CertificateVolumes, FindsCellsOfAnotherRegion) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.cell_region[CellId(0)] = 17;
  expect_rejected(c, "volume_sum", "cell 0 ");
  expect_rejected(c, "closure", "no cell");
}

TYPED_TEST(CertificateVolumes, FindsArraysOfDifferentLength) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = golden<D>();
  c.volumes.face_area.raw().pop_back();
  expect_rejected(c, "dual_nonnegative", "differ in length");
}

/// Corners of a planar quadrilateral with rounded coordinates: a simplex of 1e-19, which products of doubles see from
/// the wrong side. Its faces 0 and 2 are on the boundary, on its faces 1 and 3 stand two simplices.
TEST(CertificateVolumes3, SeeTheOuterSideOfASimplexThatIsFlatButForRounding) {
  const auto v = [](std::size_t i) { return VertexId(i); };
  CertificateCase<3> c;
  for (const Vec<3>& x : {Vec<3>{-0.12656064911282922, 0.30554443555093475, -0.625},
                          Vec<3>{-0.23385358667337133, 0.23385358667337136, -0.625},
                          Vec<3>{-0.03901806440322564, 0.1961570560806461, -0.5},
                          Vec<3>{-0.16629392246050909, 0.11111404660392044, -0.5}, Vec<3>{0, 0, -0.75}})
    c.mesh.points.push_back(x);
  for (const auto& corners :
       {std::array{v(0), v(1), v(3), v(2)}, std::array{v(0), v(2), v(3), v(4)}, std::array{v(0), v(3), v(1), v(4)}}) {
    const auto& x = c.mesh.points;
    ASSERT_GT(orientation(x[corners[0]], x[corners[1]], x[corners[2]], x[corners[3]]), 0);
    c.mesh.simplex_vertices.push_back(corners);
    c.mesh.simplex_region.push_back(1);
  }
  test::connect(c.mesh);
  for (auto& face : c.mesh.boundary_vertices)
    if (std::ranges::is_permutation(face, std::array{v(1), v(2), v(3)})) face = {v(3), v(1), v(2)};
  test::refresh(c);
  const Certificate certificate = certify(c.mesh, c.volumes);
  EXPECT_TRUE(test::check_named(certificate, "closure").ok) << test::summary(certificate);
}

}  // namespace
}  // namespace voropack
