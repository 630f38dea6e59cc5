// Checks `dual_nonnegative`, `volume_sum` and `closure`: the control volumes belong to the mesh.
#include <algorithm>
#include <map>

#include "base/parallel.h"
#include "certificate/checks.h"
#include "certificate/dual_sample.h"
#include "certificate/geometry.h"

namespace voropack::judge {

namespace {

/// Volumes and identities between them may be off by this much, relative to the sum of their terms' sizes.
constexpr double kSumTolerance = 1e-12;

/// Identities of a single cell: relative to the cell's surface or volume.
constexpr double kCellTolerance = 1e-10;

/// Cells by vertex; `valid` only if cells are sorted and name vertices of the mesh.
template <int D>
class CellIndex {
 public:
  CellIndex(const ControlVolumes<D>& volumes, std::size_t n_vertices) : volumes_(volumes) {
    const std::size_t n = volumes.cell_vertex.size();
    valid_ = volumes.cell_region.size() == n && volumes.cell_volume.size() == n;
    begin_.assign(n_vertices + 1, 0);
    for (std::size_t c = 0; valid_ && c < n; ++c) {
      const VertexId v = volumes.cell_vertex[CellId(c)];
      valid_ = !v.is_none() && v.value() < n_vertices;
      if (valid_ && c > 0) {
        const VertexId before = volumes.cell_vertex[CellId(c - 1)];
        valid_ = before < v || (before == v && volumes.cell_region[CellId(c - 1)] < volumes.cell_region[CellId(c)]);
      }
      if (valid_) ++begin_[v.value() + 1];
      if (!valid_) bad_ = static_cast<std::uint32_t>(c);
    }
    for (std::size_t v = 0; v < n_vertices; ++v) begin_[v + 1] += begin_[v];
  }
  [[nodiscard]] bool valid() const { return valid_; }
  [[nodiscard]] std::uint32_t bad_cell() const { return bad_; }
  /// kNone if there is no such cell.
  [[nodiscard]] std::uint32_t find(std::uint32_t vertex, int region) const {
    for (std::uint32_t c = begin_[vertex]; c < begin_[vertex + 1]; ++c)
      if (volumes_.cell_region[CellId(c)] == region) return c;
    return kNone;
  }

