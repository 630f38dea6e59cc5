// The report: one JSON object with every figure of a run. Unknown figures are absent, never zero.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "voropack/certificate.h"
#include "voropack/domain.h"
#include "voropack/mesh.h"
#include "voropack/pipeline.h"
#include "voropack/quality.h"

namespace voropack::app {

using Json = nlohmann::ordered_json;

/// A file that a run read.
struct InputFile {
  std::string file;
  std::optional<std::string> sha256;
  std::optional<int> dimension;
  std::optional<std::uint64_t> points, segments, facets, regions;  ///< Known of a domain only, but for regions.
  std::optional<PlaneMerge> merge{};
};

/// Figures of how the packing came about.
struct PackingFigures {
  std::uint64_t repairs = 0;
  int repair_rounds = 0;
  std::optional<double> size_ratio{};  ///< Vertices over the integral of f^-D: what the theory bounds.
};

struct Report {
  std::string command;
  Json options = Json::object();
  InputFile input;                     ///< Of a command that reads no file, without name, and absent.
  std::optional<InputFile> domain;     ///< What a mesh was compared with.
  std::optional<InputFile> case_file;  ///< Of the command solve.
  std::optional<QualityReport> quality;
  std::optional<Certificate> certificate;
  std::optional<PackingFigures> packing;
  std::optional<Json> costliest_features;
  std::optional<Json> figure3;
  std::optional<Json> solve;
  std::optional<Json> refinement;  ///< Old vertices kept and removed, new ones added.
  std::optional<Json> levels;      ///< Of a hierarchy, the finest coarse one first.
  StageTimes times;
  int threads = 0;
};

/// The report as documented, with version, commit and peak memory added.
Json to_json(const Report& report);

/// A certificate as the report has it.
Json certificate_json(const Certificate& certificate);

/// Name and hash of a file; counts are for the caller to fill in.
InputFile describe_file(const std::filesystem::path& path, std::optional<int> dimension);

template <int D>
InputFile describe_domain(const std::filesystem::path& path, const Domain<D>& domain) {
  InputFile input = describe_file(path, D);
  input.points = domain.points.size();
  input.segments = domain.segments.size();
  if (D == 3) input.facets = domain.facet_frame.size();
  input.regions = domain.region_id.size();
  input.merge = domain.merge;
  return input;
}

/// What the most vertices are due to, the costliest first.
template <int D>
Json features_json(const std::vector<CostlyFeature<D>>& features, const Domain<D>& domain);

}  // namespace voropack::app
