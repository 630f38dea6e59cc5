#include "coarsening/simplify_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "coarsening/edge_balls.h"
#include "geom/circumcenter.h"
#include "geom/polytope_distance.h"
#include "geom/predicates.h"
#include "geom/tolerance.h"
#include "packing/tied_polygons.h"

namespace voropack {

namespace {

/// How far what was taken away may be from what stands for it, in units of f.
constexpr double kMaxMove = 0.5;
/// New triangles turn away from the mean of the old ones by at most 60 degrees.
constexpr double kLeastCosine = 0.5;
/// Circumradius over shortest edge of new triangles, where the old ones are not worse.
constexpr double kMaxRatio = 2.0;
/// Holes with more corners are left alone: their best triangulation costs the cube of that.
constexpr std::size_t kMaxRim = 16;
/// Beyond this, relative to R^2, plain double precision knows on which side of a ball a point is.
constexpr double kClear = 1e-6;
/// What the volume that a triangle cuts off counts beside its shape, in units of f^3.
constexpr double kVolumeWeight = 2.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double radius_edge_ratio(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const double ab = distance(a, b), bc = distance(b, c), ca = distance(c, a);
  return 0.5 * ab * bc * ca / (norm(cross(b - a, c - a)) * std::min({ab, bc, ca}));
}

double sixfold_volume(const Vec<3>& o, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  return dot(a - o, cross(b - o, c - o));
}

void erase_value(std::vector<std::uint32_t>& values, std::uint32_t value) {
  values.erase(std::find(values.begin(), values.end(), value));
}

}  // namespace

SurfaceSimplifier::SurfaceSimplifier(const SurfaceComplex& fine, double max_volume_change)
    : fine_(&fine),
      max_volume_change_(max_volume_change),
      star_(fine.points.size()),
      curve_star_(fine.points.size()),
      is_gone_(fine.points.size(), 0),
      region_change_(fine.region_id.size(), 0.0),
      stamp_(fine.points.size(), 0),
      n_left_(fine.points.size()) {
  for (const SurfaceTriangle& t : fine.triangles) add_triangle({t});
  for (const CurveEdge& e : fine.edges) {
    for (const std::uint32_t v : e.ends) curve_star_[v].push_back(static_cast<std::uint32_t>(edges_.size()));
    edges_.push_back({e});
  }
}

void SurfaceSimplifier::add_triangle(Triangle triangle) {
  for (const std::uint32_t v : triangle.surface.corners)
    star_[v].push_back(static_cast<std::uint32_t>(triangles_.size()));
  triangles_.push_back(std::move(triangle));
}

void SurfaceSimplifier::kill_triangle(std::uint32_t t) {
  for (const std::uint32_t v : triangles_[t].surface.corners) erase_value(star_[v], t);
  triangles_[t].is_alive = false;
  triangles_[t].passengers = {};
}

std::uint32_t SurfaceSimplifier::other_end(std::uint32_t edge, std::uint32_t v) const {
  const auto& ends = edges_[edge].curve.ends;
  return ends[0] == v ? ends[1] : ends[0];
}

bool SurfaceSimplifier::is_on_curve(std::uint32_t v, std::uint32_t w) const {
  return std::ranges::any_of(curve_star_[v], [&](std::uint32_t e) { return other_end(e, v) == w; });
}

bool SurfaceSimplifier::are_adjacent(std::uint32_t v, std::uint32_t w) const {
  return is_on_curve(v, w) || std::ranges::any_of(star_[v], [&](std::uint32_t t) {
           return std::ranges::count(triangles_[t].surface.corners, w) > 0;
         });
}

bool SurfaceSimplifier::has_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::ranges::any_of(star_[a], [&](std::uint32_t t) {
    const auto& corners = triangles_[t].surface.corners;
    return std::ranges::count(corners, b) > 0 && std::ranges::count(corners, c) > 0;
  });
}

SurfacePlace SurfaceSimplifier::place_of(std::uint32_t v) const {
  const auto& curve = curve_star_[v];
  if (curve.empty() && !star_[v].empty()) return SurfacePlace::kPatch;
  if (curve.size() == 2 && edges_[curve[0]].curve.curve == edges_[curve[1]].curve.curve) return SurfacePlace::kCurve;
  return SurfacePlace::kAnchor;
}