 private:
  const ControlVolumes<D>& volumes_;
  std::vector<std::uint32_t> begin_;
  std::uint32_t bad_ = 0;
  bool valid_ = false;
};

template <int D>
struct CellSums {
  Vec<D> area;         ///< Outward area vectors of dual and boundary faces: 0 for a closed cell.
  double surface = 0;  ///< Sum of their sizes.
  double volume = 0;   ///< (1 / 2D) sum of |A_ij| h_ij: the cell's volume, as every face is seen from its site.
};

enum ClosureFault : int { kOpen = 1, kNoCell };
enum VolumeFault : int { kWrongSum = 1, kCellIdentity, kNotPositiveVolume, kBadCells };

/// The part of boundary face `vertices` that belongs to its corner i: a vector's length, signed.
template <int D>
double corner_share(const Subject<D>& subject, const std::array<std::uint32_t, D>& vertices, std::size_t i) {
  const Vec<D>& a = subject.point(vertices[i]);
  const Vec<D>& b = subject.point(vertices[(i + 1) % D]);
  if constexpr (D == 2) {
    return 0.5 * distance(a, b);
  } else {
    // Two triangles to each adjacent edge's midpoint and the circumcenter: (|ab|^2 cot c + |ac|^2 cot b) / 8.
    const Vec<3>& c = subject.point(vertices[(i + 2) % 3]);
    const double twice_area = norm(cross(b - a, c - a));
    if (!(twice_area > 0)) return 0;
    return (distance_sq(a, b) * dot(a - c, b - c) + distance_sq(a, c) * dot(a - b, c - b)) / (8 * twice_area);
  }
}

/// The unit normal of boundary face `face` that points away from `inside`.
template <int D>
Vec<D> outward_normal(const Subject<D>& subject, const std::array<std::uint32_t, D>& face, const Vec<D>& inside) {
  std::array<Vec<D>, D> corners;
  for (std::size_t i = 0; i < D; ++i) corners[i] = subject.point(face[i]);
  const Vec<D> normal = inward_normal(corners, inside);
  const double length = norm(normal);
  return length > 0 ? normal / -length : Vec<D>{};
}

template <int D>
std::vector<CellSums<D>> sum_over_faces(const Subject<D>& subject, const CellIndex<D>& index, Tally& closure) {
  const ControlVolumes<D>& volumes = subject.volumes;
  std::vector<CellSums<D>> sums(volumes.cell_vertex.size());
  for (std::size_t f = 0; f < volumes.face_vertices.size(); ++f) {
    const auto& edge = volumes.face_vertices[DualFaceId(f)];
    if (!valid_edge(subject, edge)) continue;  // Reported by dual_nonnegative.
    const int region = volumes.face_region[DualFaceId(f)];
    const double area = volumes.face_area[DualFaceId(f)];
    const Vec<D> step = subject.point(edge[1].value()) - subject.point(edge[0].value());
    const double length = norm(step);
    const Vec<D> vector = (area / length) * step;
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t c = index.find(edge[end].value(), region);
      if (c == kNone) {
        closure.fault(kNoCell, kNoFigure, edge[end].value(), static_cast<std::uint32_t>(f));
        continue;
      }
      sums[c].area += end == 0 ? vector : -vector;
      sums[c].surface += std::abs(area);
      sums[c].volume += area * length / (2 * D);
    }
  }
  for (const BoundaryFace<D>& face : subject.topology.boundary()) {
    const bool cuts = face.n_sides() == 1 || (face.n_sides() == 2 && subject.topology.region(face.simplex[0]) !=
                                                                         subject.topology.region(face.simplex[1]));
    for (std::size_t side = 0; cuts && side < 2; ++side) {
      if (face.simplex[side] == kNone) continue;
      const VertexId inside = subject.mesh.simplex_vertices[SimplexId(face.simplex[side])][face.corner[side]];
      const Vec<D> normal = outward_normal<D>(subject, face.vertices, subject.mesh.points[inside]);
      for (std::size_t i = 0; i < D; ++i) {
        const double share = corner_share<D>(subject, face.vertices, i);
        const std::uint32_t c = index.find(face.vertices[i], subject.topology.region(face.simplex[side]));
        if (c == kNone) {
          closure.fault(kNoCell, kNoFigure, face.vertices[i], kNone);
          continue;
        }
        sums[c].area += share * normal;
        sums[c].surface += std::abs(share);
      }
    }
  }
  return sums;
}

/// Per region: measures of simplices, cells and the domain, and what rounding they may carry.
struct RegionSums {
  AccurateSum simplices, cells;
  AccurateSum product;  ///< Sum over simplices of the products of their edge lengths.
  double boundary = 0;  ///< Measure of the region's boundary.
  std::optional<double> domain;
};

template <int D>
std::map<int, RegionSums> region_sums(const Subject<D>& subject, bool with_cells) {
  using Sums = std::map<int, RegionSums>;
  const auto merge = [](Sums a, const Sums& b) {
    for (const auto& [region, sums] : b) {
      a[region].simplices.add(sums.simplices);
      a[region].product.add(sums.product);
    }
    return a;
  };
  Sums regions = parallel_reduce_ordered(
      subject.mesh.simplex_vertices.size(), 65536, Sums{},
      [&](std::size_t begin, std::size_t end) {
        Sums block;
        RegionSums* sums = nullptr;
        int current = 0;
        for (std::size_t s = begin; s < end; ++s) {
          if (!subject.topology.valid(s)) continue;
          if (sums == nullptr || subject.topology.region(s) != current) {
            current = subject.topology.region(s);
            sums = &block[current];
          }
          const std::array<Vec<D>, D + 1> p = subject.topology.corners(s);
          double product = 1;
          for (std::size_t k = 1; k <= D; ++k) product *= distance(p[0], p[k]);
          constexpr double kFactorial = D == 2 ? 2 : 6;
          if constexpr (D == 2)
            sums->simplices.add(cross(p[1] - p[0], p[2] - p[0]) / kFactorial);
          else
            sums->simplices.add(dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) / kFactorial);
          sums->product.add(product);
        }
        return block;
      },
      merge);
  for (const BoundaryFace<D>& face : subject.topology.boundary()) {
    for (const std::uint32_t s : face.simplex) {
      if (s == kNone) continue;
      for (std::size_t i = 0; i < D; ++i)
        regions[subject.topology.region(s)].boundary += std::abs(corner_share<D>(subject, face.vertices, i));
    }
  }
  if (with_cells)
    for (std::size_t c = 0; c < subject.volumes.cell_vertex.size(); ++c)
      regions[subject.volumes.cell_region[CellId(c)]].cells.add(subject.volumes.cell_volume[CellId(c)]);
  if (subject.domain != nullptr) {
    for (const RegionId r : ids(subject.domain->region_id)) {
      std::optional<double>& measure = regions[subject.domain->region_id[r]].domain;
      measure = measure.value_or(0) + subject.domain->region_measure[r];
    }
  }
  return regions;
}

/// How much of the measure of its regions the domain leaves open: its facets are flat only up to the tolerance with
/// which it was built, and a mesh triangulates them in another way.
template <int D>
double domain_blur(const Domain<D>& domain) {
  double blur = 0;
  if constexpr (D == 3) {
    for (const FacetId f : ids(domain.facet_frame)) {
      double off_plane = 0, area = 0;
      for (const PointId p : domain.facet_points[f])
        off_plane = std::max(off_plane, std::abs(domain.facet_frame[f].height(domain.points[p])));
      for (const auto& t : domain.facet_triangles[f])
        area += 0.5 * norm(cross(domain.points[t[1]] - domain.points[t[0]], domain.points[t[2]] - domain.points[t[0]]));
      blur += off_plane * area;
    }
  }
  return blur;
}

