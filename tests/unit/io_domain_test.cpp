#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "support/shared_data.h"
#include "support/temporary_folder.h"
#include "voropack/io.h"

namespace voropack {
namespace {

using test::TemporaryFolder;

template <int D>
DomainInput<D> read_as(const std::filesystem::path& path) {
  return std::get<DomainInput<D>>(read_domain(path));
}

/// The fault that reading `content` from a file of that name gives; its id is empty if there was none.
Fault fault_of(const std::string& name, const std::string& content) {
  const TemporaryFolder folder;
  try {
    read_domain(folder.write(name, content));
  } catch (const Error& error) {
    EXPECT_FALSE(error.faults().front().fix.empty());
    EXPECT_NE(error.faults().front().file.find(name), std::string::npos);
    return error.faults().front();
  }
  return {};
}

const std::string kCubePoints = "8 3 0 0\n0 0 0 0\n1 1 0 0\n2 1 1 0\n3 0 1 0\n4 0 0 1\n5 1 0 1\n6 1 1 1\n7 0 1 1\n";

TEST(PolyOfTriangle, ReadsEveryPart) {
  const TemporaryFolder folder;
  const auto input = read_as<2>(folder.write("a.poly",
                                             "\xEF\xBB\xBF# comment\r\n4 2 1 1\r\n"
                                             "1 0 0 9.5 3 # a corner\r\n2 +1 0 9.5 0\r\n\r\n3 1 1e0 0 1\r\n"
                                             "4 0 1 0 1\r\n4 1\r\n1 1 2 7\r\n2 2 3 0\r\n3 3 4 8\r\n4 4 1 -9\r\n"
                                             "1\r\n1 .5 .5\r\n2\r\n1 .1 .1 12 0.25\r\n2 .2 .2 -3.0 -1"));
  ASSERT_EQ(input.points.size(), 4U);
  EXPECT_EQ(input.points[2], (Vec<2>{1.0, 1.0}));
  EXPECT_EQ(input.first_index, 1U);
  EXPECT_FALSE(input.is_surface);
  EXPECT_EQ(input.point_markers, (std::vector<std::optional<int>>{3, std::nullopt, 1, 1}));
  ASSERT_EQ(input.segments.size(), 4U);
  EXPECT_EQ(input.segments[3].points, (std::array<std::uint32_t, 2>{3, 0}));
  EXPECT_EQ(input.segments[0].marker, 7);
  EXPECT_EQ(input.segments[1].marker, std::nullopt);
  EXPECT_EQ(input.segments[3].marker, -9);
  EXPECT_EQ(input.segments[0].line, 9U);
  EXPECT_EQ(input.hole_seeds, (std::vector<Vec<2>>{{0.5, 0.5}}));
  ASSERT_EQ(input.region_seeds.size(), 2U);
  EXPECT_EQ(input.region_seeds[0].id, 12);
  EXPECT_EQ(input.region_seeds[0].max_measure, 0.25);
  EXPECT_EQ(input.region_seeds[1].id, -3);
  EXPECT_EQ(input.region_seeds[1].max_measure, std::nullopt);
}

TEST(PolyOfTetgen, ReadsFacetsOfSeveralPolygonsAndHoles) {
  const TemporaryFolder folder;
  const auto input =
      read_as<3>(folder.write("a.poly", kCubePoints + "3 1\n2 1 5\n4 0 1\n2 3\n3 4 5 6\n1 .2 .3 0\n"
                                                      "1\n4 4 5 6 7\n1 0 0\n2 0 6\n0\n1\n1 .5 .5 .5 4\n"));
  ASSERT_EQ(input.facets.size(), 3U);
  EXPECT_EQ(input.facets[0].polygons, (std::vector<std::vector<std::uint32_t>>{{0, 1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(input.facets[0].holes, (std::vector<Vec<3>>{{0.2, 0.3, 0.0}}));
  EXPECT_EQ(input.facets[0].marker, 5);
  EXPECT_EQ(input.facets[0].line, 11U);
  EXPECT_EQ(input.facets[1].marker, std::nullopt);
  EXPECT_EQ(input.facets[2].marker, std::nullopt);
  EXPECT_EQ(input.facets[2].polygons[0].size(), 2U);
  EXPECT_EQ(input.region_seeds[0].id, 4);
}

TEST(Smesh, ReadsOnePolygonForEachFacet) {
  const TemporaryFolder folder;
  const auto input =
      read_as<3>(folder.write("a.smesh", kCubePoints + "2 1\n4 0 1 2 3 6\n3 4 5\n6\n1\n1 .5 .5 .5\n0\n"));
  ASSERT_EQ(input.facets.size(), 2U);
  EXPECT_EQ(input.facets[0].marker, 6);
  EXPECT_EQ(input.facets[1].polygons[0], (std::vector<std::uint32_t>{4, 5, 6}));
  EXPECT_EQ(input.hole_seeds.size(), 1U);
}

TEST(Poly, TakesPointsFromTheNodeFileBesideIt) {
  const TemporaryFolder folder;
  folder.write("a.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n");
  const auto input = read_as<2>(folder.write("a.poly", "0 2\n1 0\n1 1 3\n0\n"));
  EXPECT_EQ(input.points.size(), 3U);
  EXPECT_EQ(input.segments[0].points, (std::array<std::uint32_t, 2>{0, 2}));
}

TEST(Node, GivesPointsOnly) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_as<2>(folder.write("a.node", "1 2 0 0\n0 3 4\n")).points, (std::vector<Vec<2>>{{3.0, 4.0}}));
  EXPECT_EQ(read_as<3>(folder.write("b.node", "1 3\n1 3 4 5")).points, (std::vector<Vec<3>>{{3.0, 4.0, 5.0}}));
}

TEST(Off, ToleratesColorsNormalsAndCountsOnTheHeaderLine) {
  const TemporaryFolder folder;
  const auto input =
      read_as<3>(folder.write("a.off",
                              "STCNOFF 3 1 3\n0 0 0 0 0 0 0 1 .1 .2 .3\n"
                              "1 0 0 0 0 0 0 1 255 0 0 255\n0 1 0 0 0 0 0 1 1 1 1\n3 0 1 2 0.5 0.5 0.5\n"));
  EXPECT_TRUE(input.is_surface);
  EXPECT_EQ(input.points.size(), 3U);
  EXPECT_EQ(input.facets.at(0).polygons.at(0), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(input.facets.at(0).line, 5U);
}

TEST(Obj, ReadsReferencesOfEveryForm) {
  const TemporaryFolder folder;
  const auto input = read_as<3>(folder.write("a.obj",
                                             "# x\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1.0\nvt 0 0\n"
                                             "vn 0 0 1\nf 1/1/1 2//1 3/1\nf -3 \\\n -2 -1\nl 1 2 3\n"));
  EXPECT_TRUE(input.is_surface);
  EXPECT_EQ(input.points.size(), 3U);
  ASSERT_EQ(input.facets.size(), 2U);
  EXPECT_EQ(input.facets[0].polygons, input.facets[1].polygons);
  EXPECT_EQ(input.facets[1].line, 10U);
  ASSERT_EQ(input.segments.size(), 2U);
  EXPECT_EQ(input.segments[1].points, (std::array<std::uint32_t, 2>{1, 2}));
  EXPECT_EQ(input.segments[1].line, 12U);
}

const std::string kTextStl =
    "solid a b c\n facet normal 0 0 nan\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0\n  endloop\n"
    " endfacet\nFACET NORMAL 0 0 1\n OUTER LOOP\nVERTEX 1 0 0\nVERTEX 1 1 0\nVERTEX -0 1 0\nENDLOOP\nENDFACET\n"
    "endsolid a b c\n";

std::string binary_stl(std::string_view header, std::uint32_t announced, std::uint32_t n, float last = 1) {
  std::string bytes(header);
  bytes.resize(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&announced), 4);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::array<float, 12> values = {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, static_cast<float>(i), last};
    bytes.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Stl, WeldsEqualCoordinates) {
  const TemporaryFolder folder;
  const auto text = read_as<3>(folder.write("a.stl", kTextStl));
  EXPECT_EQ(text.points.size(), 4U);
  EXPECT_EQ(text.facets.at(1).polygons.at(0), (std::vector<std::uint32_t>{1, 3, 2}));
  EXPECT_EQ(text.facets.at(1).line, 9U);
  EXPECT_TRUE(text.is_surface);
  // The size, not the first word, tells that it is binary.
  const auto binary = read_as<3>(folder.write("b.stl", binary_stl("solid but binary", 3, 3)));
  EXPECT_EQ(binary.facets.size(), 3U);
  EXPECT_EQ(binary.points.size(), 5U);
}

const std::string kPlyHeader =
    "comment made by hand\nelement thing 2\nproperty list uchar short stuff\nproperty int more\nelement vertex 3\n"
    "property uchar red\nproperty double z\nproperty float x\nproperty float y\nelement face 1\n"
    "property float quality\nproperty list uint8 int vertex_index\nend_header\n";

std::string binary_ply(bool big_endian) {
  std::string bytes =
      std::string("ply\nformat binary_") + (big_endian ? "big" : "little") + "_endian 1.0\n" + kPlyHeader;
  const auto put = [&](auto value) {
    std::array<char, sizeof value> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    if (big_endian) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
  };
  put(std::uint8_t{2}), put(std::int16_t{1}), put(std::int16_t{2}), put(std::int32_t{3});
  put(std::uint8_t{0}), put(std::int32_t{3});
  for (const std::array<float, 2> p : {std::array{0.0F, 0.0F}, std::array{1.0F, 0.0F}, std::array{0.0F, 2.0F}})
    put(std::uint8_t{255}), put(0.1), put(p[0]), put(p[1]);
  put(0.5F), put(std::uint8_t{3}), put(std::int32_t{0}), put(std::int32_t{1}), put(std::int32_t{2});
  return bytes;
}

TEST(Ply, ReadsTextAndBothByteOrdersAlike) {
  const TemporaryFolder folder;
  const auto text =
      read_as<3>(folder.write("a.ply", "ply\nformat ascii 1.0\n" + kPlyHeader +
                                           "2 1 2 3\n0 3\n255 .1 0 0\n255 .1 1 0\n255 .1 0 2\n.5 3 0 1 2\n"));
  ASSERT_EQ(text.points, (std::vector<Vec<3>>{{0.0, 0.0, 0.1}, {1.0, 0.0, 0.1}, {0.0, 2.0, 0.1}}));
  EXPECT_EQ(text.facets.at(0).polygons.at(0), (std::vector<std::uint32_t>{0, 1, 2}));
  for (const bool big_endian : {false, true}) {
    const auto binary = read_as<3>(folder.write("b.ply", binary_ply(big_endian)));
    EXPECT_EQ(binary.points, text.points);
    EXPECT_EQ(binary.facets.at(0).polygons, text.facets.at(0).polygons);
  }
}

TEST(Domain, MissingFoldersAndEmptyFilesAreNamed) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.off");
  for (const char* name : {"absent.off", "folder.off"}) {
    try {
      read_domain(folder / name);
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.id(), "io.cannot_open");
    }
  }
  EXPECT_EQ(fault_of("a.off", "").id, "io.empty_file");
  EXPECT_EQ(fault_of("a.xyz", "1 2 3").id, "io.unknown_format");
  try {
    read_domain(folder.write("a.poly", "0 2 0 0\n0 0\n0\n"));
    ADD_FAILURE() << "the .node file is absent";
  } catch (const InputError& error) {
    EXPECT_EQ(error.id(), "io.cannot_open");
    EXPECT_EQ(error.faults().front().file, (folder / "a.node").string());
  }
}

struct BadFile {
  const char* name;
  std::string content;
  const char* id;
  std::optional<std::uint64_t> line;
};

class BadDomainFile : public testing::TestWithParam<BadFile> {};

TEST_P(BadDomainFile, IsRejectedWithIdAndLine) {
  const Fault fault = fault_of(GetParam().name, GetParam().content);
  EXPECT_EQ(fault.id, GetParam().id) << fault.text();
  EXPECT_EQ(fault.line, GetParam().line) << fault.text();
}

const std::string kTriangle = "3 2 0 0\n0 0 0\n1 1 0\n2 0 1\n";

INSTANTIATE_TEST_SUITE_P(
    All, BadDomainFile,
    testing::Values(
        BadFile{"a.node", "2 2 0 0\n0 0 0\n", "io.truncated", 2}, BadFile{"a.node", "# only\n", "io.truncated", 1},
        BadFile{"a.node", "1 2 0 0\n0 x 0\n", "io.bad_number", 2},
        BadFile{"a.node", "1 2 0 0\n0 0x1 0\n", "io.bad_number", 2},
        BadFile{"a.node", "1 2 0 0\n0 1,5 0\n", "io.bad_number", 2},
        BadFile{"a.node", "1 2 0 0\n0 nan 0\n", "io.not_finite", 2},
        BadFile{"a.node", "1 2 0 0\n0 0 -inf\n", "io.not_finite", 2},
        BadFile{"a.node", "1 2 0 0\n0 1e999 0\n", "io.not_finite", 2},
        BadFile{"a.node", "1 2 0 0\n0 0\n", "io.missing_value", 2},
        BadFile{"a.node", "1 2 0 0\n0 0 0 0\n", "io.extra_value", 2},
        BadFile{"a.node", "1 2 0 0\n0 0 0\n1 0 0\n", "io.bad_count", 3},
        BadFile{"a.node", "1 2 0 2\n0 0 0\n", "io.bad_count", 1},
        BadFile{"a.node", "1000000000000000000 2 0 0\n0 0 0\n", "io.bad_count", 1},
        BadFile{"a.node", "1000000000 3 0 0\n0 0 0 0\n", "io.bad_count", 1},
        BadFile{"a.node", "1 3 1000000000000000000 0\n0 0 0 0\n", "io.bad_count", 1},
        BadFile{"a.node", "99999999999999999999 2 0 0\n", "io.bad_number", 1},
        BadFile{"a.node", "-1 2 0 0\n", "io.bad_count", 1}, BadFile{"a.node", "1 4 0 0\n", "io.bad_dimension", 1},
        BadFile{"a.node", "1\n0 0 0\n", "io.bad_dimension", 1}, BadFile{"a.node", "1 2\n5 0 0\n", "io.bad_index", 2},
        BadFile{"a.node", "2 2\n1 0 0\n3 0 0\n", "io.bad_index", 3},
        BadFile{"a.node", std::string("\0\x01\xff\xfe junk", 10), "io.bad_number", 1},
        BadFile{"a.smesh", kTriangle + "0 0\n0\n0\n", "io.bad_dimension", 1},
        BadFile{"a.poly", kTriangle + "1 0\n0 0 3\n0\n", "io.bad_index", 6},
        BadFile{"a.poly", kTriangle + "1 0\n0 -1 2\n0\n", "io.bad_index", 6},
        BadFile{"a.poly", kTriangle + "1 0\n0 0 1 7\n0\n", "io.extra_value", 6},
        BadFile{"a.poly", kTriangle + "2 0\n0 0 1\n0\n", "io.missing_value", 7},
        BadFile{"a.poly", kTriangle + "0 0\n1\n", "io.truncated", 6},
        BadFile{"a.poly", kTriangle + "0 0\n0\n1\n0 .1 .1 1.5\n", "io.bad_region", 8},
        BadFile{"a.poly", kTriangle + "0 0\n0\n1\n0 .1 .1 3e9\n", "io.bad_region", 8},
        BadFile{"a.poly", kTriangle + "0 0\n0\n0\n0 0\n", "io.bad_count", 8},
        BadFile{"a.poly", kCubePoints + "1 0\n0\n", "io.bad_count", 11},
        BadFile{"a.poly", kCubePoints + "1 0\n1\n4 0 1 2", "io.truncated", 12},
        BadFile{"a.poly", kCubePoints + "1 0\n1\n0\n", "io.bad_count", 12},
        BadFile{"a.off", "3 1 0\n0 0 0\n", "io.bad_header", 1},
        BadFile{"a.off", "4OFF\n3 1 0\n0 0 0\n", "io.unsupported", 1},
        BadFile{"a.off", "OFF BINARY\n1 1 0\n", "io.unsupported", 1},
        BadFile{"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "io.bad_index", 4},
        BadFile{"a.off", "OFF\n1 1 0\n0 0 0 1\n3 0 0 0\n", "io.extra_value", 3},
        BadFile{"a.off", "OFF\n1 1 0\n0 0 0\n0        \n", "io.bad_count", 4},
        BadFile{"a.off", "OFF\n1 2000000000 0\n0 0 0\n", "io.bad_count", 2},
        BadFile{"a.off", "OFF\n1 1 0\n0 0 0\n", "io.truncated", 3},
        BadFile{"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 0\n3 0 0 0\n", "io.bad_count", 5},
        BadFile{"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "io.missing_value", 4},
        BadFile{"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "io.truncated", 4},
        BadFile{"a.stl", "solid a\nhello\n", "io.unexpected_word", 2},
        BadFile{"a.stl", kTextStl + "rest", "io.bad_count", 17},
        BadFile{"a.stl", "short", "io.truncated", std::nullopt},
        BadFile{"a.stl", binary_stl("x", 4, 3), "io.truncated", std::nullopt},
        BadFile{"a.stl", binary_stl("x", 4000000000U, 3), "io.truncated", std::nullopt},
        BadFile{"a.stl", binary_stl("x", 2, 3), "io.bad_count", std::nullopt},
        BadFile{"a.stl", binary_stl("x", 2, 2, std::numeric_limits<float>::infinity()), "io.not_finite", std::nullopt},
        BadFile{"a.obj", "v 0 0 0\nf 1 1\n", "io.bad_count", 2},
        BadFile{"a.obj", "v 0 0 0\nf 1 2 3\n", "io.bad_index", 2},
        BadFile{"a.obj", "v 0 0 0\nf 0 1 1\n", "io.bad_index", 2},
        BadFile{"a.obj", "v 0 0 0\nf a b c\n", "io.bad_number", 2},
        BadFile{"a.obj", "v 0 0 0\ncurv 0 1 2\n", "io.unexpected_word", 2},
        BadFile{"a.ply", "plx\n", "io.bad_header", 1}, BadFile{"a.ply", "ply\nformat xml 1.0\n", "io.bad_header", 2},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", "io.bad_header", 4},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "io.bad_header", std::nullopt},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 0\nelement tristrips 0\nend_header\n", "io.unsupported",
                std::nullopt},
        BadFile{"a.ply", "ply\nformat ascii 1.0\n" + kPlyHeader + "2 1 2 3\n0 3\n255 .1 0 0\n", "io.truncated",
                std::nullopt},
        BadFile{"a.ply", "ply\nformat ascii 1.0\n" + kPlyHeader + "9 1 2 3\n0 3\n255 .1 0 0\n255 .1 1 0\n255 .1 0 2\n",
                "io.missing_value", 16},
        BadFile{"a.ply", binary_ply(false).substr(0, 370), "io.truncated", std::nullopt},
        BadFile{"a.ply", binary_ply(false).substr(0, binary_ply(false).size() - 1), "io.truncated", std::nullopt},
        BadFile{"a.ply", binary_ply(true) + "xx", "io.bad_count", std::nullopt}),
    [](const auto& test) {
      std::string name = std::to_string(test.index) + "_" + test.param.name + "_" + test.param.id;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return c == '.'; }, '_');
      return name;
    });

TEST(SharedDomains, AreAllRead) {
  const auto root = test::shared_data("plc");
  if (!root) GTEST_SKIP() << "shared data is absent";
  std::size_t n = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*root)) {
    if (!entry.is_regular_file()) continue;
    SCOPED_TRACE(entry.path());
    const auto input = read_as<3>(entry.path());
    EXPECT_GE(input.points.size(), 4U);
    EXPECT_GE(input.facets.size(), 4U);
    ++n;
  }
  EXPECT_GE(n, 20U);
}

