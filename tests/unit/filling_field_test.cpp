// A mesh's spacing in the simplex that holds a point is the Lipschitz envelope over all simplices.
#include "spacing/filling_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "base/random.h"
#include "spacing/affine_envelope.h"
#include "support/cases.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

using test::random_point;

constexpr double kSlope = 0.25;

/// Cones of `steepness` times the slope over random values: where that is near to 1, the linear functions on slivers
/// are steeper than the slope.
template <int D>
std::vector<double> cones(const Mesh<D>& mesh, double steepness, Random& random) {
  std::vector<double> tips, values;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) tips.push_back(0.1 + random.unit());
  for (const Vec<D>& x : mesh.points) {
    double least = std::numeric_limits<double>::infinity();
    for (const VertexId v : ids(mesh.points))
      least = std::min(least, tips[v.value()] + steepness * kSlope * distance(x, mesh.points[v]));
    values.push_back(least);
  }
  return values;
}

template <int D>
Mesh<D> random_mesh() {
  return test::mesh_of(domains::unit_box<D>(), D == 2 ? 0.1 : 0.25, Interior::kRandom);
}

template <int D>
void expect_envelope(double steepness) {
  Random random(7);
  const Mesh<D> mesh = random_mesh<D>();
  const std::vector<double> values = cones(mesh, steepness, random);
  const FillingField<D> field(mesh, values, kSlope);
  EXPECT_EQ(field.size(), mesh.simplex_vertices.size());
  for (int i = 0; i < 400; ++i) {
    const Vec<D> x = i % 2 == 0 ? random_point<D>(random, 0, 1) : random_point<D>(random, -0.5, 1.5);
    double envelope = std::numeric_limits<double>::infinity();
    for (const auto& vertices : mesh.simplex_vertices) {
      std::array<Vec<D>, D + 1> corners;
      std::array<double, D + 1> at;
      for (std::size_t k = 0; k <= D; ++k) corners[k] = mesh.points[vertices[k]], at[k] = values[vertices[k].value()];
      envelope = std::min(envelope, affine_envelope<D>(corners, at, kSlope, x));
    }
    EXPECT_NEAR(field.at(x), envelope, 1e-7);
  }
}

TEST(FillingField, IsTheEnvelopeOverAllSimplicesOfAConvexDomain) {
  for (const double steepness : {0.3, 0.99}) {
    expect_envelope<2>(steepness);
    expect_envelope<3>(steepness);
  }
}

TEST(FillingField, RangesHoldWhatIsInTheBox) {
  Random random(8);
  const Mesh<3> mesh = random_mesh<3>();
  const FillingField<3> field(mesh, cones(mesh, 0.5, random), kSlope);
  for (int i = 0; i < 200; ++i) {
    Box<3> box(random_point<3>(random, 0, 1), random_point<3>(random, 0, 1));
    for (int k = 0; k < 3; ++k)
      if (box.lo[k] > box.hi[k]) std::swap(box.lo[k], box.hi[k]);
    const Interval range = field.range(box);
    Vec<3> x;
    for (int k = 0; k < 3; ++k) x[k] = box.lo[k] + random.unit() * (box.hi[k] - box.lo[k]);
    EXPECT_GE(field.at(x), range.lo * (1 - 1e-12));
    EXPECT_LE(field.at(x), range.hi * (1 + 1e-12));
    EXPECT_FALSE(field.constant_on(box) && range.lo < range.hi);
  }
  EXPECT_EQ(field.range(Box<3>({2.0, 2.0, 2.0}, {3.0, 3.0, 3.0})).hi, std::numeric_limits<double>::infinity());
}

TEST(FillingField, SeesConstants) {
  const Mesh<2> mesh = random_mesh<2>();
  std::vector<double> values;
  for (const Vec<2>& x : mesh.points) values.push_back(0.1 + 0.2 * std::max(0.0, x[0] - 0.5));
  const FillingField<2> field(mesh, values, kSlope);
  EXPECT_EQ(field.constant_on(Box<2>({0.0, 0.0}, {0.25, 1.0})), 0.1);
  EXPECT_EQ(field.constant_on(Box<2>({0.0, 0.0}, {0.75, 1.0})), std::nullopt);
  EXPECT_EQ(field.constant_on(Box<2>({2.0, 0.0}, {3.0, 1.0})), std::nullopt);
}

}  // namespace
}  // namespace voropack
