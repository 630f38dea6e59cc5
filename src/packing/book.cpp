#include "packing/book.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "geom/polytope_distance.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

/// In a zone y is at most this part of the distance to whatever else is in a page.
constexpr double kZoneShare = 0.8;
/// The height of a zone is known at this many places along the spine and linear between them.
constexpr std::size_t kZoneSamples = 129;

/// What limits a zone in one page: the facet's other segments and the points that are on none, in (s, y).
struct PageObstacles {
  std::vector<std::array<Vec<2>, 2>> segments;
  [[nodiscard]] double distance_to(const Vec<2>& x) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : segments) least = std::min(least, distance_to_segment(x, a, b));
    return least;
  }
};

/// The zone of a book as what is left of the plane.
class OutsideOf : public Area<2> {
 public:
  explicit OutsideOf(const BookZone& zone) : zone_(zone) {}
  [[nodiscard]] bool holds(const Vec<2>& x) const override { return !zone_.holds(x); }
  [[nodiscard]] bool touches(const Box<2>& box) const override {
    for (const double s : {box.lo[0], box.hi[0]})
      for (const double y : {box.lo[1], box.hi[1]})
        if (!zone_.holds({s, y})) return true;
    return !zone_.holds(box.center());
  }
  [[nodiscard]] bool covers(const Box<2>& box) const override {
    return box.hi[0] < 0 || box.lo[0] > zone_.length() || box.hi[1] < 0 || box.lo[1] > zone_.largest_height();
  }

 private:
  const BookZone& zone_;
};

}  // namespace

BookZone::BookZone(const Domain<3>& domain, const Protection<3>& protection, SegmentId spine, std::vector<Page> pages)
    : spine_(spine), pages_(std::move(pages)) {
  const auto [a, b] = domain.segments[spine];
  start_ = domain.points[a];
  along_ = protection.incidence.direction(spine, a);
  length_ = distance(domain.points[a], domain.points[b]);
  corner_ = {protection.corner_radius(a), protection.corner_radius(b)};
  std::vector<PageObstacles> obstacles;
  double widest = 0;
  for (const Page& page : pages_) {
    inward_.push_back(protection.incidence.inward(page, spine));
    const std::size_t k = inward_.size() - 1;
    PageObstacles here;
    for (const SegmentId s : domain.facet_segments[page.facet]) {
      if (s == spine) continue;
      here.segments.push_back(
          {to_page(k, domain.points[domain.segments[s][0]]), to_page(k, domain.points[domain.segments[s][1]])});
    }
    for (const PointId p : domain.facet_points[page.facet]) {
      const Vec<2> x = to_page(k, domain.points[p]);
      widest = std::max(widest, x[1]);
      if (p != a && p != b && std::ranges::none_of(domain.facet_segments[page.facet], [&](SegmentId s) {
            return std::ranges::count(domain.segments[s], p) > 0;
          }))
        here.segments.push_back({x, x});
    }
    obstacles.push_back(std::move(here));
  }
  for (std::size_t i = 0; i < kZoneSamples; ++i) {
    const double s = length_ * static_cast<double>(i) / (kZoneSamples - 1);
    double lo = 0, hi = widest;
    // Where a point is too high, all above it are: moving up by d brings others nearer by at most d.
    for (int step = 0; step < 30; ++step) {
      const double y = 0.5 * (lo + hi);
      const bool fits = std::ranges::all_of(obstacles, [&](const PageObstacles& o) {
        return y <= kZoneShare * o.distance_to({s, y});
      });
      (fits ? lo : hi) = y;
    }
    heights_.push_back(lo);
    largest_ = std::max(largest_, lo);
  }
}

double BookZone::height_at(double s) const {
  const double t = s / length_ * (kZoneSamples - 1);
  const auto i = std::min(static_cast<std::size_t>(std::max(t, 0.0)), kZoneSamples - 2);
  const double rest = t - static_cast<double>(i);
  return (1 - rest) * heights_[i] + rest * heights_[i + 1];
}

bool BookZone::holds(const Vec<2>& x) const {
  if (!(x[0] >= 0 && x[0] <= length_ && x[1] >= 0 && x[1] <= height_at(x[0]))) return false;
  return norm(x) > corner_[0] && norm(x - Vec<2>{length_, 0.0}) > corner_[1];
}

