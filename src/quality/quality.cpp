#include "voropack/quality.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "geom/dd.h"
#include "mesh/faces.h"
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

/// The angles of triangle p, whose doubled area is `area2`.
template <int D>
void add_triangle(const Vec<D>& a, const Vec<D>& b, const Vec<D>& c, double area2, AngleTally& tally) {
  const Vec<D> ab = b - a, bc = c - b, ca = a - c;
  tally.add(-dot(ab, ca), area2);
  tally.add(-dot(ab, bc), area2);
  tally.add(-dot(bc, ca), area2);
}

struct AngleTallies {
  AngleTally face, dihedral;
};

/// [edge] of a simplex, in the order of the corners 01, 02, ..., 12, ...
template <int D>
using EdgeLengthsSq = std::array<double, D*(D + 1) / 2>;

template <int D>
EdgeLengthsSq<D> edge_lengths_sq(const std::array<Vec<D>, D + 1>& p) {
  EdgeLengthsSq<D> lengths_sq;
  std::size_t edge = 0;
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t j = i + 1; j <= D; ++j) lengths_sq[edge++] = distance_sq(p[i], p[j]);
  return lengths_sq;
}

/// Adds the angles of simplex s; those of a face between two simplices are added by the first of them.
void add_angles(const Mesh<2>&, SimplexId, const std::array<Vec<2>, 3>& p, const EdgeLengthsSq<2>&, double determinant,
                AngleTallies& tallies) {
  add_triangle(p[0], p[1], p[2], determinant, tallies.face);
}

void add_angles(const Mesh<3>& mesh, SimplexId s, const std::array<Vec<3>, 4>& p, const EdgeLengthsSq<3>& lengths_sq,
                double determinant, AngleTallies& tallies) {
  std::array<Vec<3>, 4> normal;  // Into the simplex, twice the face's area long.
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& f = kFaceCorners<3>[i];
    const Vec<3>&a = p[static_cast<std::size_t>(f[0])], &b = p[static_cast<std::size_t>(f[1])],
          &c = p[static_cast<std::size_t>(f[2])];
    normal[i] = cross(b - a, c - a);
    const SimplexId t = mesh.simplex_neighbors[s][i];
    if (t.is_none() || s < t) add_triangle(a, b, c, norm(normal[i]), tallies.face);
  }
  std::size_t opposite = 5;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet at the edge of the other two corners. |n_i x n_j| = |edge| |determinant|.
      tallies.dihedral.add(-dot(normal[i], normal[j]), std::sqrt(lengths_sq[opposite--]) * determinant);
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
      : mesh_(mesh), volumes_(volumes), observer_(observer) {}

  QualityReport measure() {
    report_.n_vertices = mesh_.points.size();
    report_.n_simplices = mesh_.simplex_vertices.size();
    report_.n_boundary_simplices = mesh_.boundary_vertices.size();
    report_.n_cells = volumes_.cell_vertex.size();
    report_.n_dual_faces = volumes_.face_area.size();
    measure_simplices();
    observer_.progress(1, 3);
    measure_edges();
    measure_cells();
    observer_.progress(2, 3);
    report_.cell_aspect = measure_spread(cell_aspects(mesh_, volumes_, simplices_, observer_), 1, 11, 40);
    observer_.progress(3, 3);
    return report_;
  }

 private:
  void measure_simplices() {
    std::vector<double> radius_edge(mesh_.simplex_vertices.size());
    simplices_.circumcenter.resize(radius_edge.size());
    simplices_.walls.resize(radius_edge.size());
    tbb::enumerable_thread_specific<AngleTallies> tallies;
    const RegionSums sums = parallel_reduce_ordered(
        radius_edge.size(), kBlock, RegionSums{},
        [&](std::size_t begin, std::size_t end) {
          observer_.check_cancelled();
          RegionSums block;
          AngleTallies& local = tallies.local();
          for (std::size_t k = begin; k != end; ++k) {
            const SimplexId s(k);
            const std::array<Vec<D>, D + 1> p = corners(mesh_, s);
            const double determinant = simplex_determinant<D>(p);
            const Vec<D> offset = circumcenter_offset<D>(p);
            simplices_.circumcenter[s] = p[0] + offset;
            simplices_.walls[s] = wall_corners(mesh_, s);
            const EdgeLengthsSq<D> lengths_sq = edge_lengths_sq<D>(p);
            const double ratio = std::sqrt(norm_sq(offset) / *std::min_element(lengths_sq.begin(), lengths_sq.end()));
            radius_edge[k] = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
            add_angles(mesh_, s, p, lengths_sq, determinant, local);
            auto& region = block.at(mesh_.simplex_region[s]);
            ++region.n;
            region.volume = region.volume + Dd(determinant / (D == 3 ? 6 : 2));
          }
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
