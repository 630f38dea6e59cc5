// Heat through a part of two materials, by the control volume method.
//
// A plate [0,2] x [0,1] of two materials, joined at x = 1: the left one generates heat, the right one conducts ten
// times as well. The right side is cooled by a fluid, the other sides are insulated. All the heat leaves through the
// right side: the method conserves it to rounding.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>

#include "voropack/diffusion.h"
#include "voropack/pipeline.h"

namespace {

constexpr int kInsulated = 1, kCooled = 2, kJoint = 3;  // Markers.

voropack::DomainInput<2> plate() {
  voropack::DomainInput<2> input;
  input.points = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}};
  const auto add = [&](std::uint32_t a, std::uint32_t b, int marker) {
    input.segments.push_back({.points = {a, b}, .marker = marker, .line = {}});
  };
  for (const std::uint32_t a : {0U, 1U, 3U, 4U, 5U}) add(a, (a + 1) % 6, kInsulated);
  add(2, 3, kCooled);
  add(1, 4, kJoint);
  input.region_seeds = {{.position = {0.5, 0.5}, .id = 1, .max_measure = {}},
                        {.position = {1.5, 0.5}, .id = 2, .max_measure = {}}};
  return input;
}

}  // namespace

int main() {
  voropack::MeshingOptions<2> options;
  options.wishes.size = 0.05;
  const voropack::MeshingResult<2> result = voropack::make_mesh(plate(), options);

  voropack::DiffusionProblem<2> problem;
  problem.conductivity = std::map<int, double>{{1, 1.0}, {2, 10.0}};
  problem.source = std::map<int, double>{{1, 100.0}, {2, 0.0}};
  problem.conditions[kCooled] = voropack::Robin<2>{.transfer = 25.0, .outside = 20.0};
  const voropack::DiffusionSolution<2> heat =
      voropack::solve(result.volumes, voropack::build_boundary_areas(result.mesh), problem);

  double hottest = 0;
  for (const double temperature : heat.values) hottest = std::max(hottest, temperature);
  double outflow = 0;
  for (const voropack::MarkerFlux& flux : heat.fluxes)
    if (flux.marker == kCooled) outflow -= flux.inflow;
  // By hand: 100 leave through the right side, so that it has 20 + 100/25 = 24, the joint 24 + 100/10 = 34, and the
  // left side 34 + 100/2 = 84.
  std::printf("%zu vertices: %.12g of 100 leave, at most %.6g of 84 degrees, %s, certificate %s\n", heat.values.size(),
              outflow, hottest, heat.matrix.is_m_matrix ? "M-matrix" : "NO M-matrix",
              result.certificate.ok ? "ok" : "FAILED");
  const bool is_good = std::abs(outflow - 100) < 1e-9 && std::abs(hottest - 84) < 0.1 && heat.matrix.is_m_matrix;
  return result.certificate.ok && is_good ? 0 : 1;
}