void SurfaceSimplifier::simplify(std::span<const double> f, double allowance) {
  f_ = f;
  room_.clear();
  for (std::size_t r = 0; r < fine_->region_id.size(); ++r)
    room_.push_back(allowance * max_volume_change_ * fine_->region_volume[r] / fine_->region_boundary_area[r]);
  rebuild_tree();
  for (std::uint32_t v = 0; v < star_.size(); ++v) wish_for(v);
  while (!queue_.empty()) {
    const Wish wish = queue_.top();
    queue_.pop();
    if (is_gone_[wish.vertex] != 0 || stamp_[wish.vertex] != wish.stamp) continue;
    if (!remove(wish.vertex)) continue;
    if (2 * n_left_ < treed_.size()) rebuild_tree();
  }
}

void SurfaceSimplifier::rebuild_tree() {
  treed_.clear();
  std::vector<Box<3>> boxes;
  for (std::uint32_t v = 0; v < star_.size(); ++v) {
    if (is_gone_[v] != 0) continue;
    treed_.push_back(v);
    boxes.emplace_back(point(v), point(v));
  }
  tree_ = BoxTree<3>(boxes);
}

void SurfaceSimplifier::wish_for(std::uint32_t v) {
  ++stamp_[v];
  if (is_gone_[v] != 0) return;
  const SurfacePlace place = place_of(v);
  if (place == SurfacePlace::kAnchor) return;
  double least = kInfinity;
  const auto compare = [&](std::uint32_t w) {
    if (w != v) least = std::min(least, distance(point(v), point(w)) / (f_[v] + f_[w]));
  };
  for (const std::uint32_t t : star_[v])
    for (const std::uint32_t w : triangles_[t].surface.corners) compare(w);
  for (const std::uint32_t e : curve_star_[v]) compare(other_end(e, v));
  if (least < 1) queue_.push({least, place == SurfacePlace::kCurve ? 1 : 0, v, stamp_[v]});
}

bool SurfaceSimplifier::walk(std::uint32_t v, std::uint32_t first, std::uint32_t begin, std::uint32_t end,
                             Sheet& sheet) const {
  const auto& corners = triangles_[first].surface.corners;
  const auto at = static_cast<std::size_t>(std::ranges::find(corners, v) - corners.begin());
  sheet.turns_along = corners[(at + 1) % 3] == begin;
  sheet.rim = {begin};
  for (std::uint32_t t = first, from = begin;;) {
    if (sheet.triangles.size() > kMaxRim) return false;
    sheet.triangles.push_back(t);
    const auto& c = triangles_[t].surface.corners;
    const std::uint32_t to = c[0] ^ c[1] ^ c[2] ^ v ^ from;
    if (to == begin) return end == begin;
    sheet.rim.push_back(to);
    if (is_on_curve(v, to)) return to == end;
    const auto next = std::ranges::find_if(
        star_[v], [&](std::uint32_t s) { return s != t && std::ranges::count(triangles_[s].surface.corners, to) > 0; });
    if (next == star_[v].end()) return false;
    t = *next;
    from = to;
  }
}

auto SurfaceSimplifier::find_sheets(std::uint32_t v) const -> std::optional<std::vector<Sheet>> {
  std::vector<Sheet> sheets;
  std::size_t n_triangles = 0;
  const auto add = [&](std::uint32_t first, std::uint32_t begin, std::uint32_t end) {
    Sheet sheet;
    if (!walk(v, first, begin, end, sheet)) return false;
    n_triangles += sheet.triangles.size();
    sheets.push_back(std::move(sheet));
    return true;
  };
  if (curve_star_[v].empty()) {
    const auto& corners = triangles_[star_[v][0]].surface.corners;
    const std::uint32_t begin = corners[0] == v ? corners[1] : corners[0];
    if (!add(star_[v][0], begin, begin)) return std::nullopt;
  } else {
    const std::uint32_t begin = other_end(curve_star_[v][0], v), end = other_end(curve_star_[v][1], v);
    for (const std::uint32_t t : star_[v])
      if (std::ranges::count(triangles_[t].surface.corners, begin) > 0 && !add(t, begin, end)) return std::nullopt;
  }
  // What touches v only there, in another sheet, keeps it.
  if (n_triangles != star_[v].size()) return std::nullopt;
  return sheets;
}

