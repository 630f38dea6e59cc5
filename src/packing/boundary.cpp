#include "packing/boundary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <span>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/circumcenter.h"
#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "packing/book.h"
#include "packing/corner.h"
#include "packing/facet.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

template <int D>
class BoundaryPacker {
 public:
  BoundaryPacker(const Spacing<D>& spacing, Protection<D>& protection, SegmentPacker<D>& segments,
                 const PackingOptions& options, const Observer& observer)
      : domain_(protection.domain()),
        given_(spacing),
        spacing_(spacing),
        protection_(protection),
        segments_(segments),
        options_(options),
        observer_(observer) {}

  BoundaryPacking<D> run(std::span<const SpacingCap<D>> lowered) {
    protection_.begin_round();
    segments_.pack(protection_, spacing_, lowered);
    add_points();
    add_segments();
    lower_spacing([&](SphereId s) { return given_f_[s.value()]; });
    find_intruders_on_segments();
    if (!is_well()) return std::move(result_);
    settle_radii();
    if constexpr (D == 3) {
      const std::size_t n_spheres = packing().center.size(), n_balls = result_.balls.size();
      starts_.resize(domain_.facet_frame.size());
      add_kept_on_facets();
      add_fans();
      settle();
      add_books();
      add_facets();
      if (result_.faults.empty()) find_intruders_beyond_segments(n_spheres, n_balls);
    }
    if (is_well()) find_overlaps();
    return std::move(result_);
  }

 private:
  Packing<D>& packing() { return result_.packing; }
  [[nodiscard]] bool is_well() const { return result_.faults.empty() && !result_.protects_more; }

  /// Where ties made a sphere smaller than f, f itself becomes smaller: later steps rely on radii that are values of
  /// one Lipschitz function.
  void settle() {
    if (lower_spacing([&](SphereId s) { return spacing_(packing().center[s]); })) settle_radii();
  }

  /// The caps for that. `f_at` is the f of spheres by now. False if there are none.
  template <class At>
  bool lower_spacing(const At& f_at) {
    const std::size_t n_tied = result_.tied.size();
    for (const SphereId s : ids(packing().center))
      if (packing().radius[s] < f_at(s) * (1 - kPackingSlack))
        result_.tied.push_back(
            {packing().center[s], 0.0, packing().radius[s], std::array{packing().carrier[s], packing().carrier[s]}});
    if (result_.tied.size() == n_tied) return false;
    spacing_ = given_.with_caps(result_.tied);
    return true;
  }

  void settle_radii() {
    parallel_for(packing().center.size(),
                 [&](std::size_t i) { packing().radius[SphereId(i)] = spacing_(packing().center[SphereId(i)]); });
  }

  SphereId add(const Vec<D>& center, double radius, PolytopeId carrier) {
    packing().center.push_back(center);
    packing().radius.push_back(radius);
    return packing().carrier.push_back(carrier);
  }

  void add_points() {
    for (const PointId p : ids(domain_.points))
      add_given(domain_.points[p], segments_.f_at(p), segments_.f_at(p), PolytopeId(p));
  }

  SphereId add_given(const Vec<D>& center, double radius, double f, PolytopeId carrier) {
    given_f_.push_back(f);
    return add(center, radius, carrier);
  }

  /// Those that fit, where not all have to stay: what overlaps nothing, is in no protecting ball and keeps the far
  /// rule.
  void add_kept_on_facets() requires(D == 3) {
    if (protection_.kept.empty()) return;
    const bool all_stay = protection_.kept.all_stay();
    SphereSet<3> spheres(domain_.box.center(), spacing_.lipschitz(), packing().radius[SphereId(0)]);
    BallSet<3> balls(domain_.box.center());
    if (!all_stay) {
      for (const SphereId s : ids(packing().center)) spheres.add({packing().center[s], packing().radius[s]});
      for (const Ball<3>& b : result_.balls) balls.add(b);
    }
    for (const FacetId facet : ids(domain_.facet_frame)) {
      const auto is_far = [&](const Vec<3>& x, double f) {
        return std::ranges::all_of(domain_.facet_segments[facet], [&](SegmentId s) {
          const auto [a, b] = domain_.segments[s];
          return distance_to_segment(x, domain_.points[a], domain_.points[b]) >= 2 * f;
        });
      };
      for (const Vec<3>& x : protection_.kept.on_facet(facet)) {
        const double f = spacing_(x);
        if (!all_stay) {
          if (spheres.conflicts(x, f) || balls.forbids(x) || !is_far(x, f)) continue;
          spheres.add({x, f});
        }
        starts_[facet.value()].spheres.push_back(add(x, f, PolytopeId(facet)));
      }
    }
  }

