// Laws of the conflict graph over random inputs (RapidCheck).
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <numeric>

#include "base/random.h"
#include "spheres/independent_set.h"
#include "spheres/pack_interior.h"

namespace voropack {
namespace {

constexpr double kLipschitz = 0.2;

template <int K>
struct Input {
  std::vector<Ball<K>> balls;
  std::vector<std::uint64_t> priority;
};

/// Points on a coarse grid, so that conflicts, touching spheres and ties of the priority are common.
template <int K>
Input<K> any_input() {
  const auto cells = *rc::gen::container<std::vector<std::vector<int>>>(
      rc::gen::container<std::vector<int>>(K + 1, rc::gen::inRange(0, 24)));
  const double base = *rc::gen::element(0.5, 1.0, 2.0);
  Input<K> input;
  for (const auto& c : cells) {
    Ball<K> ball;
    for (int k = 0; k < K; ++k) ball.center[k] = c[static_cast<std::size_t>(k)];
    ball.radius = base + kLipschitz * norm(ball.center);
    input.balls.push_back(ball);
    input.priority.push_back(static_cast<std::uint64_t>(c[K] / 4));
  }
  return input;
}

template <int K>
std::vector<std::uint8_t> sequential(const Input<K>& input) {
  std::vector<std::size_t> order(input.balls.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return input.priority[a] < input.priority[b]; });
  std::vector<std::uint8_t> joins(order.size(), 0);
  for (const std::size_t i : order) {
    bool free = true;
    for (std::size_t j = 0; j < order.size(); ++j)
      free = free &&
             (joins[j] == 0 || !SphereSet<K>::overlap(input.balls[j], input.balls[i].center, input.balls[i].radius));
    joins[i] = free ? 1 : 0;
  }
  return joins;
}

RC_GTEST_PROP(IndependentSet, IsThatOfTheSequentialPassInThePlane, ()) {
  const Input<2> input = any_input<2>();
  RC_ASSERT(independent_set(input.balls, input.priority, kLipschitz) == sequential(input));
}

RC_GTEST_PROP(IndependentSet, IsThatOfTheSequentialPassInSpace, ()) {
  const Input<3> input = any_input<3>();
  RC_ASSERT(independent_set(input.balls, input.priority, kLipschitz) == sequential(input));
}

/// Many candidates are taken in batches by priority; half of the priorities are equal, so that a batch ends among ties.
TEST(IndependentSet, IsThatOfTheSequentialPassInBatches) {
  Input<3> input;
  Random random(7);
  for (int i = 0; i < 9000; ++i) {
    Ball<3> ball;
    for (int k = 0; k < 3; ++k) ball.center[k] = 20 * random.unit();
    ball.radius = 0.3 + 0.02 * norm(ball.center);
    input.balls.push_back(ball);
    input.priority.push_back(i % 2 == 0 ? 1000 : random.bits() % 2000);
  }
  const std::vector<std::uint8_t> joins = sequential(input);
  EXPECT_GT(std::count(joins.begin(), joins.end(), 1), 1000);
  EXPECT_EQ(independent_set(input.balls, input.priority, kLipschitz), joins);
}

/// On a segment of any length with any linear spacing: neighbors keep f + f, and nothing fits in between. A gap of the
/// measure ds / (2 f) is below 2, so its middle is blocked but for what f varies within it.
RC_GTEST_PROP(Equidistribute, PacksASegmentMaximally, ()) {
  const double f0 = *rc::gen::inRange(1, 200) * 0.01;
  const double slope = *rc::gen::inRange(-10, 11) * 0.02;
  const double length = *rc::gen::inRange(1, 3000) * 0.01;
  const double least = 0.005;
  const LocalSpacing<1> f{[=](const Vec<1>& x) { return std::max(least, f0 + slope * x[0]); },
                          [](const Box<1>&) { return std::optional<double>(); }, 0.2};
  std::vector<double> at = {0};
  for (const double x : equidistribute(length, f)) at.push_back(x);
  at.push_back(length);
  const bool ends_fit = length >= f.at({0}) + f.at({length});
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    const double sum = f.at({at[i]}) + f.at({at[i + 1]});
    if (at.size() > 2 || ends_fit) RC_ASSERT(at[i + 1] - at[i] >= sum * (1 - 1e-11));
  }
  // Not one of the places could be had twice: a packing with twice the gaps would leave room.
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    const double x = 0.5 * (at[i] + at[i + 1]), fx = f.at({x});
    RC_ASSERT(x - at[i] < (fx + f.at({at[i]})) * (1 + 1e-9) || at[i + 1] - x < (fx + f.at({at[i + 1]})) * (1 + 1e-9));
  }
}

}  // namespace
}  // namespace voropack