bool SurfaceSimplifier::remove(std::uint32_t v) {
  const auto sheets = find_sheets(v);
  if (!sheets) return false;
  const bool is_on_curve = !curve_star_[v].empty();
  Edge edge;
  if (is_on_curve) {
    const std::array<std::uint32_t, 2> old = {curve_star_[v][0], curve_star_[v][1]};
    const std::uint32_t p = other_end(old[0], v), q = other_end(old[1], v);
    if (p == q || are_adjacent(p, q) || !is_empty_ball(p, q, v, star_[v].empty())) return false;
    const bool is_first = distance_sq(point(p), point(v)) >= distance_sq(point(q), point(v));
    edge.curve = edges_[old[is_first ? 0 : 1]].curve;
    edge.curve.ends = ends_of(p, q);
    edge.passengers = {v};
    for (const std::uint32_t e : old)
      edge.passengers.insert(edge.passengers.end(), edges_[e].passengers.begin(), edges_[e].passengers.end());
    for (const std::uint32_t w : edge.passengers)
      if (distance_to_segment(point(w), point(p), point(q)) > kMaxMove * f_[v]) return false;
  }
  std::vector<Patching> patchings;
  std::vector<double> change = region_change_;
  for (const Sheet& sheet : *sheets) {
    std::optional<Patching> patching = patch(v, sheet, is_on_curve);
    if (!patching || !are_edges_fit(v, *patching) || !carry(v, patchings.empty(), sheet, *patching) ||
        !allows_drift(sheet, *patching))
      return false;
    const auto& regions = triangles_[sheet.triangles[0]].surface.regions;
    for (std::size_t side = 0; side < 2; ++side)
      if (regions[side] != kNoRegion)
        change[static_cast<std::size_t>(regions[side])] += side == 0 ? -patching->volume : patching->volume;
    patchings.push_back(std::move(*patching));
  }
  for (std::size_t r = 0; r < change.size(); ++r)
    if (std::abs(change[r]) > max_volume_change_ * fine_->region_volume[r] &&
        std::abs(change[r]) > std::abs(region_change_[r]))
      return false;

  region_change_ = std::move(change);
  is_gone_[v] = 1;
  --n_left_;
  std::vector<std::uint32_t> around;
  for (std::size_t k = 0; k < sheets->size(); ++k) {
    for (const std::uint32_t t : (*sheets)[k].triangles) kill_triangle(t);
    for (Triangle& t : patchings[k].triangles) add_triangle(std::move(t));
    around.insert(around.end(), (*sheets)[k].rim.begin(), (*sheets)[k].rim.end());
  }
  if (is_on_curve) {
    for (const std::uint32_t e : std::vector<std::uint32_t>(curve_star_[v])) {
      for (const std::uint32_t w : edges_[e].curve.ends) erase_value(curve_star_[w], e);
      edges_[e].is_alive = false;
      edges_[e].passengers = {};
    }
    for (const std::uint32_t w : edge.curve.ends) {
      curve_star_[w].push_back(static_cast<std::uint32_t>(edges_.size()));
      around.push_back(w);
    }
    edges_.push_back(std::move(edge));
  }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  for (const std::uint32_t w : around) wish_for(w);
  return true;
}

