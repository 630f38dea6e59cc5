// What the command solve found, as tables and for the report.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "case.h"
#include "report.h"
#include "voropack/diffusion.h"

namespace voropack::app {

/// Errors against the exact solution. Absent where they make no sense.
struct SolveErrors {
  std::optional<double> w;  ///< Over edges with an end inside.
  double l2 = 0, h1 = 0, max = 0;
  std::optional<double> h1_without_slivers;  ///< In 3D.
  std::optional<std::uint64_t> n_slivers;
};

/// What was found, without anything that depends on the dimension.
struct SolveFigures {
  CaseMethod method = CaseMethod::kControlVolumes;
  double least = 0, largest = 0;  ///< Of u at the vertices.
  std::vector<MarkerFlux> fluxes;
  std::vector<RegionBalance> balances;
  MatrixCheck matrix;
  LinearReport linear;
  double compensation = 0;
  std::optional<SolveErrors> errors;
};

std::string solve_tables(const SolveFigures& figures);
Json solve_json(const SolveFigures& figures);
/// marker,area,inflow
std::string fluxes_csv(const SolveFigures& figures);

}  // namespace voropack::app
