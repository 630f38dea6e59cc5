// The report holds what is known and nothing else.
#include "report.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "sha256.h"

namespace voropack::app {
namespace {

std::string sha256(std::string_view text) {
  Sha256 digest;
  digest.add(text);
  return digest.finish();
}

// Vectors of FIPS 180-4's examples and of NIST's CAVP.
TEST(Sha256, MatchesKnownVectors) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotDependOnHowTheBytesArrive) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += static_cast<char>(i * 37);
  for (std::size_t cut = 0; cut <= text.size(); cut += 7) {
    Sha256 digest;
    digest.add(std::string_view(text).substr(0, cut));
    digest.add(std::string_view(text).substr(cut));
    EXPECT_EQ(digest.finish(), sha256(text)) << "cut at " << cut;
  }
}

TEST(Sha256, AMissingFileHasNone) { EXPECT_FALSE(sha256_of_file("/nonexistent/file").has_value()); }

QualityReport tetrahedron_quality() {
  QualityReport q;
  q.n_vertices = 4;
  q.n_simplices = 1;
  q.n_boundary_simplices = 4;
  q.n_cells = 4;
  q.n_dual_faces = 6;
  q.regions = {{.id = 7, .n_simplices = 1, .volume = 0.5}};
  q.radius_edge = {.min = 0.6, .mean = 0.7, .p99 = 0.8, .max = 0.9, .histogram = {}};
  q.dihedral_deg = QualityReport::Spread{.min = 70, .mean = 70.5, .p99 = 71, .max = 71, .histogram = {}};
  q.volume_sum = 0.5;
  q.domain_volume = 0.5;
  return q;
}

TEST(Report, UnknownFiguresAreAbsent) {
  Report report;
  report.command = "convert";
  report.input.file = "a.node";
  report.input.dimension = 2;
  report.threads = 3;
  const Json json = to_json(report);
  for (const char* key : {"counts", "regions", "quality", "dual", "certificate", "packing", "domain"})
    EXPECT_FALSE(json.contains(key)) << key;
  for (const char* key : {"sha256", "points", "segments", "facets", "regions"})
    EXPECT_FALSE(json["input"].contains(key)) << key;
  EXPECT_EQ(json["command"], "convert");
  EXPECT_EQ(json["threads"], 3);
  EXPECT_GT(json["peak_memory_bytes"].get<double>(), 1e5);
  EXPECT_FALSE(json["voropack"]["version"].get<std::string>().empty());
}

TEST(Report, HoldsQualityUnderTheDocumentedNames) {
  Report report;
  report.quality = tetrahedron_quality();
  const Json json = to_json(report);
  EXPECT_EQ(json["counts"], Json::parse(R"({"vertices": 4, "simplices": 1, "boundary_simplices": 4, "cells": 4,
                                            "dual_faces": 6})"));
  EXPECT_EQ(json["regions"], Json::parse(R"([{"id": 7, "simplices": 1, "volume": 0.5}])"));
  EXPECT_EQ(json["quality"]["radius_edge"], Json::parse(R"({"max": 0.9, "p99": 0.8, "mean": 0.7})"));
  EXPECT_EQ(json["quality"]["dihedral_deg"], Json::parse(R"({"min": 70.0, "max": 71.0})"));
  EXPECT_EQ(json["dual"]["volume_sum"], 0.5);
  EXPECT_EQ(json["dual"]["negative_faces"], 0);
}

TEST(Report, A2DMeshHasNoDihedralAngles) {
  Report report;
  report.quality = tetrahedron_quality();
  report.quality->dihedral_deg.reset();
  EXPECT_FALSE(to_json(report)["quality"].contains("dihedral_deg"));
}

TEST(Report, AFigureThatIsNoNumberIsAbsent) {
  Report report;
  report.quality = tetrahedron_quality();
  report.quality->radius_edge.max = std::numeric_limits<double>::infinity();
  const Json json = to_json(report);
  EXPECT_FALSE(json["quality"]["radius_edge"].contains("max"));
  EXPECT_TRUE(json["quality"]["radius_edge"].contains("mean"));
}

TEST(Report, CertificateKeepsTheOrderOfChecks) {
  Report report;
  Certificate certificate;
  certificate.ok = false;
  certificate.checks = {
      {.name = "packing", .ok = true, .tested = 12, .violations = 0, .worst = 1.5, .where = "vertex 3"},
      {.name = "closure", .ok = false, .tested = 2, .violations = 1, .worst = {}, .where = {}}};
  report.certificate = certificate;
  EXPECT_EQ(to_json(report)["certificate"], Json::parse(R"({"ok": false, "checks": [
              {"name": "packing", "ok": true, "tested": 12, "violations": 0, "worst": 1.5, "where": "vertex 3"},
              {"name": "closure", "ok": false, "tested": 2, "violations": 1}]})"));
}

TEST(Report, TimesComeInTheOrderOfTheStages) {
  Report report;
  report.times = {{"write", 4}, {"read", 1}, {"total", 10}, {"packing", 3}, {"extra", 2}};
  std::string order;
  const Json json = to_json(report);
  for (const auto& [name, seconds] : json["timing_s"].items()) order += name + ' ';
  EXPECT_EQ(order, "read packing write total extra ");
}

TEST(Report, FileIsDescribedByItsHash) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "voropack_report_test.txt";
  std::ofstream(path) << "abc";
  const InputFile input = describe_file(path, 3);
  std::filesystem::remove(path);
  EXPECT_EQ(input.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(input.dimension, 3);
}

}  // namespace
}  // namespace voropack::app
