#include "voropack/cell_integrals.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 64;  // Cells per task.

double signed_volume(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) { return cross(b - a, c - a) / 2; }
double signed_volume(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  return dot(b - a, cross(c - a, d - a)) / 6;
}

/// The points where a function is evaluated for one cell, and its values there. The first is the site.
template <int D>
struct Samples {
  std::vector<Vec<D>> x;
  std::vector<double> values;
};

/// Of each triangle (site, p, q), where q follows p: p, the midpoints of (site, p) and (p, q), and the centroid.
void place_samples(const CellShapes<2>& shapes, CellId c, const Vec<2>& site, std::vector<Vec<2>>& x) {
  const auto corners = shapes.cell_faces[c];
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec<2>&p = shapes.points[corners[k]], &q = shapes.points[corners[(k + 1) % corners.size()]];
    x.insert(x.end(), {p, 0.5 * (site + p), 0.5 * (p + q), (site + p + q) / 3});
  }
}

/// The mean over a triangle, exact for degree 3: corners, midpoints of edges, centroid [Zienkiewicz].
double add_up(const CellShapes<2>& shapes, CellId c, const Samples<2>& samples) {
  const auto corners = shapes.cell_faces[c];
  const Vec<2>& site = samples.x[0];
  double sum = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const std::size_t next = (k + 1) % corners.size();
    const double volume = signed_volume(site, shapes.points[corners[k]], shapes.points[corners[next]]);
    if (volume == 0) continue;
    const double* const f = samples.values.data();
    const double *const at_p = f + 1 + 4 * k, *const at_q = f + 1 + 4 * next;
    sum += volume * ((3 * (f[0] + at_p[0] + at_q[0]) + 8 * (at_p[1] + at_p[2] + at_q[1]) + 27 * at_p[3]) / 60);
  }
  return sum;
}

/// The samples of one face's fan of tetrahedra (site, c0, ck, ck+1), as offsets: ck; the centroids of (site, c0, ck);
/// of (site, ck, ck+1); of (c0, ck, ck+1).
struct FanSamples {
  std::size_t n_corners;
  [[nodiscard]] std::size_t corner(std::size_t k) const { return k; }
  [[nodiscard]] std::size_t spoke(std::size_t k) const { return n_corners + k - 1; }
  [[nodiscard]] std::size_t side(std::size_t k) const { return 2 * n_corners + k - 2; }
  [[nodiscard]] std::size_t outer(std::size_t k) const { return 3 * n_corners + k - 4; }
  [[nodiscard]] std::size_t size() const { return n_corners < 3 ? 0 : 4 * n_corners - 5; }
};

void place_samples(const CellShapes<3>& shapes, CellId c, const Vec<3>& site, std::vector<Vec<3>>& x) {
  for (const std::uint32_t face : shapes.cell_faces[c]) {
    const auto corners = shapes.face_points[DualFaceId(face)];
    const FanSamples fan{corners.size()};
    const std::size_t first = x.size();
    x.resize(first + fan.size());
    if (fan.size() == 0) continue;
    const auto corner = [&](std::size_t k) -> const Vec<3>& { return shapes.points[corners[k]]; };
    for (std::size_t k = 0; k < corners.size(); ++k) x[first + fan.corner(k)] = corner(k);
    for (std::size_t k = 1; k < corners.size(); ++k) x[first + fan.spoke(k)] = (site + corner(0) + corner(k)) / 3;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
      x[first + fan.side(k)] = (site + corner(k) + corner(k + 1)) / 3;
      x[first + fan.outer(k)] = (corner(0) + corner(k) + corner(k + 1)) / 3;
    }
  }
}

/// The mean over a tetrahedron, exact for degree 3: corners and centroids of faces [Zienkiewicz]. A face's polygon may
/// be listed in either direction: its site lies behind it, so its volume is positive.
double add_up(const CellShapes<3>& shapes, CellId c, const Samples<3>& samples) {
  const Vec<3>& site = samples.x[0];
  const double at_site = samples.values[0];
  std::size_t first = 1;
  double sum = 0;
  for (const std::uint32_t face : shapes.cell_faces[c]) {
    const auto corners = shapes.face_points[DualFaceId(face)];
    const FanSamples fan{corners.size()};
    const double* const f = samples.values.data() + first;
    double volume = 0, integral = 0;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
      const double part =
          signed_volume(site, shapes.points[corners[0]], shapes.points[corners[k]], shapes.points[corners[k + 1]]);
      volume += part;
      if (part != 0)
        integral += part * ((at_site + f[fan.corner(0)] + f[fan.corner(k)] + f[fan.corner(k + 1)] +
                             9 * (f[fan.spoke(k)] + f[fan.spoke(k + 1)] + f[fan.side(k)] + f[fan.outer(k)])) /
                            40);
    }
    sum += volume < 0 ? -integral : integral;
    first += fan.size();
  }
  return sum;
}

}  // namespace

template <int D>
IdVector<CellId, double> integrate_over_cells(
    const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
    const std::function<void(std::span<const Vec<D>>, int, std::span<double>)>& function) {
  const std::size_t n = volumes.cell_vertex.size();
  IdVector<CellId, double> integrals(n);
  parallel_for((n + kBlock - 1) / kBlock,
               [&](std::size_t block) {
                 Samples<D> samples;
                 for (std::size_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) {
                   const CellId c(i);
                   samples.x.assign(1, volumes.sites[volumes.cell_vertex[c]]);
                   place_samples(shapes, c, volumes.sites[volumes.cell_vertex[c]], samples.x);
                   samples.values.resize(samples.x.size());
                   function(samples.x, volumes.cell_region[c], samples.values);
                   integrals[c] = add_up(shapes, c, samples);
                 }
               },
               1);
  return integrals;
}

template <int D>
IdVector<CellId, double> integrate_over_cells(const CellShapes<D>& shapes, const ControlVolumes<D>& volumes,
                                              const std::function<double(const Vec<D>& x, int region)>& function) {
  const std::function<void(std::span<const Vec<D>>, int, std::span<double>)> at_many =
      [&](std::span<const Vec<D>> x, int region, std::span<double> values) {
        for (std::size_t k = 0; k < x.size(); ++k) values[k] = function(x[k], region);
      };
  return integrate_over_cells<D>(shapes, volumes, at_many);
}

template IdVector<CellId, double> integrate_over_cells(
    const CellShapes<2>&, const ControlVolumes<2>&,
    const std::function<void(std::span<const Vec<2>>, int, std::span<double>)>&);
template IdVector<CellId, double> integrate_over_cells(
    const CellShapes<3>&, const ControlVolumes<3>&,
    const std::function<void(std::span<const Vec<3>>, int, std::span<double>)>&);
template IdVector<CellId, double> integrate_over_cells(const CellShapes<2>&, const ControlVolumes<2>&,
                                                       const std::function<double(const Vec<2>&, int)>&);
template IdVector<CellId, double> integrate_over_cells(const CellShapes<3>&, const ControlVolumes<3>&,
                                                       const std::function<double(const Vec<3>&, int)>&);

}  // namespace voropack