TEST(SharedDomains, TheSphereIsTheSameInEveryFormat) {
  const auto root = test::shared_data("plc/surfaces");
  if (!root) GTEST_SKIP() << "shared data is absent";
  const auto off = read_as<3>(*root / "sphere.off"), ply = read_as<3>(*root / "sphere.ply");
  const auto stl = read_as<3>(*root / "sphere.stl");
  EXPECT_EQ(ply.points, off.points);
  EXPECT_EQ(stl.points.size(), off.points.size());
  EXPECT_EQ(stl.facets.size(), off.facets.size());
}

TEST(SharedDomains, AirfoilTakesItsPointsFromTheNodeFile) {
  const auto path = test::shared_data("airfoil/airfoil.poly");
  if (!path) GTEST_SKIP() << "shared data is absent";
  const auto input = read_as<2>(*path);
  EXPECT_EQ(input.points.size(), 4253U);
  EXPECT_EQ(input.segments.size(), 476U);
  EXPECT_EQ(input.hole_seeds.size(), 3U);
  EXPECT_EQ(input.segments.front().points, (std::array<std::uint32_t, 2>{0, 17}));
  EXPECT_EQ(input.segments.front().marker, 1);
  EXPECT_EQ(input.segments.front().line, 3U);
}

}  // namespace
}  // namespace voropack
