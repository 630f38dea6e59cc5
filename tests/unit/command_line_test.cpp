// Parts of the command line that need no mesh: names, exit codes, files that appear together or not at all.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <new>
#include <sstream>

#include "exit_code.h"
#include "output_set.h"
#include "parameters.h"
#include "suggest.h"
#include "terminal_observer.h"
#include "voropack/error.h"

namespace voropack::app {
namespace {

namespace fs = std::filesystem;

TEST(Suggest, EditDistanceCountsInsertionsDeletionsSubstitutionsAndSwaps) {
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("size", "size"), 0U);
  EXPECT_EQ(edit_distance("sise", "size"), 1U);
  EXPECT_EQ(edit_distance("szie", "size"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Suggest, FindsTheNearestName) {
  const std::array<std::string, 3> names = {"--size", "--seed", "--spacing"};
  EXPECT_EQ(nearest_name("--sise", names), "--size");
  EXPECT_EQ(nearest_name("--spacign", names), "--spacing");
  EXPECT_FALSE(nearest_name("--size", {}).has_value());
}

TEST(ExitCode, EachErrorHasItsOwn) {
  const Fault fault{.id = "test", .message = "message"};
  EXPECT_EQ(explain(InputError(fault)).code, ExitCode::kInput);
  EXPECT_EQ(explain(OptionError(fault)).code, ExitCode::kInput);
  EXPECT_EQ(explain(LimitError(fault)).code, ExitCode::kLimit);
  EXPECT_EQ(explain(std::bad_alloc()).code, ExitCode::kLimit);
  EXPECT_EQ(explain(NumericalError(fault)).code, ExitCode::kNotConverged);
  EXPECT_EQ(explain(InternalError(fault)).code, ExitCode::kInternal);
  EXPECT_EQ(explain(std::logic_error("unforeseen")).code, ExitCode::kInternal);
  EXPECT_EQ(explain(Cancelled()).code, ExitCode::kInterrupted);
}

TEST(Parameters, NumbersMustBePositiveAndFinite) {
  for (const char* good : {"1", "+1", "0.5", "1e-3", "2E5", ".5"})
    EXPECT_EQ(positive_number()(std::string(good)), "") << good;
  for (const char* bad : {"0", "-1", "nan", "inf", "-inf", "", "1x", "x", "1,5", "1e999", "0x10", " 1"})
    EXPECT_NE(positive_number()(std::string(bad)), "") << bad;
  EXPECT_EQ(positive_number(1)(std::string("1")), "");
  EXPECT_NE(positive_number(1)(std::string("1.0001")), "");
}

TEST(Parameters, WholeNumbersKeepTheirBounds) {
  for (const char* good : {"0", "7", "12"}) EXPECT_EQ(whole_number(0, 12)(std::string(good)), "") << good;
  for (const char* bad : {"-1", "13", "1.5", "", "1e3", "99999999999999999999"})
    EXPECT_NE(whole_number(0, 12)(std::string(bad)), "") << bad;
}

TEST(Parameters, SizesById) {
  EXPECT_EQ(size_of_id()(std::string("-3=0.25")), "");
  for (const char* bad : {"3", "=1", "3=", "3=0", "3=-1", "x=1", "3=nan", "1.5=1"})
    EXPECT_NE(size_of_id()(std::string(bad)), "") << bad;
  EXPECT_EQ(sizes_by_id({"1=0.5", "-2=3"}, "--region-size"), (std::map<int, double>{{1, 0.5}, {-2, 3}}));
  EXPECT_THROW(sizes_by_id({"1=0.5", "1=3"}, "--region-size"), OptionError);
}

TEST(Print, CountsAreGroupedByThousands) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(12345678), "12,345,678");
  EXPECT_EQ(shortened(12), "12");
  EXPECT_EQ(shortened(1234567), "1.23 M");
  EXPECT_EQ(shortened(999.7), "1 k");
}

/// A folder of its own for each test.
class Outputs : public testing::Test {
 protected:
  Outputs() {
    std::string name = (fs::temp_directory_path() / "voropack_test_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~Outputs() override { fs::remove_all(folder_); }

  static void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string read(const fs::path& path) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::size_t n_entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(Outputs, AppearOnPublish) {
  OutputSet outputs;
  write(outputs.stage(folder_ / "a.vtu"), "new");
  EXPECT_FALSE(fs::exists(folder_ / "a.vtu"));
  outputs.publish();
  EXPECT_EQ(read(folder_ / "a.vtu"), "new");
  EXPECT_EQ(n_entries(), 1U) << "the hidden folder is gone";
}

TEST_F(Outputs, LeaveNothingAndKeepTheOldFileWithoutPublish) {
  write(folder_ / "a.vtu", "old");
  {
    OutputSet outputs;
    write(outputs.stage(folder_ / "a.vtu"), "new");
    write(outputs.stage(folder_ / "deep/er/b.json"), "new");
  }
  EXPECT_EQ(read(folder_ / "a.vtu"), "old");
  EXPECT_EQ(n_entries(), 1U) << "folders that were made are removed";
}

TEST_F(Outputs, ANodeFileBringsItsCompanionsAndDropsOldOnes) {
  for (const char* name : {"a.node", "a.ele", "a.edge", "b.edge"}) write(folder_ / name, "old");
  OutputSet outputs;
  const fs::path staged = outputs.stage(folder_ / "a.node");
  write(staged, "new");
  write(fs::path(staged).replace_extension(".ele"), "new");
  outputs.publish();
  EXPECT_EQ(read(folder_ / "a.node"), "new");
  EXPECT_EQ(read(folder_ / "a.ele"), "new");
  EXPECT_FALSE(fs::exists(folder_ / "a.edge")) << "it belonged to the mesh that was replaced";
  EXPECT_TRUE(fs::exists(folder_ / "b.edge"));
}

TEST_F(Outputs, ALinkStaysALink) {
  write(folder_ / "real.json", "old");
  fs::create_symlink(folder_ / "real.json", folder_ / "link.json");
  OutputSet outputs;
  write(outputs.stage(folder_ / "link.json"), "new");
  outputs.publish();
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.json"));
  EXPECT_EQ(read(folder_ / "real.json"), "new");
}

TEST_F(Outputs, AFullDeviceIsAnErrorAndStaysADevice) {
  OutputSet outputs;
  write(outputs.stage("/dev/full"), "text");
  EXPECT_THROW(outputs.publish(), InputError);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(Outputs, AFolderOrAFileAsFolderCannotBeWritten) {
  write(folder_ / "file", "text");
  OutputSet outputs;
  EXPECT_THROW(outputs.stage(folder_), InputError);
  EXPECT_THROW(outputs.stage(folder_ / "file/a.vtu"), InputError);
}

TEST_F(Outputs, OneNameCannotBeGivenTwiceNorBeTheInput) {
  write(folder_ / "a.node", "input");
  OutputSet outputs;
  outputs.stage(folder_ / "a.node");
  EXPECT_THROW(outputs.stage(folder_ / "." / "a.node"), OptionError);
  EXPECT_THROW(outputs.protect(folder_ / "a.node"), OptionError);
}

TEST_F(Outputs, AnInputIsSafeFromWhatIsStagedLaterOrFoundBesideIt) {
  for (const char* name : {"a.node", "a.ele", "b_0001.vtu"}) write(folder_ / name, "input");
  OutputSet outputs;
  outputs.protect(folder_ / "a.node");
  outputs.protect(folder_ / "b_0001.vtu");
  EXPECT_THROW(outputs.stage(folder_ / "." / "a.node"), OptionError);
  EXPECT_THROW(outputs.stage(folder_ / "a.ele"), OptionError);
  EXPECT_THROW(outputs.replace(folder_ / "a.node"), OptionError);
  const fs::path staged = outputs.stage(folder_ / "b.pvd");
  write(staged, "new");
  write(staged.parent_path() / "b_0001.vtu", "new");
  EXPECT_THROW(outputs.publish(), OptionError);
  EXPECT_FALSE(fs::exists(folder_ / "b.pvd"));
  for (const char* name : {"a.node", "a.ele", "b_0001.vtu"}) EXPECT_EQ(read(folder_ / name), "input") << name;
}

TEST_F(Outputs, WhatIsReplacedStaysUntilThereIsAnother) {
  for (const char* name : {"1.vtu", "2.vtu"}) write(folder_ / name, "old");
  {
    OutputSet outputs;
    outputs.replace(folder_ / "1.vtu");
  }
  EXPECT_EQ(read(folder_ / "1.vtu"), "old");
  OutputSet outputs;
  for (const char* name : {"1.vtu", "2.vtu", "3.vtu"}) outputs.replace(folder_ / name);
  write(outputs.stage(folder_ / "1.vtu"), "new");
  outputs.publish();
  EXPECT_EQ(read(folder_ / "1.vtu"), "new");
  EXPECT_FALSE(fs::exists(folder_ / "2.vtu"));
  EXPECT_EQ(n_entries(), 1U);
}

TEST_F(Outputs, NothingIsPublishedAfterAbandon) {
  OutputSet outputs;
  write(outputs.stage(folder_ / "a.vtu"), "new");
  outputs.abandon();
  EXPECT_THROW(outputs.publish(), Cancelled);
  EXPECT_EQ(n_entries(), 0U);
}

}  // namespace
}  // namespace voropack::app