Vec<2> BookZone::to_page(std::size_t page, const Vec<3>& x) const {
  return {dot(x - start_, along_), dot(x - start_, inward_[page])};
}

Vec<3> BookZone::from_page(std::size_t page, const Vec<2>& x) const {
  return start_ + x[0] * along_ + x[1] * inward_[page];
}

void ReservedArea::add(const Domain<3>& domain, const BookZone& zone, std::size_t page) {
  const PlaneFrame& frame = domain.facet_frame[zone.pages()[page].facet];
  const Vec<2> start = frame.to_plane(zone.from_page(page, {0.0, 0.0}));
  zones_.push_back({&zone, start, frame.to_plane(zone.from_page(page, {1.0, 0.0})) - start,
                    frame.to_plane(zone.from_page(page, {0.0, 1.0})) - start});
}

bool ReservedArea::holds(const Vec<2>& x) const {
  for (const Placed& z : zones_)
    if (z.zone->holds(z.local(x))) return true;
  for (const Ball<2>& d : discs_)
    if (distance_sq(x, d.center) < d.radius * d.radius) return true;
  return false;
}

bool ReservedArea::touches(const Box<2>& box) const {
  const double r = 0.5 * box.diagonal();
  for (const Placed& z : zones_) {
    const Vec<2> m = z.local(box.center());
    if (m[0] > -r && m[0] < z.zone->length() + r && m[1] > -r && m[1] < z.zone->largest_height() + r) return true;
  }
  for (const Ball<2>& d : discs_)
    if (box.distance_sq(d.center) < d.radius * d.radius) return true;
  return false;
}

bool ReservedArea::covers(const Box<2>& box) const {
  for (const double x : {box.lo[0], box.hi[0]})
    for (const double y : {box.lo[1], box.hi[1]})
      if (!holds({x, y})) return false;
  return holds(box.center());
}

std::vector<Ball<2>> pack_book(const BookZone& zone, std::vector<Ball<2>> obstacles, std::vector<Ball<2>> balls,
                               const Spacing<3>& spacing, const PackingOptions& options, const Observer& observer) {
  PackingProblem<2> problem;
  problem.bounds = Box<2>({0.0, 0.0}, {zone.length(), zone.largest_height()});
  problem.foreign = std::move(obstacles);
  problem.balls = std::move(balls);
  Walls<2> spine;
  spine.simplices.push_back({Vec<2>{0.0, 0.0}, Vec<2>{zone.length(), 0.0}});
  spine.regions.push_back({0, Walls<2>::kOutside});
  const WallLocator<2> far(std::move(spine));
  const OutsideOf outside(zone);
  problem.far = &far;
  problem.reserved = &outside;
  problem.spacing = {[&](const Vec<2>& x) {
                       double f = std::numeric_limits<double>::infinity();
                       for (std::size_t k = 0; k < zone.pages().size(); ++k)
                         f = std::min(f, spacing(zone.from_page(k, x)));
                       return f;
                     },
                     [&](const Box<2>& box) -> std::optional<double> {
                       double f = std::numeric_limits<double>::infinity();
                       for (std::size_t k = 0; k < zone.pages().size(); ++k) {
                         Box<3> space;
                         for (const double s : {box.lo[0], box.hi[0]})
                           for (const double y : {box.lo[1], box.hi[1]}) space.add(zone.from_page(k, {s, y}));
                         const std::optional<double> here = spacing.constant_on(space);
                         if (!here) return std::nullopt;
                         f = std::min(f, *here);
                       }
                       return f;
                     },
                     spacing.lipschitz()};
  problem.form = options.form == PackingForm::kFiltered ? PackingForm::kFiltered : PackingForm::kMaximal;
  problem.lattice_first = options.form == PackingForm::kVoronoi;
  problem.interior = options.interior;
  problem.epsilon = options.epsilon;
  problem.seed = hash_words(options.seed, 4, zone.spine().value(), zone.pages()[0].facet.value());
  return pack_interior(problem, false, observer).spheres;
}

}  // namespace voropack
