// What the command solve found, as tables and for the report.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "case.h"
#include "report.h"
#include "solve_multigrid.h"
#include "voropack/diffusion.h"

namespace voropack::app {

/// Errors against the exact solution. Absent where they make no sense.
struct SolveErrors {
  std::optional<double> w;  ///< Over edges with an end inside.
  double l2 = 0, h1 = 0, max = 0;
  std::optional<double> h1_without_slivers;  ///< In 3D.
  std::optional<std::uint64_t> n_slivers;
};

/// An accepted step in time. Flows are means over it.
struct TimeRow {
  double time = 0, length = 0;
  double least = 0, largest = 0;  ///< Of u at its end.
  std::vector<MarkerFlux> fluxes;
  std::vector<RegionBalance> balances;
  int linear_iterations = 0;
  std::size_t newton_steps = 0;
};

struct TimeFigures {
  TransientReport report;
  std::vector<TimeRow> rows;
};

/// What was found, without anything that depends on the dimension.
struct SolveFigures {
  CaseMethod method = CaseMethod::kControlVolumes;
  double least = 0, largest = 0;  ///< Of u at the vertices.
  std::vector<MarkerFlux> fluxes;
  std::vector<RegionBalance> balances;
  MatrixCheck matrix;
  LinearReport linear;
  MultigridFigures multigrid;
  double compensation = 0;
  std::optional<NewtonReport> newton;
  std::optional<TimeFigures> time;  ///< `fluxes` and `balances` are then those of the last step.
  std::optional<SolveErrors> errors;
};

std::string solve_tables(const SolveFigures& figures);
Json solve_json(const SolveFigures& figures);
/// marker,area,inflow for each marker; in time with the time before, for each step.
std::string fluxes_csv(const SolveFigures& figures);

}  // namespace voropack::app
