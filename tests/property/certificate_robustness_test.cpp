// The certificate survives any nonsense, always says no to it, and says the same with any number of threads.
#include <gtest/gtest.h>

#include <limits>

#include "base/parallel.h"
#include "base/random.h"
#include "support/allow_threads.h"
#include "support/certificate_case.h"
#include "support/delaunay_mesh.h"

namespace voropack {
namespace {

using test::CertificateCase;

template <class Dimension>
class CertificateRobustness : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CertificateRobustness, Dimensions);

template <class Vector>
auto& any_of(Vector& vector, Random& random) {
  return vector.raw()[random.bits() % vector.size()];
}

/// Changes one number of the mesh into another one that is wrong.
template <int D>
std::string spoil(CertificateCase<D>& c, Random& random) {
  Mesh<D>& mesh = c.mesh;
  const std::size_t corner = random.bits() % (D + 1);
  const VertexId v(random.bits() % mesh.points.size());
  switch (random.bits() % 8) {
    case 0: {
      auto& p = any_of(mesh.points, random);
      p[static_cast<int>(corner) % D] += 0.05 + 0.1 * random.unit();
      return "moved point";
    }
    case 1: {
      VertexId& old = any_of(mesh.simplex_vertices, random)[corner];
      old = old == v ? VertexId::none() : v;
      return "changed corner";
    }
    case 2: {
      SimplexId& n = any_of(mesh.simplex_neighbors, random)[corner];
      const SimplexId other(random.bits() % mesh.simplex_vertices.size());
      n = n == other ? SimplexId::none() : other;
      return "changed neighbor";
    }
    case 3:
      any_of(mesh.simplex_region, random) = 5;
      return "changed region";
    case 4:
      any_of(mesh.boundary_vertices, random)[corner % D] = VertexId(std::size_t{77'777});
      return "boundary of no vertex";
    case 5:
      any_of(mesh.points, random)[0] = random.bits() % 2 == 0 ? std::numeric_limits<double>::infinity() : 1e300;
      return "huge coordinate";
    case 6: {
      auto& p = any_of(mesh.points, random);
      const Vec<D>& other = mesh.points[v];
      p = p == other ? Vec<D>{} : other;
      return "point on another one";
    }
    default:
      mesh.simplex_vertices.push_back(mesh.simplex_vertices[SimplexId(0)]);
      mesh.simplex_neighbors.push_back(mesh.simplex_neighbors[SimplexId(0)]);
      mesh.simplex_region.push_back(1);
      return "repeated simplex";
  }
}

TYPED_TEST(CertificateRobustness, RejectsEveryRandomFault) {
  constexpr int D = TypeParam::value;
  const CertificateCase<D> golden = test::golden_case<D>(4);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CertificateCase<D> c = golden;
    Random random(seed);
    std::string what = spoil(c, random);
    if (c.mesh == golden.mesh) continue;
    const Certificate certificate = certify(c.mesh, c.volumes, seed % 2 == 0 ? &c.domain : nullptr);
    EXPECT_FALSE(certificate.ok) << "seed " << seed << ": " << what;
    for (const Certificate::Check& check : certificate.checks)
      EXPECT_TRUE(check.ok || !check.where.empty()) << check.name << ", seed " << seed << ": " << what;
  }
}

TYPED_TEST(CertificateRobustness, SurvivesManyFaultsAtOnce) {
  constexpr int D = TypeParam::value;
  const CertificateCase<D> golden = test::golden_case<D>(4);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CertificateCase<D> c = golden;
    Random random(100 + seed);
    for (int k = 0; k < 40; ++k) spoil(c, random);
    EXPECT_FALSE(certify(c.mesh, c.volumes, &c.domain).ok) << seed;
  }
}

TYPED_TEST(CertificateRobustness, SurvivesAMeshOfNoise) {
  constexpr int D = TypeParam::value;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Mesh<D> mesh;
    const auto any = [&] { return VertexId(random.bits() % 40); };
    for (int i = 0; i < 35; ++i) {
      Vec<D> p;
      for (int k = 0; k < D; ++k) p[k] = std::floor(4 * random.unit());
      mesh.points.push_back(p);
      mesh.vertex_spacing.push_back(random.unit() - 0.1);
    }
    for (int i = 0; i < 60; ++i) {
      std::array<VertexId, D + 1> corners;
      for (VertexId& v : corners) v = any();
      mesh.simplex_vertices.push_back(corners);
      std::array<VertexId, D> face;
      for (VertexId& v : face) v = any();
      mesh.boundary_vertices.push_back(face);
      if (D == 3) mesh.segment_edges.push_back({any(), any()});
    }
    EXPECT_FALSE(certify(mesh, ControlVolumes<D>{}).ok) << seed;
  }
}

TYPED_TEST(CertificateRobustness, IgnoresVerticesThatNoSimplexUses) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = test::golden_case<D>(4);
  Vec<D> x;
  for (int k = 0; k < D; ++k) x[k] = 0.52;
  x[1] = 0.01;  // In a protecting ball.
  c.mesh.points.push_back(x);
  c.mesh.vertex_spacing.clear();
  c.mesh.vertex_carrier_dimension.clear();
  const Certificate certificate = certify(c.mesh, c.volumes, &c.domain);
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
}

TYPED_TEST(CertificateRobustness, IsEqualForAnyNumberOfThreads) {
  const test::AllowThreads allow(8);
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = test::golden_case<D>(D == 2 ? 80 : 12);
  Random random(3);
  for (int k = 0; k < 5; ++k) any_of(c.mesh.points, random)[0] += 0.01;
  std::string first;
  for (const int threads : {1, 2, 8}) {
    Certificate certificate;
    run_with_threads(threads, [&] { certificate = certify(c.mesh, c.volumes, &c.domain); });
    if (first.empty()) first = test::summary(certificate);
    EXPECT_EQ(test::summary(certificate), first) << threads;
    EXPECT_FALSE(certificate.ok);
  }
}

TYPED_TEST(CertificateRobustness, DoesNotDependOnPositionAndScale) {
  constexpr int D = TypeParam::value;
  CertificateCase<D> c = test::golden_case<D>(4);
  const double scale = 0x1p-20;  // A power of two: no rounding.
  for (Vec<D>& p : c.mesh.points) p *= scale;
  for (double& f : c.mesh.vertex_spacing) f *= scale;
  for (Vec<D>& p : c.volumes.sites) p *= scale;
  for (double& v : c.volumes.cell_volume) v *= std::pow(scale, D);
  for (double& a : c.volumes.face_area) a *= std::pow(scale, D - 1);
  for (double& h : c.volumes.face_edge_length) h *= scale;
  const Certificate certificate = certify(c.mesh, c.volumes);
  EXPECT_TRUE(certificate.ok) << test::summary(certificate);
}

TEST(CertificateCancel, StopsOnRequest) {
  class Impatient : public Observer {
   public:
    [[nodiscard]] bool cancelled() const override { return true; }
  } impatient;
  const CertificateCase<2> c = test::golden_case<2>(4);
  EXPECT_THROW(certify<2>(c.mesh, c.volumes, nullptr, {}, impatient), Cancelled);
}

}  // namespace
}  // namespace voropack
