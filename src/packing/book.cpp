#include "packing/book.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/random.h"
#include "geom/polytope_distance.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

/// In a zone y is at most this part of the distance to other spines and corners of a page.
constexpr double kZoneShare = 0.8;
/// Where a zone is higher than that beside something else in a page, it stays so many f away.
constexpr double kZoneRoom = 1.6;
/// Zones are maximal to so many f, if nothing else is asked for.
constexpr double kZoneEpsilon = 0.5;
/// Of the height that T4 asks for: balls beyond it are those of a larger f.
constexpr double kZoneReserve = 1.3;
/// Relative, of that height.
constexpr double kZoneAccuracy = 0.01;
/// The height of a zone is known at this many places along the spine at least, and linear between them.
constexpr std::size_t kZoneSamples = 129;

/// Halvings of the interval in which the height is.
constexpr int kZoneSteps = 30;

/// Walls whose angles with the spine differ by less than this (radians) are shared.
constexpr double kSameAngle = 1e-9;
/// A wall that runs less than this along the spine per height stands upright on its end.
constexpr double kSteep = 1e-3;

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
  [[nodiscard]] bool covers(const Box<2>& box) const override { return zone_.misses(box); }

 private:
  const BookZone& zone_;
};

}  // namespace

namespace {

/// Of pages one behind the other, with the angles between neighbors.
std::vector<BookLevel> levels_of_row(std::span<const Page> row, std::span<const double> gaps) {
  struct Part {
    std::size_t begin, end, depth;
    std::optional<std::size_t> parent;
  };
  std::vector<Part> parts = {{0, row.size(), 0, std::nullopt}};
  std::vector<BookLevel> levels;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part part = parts[i];
    if (part.end - part.begin < 2) continue;
    const auto inner = gaps.subspan(part.begin, part.end - part.begin - 1);
    const double cut = 0.5 * std::ranges::max(inner);
    BookLevel level{{}, std::numeric_limits<double>::infinity(), part.depth, part.parent};
    std::size_t begin = part.begin;
    for (std::size_t k = part.begin; k < part.end; ++k) {
      level.pages.push_back(row[k]);
      if (k + 1 < part.end && gaps[k] <= cut) continue;
      if (k + 1 < part.end) level.angle = std::min(level.angle, gaps[k]);
      parts.push_back({begin, k + 1, part.depth + 1, levels.size()});
      begin = k + 1;
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace

std::vector<BookLevel> levels_of_book(const Protection<3>& protection, SegmentId spine, std::vector<Page> pages) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const Vec<3> first = protection.incidence.inward(pages[0], spine);
  const Vec<3> along = protection.incidence.direction(spine, protection.domain().segments[spine][0]);
  std::vector<std::pair<double, Page>> turns;
  for (const Page& page : pages) {
    const Vec<3> inward = protection.incidence.inward(page, spine);
    const double turn = std::atan2(dot(cross(first, inward), along), dot(first, inward));
    turns.emplace_back(turn < 0 ? turn + kTurn : turn, page);
  }
  std::ranges::sort(turns);
  // Cut where the gap is widest: the pages then follow each other in a row.
  const auto gap_after = [&](std::size_t i) {
    return i + 1 < turns.size() ? turns[i + 1].first - turns[i].first : turns[0].first + kTurn - turns[i].first;
  };
  std::size_t widest = 0;
  for (std::size_t i = 1; i < turns.size(); ++i)
    if (gap_after(i) > gap_after(widest)) widest = i;
  std::vector<double> gaps;  // Behind each page but the last one.
  std::vector<Page> row;
  for (std::size_t i = 1; i <= turns.size(); ++i) {
    const std::size_t k = (widest + i) % turns.size();
    row.push_back(turns[k].second);
    if (i < turns.size()) gaps.push_back(gap_after(k));
  }
  return levels_of_row(row, gaps);
}

/// What limits a zone in one page, in (s, y).
struct BookZone::PageObstacles {
  std::vector<std::array<Vec<2>, 2>> spines;    ///< Of other books.
  std::vector<Ball<2>> corners;                 ///< Other than the spine's own.
  std::vector<std::array<Vec<2>, 2>> segments;  ///< Others of the facet, and points that are on none.

  [[nodiscard]] static double distance_to(const std::vector<std::array<Vec<2>, 2>>& lines, const Vec<2>& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : lines) least = std::min(least, distance_to_segment(x, a, b));
    return least;
  }
  /// The height at which the line up from (s, 0) meets a segment.
  [[nodiscard]] double height_over(double s) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto* lines : {&spines, &segments})
      for (const auto& [a, b] : *lines) {
        if ((a[0] - s) * (b[0] - s) > 0 || a[0] == b[0]) continue;
        const double y = a[1] + (s - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
        if (y > 0) least = std::min(least, y);
      }
    return least;
  }
  /// `keeps_clear(d)`: whether the distance d to something else is enough at x.
  template <class KeepsClear>
  [[nodiscard]] bool leaves_room(const Vec<2>& x, KeepsClear&& keeps_clear) const {
    const double y = x[1] / kZoneShare;
    if (y > distance_to(spines, x)) return false;
    for (const Ball<2>& c : corners)
      if (y > distance(x, c.center) - c.radius) return false;
    const double d = distance_to(segments, x);
    return y <= d || keeps_clear(d);
  }
};

