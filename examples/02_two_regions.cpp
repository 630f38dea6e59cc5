// Two materials in the plane: heat flux through their interface by the control volumes alone.
//
// The plate [0,2] x [0,1] conducts with 1 for x < 1 and with 10 for x > 1; its left side is held at 0, its right side
// at
// 1. A vertex on the interface has one cell in each region, so every dual face lies in one material and the two-point
// flux is exact here: the temperature is linear in each half and the flux is 1 / (1/1 + 1/10) = 10/11.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "voropack/pipeline.h"

namespace {

constexpr double kFlux = 10.0 / 11.0;

double conductivity(int region) { return region == 1 ? 1 : 10; }

/// The exact temperature: linear in each half, with equal flux.
double temperature(const voropack::Vec<2>& x) { return x[0] < 1 ? kFlux * x[0] : kFlux + kFlux / 10 * (x[0] - 1); }

voropack::DomainInput<2> plate() {
  voropack::DomainInput<2> input;
  input.points = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}};
  const std::vector<std::array<std::uint32_t, 2>> segments = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 0}, {1, 4}};
  for (const auto& points : segments) input.segments.push_back({.points = points, .marker = {}, .line = {}});
  input.region_seeds = {{.position = {0.5, 0.5}, .id = 1, .max_measure = {}},
                        {.position = {1.5, 0.5}, .id = 2, .max_measure = {}}};
  return input;
}

}  // namespace

int main() {
  voropack::MeshingOptions<2> options;
  options.wishes.size = 0.1;
  options.wishes.region_size = {{2, 0.05}};  // Finer in the good conductor.
  const voropack::MeshingResult<2> result = voropack::make_mesh(plate(), options);
  const voropack::ControlVolumes<2>& cells = result.volumes;

  // The net flux out of each vertex's cells, by two points: conductivity * area / length * difference.
  std::vector<double> net_flux(cells.sites.size(), 0);
  for (const voropack::DualFaceId f : voropack::ids<voropack::DualFaceId>(cells.face_area.size())) {
    const auto [i, j] = cells.face_vertices[f];
    const double coupling = conductivity(cells.face_region[f]) * cells.face_area[f] / cells.face_edge_length[f];
    const double flux = coupling * (temperature(cells.sites[j]) - temperature(cells.sites[i]));
    net_flux[i.value()] += flux;
    net_flux[j.value()] -= flux;
  }
  double inflow = 0, worst_inside = 0;
  for (const voropack::VertexId v : voropack::ids(cells.sites)) {
    const double x = cells.sites[v][0], flux = net_flux[v.value()];
    if (x == 0) inflow += flux;
    if (x > 0 && x < 2) worst_inside = std::max(worst_inside, std::abs(flux));
  }
  std::printf("%zu vertices, %zu cells; flux %.15g (exact %.15g), largest residual inside %.1e, certificate %s\n",
              cells.sites.size(), cells.cell_volume.size(), inflow, kFlux, worst_inside,
              result.certificate.ok ? "ok" : "FAILED");
  return result.certificate.ok && std::abs(inflow - kFlux) < 1e-10 && worst_inside < 1e-10 ? 0 : 1;
}