auto SurfaceSimplifier::patch(std::uint32_t v, const Sheet& sheet, bool is_open) const -> std::optional<Patching> {
  const std::vector<std::uint32_t>& rim = sheet.rim;
  const std::size_t n = rim.size();
  if (n < 3 || n > kMaxRim) return std::nullopt;
  Vec<3> mean{0, 0, 0};
  double worst = kMaxRatio;
  for (std::size_t i = 0; i + (is_open ? 1 : 0) < n; ++i) {
    const Vec<3>&a = point(rim[i]), &b = point(rim[(i + 1) % n]);
    mean += cross(a - point(v), b - point(v));
    worst = std::max(worst, radius_edge_ratio(point(v), a, b));
  }
  const double unit = f_[v] * f_[v] * f_[v];
  const auto may_have_edge = [&](std::size_t i, std::size_t j) {
    return j == i + 1 || (i == 0 && j == n - 1) || !are_adjacent(rim[i], rim[j]);
  };
  const auto cost = [&](std::size_t i, std::size_t m, std::size_t j) {
    const Vec<3>&a = point(rim[i]), &b = point(rim[m]), &c = point(rim[j]);
    const Vec<3> normal = cross(b - a, c - a);
    if (!(dot(normal, mean) > kLeastCosine * norm(normal) * norm(mean))) return kInfinity;
    const double ratio = radius_edge_ratio(a, b, c);
    if (!(ratio <= worst)) return kInfinity;
    if (!may_have_edge(i, m) || !may_have_edge(m, j) || !may_have_edge(i, j)) return kInfinity;
    if (has_triangle(rim[i], rim[m], rim[j]) || !is_empty_ball(rim[i], rim[m], rim[j], v)) return kInfinity;
    return ratio * ratio + kVolumeWeight * std::abs(sixfold_volume(point(v), a, b, c)) / unit;
  };
  // The best triangulation of each run of the rim, closed by the edge between its ends.
  std::array<std::array<double, kMaxRim>, kMaxRim> best{};
  std::array<std::array<std::size_t, kMaxRim>, kMaxRim> apex{};
  for (std::size_t length = 2; length < n; ++length)
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      best[i][j] = kInfinity;
      for (std::size_t m = i + 1; m < j; ++m) {
        const double parts = best[i][m] + best[m][j];
        if (!(parts < best[i][j])) continue;
        const double sum = parts + cost(i, m, j);
        if (sum < best[i][j]) best[i][j] = sum, apex[i][j] = m;
      }
    }
  if (best[0][n - 1] == kInfinity) return std::nullopt;

  Patching result;
  const SurfaceTriangle& like = triangles_[sheet.triangles[0]].surface;
  std::vector<std::array<std::size_t, 2>> stack = {{0, n - 1}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    if (j == i + 1) continue;
    const std::size_t m = apex[i][j];
    stack.push_back({i, m});
    stack.push_back({m, j});
    Triangle t;
    t.surface = like;
    t.surface.corners = {rim[i], rim[m], rim[j]};
    if (!sheet.turns_along) std::swap(t.surface.corners[1], t.surface.corners[2]);
    const auto& c = t.surface.corners;
    result.volume += sixfold_volume(point(v), point(c[0]), point(c[1]), point(c[2])) / 6;
    result.area += 0.5 * norm(cross(point(c[1]) - point(c[0]), point(c[2]) - point(c[0])));
    result.triangles.push_back(std::move(t));
  }
  return result;
}

bool SurfaceSimplifier::are_edges_fit(std::uint32_t v, const Patching& patching) const {
  const auto has_edge = [](const SurfaceTriangle& t, std::uint32_t a, std::uint32_t b) {
    return std::ranges::count(t.corners, a) > 0 && std::ranges::count(t.corners, b) > 0;
  };
  for (std::size_t k = 0; k < patching.triangles.size(); ++k) {
    const SurfaceTriangle& t = patching.triangles[k].surface;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t.corners[i], b = t.corners[(i + 1) % 3];
      if (is_on_curve(a, b)) continue;
      for (std::size_t l = 0; l < k; ++l) {
        const SurfaceTriangle& s = patching.triangles[l].surface;
        if (has_edge(s, a, b) && !is_edge_fit(v, t, s, a, b)) return false;
      }
      for (const std::uint32_t other : star_[a]) {
        const SurfaceTriangle& s = triangles_[other].surface;
        if (has_edge(s, a, b) && std::ranges::count(s.corners, v) == 0 && !is_edge_fit(v, t, s, a, b)) return false;
      }
    }
  }
  return true;
}

template <class Accept>
bool SurfaceSimplifier::is_any_near(const Vec<3>& x, double reach_sq, Accept&& accept) const {
  return tree_.find([&](const Box<3>& box) { return box.distance_sq(x) <= reach_sq; },
                    [&](std::uint32_t item) {
                      const std::uint32_t w = treed_[item];
                      if (is_gone_[w] != 0) return false;
                      const double d = distance_sq(x, point(w));
                      return d <= reach_sq && accept(w, d);
                    });
}

bool SurfaceSimplifier::is_edge_fit(std::uint32_t v, const SurfaceTriangle& t, const SurfaceTriangle& s,
                                    std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t p = third_corner(t, a, b), q = third_corner(s, a, b);
  const auto found = edge_balls(point(a), point(b), point(p), point(q), regions_beside(t, a, b));
  if (!found) return false;
  for (std::size_t k = 0; k < found->n; ++k) {
    const Vec<3>& x = found->balls[k].center;
    const double reach_sq = found->balls[k].radius * found->balls[k].radius * (1 - kBallMargin);
    const auto is_inside = [&](std::uint32_t w, double d) {
      return d < reach_sq && w != v && w != a && w != b && w != p && w != q;
    };
    if (is_any_near(x, reach_sq, is_inside)) return false;
  }
  return true;
}