BookZone::BookZone(const Domain<3>& domain, const Protection<3>& protection, const Spacing<3>& spacing, SegmentId spine,
                   BookLevel level, const BookZone* below)
    : spine_(spine), pages_(std::move(level.pages)), below_(below) {
  const auto [a, b] = domain.segments[spine];
  start_ = domain.points[a];
  along_ = protection.incidence.direction(spine, a);
  length_ = distance(domain.points[a], domain.points[b]);
  corner_ = {protection.corner_radius(a), protection.corner_radius(b)};
  for (const Page& page : pages_) inward_.push_back(protection.incidence.inward(page, spine));
  find_shared_walls(domain, protection);
  std::vector<PageObstacles> obstacles;
  double widest = 0;
  for (std::size_t k = 0; k < pages_.size(); ++k) {
    obstacles.push_back(find_obstacles(domain, protection, k));
    for (const PointId p : domain.facet_points[pages_[k].facet])
      widest = std::max(widest, to_page(k, domain.points[p])[1]);
  }
  // The largest of all pages: of whatever borders one page, protecting balls reach into the copies in all others.
  const auto f = [&](const Vec<2>& x) {
    double largest = 0;
    for (std::size_t k = 0; k < pages_.size(); ++k) largest = std::max(largest, spacing(from_page(k, x)));
    return largest;
  };
  find_positions(obstacles);
  for (const double s : positions_) {
    double lo = 0, hi = std::min(widest, height_below_walls(s));
    for (const PageObstacles& o : obstacles) hi = std::min(hi, o.height_over(s));
    hi = std::min(hi, height_needed(spacing, level.angle, s, hi));
    // What is known of f at one height is mostly enough at the next one.
    double known_height = 0, known = f({s, 0});
    const auto keeps_clear = [&](double y, double d) {
      const double slack = spacing.lipschitz() * std::abs(y - known_height);
      if (std::abs(d - kZoneRoom * known) > kZoneRoom * slack) return d > kZoneRoom * known;
      known_height = y;
      known = f({s, y});
      return d >= kZoneRoom * known;
    };
    for (int step = 0; step < kZoneSteps; ++step) {
      const double y = 0.5 * (lo + hi);
      const bool fits = std::ranges::all_of(obstacles, [&](const auto& o) {
        return o.leaves_room({s, y}, [&](double d) { return keeps_clear(y, d); });
      });
      (fits ? lo : hi) = y;
    }
    heights_.push_back(lo);
    largest_ = std::max(largest_, lo);
  }
}

