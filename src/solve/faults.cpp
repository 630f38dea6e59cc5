#include "solve/faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "base/names.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// "did you mean 3? " if one of the ids is near, and all of them.
std::string known_ids(std::string_view what, int id, const std::set<int>& ids) {
  constexpr std::size_t kMaxListed = 20;
  std::vector<std::string> names;
  for (const int known : ids) names.push_back(std::to_string(known));
  std::string near = nearest_name(std::to_string(id), names);
  if (near.empty() && !ids.empty()) {  // No misspelling; the next number.
    const int next = *std::min_element(ids.begin(), ids.end(), [&](int a, int b) {
      return std::abs(std::int64_t{a} - id) < std::abs(std::int64_t{b} - id);
    });
    near = std::to_string(next);
  }
  if (names.empty()) return fmt::format("there are no {}", what);
  const bool is_cut = names.size() > kMaxListed;
  if (is_cut) names.resize(kMaxListed);
  return fmt::format("did you mean {}? The {} are {}{}", near, what, join_names(names), is_cut ? ", ..." : "");
}

}  // namespace

void fail_input(std::string id, std::string message, std::string fix, std::vector<double> position) {
  throw InputError(Fault{
      .id = std::move(id), .message = std::move(message), .fix = std::move(fix), .position = std::move(position)});
}

void check_regions(const std::map<int, double>& by_region, const std::set<int>& regions, std::string_view name) {
  for (const auto& [region, value] : by_region)
    if (!regions.contains(region))
      fail_input("solve.unknown_region", fmt::format("{} is given for region {}, which is not there", name, region),
                 known_ids("regions", region, regions));
  for (const int region : regions)
    if (!by_region.contains(region))
      fail_input("solve.unknown_region", fmt::format("{} is not given for region {}", name, region),
                 "give it for every region");
}

void check_length(const IdVector<VertexId, double>& by_vertex, std::size_t n_vertices, std::string_view name) {
  if (by_vertex.size() != n_vertices)
    fail_input("solve.wrong_length",
               fmt::format("{} has {} values for {} vertices", name, by_vertex.size(), n_vertices),
               "give one value for each vertex");
}

void check_marker(int marker, const std::set<int>& markers) {
  if (!markers.contains(marker))
    fail_input("solve.unknown_marker", fmt::format("a condition is given for marker {}, which no boundary has", marker),
               known_ids("markers", marker, markers));
}

void refuse_state_function(std::string_view name, std::string fix) {
  fail_input("solve.nonlinear", fmt::format("{} depends on the solution", name), std::move(fix));
}

}  // namespace voropack