template <int D>
Check check_volume_sum(const Subject<D>& subject, const CellIndex<D>& index, const std::vector<CellSums<D>>& sums) {
  const ControlVolumes<D>& volumes = subject.volumes;
  const bool with_cells = !volumes.cell_vertex.empty();
  Tally tally;
  std::string sum_text;
  double worst_sum = 0;
  if (with_cells && !index.valid()) tally.fault(kBadCells, kNoFigure, index.bad_cell());
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double volume = volumes.cell_volume[CellId(c)];
    const double figure = std::abs(volume - sums[c].volume) / std::abs(volume);
    const auto id = static_cast<std::uint32_t>(c);
    if (!(volume > 0) || !std::isfinite(volume))
      tally.violation(kNotPositiveVolume, -volume, id);
    else if (!(figure <= kCellTolerance))
      tally.violation(kCellIdentity, figure, id);
    else
      ++tally.tested;
  }
  if (with_cells || subject.domain != nullptr) {
    const double blur = subject.domain != nullptr ? domain_blur(*subject.domain) : 0;
    for (const auto& [region, sum] : region_sums(subject, with_cells && index.valid())) {
      const double simplices = sum.simplices.value();
      // Rounding of each simplex's measure, and of the coordinates of vertices on the boundary.
      const double slack = kSumTolerance * std::abs(simplices) + 8 * kUnitRoundoff * sum.product.value();
      const double moved = slack + subject.topology.resolution() * sum.boundary + blur;
      const auto compare = [&](double other, double allowed, const char* what) {
        const double off = std::abs(simplices - other);
        const double relative = off / std::max(std::abs(simplices), std::abs(other));
        ++tally.tested;
        const bool wrong = !(off <= allowed);
        if (wrong) tally.fault(kWrongSum, relative, static_cast<std::uint32_t>(region));
        if (sum_text.empty() || relative > worst_sum || wrong) {
          worst_sum = relative;
          sum_text = "region " + std::to_string(region) + ": simplices " + number(simplices) + ", " + what + ' ' +
                     number(other);
        }
      };
      if (with_cells && index.valid()) compare(sum.cells.value(), slack, "cells");
      if (subject.domain != nullptr) compare(sum.domain.value_or(0), moved, "domain");
    }
  }
  const auto cell = [&] {
    const std::uint32_t c = tally.worst.ids[0];
    return "cell " + std::to_string(c) + " of " + subject.vertex_text(volumes.cell_vertex[CellId(c)].value());
  };
  if (tally.violations == 0 && tally.tested > 0) tally.note({.kind = 0, .figure = worst_sum, .present = true});
  switch (tally.worst.present ? tally.worst.kind : 0) {
    case kBadCells:
      sum_text = cell() + " is out of order or names no vertex";
      break;
    case kNotPositiveVolume:
      sum_text = cell() + " has a volume that is not positive";
      break;
    case kCellIdentity:
      sum_text = cell() + " has another volume than its faces enclose";
      break;
    default:
      break;
  }
  return make_check("volume_sum", tally, sum_text);
}

template <int D>
Check check_closure(const Subject<D>& subject, const std::vector<CellSums<D>>& sums, Tally tally) {
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double figure = norm(sums[c].area) / sums[c].surface;
    if (figure <= kCellTolerance)
      tally.legal(figure, static_cast<std::uint32_t>(c));
    else
      tally.violation(kOpen, figure, static_cast<std::uint32_t>(c));
  }
  std::string where;
  if (tally.worst.present && tally.worst.kind == kNoCell) {
    where = subject.vertex_text(tally.worst.ids[0]) + " has no cell in a region that " +
            (tally.worst.ids[1] == kNone ? "its boundary faces bound" : "its dual faces lie in");
  } else if (tally.worst.present) {
    const std::uint32_t c = tally.worst.ids[0];
    where = "cell " + std::to_string(c) + " of " + subject.vertex_text(subject.volumes.cell_vertex[CellId(c)].value()) +
            " in region " + std::to_string(subject.volumes.cell_region[CellId(c)]);
  }
  return make_check("closure", tally, where);
}

}  // namespace

template <int D>
std::array<Check, 3> check_volumes(const Subject<D>& subject) {
  const ControlVolumes<D>& volumes = subject.volumes;
  const CellIndex<D> index(volumes, subject.mesh.points.size());
  const std::size_t n_faces = volumes.face_vertices.size();
  const bool complete = volumes.face_region.size() == n_faces && volumes.face_area.size() == n_faces &&
                        volumes.face_edge_length.size() == n_faces;
  Tally closure;
  std::vector<CellSums<D>> sums;
  if (index.valid() && complete && !volumes.cell_vertex.empty()) sums = sum_over_faces(subject, index, closure);
  return {check_dual_nonnegative(subject, complete), check_volume_sum(subject, index, sums),
          check_closure(subject, sums, closure)};
}

template std::array<Check, 3> check_volumes(const Subject<2>&);
template std::array<Check, 3> check_volumes(const Subject<3>&);

}  // namespace voropack::judge
