// The certificate's checks of control volumes: each tampered number is found and named.
#include <gtest/gtest.h>

#include "support/certificate_case.h"

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

}  // namespace
}  // namespace voropack