/// Where heights are looked at: evenly, and on both sides of where something begins or ends. Not at the ends of the
/// spine themselves, where what leaves them is met at no height.
void BookZone::find_positions(const std::vector<PageObstacles>& obstacles) {
  const double least = kSameAngle * length_;
  const auto add = [&](double s) { positions_.push_back(std::clamp(s, least, length_ - least)); };
  for (std::size_t i = 0; i < kZoneSamples; ++i) add(length_ * static_cast<double>(i) / (kZoneSamples - 1));
  for (const PageObstacles& o : obstacles)
    for (const auto* lines : {&o.spines, &o.segments})
      for (const auto& line : *lines)
        for (const Vec<2>& x : line)
          for (const double s : {x[0] - least, x[0] + least})
            if (s > 0 && s < length_) add(s);
  for (std::size_t i = 1; i < walls_.size(); ++i) add(walls_[i][1][0]);
  std::sort(positions_.begin(), positions_.end());
  positions_.erase(std::unique(positions_.begin(), positions_.end()), positions_.end());
}

BookZone::PageObstacles BookZone::find_obstacles(const Domain<3>& domain, const Protection<3>& protection,
                                                 std::size_t k) const {
  const FacetId facet = pages_[k].facet;
  const auto ends_of_spine = domain.segments[spine_];
  const auto is_end = [&](PointId p) { return p == ends_of_spine[0] || p == ends_of_spine[1]; };
  PageObstacles result;
  std::vector<PointId> on_segments;
  for (const SegmentId s : domain.facet_segments[facet]) {
    auto ends = domain.segments[s];
    on_segments.insert(on_segments.end(), ends.begin(), ends.end());
    if (s == spine_) continue;
    if (is_end(ends[1])) std::swap(ends[0], ends[1]);
    std::array<Vec<2>, 2> line = {to_page(k, domain.points[ends[0]]), to_page(k, domain.points[ends[1]])};
    if (is_wall(k, s)) {
      // What is longer than in other pages.
      const double whole = distance(line[0], line[1]), shared = shared_length(line[0]);
      if (shared >= whole * (1 - kSameAngle)) continue;
      line[0] = line[0] + (shared / whole) * (line[1] - line[0]);
    }
    (protection.is_spine(s, facet) ? result.spines : result.segments).push_back(line);
  }
  for (const PointId p : domain.facet_points[facet]) {
    const Vec<2> x = to_page(k, domain.points[p]);
    if (protection.corner_radius(p) > 0 && !is_end(p)) result.corners.push_back({x, protection.corner_radius(p)});
    if (std::ranges::count(on_segments, p) == 0) result.segments.push_back({x, x});
  }
  return result;
}

/// The length of the shared wall that begins at this end of the spine.
double BookZone::shared_length(const Vec<2>& tip) const {
  for (std::size_t i = 1; i < walls_.size(); ++i)
    if (distance(walls_[i][0], tip) < 0.5 * length_) return distance(walls_[i][0], walls_[i][1]);
  return 0;
}

double BookZone::least_spacing(const Spacing<3>& spacing, const Vec<2>& x) const {
  double f = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < pages_.size(); ++k) f = std::min(f, spacing(from_page(k, x)));
  return f;
}

void BookZone::find_shared_walls(const Domain<3>& domain, const Protection<3>& protection) {
  walls_ = {{Vec<2>{0, 0}, Vec<2>{length_, 0}}};
  wall_segments_.resize(pages_.size());
  const auto ends = domain.segments[spine_];
  for (std::size_t end = 0; end < 2; ++end) {
    std::vector<SegmentId> sides;
    double angle = -1, shortest = std::numeric_limits<double>::infinity();
    for (const Page& page : pages_)
      for (const Sector& sector : protection.incidence.sectors(page.facet, ends[end])) {
        const bool follows = (page.side == 0) == (end == 0);
        if ((follows ? sector.first : sector.second) != spine_) continue;
        const SegmentId side = follows ? sector.second : sector.first;
        const double here = sector.end - sector.begin;
        if (angle < 0) angle = here;
        if (side == spine_ || std::abs(here - angle) > kSameAngle || protection.is_spine(side, page.facet)) continue;
        sides.push_back(side);
        const auto [p, q] = domain.segments[side];
        shortest = std::min(shortest, distance(domain.points[p], domain.points[q]));
      }
    if (sides.size() != pages_.size() || angle >= std::numbers::pi) continue;
    const double forward = end == 0 ? 1 : -1;
    const Vec<2> tip{end == 0 ? 0 : length_, 0};
    walls_.push_back({tip, tip + shortest * Vec<2>{forward * std::cos(angle), std::sin(angle)}});
    for (std::size_t k = 0; k < sides.size(); ++k) wall_segments_[k].push_back(sides[k]);
  }
}

