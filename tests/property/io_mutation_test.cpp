// Readers survive any file: valid ones cut short or changed at random either parse to sound data or are rejected.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/random.h"
#include "fuzz/targets.h"

namespace voropack {
namespace {

std::vector<std::string> load_inputs(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> inputs;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

/// A few random changes: bytes, digits, copied or removed stretches, numbers that break things.
std::string mutated(std::string bytes, Random& random) {
  constexpr std::array<std::string_view, 8> kNasty = {"-1", "4294967296", "1e999", "nan", "99999999999999999999",
                                                      "",   "\n",         "0"};
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random.bits() % n; };
  for (std::size_t n = 1 + below(4); n > 0 && !bytes.empty(); --n) {
    const std::size_t at = below(bytes.size());
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<char>(random.bits());
        break;
      case 1:
        bytes[at] = static_cast<char>('0' + below(10));
        break;
      case 2:
        bytes.erase(at, 1 + below(20));
        break;
      case 3:
        bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(40)));
        break;
      default:
        bytes.insert(at, kNasty[below(kNasty.size())]);
    }
  }
  return bytes;
}

class Reader : public testing::TestWithParam<fuzz::Target> {};

TEST_P(Reader, AcceptsItsOwnExamples) {
  const auto inputs = load_inputs(std::filesystem::path("tests/fuzz/corpus") / GetParam().name);
  ASSERT_FALSE(inputs.empty());
  for (const std::string& input : inputs) EXPECT_TRUE(GetParam().parse_is_sound({"input", input}));
}

TEST_P(Reader, SurvivesTruncationAtEveryByte) {
  for (const std::string& input : load_inputs(std::filesystem::path("tests/fuzz/corpus") / GetParam().name))
    for (std::size_t n = 0; n <= input.size(); n += 1 + n / 200)
      ASSERT_TRUE(fuzz::accepts_or_rejects(GetParam(), std::string_view(input).substr(0, n))) << "cut at " << n;
}

TEST_P(Reader, SurvivesRandomChanges) {
  constexpr int kChangesPerFile = 300;
  for (const std::string& input : load_inputs(std::filesystem::path("tests/fuzz/corpus") / GetParam().name))
    for (int seed = 0; seed < kChangesPerFile; ++seed) {
      Random random(static_cast<std::uint64_t>(seed));
      ASSERT_TRUE(fuzz::accepts_or_rejects(GetParam(), mutated(input, random))) << "seed " << seed;
    }
}

TEST_P(Reader, SurvivesWhatOnceBrokeIt) {
  for (const std::string& input : load_inputs(std::filesystem::path("tests/regression/inputs") / GetParam().name))
    EXPECT_TRUE(fuzz::accepts_or_rejects(GetParam(), input));
}

INSTANTIATE_TEST_SUITE_P(All, Reader, testing::ValuesIn(fuzz::kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace voropack
