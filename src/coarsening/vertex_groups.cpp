#include "coarsening/vertex_groups.h"

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "geom/tolerance.h"

namespace voropack {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <std::size_t N>
void set_lane(std::array<Lanes, N>& lanes, std::size_t i, double x) {
  lanes[i / Lanes::kSize].set(i % Lanes::kSize, x);
}

/// Bit i tells what `test` says of lane i, for n_pairs pairs of lanes.
template <class Test>
unsigned bits_of(std::size_t n_pairs, const Test& test) {
  Lanes::Bits bits{};
  for (std::size_t k = 0; k < n_pairs; ++k) {
    const std::int64_t first = std::int64_t{1} << (Lanes::kSize * k);
    bits |= test(k).bits & Lanes::Bits{first, 2 * first};
  }
  return static_cast<unsigned>(bits[0] | bits[1]);
}

/// A box around `box` with all places less than `by` away from it, whatever is rounded.
template <int D>
Box<D> inflated(Box<D> box, double by) {
  if (box.empty()) return box;
  double size = by;
  for (int axis = 0; axis < D; ++axis) size = std::max({size, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
  box.inflate(by + size * 4 * std::numeric_limits<double>::epsilon());
  return box;
}

}  // namespace

template <int D>
VertexGroups<D>::VertexGroups(std::vector<VertexId> along_curve, const IdVector<VertexId, Vec<D>>& points)
    : vertices(std::move(along_curve)) {
  const std::size_t n = (vertices.size() + kSize - 1) / kSize;
  coordinates.resize(n);
  balls.resize(n);
  boxes.resize(n);
  parallel_for(n, [&](std::size_t g) {
    const auto row = members(g);
    for (std::size_t i = 0; i < kSize; ++i) {
      const Vec<D>& x = points[row[std::min(i, row.size() - 1)]];
      boxes[g].add(x);
      for (int axis = 0; axis < D; ++axis) set_lane(coordinates[g][static_cast<std::size_t>(axis)], i, x[axis]);
    }
    balls[g] = {boxes[g].center(), 0.5 * boxes[g].diagonal()};
  });
  for (std::size_t begin = 0, end = n; end - begin > 1; begin = std::exchange(end, boxes.size()))
    for (std::size_t first = begin; first < end; first += kChildren) {
      Box<D> box;
      for (std::size_t k = first; k < std::min(first + kChildren, end); ++k) box.add(boxes[k]);
      boxes.push_back(box);
    }
}

template <int D>
Vacancies<D>::Vacancies(const VertexGroups<D>& groups, const IdVector<VertexId, double>& f)
    : groups_(groups), radii_(groups.size()), gone_(groups.size(), 0) {
  std::vector<double> most(groups.boxes.size());
  parallel_for(groups.size(), [&](std::size_t g) {
    const auto row = groups.members(g);
    for (std::size_t i = 0; i < row.size(); ++i) {
      set_lane(radii_[g], i, f[row[i]]);
      most[g] = std::max(most[g], f[row[i]]);
    }
    gone_[g] = static_cast<std::uint16_t>(~0U << row.size());
  });
  for (std::size_t begin = 0, n = groups.size(); n > 0;) {
    layers_.push_back(nodes_.size());
    const std::size_t end = begin + n, n_above = n > 1 ? (n + kChildren - 1) / kChildren : 0;
    for (std::size_t first = begin; first < end; first += kChildren) {
      Node node;
      double most_of_all = 0;
      for (std::size_t k = 0; k < kChildren; ++k) {
        const bool is_there = first + k < end;
        const Box<D> box = is_there ? inflated(groups.boxes[first + k], most[first + k]) : Box<D>();
        if (is_there) most_of_all = std::max(most_of_all, most[first + k]);
        for (std::size_t axis = 0; axis < kAxes; ++axis) {
          set_lane(node.lo[axis], k, box.lo[static_cast<int>(axis)]);
          set_lane(node.hi[axis], k, box.hi[static_cast<int>(axis)]);
        }
      }
      nodes_.push_back(node);
      if (n_above > 0) most[end + (first - begin) / kChildren] = most_of_all;
    }
    begin = end;
    n = n_above > 1 ? n_above : 0;
  }
  is_empty_.resize(nodes_.size(), 0);
}

template <int D>
Ball<D> Vacancies<D>::sphere(std::uint32_t number) const {
  const std::size_t group = number / kSize, pair = number % kSize / Lanes::kSize, lane = number % Lanes::kSize;
  Ball<D> ball{{}, radii_[group][pair][lane]};
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    ball.center[static_cast<int>(axis)] = groups_.coordinates[group][axis][pair][lane];
  return ball;
}

template <int D>
void Vacancies<D>::take_sphere(const Ball<D>& sphere) {
  take(sphere, [&](std::size_t g, const auto& distance_sq) {  // As SphereSet::overlap.
    return bits_of(kSize / Lanes::kSize, [&](std::size_t k) {
      const Lanes sum = (Lanes(sphere.radius) + radii_[g][k]) * Lanes(1 - kPackingSlack);
      return distance_sq(k) < sum * sum;
    });
  });
}

template <int D>
void Vacancies<D>::take_ball(const Ball<D>& ball) {
  // That of a flat simplex is not finite, and holds nothing.
  if (!(ball.radius > 0 && std::isfinite(ball.radius) && is_finite(ball.center))) return;
  const Lanes above = std::nextafter(ball.radius * ball.radius * (1 + kBallMargin), kInfinity);
  take({ball.center, ball.radius * (1 + kBallMargin)}, [&](std::size_t, const auto& distance_sq) {
    return bits_of(kSize / Lanes::kSize,
                   [&](std::size_t k) { return distance_sq(k) < above; });  // As BallSet::forbids.
  });
}

/// test(group, distance_sq) has the bits of the vertices that go; distance_sq(k) is how far pair k is from the center.
template <int D>
template <class Test>
void Vacancies<D>::take_below(std::size_t layer, std::size_t node, const Ball<D>& ball, const Test& test) {
  constexpr unsigned kAllVertices = (1U << kSize) - 1, kAllChildren = (1U << kChildren) - 1;
  const std::size_t at = layers_[layer] + node;
  unsigned hit = bits_of(kChildren / Lanes::kSize, [&](std::size_t k) {
    const Node& boxes = nodes_[at];
    const auto meets = [&](std::size_t axis) {
      const double x = ball.center[static_cast<int>(axis)];
      return (boxes.lo[axis][k] < Lanes(x + ball.radius)) & (boxes.hi[axis][k] > Lanes(x - ball.radius));
    };
    Lanes::Mask mask = meets(0);
    for (std::size_t axis = 1; axis < kAxes; ++axis) mask = mask & meets(axis);
    return mask;
  });
  for (hit &= ~unsigned{is_empty_[at]}; hit != 0; hit &= hit - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(hit));
    const std::size_t child = node * kChildren + k;
    bool is_empty = false;
    if (layer == 0) {
      const auto distance_sq = [&](std::size_t pair) {
        Lanes sum = 0.0;
        for (std::size_t axis = 0; axis < kAxes; ++axis)
          sum = sum + square(Lanes(ball.center[static_cast<int>(axis)]) - groups_.coordinates[child][axis][pair]);
        return sum;
      };
      gone_[child] = static_cast<std::uint16_t>(gone_[child] | test(child, distance_sq));
      is_empty = gone_[child] == kAllVertices;
    } else {
      take_below(layer - 1, child, ball, test);
      is_empty = is_empty_[layers_[layer - 1] + child] == kAllChildren;
    }
    if (is_empty) is_empty_[at] = static_cast<std::uint8_t>(is_empty_[at] | 1U << k);
  }
}

template struct VertexGroups<2>;
template struct VertexGroups<3>;
template class Vacancies<2>;
template class Vacancies<3>;

}  // namespace voropack