/// How high one may go at s before a shared wall.
double BookZone::height_below_walls(double s) const {
  double height = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < walls_.size(); ++i) {
    const auto& [tip, far] = walls_[i];
    const double run = (far[0] - tip[0]) * (tip[0] > 0 ? -1 : 1), along = std::abs(s - tip[0]);
    if (along < run && run > kSteep * far[1]) height = std::min(height, along / run * far[1]);
  }
  return height;
}

/// The least height W at s with W >= f (1 + sqrt(1 + 1 / sin^2(angle / 2))), beyond which balls of one page are clear
/// of centers of others.
double BookZone::height_needed(const Spacing<3>& spacing, double angle, double s, double most) const {
  const double sine = std::sin(0.5 * angle), widths = kZoneReserve * (1 + std::sqrt(1 + 1 / (sine * sine)));
  double height = 0;
  while (height < most) {
    const double needed = widths * least_spacing(spacing, {s, height});
    if (needed <= height * (1 + kZoneAccuracy)) break;
    height = needed;
  }
  return std::min(height, most);
}

double BookZone::height_at(double s) const {
  const auto next = std::upper_bound(positions_.begin() + 1, positions_.end() - 1, s);
  const auto i = static_cast<std::size_t>(next - positions_.begin()) - 1;
  const double t = std::clamp((s - positions_[i]) / (positions_[i + 1] - positions_[i]), 0.0, 1.0);
  return (1 - t) * heights_[i] + t * heights_[i + 1];
}

std::array<double, 2> BookZone::heights_between(double s, double t) const {
  std::array<double, 2> range = {height_at(s), height_at(s)};
  const auto take = [&](double height) { range = {std::min(range[0], height), std::max(range[1], height)}; };
  take(height_at(t));
  const auto begin = std::ranges::lower_bound(positions_, s), end = std::ranges::upper_bound(positions_, t);
  for (auto i = begin; i < end; ++i) take(heights_[static_cast<std::size_t>(i - positions_.begin())]);
  return range;
}

bool BookZone::reaches(const Vec<2>& x) const {
  return x[1] <= height_at(x[0]) || (below_ != nullptr && below_->reaches(x));
}

bool BookZone::holds(const Vec<2>& x) const {
  if (!(x[0] >= 0 && x[0] <= length_ && x[1] >= 0 && x[1] <= height_at(x[0]))) return false;
  if (below_ != nullptr && below_->reaches(x)) return false;
  return norm(x) > corner_[0] && norm(x - Vec<2>{length_, 0.0}) > corner_[1];
}

bool BookZone::misses(const Box<2>& box) const {
  const double begin = std::max(box.lo[0], 0.0), end = std::min(box.hi[0], length_);
  if (begin > end || box.hi[1] < 0 || box.lo[1] > heights_between(begin, end)[1]) return true;
  for (const BookZone* zone = below_; zone != nullptr; zone = zone->below_)
    if (box.hi[1] <= zone->heights_between(begin, end)[0]) return true;
  return false;
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
  Walls<2> walls;
  for (const auto& wall : zone.walls()) {
    walls.simplices.push_back(wall);
    walls.regions.push_back({0, Walls<2>::kOutside});
  }
  const WallLocator<2> far(std::move(walls));
  const OutsideOf outside(zone);
  problem.far = &far;
  problem.reserved = &outside;
  problem.spacing = {[&](const Vec<2>& x) { return zone.least_spacing(spacing, x); },
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
  problem.epsilon = options.form == PackingForm::kVoronoi ? kZoneEpsilon : options.epsilon;
  problem.seed = hash_words(options.seed, 4, zone.spine().value(), zone.pages()[0].facet.value());
  return pack_interior(problem, false, observer).spheres;
}

}  // namespace voropack
