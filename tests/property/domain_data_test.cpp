// Files that others made: CAD-like solids, smooth surfaces and small angles.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "support/plc_files.h"
#include "support/shared_data.h"
#include "voropack/domain.h"
#include "voropack/error.h"
#include "voropack/io.h"

namespace voropack {
namespace {

struct DataCase {
  std::string file;
  std::size_t n_regions = 1;
  bool at_60_degrees = false;
};

std::ostream& operator<<(std::ostream& out, const DataCase& c) { return out << c.file; }

DomainInput<3> read(const std::filesystem::path& path) {
  return path.extension() == ".off" ? test::read_off_file(path) : test::read_smesh_file(path);
}

std::string first_fault(const DomainInput<3>& input, const DomainOptions& options) {
  try {
    build_domain(input, options);
  } catch (const InputError& error) {
    return error.id();
  }
  return "";
}

class AcceptedFile : public testing::TestWithParam<DataCase> {};

TEST_P(AcceptedFile, HasTheVolumeOfItsTriangles) {
  const auto path = test::shared_data("plc/" + GetParam().file);
  if (!path) GTEST_SKIP() << "no shared data";
  const DomainInput<3> input = read(*path);
  const Domain<3> domain = build_domain(input, {.min_angle_deg = 0});
  EXPECT_EQ(domain.region_id.size(), GetParam().n_regions);
  if (domain.points.size() < 200) {
    EXPECT_EQ(find_domain_fault(domain), "");
  }
  double sum = 0;
  for (const double measure : domain.region_measure) sum += measure;
  // Polygons of .smesh files do not all turn the same way, those of .off files do.
  if (input.is_surface) {
    // Points that move by h sweep no more than h times the area, which is at most 6 diameters squared here.
    const double moved = domain.merge ? domain.merge->largest_displacement : 0;
    EXPECT_NEAR(sum, test::enclosed_volume(input), 1e-12 * sum + 6 * moved * std::pow(domain.diameter(), 2));
  }
  EXPECT_EQ(first_fault(input, {.min_angle_deg = 60}), GetParam().at_60_degrees ? "" : "domain.small_angle");
}

INSTANTIATE_TEST_SUITE_P(
    Domain, AcceptedFile,
    testing::Values(DataCase{"solids/cubes.off", 2, true}, DataCase{"solids/hole.off"},
                    DataCase{"solids/joint.off", 1, true}, DataCase{"solids/mpi.off"},
                    DataCase{"solids/double-torus-example.off"}, DataCase{"solids/pipe.off", 1, true},
                    DataCase{"solids/spool.off"}, DataCase{"solids/star.off"}, DataCase{"solids/step.off"},
                    DataCase{"solids/u.off"}, DataCase{"small-angles/slit-1.smesh"},
                    DataCase{"small-angles/slit-5.smesh"}, DataCase{"small-angles/slit-10.smesh"},
                    DataCase{"small-angles/spike-1-7.smesh"}, DataCase{"small-angles/spike-5-7.smesh"},
                    DataCase{"small-angles/spike-10-4.smesh"}, DataCase{"small-angles/spike-10-10.smesh"},
                    DataCase{"small-angles/wedge-1.smesh"}, DataCase{"small-angles/wedge-5.smesh"},
                    DataCase{"small-angles/wedge-10.smesh"}, DataCase{"surfaces/eight.off"},
                    DataCase{"surfaces/knot1.off"}, DataCase{"surfaces/sphere.off"}));

TEST(DomainData, PolygonsRoundedToSixDigitsAreNotPlanarWithoutMoving) {
  for (const char* file : {"plc/solids/mpi.off", "plc/solids/double-torus-example.off"}) {
    const auto path = test::shared_data(file);
    if (!path) GTEST_SKIP() << "no shared data";
    const DomainInput<3> input = read(*path);
    EXPECT_EQ(first_fault(input, {.min_angle_deg = 0, .merge_distance = 0}), "domain.nonplanar_facet");
    const Domain<3> domain = build_domain(input, {.min_angle_deg = 0});
    EXPECT_EQ(domain.facet_frame.size(), input.facets.size());
    ASSERT_TRUE(domain.merge.has_value());
    EXPECT_LT(domain.merge->largest_displacement, 2e-6 * domain.diameter());
  }
}

TEST(DomainData, EveryFileIsADomain) {
  const auto folder = test::shared_data("plc");
  if (!folder) GTEST_SKIP() << "no shared data";
  std::size_t n_files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*folder)) {
    if (!entry.is_regular_file()) continue;
    SCOPED_TRACE(entry.path().filename().string());
    const AnyDomainInput input = read_domain(entry.path());
    const Domain<3> domain = build_domain(std::get<DomainInput<3>>(input), {.min_angle_deg = 0});
    if (domain.points.size() < 400) {
      EXPECT_EQ(find_domain_fault(domain), "");
    }
    if (domain.merge) {
      EXPECT_LE(domain.merge->largest_displacement, domain.merge->distance);
    }
    ++n_files;
  }
  EXPECT_GE(n_files, 25U);
}

TEST(DomainData, RoundedSolidsHaveTheirFacets) {
  const std::vector<std::pair<const char*, std::size_t>> files = {{"plc/solids/joint.off", 109},
                                                                  {"plc/solids/step.off", 7},
                                                                  {"plc/surfaces/sphere.off", 320},
                                                                  {"plc/surfaces/eight.off", 634}};
  for (const auto& [file, n_facets] : files) {
    const auto path = test::shared_data(file);
    if (!path) GTEST_SKIP() << "no shared data";
    EXPECT_EQ(build_domain(read(*path), {.min_angle_deg = 0}).facet_frame.size(), n_facets) << file;
  }
}

TEST(DomainData, ASlitIsCutOutOfItsBox) {
  const auto path = test::shared_data("plc/small-angles/slit-10.smesh");
  if (!path) GTEST_SKIP() << "no shared data";
  const DomainInput<3> input = read(*path);
  const Domain<3> domain = build_domain(input, {.min_angle_deg = 0});
  const double width = input.points[12][0] - input.points[10][0];
  // A prism of height 1/2 and length 1/2 over the slit's width.
  EXPECT_NEAR(domain.region_measure[RegionId(0)], 1 - 0.5 * 0.5 * 0.5 * width, 1e-13);
  EXPECT_EQ(domain.facet_marker.size(), 10U);
}

}  // namespace
}  // namespace voropack
