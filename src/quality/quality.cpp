#include "voropack/quality.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geom/circumcenter.h"
#include "geom/dd.h"
#include "mesh/simplex_faces.h"
#include "quality/cell_aspect.h"
#include "quality/spread.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 4096;

template <int D>
std::array<Vec<D>, D + 1> corners(const Mesh<D>& mesh, SimplexId s) {
  std::array<Vec<D>, D + 1> p;
  for (std::size_t k = 0; k <= D; ++k) p[k] = mesh.points[mesh.simplex_vertices[s][k]];
  return p;
}

template <int D>
double shortest_edge_sq(const std::array<Vec<D>, D + 1>& p) {
  double least = distance_sq(p[0], p[1]);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = i + 1; j < p.size(); ++j) least = std::min(least, distance_sq(p[i], p[j]));
  return least;
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

/// Adds the angles of simplex s; those of a face between two simplices are added by the first of them.
void add_angles(const Mesh<2>&, SimplexId, const std::array<Vec<2>, 3>& p, double determinant, AngleTallies& tallies) {
  add_triangle(p[0], p[1], p[2], determinant, tallies.face);
}

void add_angles(const Mesh<3>& mesh, SimplexId s, const std::array<Vec<3>, 4>& p, double determinant,
                AngleTallies& tallies) {
  std::array<Vec<3>, 4> normal;  // Into the simplex, twice the face's area long.
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& f = kFaceCorners<3>[i];
    const Vec<3>&a = p[static_cast<std::size_t>(f[0])], &b = p[static_cast<std::size_t>(f[1])],
          &c = p[static_cast<std::size_t>(f[2])];
    normal[i] = cross(b - a, c - a);
    const SimplexId t = mesh.simplex_neighbors[s][i];
    if (t.is_none() || s < t) add_triangle(a, b, c, norm(normal[i]), tallies.face);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet at the edge of the other two corners, kl.
      const std::size_t k = i > 0 ? 0 : j > 1 ? 1 : 2;
      const double edge = distance(p[k], p[6 - i - j - k]);
      // |n_i x n_j| = |edge| |determinant|.
      tallies.dihedral.add(-dot(normal[i], normal[j]), edge * determinant);
    }
  }
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
    std::vector<double> aspects = cell_aspects(mesh_, volumes_, circumcenters_, observer_);
    report_.cell_aspect = measure_spread(aspects, 1, 11, 40);
    observer_.progress(3, 3);
    return report_;
  }

 private:
  void measure_simplices() {
    std::vector<double> radius_edge(mesh_.simplex_vertices.size());
    circumcenters_.resize(radius_edge.size());
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
            circumcenters_[s] = p[0] + offset;
            const double ratio = std::sqrt(norm_sq(offset) / shortest_edge_sq<D>(p));
            radius_edge[k] = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
            add_angles(mesh_, s, p, determinant, local);
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
    for (const AngleTallies& t : tallies) {  // Counts and extremes: any order gives the same.
      all.face.merge(t.face);
      all.dihedral.merge(t.dihedral);
    }
    report_.angle_deg = all.face.spread_deg();
    if constexpr (D == 3) report_.dihedral_deg = all.dihedral.spread_deg();
  }

  /// Edges on an interface have one dual face per region and count once.
  void measure_edges() {
    std::vector<double> lengths;
    lengths.reserve(volumes_.face_area.size());
    for (const DualFaceId f : ids(volumes_.face_area)) {
      if (f.value() > 0 && volumes_.face_vertices[f] == volumes_.face_vertices[DualFaceId(f.value() - 1)]) continue;
      lengths.push_back(volumes_.face_edge_length[f]);
    }
    const double longest = lengths.empty() ? 0 : *std::max_element(lengths.begin(), lengths.end());
    report_.edge_length = measure_spread(lengths, 0, longest, 40);
  }

  void measure_cells() {
    Dd sum;
    for (const double volume : volumes_.cell_volume) sum = sum + Dd(volume);
    report_.volume_sum = to_double(sum);
    if (!volumes_.cell_volume.empty())
      report_.min_cell_volume = *std::min_element(volumes_.cell_volume.begin(), volumes_.cell_volume.end());
    if (!volumes_.face_area.empty())
      report_.min_face_area = *std::min_element(volumes_.face_area.begin(), volumes_.face_area.end());
    report_.n_negative_faces = static_cast<std::uint64_t>(
        std::count_if(volumes_.face_area.begin(), volumes_.face_area.end(), [](double a) { return a < 0; }));
  }

  const Mesh<D>& mesh_;
  const ControlVolumes<D>& volumes_;
  Observer& observer_;
  IdVector<SimplexId, Vec<D>> circumcenters_;
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
