// The least that reads .off and .smesh files into DomainInput, so that tests of the domain do not depend on the
// readers.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "voropack/domain.h"

namespace voropack::test {

/// The numbers and words of a file without comments.
inline std::vector<std::string> tokens_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path.string());
  std::vector<std::string> tokens;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) tokens.push_back(word);
  }
  return tokens;
}

inline DomainInput<3> read_off_file(const std::filesystem::path& path) {
  const auto tokens = tokens_of(path);
  std::size_t at = 1;
  const auto integer = [&] { return static_cast<std::uint32_t>(std::stoul(tokens.at(at++))); };
  DomainInput<3> input;
  input.is_surface = true;
  input.file = path.filename().string();
  const auto n_points = integer(), n_facets = integer();
  ++at;
  for (std::uint32_t i = 0; i < n_points; ++i) {
    Vec<3> x;
    for (int k = 0; k < 3; ++k) x[k] = std::stod(tokens.at(at++));
    input.points.push_back(x);
  }
  for (std::uint32_t i = 0; i < n_facets; ++i) {
    std::vector<std::uint32_t> polygon(integer());
    for (auto& p : polygon) p = integer();
    input.facets.push_back({{polygon}, {}, {}, {}});
  }
  return input;
}

inline DomainInput<3> read_smesh_file(const std::filesystem::path& path) {
  const auto tokens = tokens_of(path);
  std::size_t at = 0;
  const auto integer = [&] { return static_cast<std::uint32_t>(std::stoul(tokens.at(at++))); };
  DomainInput<3> input;
  input.file = path.filename().string();
  const auto n_points = integer();
  at += 3;
  for (std::uint32_t i = 0; i < n_points; ++i) {
    input.first_index = i == 0 ? integer() : (++at, input.first_index);
    Vec<3> x;
    for (int k = 0; k < 3; ++k) x[k] = std::stod(tokens.at(at++));
    input.points.push_back(x);
  }
  const auto n_facets = integer();
  const bool marked = integer() != 0;
  for (std::uint32_t i = 0; i < n_facets; ++i) {
    std::vector<std::uint32_t> polygon(integer());
    for (auto& p : polygon) p = integer() - input.first_index;
    input.facets.push_back({{polygon}, {}, {}, {}});
    if (marked) input.facets.back().marker = static_cast<int>(integer());
  }
  return input;
}

/// The volume inside a closed surface whose polygons all turn the same way: the divergence theorem over fans.
inline double enclosed_volume(const DomainInput<3>& input) {
  long double sum = 0;
  for (const auto& facet : input.facets) {
    const auto& polygon = facet.polygons.front();
    const Vec<3> origin = input.points.front();
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      sum += dot(input.points[polygon[0]] - origin,
                 cross(input.points[polygon[i]] - origin, input.points[polygon[i + 1]] - origin));
  }
  return std::abs(static_cast<double>(sum / 6));
}

}  // namespace voropack::test
