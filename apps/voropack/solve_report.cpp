#include "solve_report.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "print.h"
#include "terminal_observer.h"

namespace voropack::app {

namespace {

std::string number(double value) { return fmt::format("{:.6g}", value); }

std::string flux_table(const SolveFigures& figures) {
  std::string text = fmt::format("{:<18}{:>14}{:>16}\n", "marker", "area", "inflow");
  for (const MarkerFlux& flux : figures.fluxes)
    text += fmt::format("{:<18}{:>14}{:>16}\n", flux.marker, number(flux.area), number(flux.inflow));
  return text;
}

std::string balance_table(const SolveFigures& figures) {
  std::string text = fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{:>12}\n", "region", "volume", "source",
                                 "absorbed", "boundary", "interfaces", "imbalance");
  for (const RegionBalance& b : figures.balances)
    text += fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{:>12.2g}\n", b.region, number(b.volume), number(b.source),
                        number(b.absorbed), number(b.boundary_inflow), number(b.interface_inflow), b.imbalance);
  return text;
}

std::string matrix_line(const MatrixCheck& matrix) {
  if (matrix.is_m_matrix) return "M-matrix: the maximum principle holds";
  std::string text = "no M-matrix:";
  if (matrix.n_positive_couplings > 0)
    text += fmt::format(" {} positive couplings", grouped(matrix.n_positive_couplings));
  if (matrix.n_negative_row_sums > 0) text += fmt::format(" {} negative row sums", grouped(matrix.n_negative_row_sums));
  if (matrix.n_floating > 0) text += fmt::format(" {} parts free up to a constant", grouped(matrix.n_floating));
  return text;
}

std::string linear_line(const LinearReport& linear) {
  std::string text = linear.method;
  if (!linear.preconditioner.empty()) text += ", " + linear.preconditioner;
  text += fmt::format(", {} unknowns", grouped(linear.n_unknowns));
  if (linear.n_iterations > 0)
    text += fmt::format(", {} iterations", grouped(static_cast<std::uint64_t>(linear.n_iterations)));
  return text + fmt::format(", residual {:.2g}", linear.residual);
}

std::string error_table(const SolveErrors& errors) {
  std::string text = "error\n";
  const auto row = [&](std::string_view name, const std::optional<double>& value) {
    if (value) text += fmt::format("{:<18}{:>14.6g}\n", name, *value);
  };
  row("W", errors.w);
  row("L2", errors.l2);
  row("H1", errors.h1);
  if (errors.n_slivers.value_or(0) > 0) {
    row("H1 no slivers", errors.h1_without_slivers);
    text += fmt::format("{:<18}{:>14}\n", "slivers", grouped(*errors.n_slivers));
  }
  row("max", errors.max);
  return text;
}

void set_number(Json& object, const char* key, double value) {
  if (std::isfinite(value)) object[key] = value;
}

Json linear_json(const LinearReport& linear) {
  Json json = {{"method", linear.method}};
  if (!linear.preconditioner.empty()) json["preconditioner"] = linear.preconditioner;
  json["unknowns"] = linear.n_unknowns;
  json["entries"] = linear.n_entries;
  json["iterations"] = linear.n_iterations;
  set_number(json, "residual", linear.residual);
  if (!linear.residuals.empty()) json["residuals"] = linear.residuals;
  return json;
}

}  // namespace

std::string solve_tables(const SolveFigures& figures) {
  std::string text;
  if (!figures.fluxes.empty()) text += flux_table(figures) + '\n';
  if (!figures.balances.empty()) text += balance_table(figures) + '\n';
  if (figures.errors) text += error_table(*figures.errors) + '\n';
  if (figures.compensation != 0)
    text += fmt::format("{:<18}{} of source was taken away, so that the problem is solvable\n", "compensation",
                        number(figures.compensation));
  text += fmt::format("{:<18}{} .. {}\n", "u", number(figures.least), number(figures.largest));
  text += fmt::format("{:<18}{}\n", "matrix", matrix_line(figures.matrix));
  return text + fmt::format("{:<18}{}\n", "linear system", linear_line(figures.linear));
}

Json solve_json(const SolveFigures& figures) {
  Json json = {{"method", figures.method == CaseMethod::kControlVolumes ? "cvm" : "fem"}};
  json["solution"] = {{"min", figures.least}, {"max", figures.largest}};
  const MatrixCheck& matrix = figures.matrix;
  json["matrix"] = {{"m_matrix", matrix.is_m_matrix},
                    {"positive_couplings", matrix.n_positive_couplings},
                    {"negative_row_sums", matrix.n_negative_row_sums},
                    {"floating", matrix.n_floating}};
  set_number(json["matrix"], "largest_positive", matrix.largest_positive);
  json["linear"] = linear_json(figures.linear);
  if (figures.method == CaseMethod::kControlVolumes) {
    json["fluxes"] = Json::array();
    for (const MarkerFlux& flux : figures.fluxes)
      json["fluxes"].push_back({{"marker", flux.marker}, {"area", flux.area}, {"inflow", flux.inflow}});
    json["balances"] = Json::array();
    for (const RegionBalance& b : figures.balances)
      json["balances"].push_back({{"region", b.region},
                                  {"volume", b.volume},
                                  {"source", b.source},
                                  {"absorbed", b.absorbed},
                                  {"boundary_inflow", b.boundary_inflow},
                                  {"interface_inflow", b.interface_inflow},
                                  {"imbalance", b.imbalance},
                                  {"throughput", b.throughput}});
    if (figures.compensation != 0) json["compensation"] = figures.compensation;
  }
  if (figures.errors) {
    const SolveErrors& errors = *figures.errors;
    Json& object = json["errors"] = Json::object();
    if (errors.w) set_number(object, "W", *errors.w);
    set_number(object, "L2", errors.l2);
    set_number(object, "H1", errors.h1);
    if (errors.h1_without_slivers) set_number(object, "H1ns", *errors.h1_without_slivers);
    if (errors.n_slivers) object["nsliv"] = *errors.n_slivers;
    set_number(object, "max", errors.max);
  }
  return json;
}

std::string fluxes_csv(const SolveFigures& figures) {
  std::string text = "marker,area,inflow\n";
  for (const MarkerFlux& flux : figures.fluxes) text += fmt::format("{},{},{}\n", flux.marker, flux.area, flux.inflow);
  return text;
}

}  // namespace voropack::app
