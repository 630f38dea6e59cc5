#include "packing/boundary.h"

#include <algorithm>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/circumball.h"
#include "packing/facet.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

template <int D>
LocalSpacing<1> spacing_along(const Spacing<D>& spacing, const Vec<D>& a, const Vec<D>& direction) {
  return {[&spacing, a, direction](const Vec<1>& t) { return spacing(a + t[0] * direction); },
          [&spacing, a, direction](const Box<1>& box) {
            Box<D> space;
            space.add(a + box.lo[0] * direction);
            space.add(a + box.hi[0] * direction);
            return spacing.constant_on(space);
          },
          spacing.lipschitz()};
}

/// Arc lengths of the centers inside a segment, ascending.
template <int D>
std::vector<double> pack_segment(const Domain<D>& domain, SegmentId segment, const Spacing<D>& spacing,
                                 const PackingOptions& options, const Observer& observer) {
  const Vec<D> a = domain.points[domain.segments[segment][0]], b = domain.points[domain.segments[segment][1]];
  const double length = distance(a, b);
  const LocalSpacing<1> along = spacing_along(spacing, a, (b - a) / length);
  if (options.form == PackingForm::kVoronoi) return equidistribute(length, along);
  PackingProblem<1> problem;
  problem.bounds = Box<1>({0.0}, {length});
  problem.fixed = {{{0.0}, along.at({0.0})}, {{length}, along.at({length})}};
  problem.spacing = along;
  problem.form = options.form;
  problem.epsilon = options.epsilon;
  problem.seed = hash_words(options.seed, 1, segment.value());
  std::vector<double> positions;
  for (const Ball<1>& s : pack_interior(problem, false, observer).spheres) positions.push_back(s.center[0]);
  std::sort(positions.begin(), positions.end());
  return positions;
}

template <int D>
class BoundaryPacker {
 public:
  BoundaryPacker(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options,
                 const Observer& observer)
      : domain_(domain), spacing_(spacing), options_(options), observer_(observer) {}

  BoundaryPacking<D> run() {
    add_points();
    add_segments();
    find_intruders(0, 0);
    if (!result_.faults.empty()) return std::move(result_);
    if constexpr (D == 3) {
      const std::size_t n_spheres = result_.packing.center.size(), n_balls = result_.balls.size();
      add_facets();
      if (result_.faults.empty()) find_intruders(n_spheres, n_balls);
    }
    if (result_.faults.empty()) find_overlaps();
    return std::move(result_);
  }

 private:
  Packing<D>& packing() { return result_.packing; }

  SphereId add(const Vec<D>& center, double radius, PolytopeId carrier) {
    packing().center.push_back(center);
    packing().radius.push_back(radius);
    return packing().carrier.push_back(carrier);
  }

  void add_points() {
    for (const PointId p : ids(domain_.points)) add(domain_.points[p], spacing_(domain_.points[p]), PolytopeId(p));
  }

