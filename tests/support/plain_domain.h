// Domain<D> structures built by hand, without validation: for tests of the stages after the domain's.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "base/random.h"
#include "support/point_sets.h"
#include "voropack/domain.h"

namespace voropack::plain {

/// Collects polytopes. Segments are shared by their ends; every facet is convex and given by its corners in order.
template <int D>
class Builder {
 public:
  PointId point(const Vec<D>& x, int marker = 0) {
    domain_.box.add(x);
    domain_.point_marker.push_back(marker);
    domain_.point_region.push_back(RegionId::none());
    return domain_.points.push_back(x);
  }

  /// In 2D a wall with `left` and `right` as regions.
  SegmentId segment(PointId a, PointId b, int marker = 0, RegionId left = RegionId(0),
                    RegionId right = RegionId::none()) {
    const auto [entry, is_new] = segments_.try_emplace(std::minmax(a, b), SegmentId(domain_.segments.size()));
    if (is_new) {
      domain_.segments.push_back({a, b});
      domain_.segment_marker.push_back(marker);
      domain_.segment_region.push_back(RegionId::none());
      if (D == 2) domain_.wall_regions.push_back({left, right});
    }
    return entry->second;
  }

  /// A closed polygon, its regions as seen when walking along.
  void loop(const std::vector<PointId>& corners, RegionId left, RegionId right, int marker = 0) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      segment(corners[i], corners[(i + 1) % corners.size()], marker, left, right);
  }

  /// Side 0 is where the corners look counterclockwise.
  FacetId facet(const std::vector<PointId>& corners, RegionId side0, RegionId side1, int marker = 0) requires(D == 3) {
    const auto& x = domain_.points;
    PlaneFrame frame;
    frame.origin = x[corners[0]];
    const Vec<3> u = x[corners[1]] - frame.origin;
    Vec<3> n = cross(u, x[corners[2]] - frame.origin);
    frame.u = u / norm(u);
    frame.normal = n / norm(n);
    frame.v = cross(frame.normal, frame.u);
    domain_.facet_frame.push_back(frame);
    domain_.facet_marker.push_back(marker);
    std::vector<SegmentId> sides;
    for (std::size_t i = 0; i < corners.size(); ++i)
      sides.push_back(segment(corners[i], corners[(i + 1) % corners.size()]));
    std::sort(sides.begin(), sides.end());
    domain_.facet_segments.push_row(sides);
    std::vector<PointId> sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    domain_.facet_points.push_row(sorted);
    std::vector<std::array<PointId, 3>> triangles;
    for (std::size_t i = 2; i < corners.size(); ++i) triangles.push_back({corners[0], corners[i - 1], corners[i]});
    domain_.facet_triangles.push_row(triangles);
    domain_.wall_regions.push_back({side0, side1});
    return FacetId(domain_.facet_frame.size() - 1);
  }

  /// Side 1 is the region, so that corners look counterclockwise from outside.
  void box(const Vec<D>& lo, const Vec<D>& hi, RegionId region) {
    std::vector<PointId> p;
    for (unsigned i = 0; i < (1U << D); ++i) {
      Vec<D> x;
      for (int k = 0; k < D; ++k) x[k] = (i >> k & 1U) != 0 ? hi[k] : lo[k];
      p.push_back(point(x));
    }
    if constexpr (D == 2) {
      loop({p[0], p[1], p[3], p[2]}, region, RegionId::none());
    } else {
      const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
      int marker = 1;
      for (const auto& f : faces) {
        std::vector<PointId> corners;
        for (int i : f) corners.push_back(p[static_cast<std::size_t>(i)]);
        facet(corners, RegionId::none(), region, marker++);
      }
    }
  }

  RegionId region(int id, double measure) {
    domain_.region_id.push_back(id);
    domain_.region_max_simplex.push_back(std::nullopt);
    return domain_.region_measure.push_back(measure);
  }

  Domain<D>& domain() { return domain_; }

 private:
  Domain<D> domain_;
  std::map<std::pair<PointId, PointId>, SegmentId> segments_;
};

/// The unit square or cube.
template <int D>
Domain<D> unit_box() {
  Builder<D> build;
  Vec<D> one;
  for (int k = 0; k < D; ++k) one[k] = 1;
  build.box({}, one, build.region(1, 1.0));
  return build.domain();
}

/// The unit box with points, segments and (3D) triangles in it, one in each cell of a grid, so that they do not meet.
template <int D>
Domain<D> random_features(std::uint64_t seed, int cells) {
  Random random(seed);
  Builder<D> build;
  Vec<D> one;
  for (int k = 0; k < D; ++k) one[k] = 1;
  const RegionId inside = build.region(1, 1.0);
  build.box({}, one, inside);
  int n = 1;
  for (int k = 0; k < D; ++k) n *= cells;
  for (int c = 0; c < n; ++c) {
    const auto here = [&] {
      Vec<D> x = test::random_point<D>(random);
      for (int k = 0, rest = c; k < D; ++k, rest /= cells) x[k] = (rest % cells + 0.1 + 0.8 * x[k]) / cells;
      return build.point(x);
    };
    switch (random.bits() % (D + 2)) {
      case 0: {
        build.domain().point_region[here()] = inside;
        break;
      }
      case 1:
      case 2: {
        const PointId a = here();
        build.segment(a, here(), 0, inside, inside);
        break;
      }
      case 3: {
        if constexpr (D == 3) {
          const PointId a = here();
          const PointId b = here();
          build.facet({a, b, here()}, inside, inside);
        }
        break;
      }
      default:
        break;
    }
  }
  return build.domain();
}

/// Two nested boxes: region 1 between them, region 2 inside the smaller one.
template <int D>
Domain<D> nested_boxes() {
  Builder<D> build;
  Vec<D> one, lo, hi;
  for (int k = 0; k < D; ++k) {
    one[k] = 1;
    lo[k] = 0.4;
    hi[k] = 0.6;
  }
  const double small = std::pow(0.2, D);
  const RegionId outer = build.region(1, 1 - small);
  const RegionId inner = build.region(7, small);
  build.box({}, one, outer);
  const std::size_t first = build.domain().n_walls();
  build.box(lo, hi, inner);
  for (std::size_t w = first; w < build.domain().n_walls(); ++w)
    for (RegionId& r : build.domain().wall_regions[w])
      if (r.is_none()) r = outer;
  return build.domain();
}

}  // namespace voropack::plain
