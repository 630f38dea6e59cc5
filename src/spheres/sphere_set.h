// A growing set of f-spheres with fast conflict queries, and a set of protecting balls with fast point queries.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "geom/tolerance.h"
#include "spheres/block_grid.h"
#include "voropack/vec.h"

namespace voropack {

/// A ball by center and radius.
template <int K>
struct Ball {
  Vec<K> center;
  double radius = 0;
};

/// Spheres whose radii are values of one Lipschitz function. Kept in one grid per octave of the radius.
template <int K>
class SphereSet {
 public:
  /// `lipschitz` bounds how fast radii vary: it limits the search. `unit` is a typical radius, `origin` a point near.
  SphereSet(const Vec<K>& origin, double lipschitz, double unit)
      : origin_(origin), ratio_((1 + lipschitz) / (1 - lipschitz)), unit_(unit * (1 - 1e-6)) {}

  [[nodiscard]] std::size_t size() const { return spheres_.size(); }
  [[nodiscard]] const Ball<K>& operator[](std::size_t i) const { return spheres_[i]; }
  [[nodiscard]] const std::vector<Ball<K>>& spheres() const { return spheres_; }

  void add(const Ball<K>& sphere) {
    const auto id = static_cast<std::uint32_t>(spheres_.size());
    spheres_.push_back(sphere);
    Level& level = level_of(sphere.radius);
    level.smallest = std::min(level.smallest, sphere.radius);
    level.largest = std::max(level.largest, sphere.radius);
    std::uint32_t& head = level.grid.head(level.grid.index(sphere.center));
    next_.push_back(head);
    head = id;
  }

  /// Calls visit(id) for every sphere that an f-sphere (x, radius) could conflict with, until visit returns true.
  template <class Visit>
  bool visit_near(const Vec<K>& x, double radius, Visit&& visit) const {
    const double least = radius / ratio_, most = radius * ratio_;
    for (const Level& level : levels_) {
      if (level.largest < least || level.smallest > most) continue;
      Box<K> box(x, x);
      box.inflate(radius + std::min(level.largest, most));
      const bool stopped = level.grid.visit(box, [&](std::uint32_t id) {
        for (; id != BlockGrid<K>::kEnd; id = next_[id])
          if (visit(id)) return true;
        return false;
      });
      if (stopped) return true;
    }
    return false;
  }

  /// True if the f-sphere (x, radius) overlaps a sphere of the set.
  [[nodiscard]] bool conflicts(const Vec<K>& x, double radius) const {
    std::uint32_t hint = 0;
    return conflicts(x, radius, hint);
  }
  /// The same for one sphere after the other: `hint`, 0 at first, is a sphere that may well overlap this one, too.
  [[nodiscard]] bool conflicts(const Vec<K>& x, double radius, std::uint32_t& hint) const {
    if (hint < spheres_.size() && overlap(spheres_[hint], x, radius)) return true;
    const auto hit = [&](std::uint32_t id) {
      if (!overlap(spheres_[id], x, radius)) return false;
      hint = id;
      return true;
    };
    // Mostly a sphere in the cell of x itself answers.
    for (const Level& level : levels_)
      for (std::uint32_t id = level.grid.find(x); id != BlockGrid<K>::kEnd; id = next_[id])
        if (hit(id)) return true;
    return visit_near(x, radius, hit);
  }

  /// True if one sphere q of the set leaves no room in the ball (m, r), for every f with f(m) and the Lipschitz
  /// constant given: |m - q| + (1 + b) r < f(q) + f(m).
  [[nodiscard]] bool covers(const Vec<K>& m, double r, double f_m, double lipschitz) const {
    return visit_near(m, f_m, [&](std::uint32_t id) {
      const Ball<K>& q = spheres_[id];
      const double reach = q.radius + f_m - (1 + lipschitz) * r;
      return reach > 0 && distance_sq(m, q.center) < reach * reach;
    });
  }