  void add_segments() {
    std::vector<std::vector<double>> positions(domain_.segments.size());
    parallel_for(
        positions.size(),
        [&](std::size_t s) {
          observer_.check_cancelled();
          positions[s] = pack_segment(domain_, SegmentId(s), spacing_, options_, observer_);
        },
        1);
    for (const SegmentId s : ids(domain_.segments)) {
      const auto [a, b] = domain_.segments[s];
      const Vec<D> start = domain_.points[a], end = domain_.points[b];
      const double length = distance(start, end);
      std::vector<SphereId> chain = {SphereId(a.value())};
      for (const double t : positions[s.value()]) {
        const Vec<D> x = point_between(start, end, t / length);
        chain.push_back(add(x, spacing_(x), PolytopeId(s)));
      }
      chain.push_back(SphereId(b.value()));
      spheres_of_segment_.push_row(chain);
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        packing().subsegments.push_back({{chain[k], chain[k + 1]}, PolytopeId(s)});
        const Vec<D> p = packing().center[chain[k]], q = packing().center[chain[k + 1]];
        result_.balls.push_back({0.5 * (p + q), 0.5 * distance(p, q)});
      }
    }
  }

  /// Exact in every coordinate that both ends share.
  static Vec<D> point_between(const Vec<D>& a, const Vec<D>& b, double t) {
    Vec<D> x;
    for (int k = 0; k < D; ++k) x[k] = a[k] == b[k] ? a[k] : (1 - t) * a[k] + t * b[k];
    return x;
  }

  void add_facets() requires(D == 3) {
    std::vector<PackedFacet> facets(domain_.facet_frame.size());
    parallel_for(
        facets.size(),
        [&](std::size_t f) {
          observer_.check_cancelled();
          facets[f] = pack_facet(domain_, FacetId(f), packing(), spheres_of_segment_, spacing_, options_, observer_);
        },
        1);
    for (const FacetId f : ids(domain_.facet_frame)) {
      const PackedFacet& facet = facets[f.value()];
      result_.faults.insert(result_.faults.end(), facet.faults.begin(), facet.faults.end());
      const std::size_t first = packing().center.size();
      for (std::size_t i = 0; i < facet.centers.size(); ++i) add(facet.centers[i], facet.radii[i], PolytopeId(f));
      for (const auto& t : facet.triangles) {
        ProtectedSimplex<2> subfacet{{}, PolytopeId(f)};
        std::array<Vec<3>, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) {
          subfacet.spheres[i] =
              t[i] < facet.boundary.size() ? facet.boundary[t[i]] : SphereId(first + t[i] - facet.boundary.size());
          corners[i] = packing().center[subfacet.spheres[i]];
        }
        packing().subfacets.push_back(subfacet);
        const Vec<3> c = circumcenter(corners);
        result_.balls.push_back({c, distance(c, corners[0])});
      }
    }
  }

  [[nodiscard]] bool is_corner(std::size_t ball, SphereId s) const {
    const auto& p = result_.packing;
    if (ball < p.subsegments.size()) return std::ranges::count(p.subsegments[ball].spheres, s) > 0;
    return std::ranges::count(p.subfacets[ball - p.subsegments.size()].spheres, s) > 0;
  }

  /// Faults where a center lies in a protecting ball or too near to one. Pairs of a sphere below `old_spheres` and a
  /// ball below `old_balls` have been looked at before.
  void find_intruders(std::size_t old_spheres, std::size_t old_balls) {
    BallSet<D> set(domain_.box.center());
    for (const Ball<D>& b : result_.balls) set.add(b);
    const std::size_t n = packing().center.size();
    std::vector<std::vector<std::uint32_t>> hit(n);
    parallel_for(n, [&](std::size_t s) {
      set.visit_holding(packing().center[SphereId(s)], kBallMargin, [&](std::uint32_t b) {
        if ((s >= old_spheres || b >= old_balls) && !is_corner(b, SphereId(s))) hit[s].push_back(b);
        return false;
      });
    });
    for (const auto& balls : hit)
      for (const std::uint32_t b : balls)
        result_.faults.push_back(repair_cap(result_.balls[b].center, result_.balls[b].radius, spacing_));
  }

  void find_overlaps() {
    if (packing().center.empty()) return;
    SphereSet<D> set(domain_.box.center(), spacing_.lipschitz(), packing().radius[SphereId(0)]);
    for (const SphereId s : ids(packing().center)) set.add({packing().center[s], packing().radius[s]});
    std::vector<std::uint32_t> partner(set.size(), BlockGrid<D>::kEnd);
    parallel_for(set.size(), [&](std::size_t i) {
      set.visit_near(set[i].center, set[i].radius, [&](std::uint32_t j) {
        if (j >= i || !SphereSet<D>::overlap(set[j], set[i].center, set[i].radius)) return false;
        partner[i] = j;
        return true;
      });
    });
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (partner[i] == BlockGrid<D>::kEnd) continue;
      const Ball<D>&p = set[i], &q = set[partner[i]];
      result_.faults.push_back(repair_cap(0.5 * (p.center + q.center), p.radius + q.radius, spacing_));
    }
  }

  const Domain<D>& domain_;
  const Spacing<D>& spacing_;
  const PackingOptions& options_;
  const Observer& observer_;
  BoundaryPacking<D> result_;
  Csr<SegmentId, SphereId> spheres_of_segment_;
};

}  // namespace

template <int D>
BoundaryPacking<D> pack_boundary(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options,
                                 const Observer& observer) {
  return BoundaryPacker<D>(domain, spacing, options, observer).run();
}

template BoundaryPacking<2> pack_boundary(const Domain<2>&, const Spacing<2>&, const PackingOptions&, const Observer&);
template BoundaryPacking<3> pack_boundary(const Domain<3>&, const Spacing<3>&, const PackingOptions&, const Observer&);

}  // namespace voropack
