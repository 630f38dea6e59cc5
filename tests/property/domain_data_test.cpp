// Files that others made: CAD-like solids, smooth surfaces and small angles.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "support/plc_files.h"
#include "support/shared_data.h"
#include "voropack/domain.h"
#include "voropack/error.h"

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

std::string first_fault(const DomainInput<3>& input, double min_angle_deg) {
  try {
    build_domain(input, {.min_angle_deg = min_angle_deg});
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
    EXPECT_NEAR(sum / test::enclosed_volume(input), 1, 1e-12);
  }
  EXPECT_EQ(first_fault(input, 60), GetParam().at_60_degrees ? "" : "domain.small_angle");
}

INSTANTIATE_TEST_SUITE_P(
    Domain, AcceptedFile,
    testing::Values(DataCase{"solids/cubes.off", 2, true}, DataCase{"solids/hole.off"}, DataCase{"solids/joint.off"},
                    DataCase{"solids/pipe.off", 1, true}, DataCase{"solids/spool.off"}, DataCase{"solids/star.off"},
                    DataCase{"solids/step.off"}, DataCase{"solids/u.off"}, DataCase{"small-angles/slit-1.smesh"},
                    DataCase{"small-angles/slit-5.smesh"}, DataCase{"small-angles/slit-10.smesh"},
                    DataCase{"small-angles/spike-1-7.smesh"}, DataCase{"small-angles/spike-5-7.smesh"},
                    DataCase{"small-angles/spike-10-4.smesh"}, DataCase{"small-angles/spike-10-10.smesh"},
                    DataCase{"small-angles/wedge-1.smesh"}, DataCase{"small-angles/wedge-5.smesh"},
                    DataCase{"small-angles/wedge-10.smesh"}, DataCase{"surfaces/eight.off"},
                    DataCase{"surfaces/knot1.off"}, DataCase{"surfaces/sphere.off"}));

TEST(DomainData, PolygonsRoundedToSixDigitsAreNotPlanar) {
  for (const char* file : {"plc/solids/mpi.off", "plc/solids/double-torus-example.off"}) {
    const auto path = test::shared_data(file);
    if (!path) GTEST_SKIP() << "no shared data";
    EXPECT_EQ(first_fault(read(*path), 0), "domain.nonplanar_facet");
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
