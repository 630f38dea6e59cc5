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
  const bool stores = figures.time.has_value();
  const auto stored = [&](const std::string& word) { return stores ? fmt::format("{:>14}", word) : std::string(); };
  std::string text = fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{}{:>12}\n", "region", "volume", "source",
                                 "absorbed", "boundary", "interfaces", stored("stored"), "imbalance");
  for (const RegionBalance& b : figures.balances)
    text += fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{}{:>12.2g}\n", b.region, number(b.volume),
                        number(b.source), number(b.absorbed), number(b.boundary_inflow), number(b.interface_inflow),
                        stored(number(b.stored)), b.imbalance);
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

/// Nothing where multigrid was not wanted.
std::string multigrid_lines(const MultigridFigures& multigrid) {
  std::string text;
  if (multigrid.made)
    text += fmt::format("{:<18}{} levels down to {} unknowns, operator complexity {:.3g}\n", "multigrid",
                        multigrid.made->levels.size(), grouped(multigrid.made->levels.back().n_unknowns),
                        multigrid.made->operator_complexity);
  if (!multigrid.refused.empty()) text += fmt::format("{:<18}not used: {}\n", "multigrid", multigrid.refused);
  return text;
}

Json multigrid_json(const MultigridFigures& multigrid) {
  Json json = Json::object();
  if (multigrid.made) {
    json["unknowns"] = Json::array();
    for (const MultigridLevelReport& level : multigrid.made->levels) json["unknowns"].push_back(level.n_unknowns);
    json["operator_complexity"] = multigrid.made->operator_complexity;
  }
  if (!multigrid.refused.empty()) json["refused"] = multigrid.refused;
  return json;
}

Json newton_json(const NewtonReport& newton) {
  Json json = Json::object();
  set_number(json, "first_residual", newton.first_residual);
  set_number(json, "residual", newton.residual);
  json["steps"] = Json::array();
  for (const NewtonStep& step : newton.steps)
    json["steps"].push_back(
        {{"residual", step.residual}, {"damping", step.damping}, {"linear_iterations", step.linear_iterations}});
  return json;
}

Json fluxes_json(const std::vector<MarkerFlux>& fluxes) {
  Json list = Json::array();
  for (const MarkerFlux& flux : fluxes)
    list.push_back({{"marker", flux.marker}, {"area", flux.area}, {"inflow", flux.inflow}});
  return list;
}

Json balances_json(const std::vector<RegionBalance>& balances, bool with_stored) {
  Json list = Json::array();
  for (const RegionBalance& b : balances) {
    Json json = {{"region", b.region},
                 {"volume", b.volume},
                 {"source", b.source},
                 {"absorbed", b.absorbed},
                 {"boundary_inflow", b.boundary_inflow},
                 {"interface_inflow", b.interface_inflow}};
    if (with_stored) json["stored"] = b.stored;
    json["imbalance"] = b.imbalance;
    json["throughput"] = b.throughput;
    list.push_back(std::move(json));
  }
  return list;
}

Json time_json(const TimeFigures& time) {
  const TransientReport& report = time.report;
  Json json = {{"steps", report.n_steps},
               {"rejected", report.n_rejected},
               {"factorizations", report.n_factorizations},
               {"linear_iterations", report.linear_iterations},
               {"shortest_step", report.shortest_step},
               {"longest_step", report.longest_step}};
  json["series"] = Json::array();
  for (const TimeRow& row : time.rows) {
    Json entry = {{"time", row.time}, {"step", row.length}, {"min", row.least}, {"max", row.largest}};
    entry["linear_iterations"] = row.linear_iterations;
    if (row.newton_steps > 0) entry["newton_steps"] = row.newton_steps;
    entry["fluxes"] = fluxes_json(row.fluxes);
    entry["balances"] = balances_json(row.balances, true);
    json["series"].push_back(std::move(entry));
  }
  return json;
}

std::string time_line(const TransientReport& report) {
  std::string text =
      fmt::format("{} steps of {:.3g} .. {:.3g}", grouped(report.n_steps), report.shortest_step, report.longest_step);
  if (report.n_rejected > 0) text += fmt::format(", {} rejected", grouped(report.n_rejected));
  return text;
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
  if (figures.time) text += fmt::format("{:<18}{}\n", "time", time_line(figures.time->report));
  if (figures.newton)
    text += fmt::format("{:<18}{} steps, residual {:.2g}\n", "Newton", figures.newton->steps.size(),
                        figures.newton->residual);
  text += fmt::format("{:<18}{}\n", "matrix", matrix_line(figures.matrix));
  text += fmt::format("{:<18}{}\n", "linear system", linear_line(figures.linear));
  return text + multigrid_lines(figures.multigrid);
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
  if (Json multigrid = multigrid_json(figures.multigrid); !multigrid.empty()) json["multigrid"] = std::move(multigrid);
  if (figures.newton) json["newton"] = newton_json(*figures.newton);
  json["fluxes"] = fluxes_json(figures.fluxes);
  json["balances"] = balances_json(figures.balances, figures.time.has_value());
  if (figures.compensation != 0) json["compensation"] = figures.compensation;
  if (figures.time) json["time"] = time_json(*figures.time);
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
  const auto rows = [](const std::string& before, const std::vector<MarkerFlux>& fluxes) {
    std::string text;
    for (const MarkerFlux& flux : fluxes)
      text += fmt::format("{}{},{},{}\n", before, flux.marker, flux.area, flux.inflow);
    return text;
  };
  if (!figures.time) return "marker,area,inflow\n" + rows("", figures.fluxes);
  std::string text = "time,marker,area,inflow\n";
  for (const TimeRow& row : figures.time->rows) text += rows(fmt::format("{},", row.time), row.fluxes);
  return text;
}

}  // namespace voropack::app
