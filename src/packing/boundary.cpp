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
#include "packing/strands.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

/// Centers of a segment that were cocircular by symmetry with others move by this much, relative to f.
constexpr double kSegmentJitter = 1e-4;

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

/// Arc lengths of the new centers inside an untied segment of the random forms, ascending.
template <int D>
std::vector<double> pack_segment(const Domain<D>& domain, SegmentId segment,
                                 std::span<const typename KeptCenters<D>::OnSegment> kept, const Spacing<D>& spacing,
                                 const PackingOptions& options, const Observer& observer) {
  const Vec<D> a = domain.points[domain.segments[segment][0]], b = domain.points[domain.segments[segment][1]];
  const double length = distance(a, b);
  const LocalSpacing<1> along = spacing_along(spacing, a, (b - a) / length);
  PackingProblem<1> problem;
  problem.bounds = Box<1>({0.0}, {length});
  problem.fixed = {{{0.0}, along.at({0.0})}, {{length}, along.at({length})}};
  for (const auto& k : kept) problem.fixed.push_back({{k.position}, along.at({k.position})});
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
  using KeptCenter = typename KeptCenters<D>::OnSegment;

 public:
  BoundaryPacker(const Domain<D>& domain, const Spacing<D>& spacing, Protection<D>& protection,
                 const PackingOptions& options, const Observer& observer)
      : domain_(domain),
        given_(spacing),
        spacing_(spacing),
        protection_(protection),
        options_(options),
        observer_(observer) {}

  BoundaryPacking<D> run() {
    protection_.begin_round();
    choose_kept_on_segments();
    add_points();
    add_segments();
    settle();
    find_intruders(0, 0);
    if constexpr (D == 3) {
      if (!is_well()) return std::move(result_);
      const std::size_t n_spheres = packing().center.size(), n_balls = result_.balls.size();
      starts_.resize(domain_.facet_frame.size());
      add_kept_on_facets();
      add_fans();
      settle();
      add_books();
      add_facets();
      if (result_.faults.empty()) find_intruders(n_spheres, n_balls);
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
    const std::size_t n_tied = result_.tied.size();
    for (const SphereId s : ids(packing().center))
      if (packing().radius[s] < spacing_(packing().center[s]) * (1 - kPackingSlack))
        result_.tied.push_back(
            {packing().center[s], 0.0, packing().radius[s], std::array{packing().carrier[s], packing().carrier[s]}});
    if (result_.tied.size() == n_tied) return;
    spacing_ = given_.with_caps(result_.tied);
    parallel_for(packing().center.size(),
                 [&](std::size_t i) { packing().radius[SphereId(i)] = spacing_(packing().center[SphereId(i)]); });
  }

  SphereId add(const Vec<D>& center, double radius, PolytopeId carrier) {
    packing().center.push_back(center);
    packing().radius.push_back(radius);
    return packing().carrier.push_back(carrier);
  }

  void add_points() {
    for (const PointId p : ids(domain_.points)) add(domain_.points[p], spacing_(domain_.points[p]), PolytopeId(p));
  }

  /// Those that fit, where not all have to stay: along each segment what leaves room for the one before and the end.
  void choose_kept_on_segments() {
    for (const SegmentId s : ids(domain_.segments)) {
      std::vector<KeptCenter> chosen(protection_.kept.on_segment(s).begin(), protection_.kept.on_segment(s).end());
      if (!protection_.kept.all_stay()) {
        const auto [a, b] = domain_.segments[s];
        const double length = distance(domain_.points[a], domain_.points[b]), last = spacing_(domain_.points[b]);
        double begin = 0, radius = spacing_(domain_.points[a]);
        std::erase_if(chosen, [&](const KeptCenter& k) {
          const double f = spacing_(k.center);
          const bool fits = k.position - begin >= (radius + f) * (1 - kPackingSlack) &&
                            length - k.position >= (f + last) * (1 - kPackingSlack);
          if (fits) begin = k.position, radius = f;
          return !fits;
        });
      }
      kept_on_segment_.push_row(chosen);
    }
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
    const std::vector<PackedStrand> strands = pack_strands(segment_strands(), segment_ties(), spacing_,
                                                           D == 3 ? kTieJitter : 0.0, hash_words(options_.seed, 1));
    for (const SegmentId s : ids(domain_.segments)) {
      const auto [a, b] = domain_.segments[s];
      const Vec<D> start = domain_.points[a], end = domain_.points[b];
      const double length = distance(start, end);
      const std::array<double, 2> rim = {protection_.corner_radius(a), protection_.corner_radius(b)};
      std::vector<SphereId> chain = {SphereId(a.value())};
      const auto append_center = [&](const Vec<D>& x, double radius) {
        chain.push_back(add(x, std::min(radius, spacing_(x)), PolytopeId(s)));
      };
      const auto append = [&](double t, double radius) {
        append_center(point_between(start, end, t / length), radius);
      };
      const double unlimited = std::numeric_limits<double>::infinity();
      const PackedStrand& strand = strands[s.value()];
      if (rim[0] > 0) append(rim[0], unlimited);
      for (std::size_t k = 0; k < strand.position.size(); ++k) {
        if (strand.kept[k] >= 0)
          append_center(kept_on_segment_[s][static_cast<std::size_t>(strand.kept[k])].center, strand.radius[k]);
        else
          append(rim[0] + strand.position[k], strand.radius[k]);
      }
      if (rim[1] > 0) append(length - rim[1], unlimited);
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

  /// The segments between the corners at their ends.
  std::vector<Strand<D>> segment_strands() {
    std::vector<Strand<D>> strands;
    for (const SegmentId s : ids(domain_.segments)) {
      const auto [a, b] = domain_.segments[s];
      const Vec<D> start = domain_.points[a], end = domain_.points[b];
      const double length = distance(start, end), first = protection_.corner_radius(a);
      const double last = protection_.corner_radius(b);
      Strand<D> strand;
      strand.length = length - first - last;
      strand.at = [=](double t) { return point_between(start, end, (first + t) / length); };
      if (protection_.shaken.contains(s)) strand.jitter = kSegmentJitter;
      for (const KeptCenter& k : kept_on_segment_[s]) strand.kept.push_back(k.position - first);
      if (options_.form != PackingForm::kVoronoi && first == 0 && last == 0)
        strand.positions = [this, s] {
          return pack_segment(domain_, s, kept_on_segment_[s], spacing_, options_, observer_);
        };
      strands.push_back(std::move(strand));
    }
    return strands;
  }

  std::vector<Tie> segment_ties() {
    std::vector<Tie> ties;
    for (const auto& [p, groups] : protection_.fans.all())
      for (const auto& segments : groups) {
        Tie tie{{}, protection_.least_angle(p, segments), protection_.corner_radius(p)};
        for (const SegmentId s : segments) {
          double angle = std::numbers::pi;
          for (const SegmentId t : segments)
            if (t != s)
              angle = std::min(
                  angle, angle_between(protection_.incidence.direction(s, p), protection_.incidence.direction(t, p)));
          tie.ends.push_back({s.value(), domain_.segments[s][1] == p, angle});
        }
        ties.push_back(std::move(tie));
      }
    return ties;
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

  /// Exact in every coordinate that both ends share.
  static Vec<D> point_between(const Vec<D>& a, const Vec<D>& b, double t) {
    Vec<D> x;
    for (int k = 0; k < D; ++k) x[k] = a[k] == b[k] ? a[k] : (1 - t) * a[k] + t * b[k];
    return x;
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
    for (std::size_t s = 0; s < n; ++s)
      for (const std::uint32_t b : hit[s]) answer(SphereId(s), b);
  }

  void answer(SphereId s, std::uint32_t ball) {
    const Intrusion<D> intrusion{packing().center[s],
                                 packing().carrier[s],
                                 result_.balls[ball],
                                 carrier_of(ball),
                                 nearest_corner(ball, packing().center[s]),
                                 corner_of(s),
                                 corner_of_ball(ball)};
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
  const PackingOptions& options_;
  const Observer& observer_;
  BoundaryPacking<D> result_;
  Csr<SegmentId, KeptCenter> kept_on_segment_;
  Csr<SegmentId, SphereId> spheres_of_segment_;
  std::vector<FacetStart> starts_;                               ///< By facet.
  std::vector<std::unique_ptr<BookZone>> zones_;                 ///< Reserved areas refer to them.
  std::map<std::size_t, std::vector<SphereId>> tied_with_ball_;  ///< The corners of its tied polygon.
  std::map<SphereId, PointId> corner_of_sphere_;                 ///< Of centers on the spheres of corners.
};

}  // namespace

template <int D>
BoundaryPacking<D> pack_boundary(const Spacing<D>& spacing, Protection<D>& protection, const PackingOptions& options,
                                 const Observer& observer) {
  return BoundaryPacker<D>(protection.domain(), spacing, protection, options, observer).run();
}

template BoundaryPacking<2> pack_boundary(const Spacing<2>&, Protection<2>&, const PackingOptions&, const Observer&);
template BoundaryPacking<3> pack_boundary(const Spacing<3>&, Protection<3>&, const PackingOptions&, const Observer&);

}  // namespace voropack