  static bool overlap(const Ball<K>& q, const Vec<K>& x, double radius) {
    const double sum = (q.radius + radius) * (1 - kPackingSlack);
    return distance_sq(q.center, x) < sum * sum;
  }

 private:
  /// The spheres with begin <= radius < 2 * begin, where begin is the unit times a power of two.
  struct Level {
    double begin;
    BlockGrid<K> grid;
    double smallest, largest;
  };
  Level& level_of(double radius) {
    for (Level& level : levels_)
      if (level.begin <= radius && radius < 2 * level.begin) return level;
    double begin = std::ldexp(unit_, std::ilogb(radius / unit_));
    if (begin > radius) begin /= 2;  // The quotient was rounded up to a power of two.
    levels_.push_back({begin, BlockGrid<K>(origin_, 2 * begin), radius, radius});
    return levels_.back();
  }

  Vec<K> origin_;
  double ratio_, unit_;
  std::vector<Ball<K>> spheres_;
  std::vector<std::uint32_t> next_;
  std::vector<Level> levels_;
};

/// Balls that no new center may enter.
template <int K>
class BallSet {
 public:
  explicit BallSet(const Vec<K>& origin) : origin_(origin) {}

  /// That of a flat simplex is not finite, and holds nothing.
  void add(const Ball<K>& ball) {
    const auto id = static_cast<std::uint32_t>(balls_.size());
    balls_.push_back(ball);
    if (!(ball.radius > 0 && std::isfinite(ball.radius) && is_finite(ball.center))) return;
    const int exponent = std::ilogb(ball.radius);
    auto it = levels_.find(exponent);
    if (it == levels_.end()) it = levels_.emplace(exponent, BlockGrid<K>(origin_, std::ldexp(2.0, exponent))).first;
    BlockGrid<K>& grid = it->second;
    Box<K> box(ball.center, ball.center);
    box.inflate(ball.radius * (1 + 1e-9));
    const auto lo = grid.index(box.lo), hi = grid.index(box.hi);
    auto cell = lo;
    for (;;) {
      std::uint32_t& head = grid.head(cell);
      links_.push_back({id, head});
      head = static_cast<std::uint32_t>(links_.size() - 1);
      std::size_t k = 0;
      while (k < K && ++cell[k] > hi[k]) {
        cell[k] = lo[k];
        ++k;
      }
      if (k == K) break;
    }
  }

  [[nodiscard]] std::size_t size() const { return balls_.size(); }
  [[nodiscard]] const Ball<K>& operator[](std::size_t i) const { return balls_[i]; }

  /// Calls visit(id) for every ball that holds x in its interior or within `margin` * R^2 of power, until visit returns
  /// true.
  template <class Visit>
  bool visit_holding(const Vec<K>& x, double margin, Visit&& visit) const {
    for (const auto& [exponent, grid] : levels_) {
      for (std::uint32_t link = grid.find(x); link != BlockGrid<K>::kEnd; link = links_[link].next) {
        const Ball<K>& ball = balls_[links_[link].ball];
        if (distance_sq(x, ball.center) <= ball.radius * ball.radius * (1 + margin) && visit(links_[link].ball))
          return true;
      }
    }
    return false;
  }
  /// True if x may not be a center: it lies in a ball or too near to one.
  [[nodiscard]] bool forbids(const Vec<K>& x) const {
    return visit_holding(x, kBallMargin, [](std::uint32_t) { return true; });
  }
  /// True if the ball (m, r) lies wholly in one forbidden ball.
  [[nodiscard]] bool covers(const Vec<K>& m, double r) const {
    return visit_holding(m, 0.0, [&](std::uint32_t id) {
      const double room = balls_[id].radius - r;
      return room > 0 && distance_sq(m, balls_[id].center) < room * room;
    });
  }

 private:
  struct Link {
    std::uint32_t ball, next;
  };
  Vec<K> origin_;
  std::vector<Ball<K>> balls_;
  std::vector<Link> links_;
  std::map<int, BlockGrid<K>> levels_;  ///< By the exponent of the radius.
};

}  // namespace voropack
