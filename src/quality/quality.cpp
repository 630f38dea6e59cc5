#include "voropack/quality.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "geom/dd.h"
#include "geom/number_vec.h"
#include "mesh/faces.h"
#include "mesh/incidence.h"
#include "quality/cell_aspect.h"
#include "quality/spread.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 4096;           // Simplices per task.
constexpr std::size_t kFaceBlock = 1U << 16U;  // Dual faces per task.

template <int D>
std::array<Vec<D>, D + 1> corners(const Mesh<D>& mesh, SimplexId s) {
  const auto& v = mesh.simplex_vertices[s];
  if constexpr (D == 2)
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
  else
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]};
}

template <int D>
using PointPair = NumberVec<Lanes, D>;

/// The angles of triangles abc with the given doubled areas, of those lanes that count.
template <int D>
void add_triangles(const PointPair<D>& a, const PointPair<D>& b, const PointPair<D>& c, Lanes area2,
                   const std::array<bool, Lanes::kSize>& counts, AngleTally& tally) {
  const PointPair<D> ab = difference<Lanes>(b, a), bc = difference<Lanes>(c, b), ca = difference<Lanes>(a, c);
  const std::array<Lanes, 3> cosine = {-dot<Lanes>(ab, ca), -dot<Lanes>(ab, bc), -dot<Lanes>(bc, ca)};
  for (std::size_t lane = 0; lane < Lanes::kSize; ++lane)
    for (const Lanes& x : cosine) tally.add_if(counts[lane], x[lane], area2[lane]);
}

struct AngleTallies {
  AngleTally face, dihedral;
};

/// [edge] of simplices, in the order of the corners 01, 02, ..., 12, ...
template <int D>
using EdgeLengthsSq = std::array<Lanes, D*(D + 1) / 2>;

template <int D>
EdgeLengthsSq<D> edge_lengths_sq(const SimplexPair<D>& p) {
  EdgeLengthsSq<D> lengths_sq;
  std::size_t edge = 0;
  for (std::size_t i = 0; i <= D; ++i) {
    for (std::size_t j = i + 1; j <= D; ++j) {
      const PointPair<D> e = difference<Lanes>(p[j], p[i]);
      lengths_sq[edge++] = dot<Lanes>(e, e);
    }
  }
  return lengths_sq;
}

/// Adds the angles of the simplices from `first` on that are in the lanes that count; those of a face between two
/// simplices are added by the first of them.
void add_angles(const Mesh<2>&, SimplexId, const std::array<bool, Lanes::kSize>& counts, const SimplexPair<2>& p,
                const EdgeLengthsSq<2>&, Lanes determinant, AngleTallies& tallies) {
  add_triangles<2>(p[0], p[1], p[2], determinant, counts, tallies.face);
}

void add_angles(const Mesh<3>& mesh, SimplexId first, const std::array<bool, Lanes::kSize>& counts,
                const SimplexPair<3>& p, const EdgeLengthsSq<3>& lengths_sq, Lanes determinant, AngleTallies& tallies) {
  std::array<PointPair<3>, 4> normal;  // Into the simplex, twice the face's area long.
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& f = kFaceCorners<3>[i];
    const PointPair<3>&a = p[static_cast<std::size_t>(f[0])], &b = p[static_cast<std::size_t>(f[1])],
          &c = p[static_cast<std::size_t>(f[2])];
    normal[i] = cross<Lanes>(difference<Lanes>(b, a), difference<Lanes>(c, a));
    std::array<bool, Lanes::kSize> first_of_face;
    for (std::size_t lane = 0; lane < Lanes::kSize; ++lane) {
      const SimplexId s(first.value() + (counts[lane] ? lane : 0));
      const SimplexId t = mesh.simplex_neighbors[s][i];
      first_of_face[lane] = counts[lane] & (t.is_none() | (s < t));
    }
    add_triangles<3>(a, b, c, sqrt(dot<Lanes>(normal[i], normal[i])), first_of_face, tallies.face);
  }
  std::size_t opposite = 5;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet at the edge of the other two corners. |n_i x n_j| = |edge| |determinant|.
      const Lanes x = -dot<Lanes>(normal[i], normal[j]), y = sqrt(lengths_sq[opposite--]) * determinant;
      for (std::size_t lane = 0; lane < Lanes::kSize; ++lane) tallies.dihedral.add_if(counts[lane], x[lane], y[lane]);
    }
  }
}

