// What holds of the levels of every hierarchy.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "voropack/certificate.h"
#include "voropack/coarsening.h"
#include "voropack/dual.h"

namespace voropack::test {

/// Each vertex of the level is one of the finest mesh and one of the next finer one, in the same place, no two are the
/// same one, and there are fewer than on the next finer one.
template <int D>
void expect_nested(const Mesh<D>& finest, const Mesh<D>& finer, const CoarseLevel<D>& level) {
  ASSERT_EQ(level.finest_vertex.size(), level.mesh.points.size());
  ASSERT_EQ(level.finer_vertex.size(), level.mesh.points.size());
  EXPECT_LT(level.mesh.points.size(), finer.points.size());
  std::vector<std::uint8_t> seen(finer.points.size(), 0);
  for (const VertexId v : ids(level.mesh.points)) {
    EXPECT_EQ(level.mesh.points[v], finest.points[level.finest_vertex[v]]);
    EXPECT_EQ(level.mesh.points[v], finer.points[level.finer_vertex[v]]);
    EXPECT_EQ(seen[level.finer_vertex[v].value()]++, 0);
  }
}

/// All levels, each with fewer vertices than the one before.
template <int D>
void expect_nested(const Mesh<D>& finest, const CoarseningHierarchy<D>& hierarchy) {
  const Mesh<D>* finer = &finest;
  for (const CoarseLevel<D>& level : hierarchy.levels) {
    expect_nested(finest, *finer, level);
    finer = &level.mesh;
  }
}

/// Certified as what the level says that it is: Voronoi-maximal, or maximal with its epsilon; and
/// `gradation`-Lipschitz.
template <int D>
void expect_certified(const CoarseLevel<D>& level, const Domain<D>* domain, std::optional<double> gradation = {}) {
  CertificateOptions claims;
  claims.gradation = gradation;
  if (level.epsilon > 0) {
    claims.form = PackingForm::kMaximal;
    claims.epsilon = level.epsilon;
  }
  for (const Certificate::Check& check :
       certify<D>(level.mesh, build_control_volumes(level.mesh), domain, claims).checks)
    EXPECT_TRUE(check.ok) << check.name << ": " << check.violations << " of " << check.tested << ", " << check.where;
}

}  // namespace voropack::test