bool SurfaceSimplifier::carry(std::uint32_t v, bool takes_vertex, const Sheet& sheet, Patching& patching) const {
  const double limit = kMaxMove * f_[v];
  const auto board = [&](std::uint32_t w) {
    double nearest = kInfinity;
    Triangle* best = nullptr;
    for (Triangle& t : patching.triangles) {
      const auto& c = t.surface.corners;
      const double d = distance_to_triangle(point(w), point(c[0]), point(c[1]), point(c[2]));
      if (d < nearest) nearest = d, best = &t;
    }
    if (nearest > limit) return false;
    best->passengers.push_back(w);
    return true;
  };
  if (takes_vertex && !board(v)) return false;
  for (const std::uint32_t t : sheet.triangles)
    for (const std::uint32_t w : triangles_[t].passengers)
      if (!board(w)) return false;
  return true;
}

bool SurfaceSimplifier::allows_drift(const Sheet& sheet, Patching& patching) const {
  double before = 0, room = kInfinity;
  for (const std::uint32_t t : sheet.triangles) before += triangles_[t].drift;
  for (const int r : triangles_[sheet.triangles[0]].surface.regions)
    if (r != kNoRegion) room = std::min(room, room_[static_cast<std::size_t>(r)]);
  const double total = before + patching.volume;
  if (std::abs(total) > room * patching.area && std::abs(total) > std::abs(before)) return false;
  for (Triangle& t : patching.triangles) {
    const auto& c = t.surface.corners;
    t.drift = total / patching.area * 0.5 * norm(cross(point(c[1]) - point(c[0]), point(c[2]) - point(c[0])));
  }
  return true;
}

bool SurfaceSimplifier::is_empty_ball(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t gone) const {
  const Vec<3> center = triangle_circumcenter(point(a), point(b), point(c));
  const double radius_sq = distance_sq(center, point(a));
  const double outer = radius_sq * (1 + kClear), inner = radius_sq * (1 - kClear);
  std::vector<std::uint32_t> tied;
  const auto is_inside = [&](std::uint32_t w, double d) {
    if (w == gone || w == a || w == b || w == c) return false;
    const int side = d < inner ? 1 : in_diametral_ball(point(a), point(b), point(c), point(w));
    if (side == 0) tied.push_back(w);
    return side > 0;
  };
  return !is_any_near(center, outer, is_inside) && (tied.empty() || is_chosen_by_ties({a, b, c}, std::move(tied)));
}

bool SurfaceSimplifier::is_empty_ball(std::uint32_t a, std::uint32_t b, std::uint32_t gone, bool is_dangling) const {
  const Vec<3> center = 0.5 * (point(a) + point(b));
  const double outer = 0.25 * distance_sq(point(a), point(b)) * (1 + kClear);
  // An edge of triangles is Delaunay with them, whatever lies on the sphere.
  const int least = is_dangling ? 0 : 1;
  return !is_any_near(center, outer, [&](std::uint32_t w, double) {
    return w != gone && w != a && w != b && in_diametral_ball(point(a), point(b), point(w)) >= least;
  });
}

bool SurfaceSimplifier::is_chosen_by_ties(std::array<std::uint32_t, 3> corners, std::vector<std::uint32_t> tied) const {
  std::vector<Vec<3>> points;
  for (const std::uint32_t v : corners) points.push_back(point(v));
  for (const std::uint32_t v : tied) {
    if (orientation(points[0], points[1], points[2], point(v)) != 0) return false;
    points.push_back(point(v));
  }
  const std::vector<std::array<std::uint32_t, 3>> settled = settle_polygon(points);
  return std::ranges::find(settled, std::array<std::uint32_t, 3>{0, 1, 2}) != settled.end();
}

LevelSurface SurfaceSimplifier::surface() const {
  LevelSurface out;
  for (std::uint32_t v = 0; v < star_.size(); ++v) {
    if (is_gone_[v] != 0) continue;
    out.vertices.push_back(v);
  }
  for (const Triangle& t : triangles_)
    if (t.is_alive) out.triangles.push_back(t.surface);
  for (const Edge& e : edges_)
    if (e.is_alive) out.edges.push_back(e.curve);
  return out;
}

double SurfaceSimplifier::volume_change() const {
  double largest = 0;
  for (std::size_t r = 0; r < region_change_.size(); ++r)
    largest = std::max(largest, std::abs(region_change_[r]) / fine_->region_volume[r]);
  return largest;
}

}  // namespace voropack