/// Bit i: the region ends at the face opposite to corner i.
template <int D>
std::uint8_t wall_corners(const Mesh<D>& mesh, SimplexId s) {
  unsigned walls = 0;
  for (int i = 0; i <= D; ++i)
    if (neighbor_in_region(mesh, s, i).is_none()) walls |= 1U << static_cast<unsigned>(i);
  return static_cast<std::uint8_t>(walls);
}

/// Figures of a block of simplices, region by region; regions ascend.
struct RegionSums {
  struct Region {
    int id;
    std::uint64_t n;
    Dd volume;
  };
  std::vector<Region> regions;

  Region& at(int id) {
    auto place = std::lower_bound(regions.begin(), regions.end(), id, [](const Region& r, int x) { return r.id < x; });
    if (place == regions.end() || place->id != id) place = regions.insert(place, {id, 0, {}});
    return *place;
  }
};

template <int D>
class QualityMeasure {
 public:
  QualityMeasure(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, Observer& observer)
      : mesh_(mesh), volumes_(volumes), observer_(observer), simplices_(mesh.simplex_vertices.size()) {}

  QualityReport measure() {
    report_.n_vertices = mesh_.points.size();
    report_.n_simplices = mesh_.simplex_vertices.size();
    report_.n_boundary_simplices = mesh_.boundary_vertices.size();
    report_.n_cells = volumes_.cell_vertex.size();
    report_.n_dual_faces = volumes_.face_area.size();
    Csr<VertexId, SimplexId> vertex_simplices;
    parallel_invoke(
        [&] { measure_simplices(); },
        [&] { vertex_simplices = invert_incidence<VertexId>(mesh_.simplex_vertices, mesh_.points.size()); });
    observer_.progress(1, 3);
    measure_edges();
    measure_cells();
    observer_.progress(2, 3);
    report_.cell_aspect =
        measure_spread(cell_aspects(mesh_, volumes_, vertex_simplices, simplices_, observer_), 1, 11, 40);
    observer_.progress(3, 3);
    return report_;
  }

 private:
  void measure_simplices() {
    std::vector<double> radius_edge(mesh_.simplex_vertices.size());
    tbb::enumerable_thread_specific<AngleTallies> tallies;
    const RegionSums sums = parallel_reduce_ordered(
        radius_edge.size(), kBlock, RegionSums{},
        [&](std::size_t begin, std::size_t end) {
          observer_.check_cancelled();
          RegionSums block;
          AngleTallies& local = tallies.local();
          for (std::size_t k = begin; k < end; k += Lanes::kSize) measure_pair(k, end, radius_edge, local, block);
          return block;
        },
        [](RegionSums a, const RegionSums& b) {
          for (const auto& r : b.regions) {
            a.at(r.id).n += r.n;
            a.at(r.id).volume = a.at(r.id).volume + r.volume;
          }
          return a;
        });
    Dd total;
    for (const auto& r : sums.regions) {
      report_.regions.push_back({r.id, r.n, to_double(r.volume)});
      total = total + r.volume;
    }
    report_.domain_volume = to_double(total);
    report_.radius_edge = measure_spread(radius_edge, 0, 4, 40);
    AngleTallies all;
    for (AngleTallies& t : tallies) {  // Counts and extremes: any order gives the same.
      all.face.merge(t.face);
      all.dihedral.merge(t.dihedral);
    }
    report_.angle_deg = all.face.spread_deg();
    if constexpr (D == 3) report_.dihedral_deg = all.dihedral.spread_deg();
  }