  void add_segments() {
    for (const SegmentId s : ids(domain_.segments)) {
      const auto [a, b] = domain_.segments[s];
      std::vector<SphereId> chain = {SphereId(a.value())};
      for (const auto& c : segments_.centers(s)) chain.push_back(add_given(c.position, c.radius, c.f, PolytopeId(s)));
      chain.push_back(SphereId(b.value()));
      fit_radii(chain);
      spheres_of_segment_.push_row(chain);
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        packing().subsegments.push_back({{chain[k], chain[k + 1]}, PolytopeId(s)});
        const Vec<D> p = packing().center[chain[k]], q = packing().center[chain[k + 1]];
        result_.balls.push_back({0.5 * (p + q), 0.5 * distance(p, q)});
      }
    }
  }

  /// Makes the spheres of a chain small enough not to overlap the next ones, unless these are across a sharp feature.
  void fit_radii(const std::vector<SphereId>& chain) {
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      double &r = packing().radius[chain[k]], &s = packing().radius[chain[k + 1]];
      const double gap = distance(packing().center[chain[k]], packing().center[chain[k + 1]]);
      if (gap >= (r + s) * (1 - kPackingSlack)) continue;
      if (protection_.incidence.form_sharp_feature(packing().carrier[chain[k]], packing().carrier[chain[k + 1]]))
        continue;
      const double factor = gap / (r + s);
      r *= factor;
      s *= factor;
    }
  }

  /// The triangles around corners, and the centers on their arcs.
  void add_fans() requires(D == 3) {
    for (const FanArc& fan : pack_corners(domain_, protection_, spacing_, hash_words(options_.seed, 3))) {
      const double radius = protection_.corner_radius(fan.apex);
      std::vector<SphereId> rim;
      if (!fan.sector.first.is_none()) rim.push_back(rim_sphere(fan.sector.first, fan.apex));
      FacetStart& start = starts_[fan.facet.value()];
      const auto append = [&](double t, double r) {
        const Vec<3> x = point_of_arc(domain_, fan, radius, t);
        rim.push_back(add(x, std::min(r, spacing_(x)), PolytopeId(fan.facet)));
        start.spheres.push_back(rim.back());
        corner_of_sphere_[rim.back()] = fan.apex;
      };
      if (fan.sector.first.is_none()) append(0, std::numeric_limits<double>::infinity());
      for (std::size_t k = 0; k < fan.arc.position.size(); ++k) append(fan.arc.position[k], fan.arc.radius[k]);
      rim.push_back(fan.sector.first.is_none() ? rim.front() : rim_sphere(fan.sector.second, fan.apex));
      fit_radii(rim);
      for (std::size_t k = 0; k + 1 < rim.size(); ++k)
        start.fans.push_back({SphereId(fan.apex.value()), rim[k], rim[k + 1]});
      start.reserved.add_disc({domain_.facet_frame[fan.facet].to_plane(domain_.points[fan.apex]), radius});
    }
  }

  /// The center where a segment crosses the sphere of the corner at its end.
  SphereId rim_sphere(SegmentId s, PointId corner) {
    const auto chain = spheres_of_segment_[s];
    const SphereId rim = domain_.segments[s][0] == corner ? chain[1] : chain[chain.size() - 2];
    corner_of_sphere_[rim] = corner;
    return rim;
  }

  /// The equal parts of pages. First those that all pages of a book share, then what ever fewer of them do.
  void add_books() requires(D == 3) {
    struct Planned {
      SegmentId spine;
      BookLevel level;
      std::size_t first;  ///< The zone of the book's first level.
    };
    std::vector<Planned> plan;
    std::size_t depth = 0;
    for (const auto& [spine, groups] : protection_.books.all())
      for (const auto& pages : groups) {
        const std::size_t first = plan.size();
        for (BookLevel& level : levels_of_book(protection_, spine, pages)) {
          depth = std::max(depth, level.depth);
          plan.push_back({spine, std::move(level), first});
        }
      }
    zones_.resize(plan.size());
    for (std::size_t d = 0; d <= depth; ++d) {
      for (std::size_t i = 0; i < plan.size(); ++i) {
        const auto& [spine, level, first] = plan[i];
        if (level.depth != d) continue;
        observer_.check_cancelled();
        const BookZone* below = level.parent ? zones_[first + *level.parent].get() : nullptr;
        zones_[i] = std::make_unique<BookZone>(domain_, protection_, spacing_, spine, level, below);
        if (zones_[i]->largest_height() > 0) fill_zone(*zones_[i], d);
      }
      settle();
    }
  }

  /// Puts the same centers into all pages of a zone. They keep clear of what is in the pages already.
  void fill_zone(const BookZone& zone, std::size_t depth) requires(D == 3) {
    const std::vector<Page>& pages = zone.pages();
    std::vector<Ball<2>> obstacles, balls;
    for (std::size_t k = 0; k < pages.size(); ++k) collect(zone, k, obstacles, balls);
    const std::vector<Ball<2>> centers =
        pack_book(zone, std::move(obstacles), std::move(balls), spacing_, options_, observer_);
    const double wobble = kTieJitter * (1 - std::cos(protection_.least_angle(zone.spine(), pages)));
    for (std::size_t k = 0; k < pages.size(); ++k) {
      FacetStart& start = starts_[pages[k].facet.value()];
      start.reserved.add(domain_, zone, k);
      for (std::size_t i = 0; i < centers.size(); ++i) {
        Vec<2> x = centers[i].center;
        for (int axis = 0; axis < 2; ++axis) {
          const auto h = hash_words(options_.seed, 5, zone.spine().value(), depth, k, i, axis);
          x[axis] += wobble / std::numbers::sqrt2 * centers[i].radius * (2 * to_unit(h) - 1);
        }
        const Vec<3> p = zone.from_page(k, x);
        start.spheres.push_back(
            add(p, std::min(spacing_(p), centers[i].radius * (1 - 2 * wobble)), PolytopeId(pages[k].facet)));
      }
    }
  }

  /// What a book finds in its k-th page, in the page's coordinates.
  void collect(const BookZone& zone, std::size_t k, std::vector<Ball<2>>& obstacles,
               std::vector<Ball<2>>& balls) requires(D == 3) {
    const FacetId facet = zone.pages()[k].facet;
    const FacetStart& start = starts_[facet.value()];
    const auto take = [&](SphereId s) {
      const Vec<2> x = zone.to_page(k, packing().center[s]);
      if (x[1] > -packing().radius[s]) obstacles.push_back({x, packing().radius[s]});
    };
    for (const PointId p : domain_.facet_points[facet]) take(SphereId(p.value()));
    for (const SegmentId s : domain_.facet_segments[facet]) {
      const auto chain = spheres_of_segment_[s];
      for (const SphereId sphere : chain.subspan(1, chain.size() - 2)) take(sphere);
      for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
        const Vec<2> a = zone.to_page(k, packing().center[chain[i]]),
                     b = zone.to_page(k, packing().center[chain[i + 1]]);
        balls.push_back({0.5 * (a + b), 0.5 * distance(a, b)});
      }
    }
    for (const SphereId s : start.spheres) take(s);
    for (const auto& fan : start.fans) {
      std::array<Vec<2>, 3> corners;
      for (std::size_t i = 0; i < 3; ++i) corners[i] = zone.to_page(k, packing().center[fan[i]]);
      const Vec<2> c = fast_circumcenter(corners);
      if (c[1] > 0) balls.push_back({c, distance(c, corners[0])});
    }
  }

  void add_facets() requires(D == 3) {
    std::vector<PackedFacet> facets(domain_.facet_frame.size());
    parallel_for(
        facets.size(),
        [&](std::size_t f) {
          observer_.check_cancelled();
          facets[f] = pack_facet(domain_, protection_.incidence, FacetId(f), packing(), spheres_of_segment_, starts_[f],
                                 spacing_, options_, observer_);
        },
        1);
    for (const FacetId f : ids(domain_.facet_frame)) {
      const PackedFacet& facet = facets[f.value()];
      result_.faults.insert(result_.faults.end(), facet.faults.begin(), facet.faults.end());
      const std::size_t first = packing().center.size();
      const auto sphere = [&](std::uint32_t i) {
        return i < facet.boundary.size() ? facet.boundary[i] : SphereId(first + i - facet.boundary.size());
      };
      for (std::size_t i = 0; i < facet.centers.size(); ++i) add(facet.centers[i], facet.radii[i], PolytopeId(f));
      for (const TiedPolygon& polygon : facet.tied) {
        std::vector<SphereId> corners;
        for (const std::uint32_t i : polygon.points) corners.push_back(sphere(i));
        for (const std::uint32_t t : polygon.triangles) tied_with_ball_[result_.balls.size() + t] = corners;
      }
      for (const auto& t : facet.triangles) {
        ProtectedSimplex<2> subfacet{{}, PolytopeId(f)};
        std::array<Vec<3>, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) {
          subfacet.spheres[i] = sphere(t[i]);
          corners[i] = packing().center[subfacet.spheres[i]];
        }
        packing().subfacets.push_back(subfacet);
        const Vec<3> c = triangle_circumcenter(corners[0], corners[1], corners[2]);
        result_.balls.push_back({c, distance(c, corners[0])});
        if (is_finite(c)) continue;
        // Flat after rounding: nothing can be told of its ball.
        const double size = std::max(distance(corners[0], corners[1]), distance(corners[0], corners[2]));
        result_.faults.push_back(repair_cap(corners[0], size, spacing_, PolytopeId(f), PolytopeId(f)));
      }
    }
  }

  /// Of the ball's simplex, or of the tied polygon that the simplex is a part of.
  [[nodiscard]] bool is_corner(std::size_t ball, SphereId s) const {
    const auto& p = result_.packing;
    if (ball < p.subsegments.size()) return std::ranges::count(p.subsegments[ball].spheres, s) > 0;
    if (std::ranges::count(p.subfacets[ball - p.subsegments.size()].spheres, s) > 0) return true;
    const auto tied = tied_with_ball_.find(ball);
    return tied != tied_with_ball_.end() && std::ranges::count(tied->second, s) > 0;
  }

  /// Faults where a center lies in a protecting ball or too near to one. Pairs of which neither is new have been looked
  /// at before.
  template <class NewSphere, class NewBall>
  void find_intruders(const NewSphere& is_new_sphere, const NewBall& is_new_ball) {
    BallSet<D> all(domain_.box.center()), fresh(domain_.box.center());
    std::vector<std::uint32_t> fresh_ball;
    for (std::size_t b = 0; b < result_.balls.size(); ++b) {
      const Ball<D> grown = grown_by_blur(result_.balls[b], domain_.box);
      all.add(grown);
      if (!is_new_ball(b)) continue;
      fresh.add(grown);
      fresh_ball.push_back(static_cast<std::uint32_t>(b));
    }
    const std::size_t n = packing().center.size();
    std::vector<std::vector<std::uint32_t>> hit(n);
    parallel_for(n, [&](std::size_t i) {
      const SphereId s(i);
      const auto take = [&](std::uint32_t b) {
        if (!is_corner(b, s) && is_intruder(s, b)) hit[i].push_back(b);
        return false;
      };
      if (is_new_sphere(s))
        all.visit_holding(packing().center[s], kBallMargin, take);
      else
        fresh.visit_holding(packing().center[s], kBallMargin, [&](std::uint32_t b) { return take(fresh_ball[b]); });
    });
    for (std::size_t s = 0; s < n; ++s)
      for (const std::uint32_t b : hit[s]) answer(SphereId(s), b);
  }

  /// Of a center in the ball as it is grown by blur.
  [[nodiscard]] bool is_intruder(SphereId s, std::uint32_t ball) const {
    const Vec<D>& x = result_.packing.center[s];
    const auto& [center, radius] = result_.balls[ball];
    return distance_sq(x, center) <= radius * radius * (1 + kBallMargin) || is_inside_ball(result_.packing, ball, x);
  }

  void find_intruders_on_segments() {
    const auto is_new = [&](PolytopeId carrier) {
      return carrier.dimension == 1 && segments_.is_new(SegmentId(carrier.index));
    };
    find_intruders([&](SphereId s) { return is_new(packing().carrier[s]); },
                   [&](std::size_t b) { return is_new(packing().subsegments[b].carrier); });
  }

  /// On segments all is well.
  void find_intruders_beyond_segments(std::size_t old_spheres, std::size_t old_balls) requires(D == 3) {
    find_intruders([&](SphereId s) { return s.value() >= old_spheres; }, [&](std::size_t b) { return b >= old_balls; });
  }

  void answer(SphereId s, std::uint32_t ball) {
    const Intrusion<D> intrusion{packing().center[s],
                                 packing().carrier[s],
                                 result_.balls[ball],
                                 carrier_of(ball),
                                 nearest_corner(ball, packing().center[s]),
                                 corner_of(s),
                                 corner_of_ball(ball)};
    // Whatever the answer is, it has to be seen whether it has helped.
    for (const PolytopeId p : {intrusion.carrier, intrusion.ball_carrier})
      if (p.dimension == 1) segments_.pack_again(SegmentId(p.index));
    const auto cap = protection_.adapt(intrusion, spacing_);
    if (cap)
      result_.faults.push_back(*cap);
    else
      result_.protects_more = true;
  }

  [[nodiscard]] Vec<D> nearest_corner(std::uint32_t ball, const Vec<D>& x) const {
    const auto& p = result_.packing;
    const auto nearest = [&](const auto& spheres) {
      return p.center[*std::ranges::min_element(spheres, {}, [&](SphereId s) { return distance_sq(p.center[s], x); })];
    };
    return ball < p.subsegments.size() ? nearest(p.subsegments[ball].spheres)
                                       : nearest(p.subfacets[ball - p.subsegments.size()].spheres);
  }

  [[nodiscard]] PolytopeId carrier_of(std::uint32_t ball) const {
    const auto& p = result_.packing;
    return ball < p.subsegments.size() ? p.subsegments[ball].carrier : p.subfacets[ball - p.subsegments.size()].carrier;
  }

  [[nodiscard]] std::optional<PointId> corner_of(SphereId s) const {
    const auto it = corner_of_sphere_.find(s);
    return it == corner_of_sphere_.end() ? std::nullopt : std::optional(it->second);
  }

  [[nodiscard]] std::optional<PointId> corner_of_ball(std::uint32_t ball) const {
    const auto& p = result_.packing;
    if (ball < p.subsegments.size()) return std::nullopt;
    for (const SphereId s : p.subfacets[ball - p.subsegments.size()].spheres)
      if (s.value() < domain_.points.size() && protection_.corner_radius(PointId(s.value())) > 0)
        return PointId(s.value());
    return std::nullopt;
  }

  void find_overlaps() {
    if (packing().center.empty()) return;
    SphereSet<D> set(domain_.box.center(), spacing_.lipschitz(), packing().radius[SphereId(0)]);
    for (const SphereId s : ids(packing().center)) set.add({packing().center[s], packing().radius[s]});
    std::vector<std::uint32_t> partner(set.size(), BlockGrid<D>::kEnd);
    parallel_for(set.size(), [&](std::size_t i) {
      set.visit_near(set[i].center, set[i].radius, [&](std::uint32_t j) {
        if (j >= i || !SphereSet<D>::overlap(set[j], set[i].center, set[i].radius)) return false;
        if (protection_.incidence.form_sharp_feature(packing().carrier[SphereId(i)], packing().carrier[SphereId(j)]))
          return false;
        partner[i] = j;
        return true;
      });
    });
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (partner[i] == BlockGrid<D>::kEnd) continue;
      const Ball<D>&p = set[i], &q = set[partner[i]];
      result_.faults.push_back(repair_cap(0.5 * (p.center + q.center), p.radius + q.radius, spacing_,
                                          packing().carrier[SphereId(i)], packing().carrier[SphereId(partner[i])]));
    }
  }

  const Domain<D>& domain_;
  const Spacing<D>& given_;
  Spacing<D> spacing_;  ///< With what ties ask for.
  Protection<D>& protection_;
  SegmentPacker<D>& segments_;
  const PackingOptions& options_;
  const Observer& observer_;
  BoundaryPacking<D> result_;
  std::vector<double> given_f_;  ///< By sphere on points and segments.
  Csr<SegmentId, SphereId> spheres_of_segment_;
  std::vector<FacetStart> starts_;                               ///< By facet.
  std::vector<std::unique_ptr<BookZone>> zones_;                 ///< Reserved areas refer to them.
  std::map<std::size_t, std::vector<SphereId>> tied_with_ball_;  ///< The corners of its tied polygon.
  std::map<SphereId, PointId> corner_of_sphere_;                 ///< Of centers on the spheres of corners.
};

}  // namespace

template <int D>
BoundaryPacking<D> pack_boundary(const Spacing<D>& spacing, std::span<const SpacingCap<D>> lowered,
                                 Protection<D>& protection, SegmentPacker<D>& segments, const PackingOptions& options,
                                 const Observer& observer) {
  return BoundaryPacker<D>(spacing, protection, segments, options, observer).run(lowered);
}

template BoundaryPacking<2> pack_boundary(const Spacing<2>&, std::span<const SpacingCap<2>>, Protection<2>&,
                                          SegmentPacker<2>&, const PackingOptions&, const Observer&);
template BoundaryPacking<3> pack_boundary(const Spacing<3>&, std::span<const SpacingCap<3>>, Protection<3>&,
                                          SegmentPacker<3>&, const PackingOptions&, const Observer&);

}  // namespace voropack
