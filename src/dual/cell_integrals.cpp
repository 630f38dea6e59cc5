#include "voropack/cell_integrals.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.h"

namespace voropack {

namespace {

constexpr std::size_t kGrain = 64;  // Cells per task.

double signed_volume(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) { return cross(b - a, c - a) / 2; }
double signed_volume(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  return dot(b - a, cross(c - a, d - a)) / 6;
}

/// Mean of a function on a triangle, exact for degree 3: corners, midpoints of edges, centroid [Zienkiewicz].
template <class Fn>
double mean_value(Fn&& fn, const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  return (3 * (fn(a) + fn(b) + fn(c)) + 8 * (fn(0.5 * (a + b)) + fn(0.5 * (b + c)) + fn(0.5 * (c + a))) +
          27 * fn((a + b + c) / 3)) /
         60;
}

/// The same on a tetrahedron: corners and centroids of faces.
template <class Fn>
double mean_value(Fn&& fn, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  return (fn(a) + fn(b) + fn(c) + fn(d) +
          9 * (fn((a + b + c) / 3) + fn((a + b + d) / 3) + fn((a + c + d) / 3) + fn((b + c + d) / 3))) /
         40;
}

template <class Fn>
double integrate_cell(const CellShapes<2>& shapes, CellId c, const Vec<2>& site, Fn&& fn) {
  const auto corners = shapes.cell_faces[c];
  double sum = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec<2>&p = shapes.points[corners[k]], &q = shapes.points[corners[(k + 1) % corners.size()]];
    const double volume = signed_volume(site, p, q);
    if (volume != 0) sum += volume * mean_value(fn, site, p, q);
  }
  return sum;
}

/// A face's polygon may be listed in either direction: its site lies behind it, so its volume is positive.
template <class Fn>
double integrate_cell(const CellShapes<3>& shapes, CellId c, const Vec<3>& site, Fn&& fn) {
  double sum = 0;
  for (const std::uint32_t face : shapes.cell_faces[c]) {
    const auto corners = shapes.face_points[DualFaceId(face)];
    double volume = 0, integral = 0;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
      const Vec<3>&p = shapes.points[corners[0]], &q = shapes.points[corners[k]], &r = shapes.points[corners[k + 1]];
      const double part = signed_volume(site, p, q, r);
      volume += part;
      if (part != 0) integral += part * mean_value(fn, site, p, q, r);
    }
    sum += volume < 0 ? -integral : integral;
  }
  return sum;
}

}  // namespace

template <int D>
IdVector<CellId, double> integrate_over_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
                                              const std::function<double(const Vec<D>& x, int region)>& function) {
  IdVector<CellId, double> integrals(volumes.cell_vertex.size());
  parallel_for(
      integrals.size(),
      [&](std::size_t i) {
        const CellId c(i);
        const auto fn = [&](const Vec<D>& x) { return function(x, volumes.cell_region[c]); };
        integrals[c] = integrate_cell(shapes, c, volumes.sites[volumes.cell_vertex[c]], fn);
      },
      kGrain);
  return integrals;
}

template IdVector<CellId, double> integrate_over_cells(const CellShapes<2>&, const ControlVolumes<2>&,
                                                       const std::function<double(const Vec<2>&, int)>&);
template IdVector<CellId, double> integrate_over_cells(const CellShapes<3>&, const ControlVolumes<3>&,
                                                       const std::function<double(const Vec<3>&, int)>&);

}  // namespace voropack
