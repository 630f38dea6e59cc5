#include <gtest/gtest.h>

#include "support/shared_data.h"
#include "support/temporary_folder.h"
#include "voropack/io.h"

namespace voropack {
namespace {

TEST(SharedDomains, AreAllRead) {
  const auto root = test::shared_data("plc");
  if (!root) GTEST_SKIP() << "shared data is absent";
  std::size_t n = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*root)) {
    if (!entry.is_regular_file()) continue;
    SCOPED_TRACE(entry.path());
    const auto input = std::get<DomainInput<3>>(read_domain(entry.path()));
    EXPECT_GE(input.points.size(), 4U);
    EXPECT_GE(input.facets.size(), 4U);
    ++n;
  }
  EXPECT_GE(n, 20U);
}

TEST(SharedDomains, AirfoilTakesItsPointsFromTheNodeFile) {
  const auto path = test::shared_data("airfoil/airfoil.poly");
  if (!path) GTEST_SKIP() << "shared data is absent";
  const auto input = std::get<DomainInput<2>>(read_domain(*path));
  EXPECT_EQ(input.points.size(), 4253U);
  EXPECT_EQ(input.segments.size(), 476U);
  EXPECT_EQ(input.hole_seeds.size(), 3U);
  EXPECT_EQ(input.segments.front().points, (std::array<std::uint32_t, 2>{0, 17}));
  EXPECT_EQ(input.segments.front().marker, 1);
  EXPECT_EQ(input.segments.front().line, 3U);
}

}  // namespace
}  // namespace voropack
