#include "report.h"

#include <sys/resource.h>

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "sha256.h"
#include "version.h"

namespace voropack::app {

namespace {

/// Absent if it is no number: JSON has no infinity.
void set_number(Json& object, const char* key, double value) {
  if (std::isfinite(value)) object[key] = value;
}

template <class T>
void set_if_known(Json& object, const char* key, const std::optional<T>& value) {
  if (value) object[key] = *value;
}

Json input_json(const InputFile& input) {
  Json json;
  json["file"] = input.file;
  set_if_known(json, "sha256", input.sha256);
  set_if_known(json, "dimension", input.dimension);
  set_if_known(json, "points", input.points);
  set_if_known(json, "segments", input.segments);
  set_if_known(json, "facets", input.facets);
  set_if_known(json, "regions", input.regions);
  if (input.merge)
    json["merge"] = {{"distance", input.merge->distance},
                     {"angle_deg", input.merge->angle_deg},
                     {"moved", input.merge->n_moved},
                     {"largest_displacement", input.merge->largest_displacement}};
  return json;
}

enum class Figure { kMin, kMean, kP99, kMax };

Json spread_json(const QualityReport::Spread& spread, std::initializer_list<Figure> figures) {
  Json json = Json::object();
  for (const Figure figure : figures) {
    switch (figure) {
      case Figure::kMin:
        set_number(json, "min", spread.min);
        break;
      case Figure::kMean:
        set_number(json, "mean", spread.mean);
        break;
      case Figure::kP99:
        set_number(json, "p99", spread.p99);
        break;
      case Figure::kMax:
        set_number(json, "max", spread.max);
        break;
    }
  }
  return json;
}

void add_quality(Json& json, const QualityReport& q) {
  using enum Figure;
  json["counts"] = {{"vertices", q.n_vertices},
                    {"simplices", q.n_simplices},
                    {"boundary_simplices", q.n_boundary_simplices},
                    {"cells", q.n_cells},
                    {"dual_faces", q.n_dual_faces}};
  json["regions"] = Json::array();
  for (const QualityReport::Region& region : q.regions)
    json["regions"].push_back({{"id", region.id}, {"simplices", region.n_simplices}, {"volume", region.volume}});

  Json quality = Json::object(), dual = Json::object();
  if (q.n_simplices > 0) {
    quality["radius_edge"] = spread_json(q.radius_edge, {kMax, kP99, kMean});
    quality["angle_deg"] = spread_json(q.angle_deg, {kMin, kMax});
    if (q.dihedral_deg) quality["dihedral_deg"] = spread_json(*q.dihedral_deg, {kMin, kMax});
    quality["edge_length"] = spread_json(q.edge_length, {kMin, kMean, kMax});
    set_number(dual, "volume_sum", q.volume_sum);
    set_number(dual, "domain_volume", q.domain_volume);
  }
  if (q.n_cells > 0) set_number(dual, "min_volume", q.min_cell_volume);
  if (q.n_dual_faces > 0) {
    set_number(dual, "min_face_area", q.min_face_area);
    dual["negative_faces"] = q.n_negative_faces;
    dual["zero_faces"] = q.n_zero_faces;
    set_number(dual, "zeroed_area", q.zeroed_area);
    set_number(dual, "zeroed_area_bound", q.zeroed_area_bound);
  }
  if (q.n_cells > 0) dual["cell_aspect"] = spread_json(q.cell_aspect, {kMax, kP99, kMean});
  json["quality"] = std::move(quality);
  json["dual"] = std::move(dual);
}

/// In the order of the stages; names that the order does not know follow.
Json timing_json(const StageTimes& times) {
  constexpr std::array<std::string_view, 11> kOrder = {"read",  "spacing", "packing",     "delaunay",
                                                       "dual",  "quality", "certificate", "assemble",
                                                       "solve", "write",   "total"};
  Json json = Json::object();
  for (const std::string_view name : kOrder)
    if (const auto found = times.find(std::string(name)); found != times.end()) json[found->first] = found->second;
  for (const auto& [name, seconds] : times)
    if (!json.contains(name)) json[name] = seconds;
  return json;
}

template <int D>
Json polytope_json(PolytopeId p, const Domain<D>& domain) {
  if (p.dimension == 0) {
    Json json = {{"dimension", 0}, {"position", domain.points[PointId(p.index)].coord}};
    if (const int marker = domain.point_marker[PointId(p.index)]; marker != 0) json["marker"] = marker;
    return json;
  }
  const int marker =
      p.dimension == 1 ? domain.segment_marker[SegmentId(p.index)] : domain.facet_marker[FacetId(p.index)];
  return {{"dimension", p.dimension + 0U}, {"marker", marker}};
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

Json certificate_json(const Certificate& certificate) {
  Json checks = Json::array();
  for (const Certificate::Check& check : certificate.checks) {
    Json json = {{"name", check.name}, {"ok", check.ok}, {"tested", check.tested}, {"violations", check.violations}};
    if (check.worst) set_number(json, "worst", *check.worst);
    if (!check.where.empty()) json["where"] = check.where;
    checks.push_back(std::move(json));
  }
  return {{"ok", certificate.ok}, {"checks", std::move(checks)}};
}

InputFile describe_file(const std::filesystem::path& path, std::optional<int> dimension) {
  InputFile input;
  input.file = path.string();
  input.sha256 = sha256_of_file(path);
  input.dimension = dimension;
  return input;
}

template <int D>
Json features_json(const std::vector<CostlyFeature<D>>& features, const Domain<D>& domain) {
  using Kind = typename CostlyFeature<D>::Kind;
  Json list = Json::array();
  for (const CostlyFeature<D>& feature : features) {
    Json json = {{"kind", feature.kind == Kind::kGap ? "gap" : feature.kind == Kind::kAngle ? "angle" : "repair"}};
    json["vertices"] = std::llround(feature.vertices);
    json["place"] = feature.place.coord;
    if (feature.kind == Kind::kAngle)
      set_number(json, "angle_deg", feature.angle_deg);
    else
      set_number(json, "size", feature.size);
    json["polytopes"] = Json::array({polytope_json(feature.polytopes[0], domain)});
    if (feature.polytopes[1] != feature.polytopes[0])
      json["polytopes"].push_back(polytope_json(feature.polytopes[1], domain));
    json["pairs"] = feature.n_pairs;
    set_number(json, "radius", feature.radius);
    list.push_back(std::move(json));
  }
  return list;
}

template Json features_json(const std::vector<CostlyFeature<2>>&, const Domain<2>&);
template Json features_json(const std::vector<CostlyFeature<3>>&, const Domain<3>&);

Json to_json(const Report& report) {
  Json json;
  json["voropack"] = {{"version", version()}};
  if (!commit().empty()) json["voropack"]["commit"] = commit();
  json["command"] = report.command;
  json["options"] = report.options;
  if (!report.input.file.empty()) json["input"] = input_json(report.input);
  if (report.domain) json["domain"] = input_json(*report.domain);
  if (report.case_file) json["case"] = input_json(*report.case_file);
  if (report.quality) add_quality(json, *report.quality);
  if (report.packing) {
    json["packing"] = {{"repairs", report.packing->repairs}, {"repair_rounds", report.packing->repair_rounds}};
    if (report.packing->size_ratio) set_number(json["packing"], "size_ratio", *report.packing->size_ratio);
  }
  if (report.costliest_features) json["costliest_features"] = *report.costliest_features;
  if (report.certificate) json["certificate"] = certificate_json(*report.certificate);
  if (report.solve) json["solve"] = *report.solve;
  if (report.figure3) json["figure3"] = *report.figure3;
  if (report.refinement) json["refinement"] = *report.refinement;
  if (report.levels) json["levels"] = *report.levels;
  json["timing_s"] = timing_json(report.times);
  json["threads"] = report.threads;
  json["peak_memory_bytes"] = peak_memory_bytes();
  return json;
}

}  // namespace voropack::app