  /// Measures simplex k and the next one if it is before `end`.
  void measure_pair(std::size_t k, std::size_t end, std::vector<double>& radius_edge, AngleTallies& tallies,
                    RegionSums& sums) {
    const std::array<bool, Lanes::kSize> counts = {true, k + 1 < end};
    const SimplexPair<D> p = simplex_pair<D>(corners(mesh_, SimplexId(k)), corners(mesh_, SimplexId(k + counts[1])));
    const CircumcenterPair<D> center = circumcenter_pair<D>(p);
    const EdgeLengthsSq<D> lengths_sq = edge_lengths_sq<D>(p);
    Lanes shortest_sq = lengths_sq[0];
    for (const Lanes& length_sq : lengths_sq) shortest_sq = min(shortest_sq, length_sq);
    const Lanes ratio = sqrt(dot<Lanes>(center.offset, center.offset) / shortest_sq);
    add_angles(mesh_, SimplexId(k), counts, p, lengths_sq, center.determinant, tallies);
    for (std::size_t lane = 0; lane < Lanes::kSize && counts[lane]; ++lane) {
      const SimplexId s(k + lane);
      for (std::size_t i = 0; i < D; ++i) simplices_.circumcenter[s][i] = p[0][i][lane] + center.offset[i][lane];
      simplices_.walls[s] = wall_corners(mesh_, s);
      radius_edge[k + lane] = std::isnan(ratio[lane]) ? std::numeric_limits<double>::infinity() : ratio[lane];
      auto& region = sums.at(mesh_.simplex_region[s]);
      ++region.n;
      region.volume = region.volume + Dd(center.determinant[lane] / (D == 3 ? 6 : 2));
    }
  }

  /// Edges on an interface have one dual face per region and count once.
  void measure_edges() {
    const std::vector<double>& lengths = volumes_.face_edge_length.raw();
    const auto repeats = [&](std::size_t f) {
      return f > 0 && volumes_.face_vertices[DualFaceId(f)] == volumes_.face_vertices[DualFaceId(f - 1)];
    };
    struct Seen {
      double longest = 0;
      bool repeated = false;
    };
    const Seen seen = parallel_reduce_ordered(
        lengths.size(), kFaceBlock, Seen{},
        [&](std::size_t begin, std::size_t end) {
          Seen block;
          for (std::size_t f = begin; f != end; ++f) {
            block.longest = std::max(block.longest, lengths[f]);
            block.repeated |= repeats(f);
          }
          return block;
        },
        [](const Seen& a, const Seen& b) {
          return Seen{std::max(a.longest, b.longest), a.repeated || b.repeated};
        });
    std::vector<double> once;
    for (std::size_t f = 0; seen.repeated && f < lengths.size(); ++f)
      if (!repeats(f)) once.push_back(lengths[f]);
    report_.edge_length = measure_spread(seen.repeated ? once : lengths, 0, seen.longest, 40);
  }

  void measure_cells() {
    Dd sum;
    for (const double volume : volumes_.cell_volume) sum = sum + Dd(volume);
    report_.volume_sum = to_double(sum);
    if (!volumes_.cell_volume.empty())
      report_.min_cell_volume = *std::min_element(volumes_.cell_volume.begin(), volumes_.cell_volume.end());
    report_.n_zero_faces = volumes_.n_zero_areas;
    report_.zeroed_area = volumes_.zeroed_area;
    report_.zeroed_area_bound = volumes_.zeroed_area_bound;
    if (volumes_.face_area.empty()) return;
    struct Areas {
      double least;
      std::uint64_t n_negative = 0;
    };
    const std::vector<double>& areas = volumes_.face_area.raw();
    const Areas all = parallel_reduce_ordered(
        areas.size(), kFaceBlock, Areas{areas[0]},
        [&](std::size_t begin, std::size_t end) {
          Areas block{areas[begin]};
          for (std::size_t f = begin; f != end; ++f) {
            block.least = std::min(block.least, areas[f]);
            block.n_negative += areas[f] < 0 ? 1U : 0U;
          }
          return block;
        },
        [](const Areas& a, const Areas& b) {
          return Areas{std::min(a.least, b.least), a.n_negative + b.n_negative};
        });
    report_.min_face_area = all.least;
    report_.n_negative_faces = all.n_negative;
  }

  const Mesh<D>& mesh_;
  const ControlVolumes<D>& volumes_;
  Observer& observer_;
  SimplexFigures<D> simplices_;
  QualityReport report_;
};

}  // namespace

template <int D>
QualityReport measure_quality(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, Observer& observer) {
  observer.begin_stage("quality");
  return QualityMeasure<D>(mesh, volumes, observer).measure();
}

template QualityReport measure_quality(const Mesh<2>&, const ControlVolumes<2>&, Observer&);
template QualityReport measure_quality(const Mesh<3>&, const ControlVolumes<3>&, Observer&);

}  // namespace voropack
