// Values that are remembered: always the function's own, and computed once as long as there is room.
#include "spacing/value_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>

#include "base/parallel.h"
#include "base/random.h"

namespace voropack {
namespace {

double value_at(const Vec<3>& x) { return 1 + norm_sq(x); }

TEST(ValueMemory, ComputesEachPlaceOnce) {
  const auto memory = std::make_unique<ValueMemory<3>>();
  constexpr int n = 20000;
  int n_computed = 0;
  for (int round = 0; round < 3; ++round) {
    Random random(1);
    for (int i = 0; i < n; ++i) {
      const Vec<3> x{random.unit(), random.unit(), -random.unit()};
      EXPECT_EQ(memory->get(x, [&] { return ++n_computed, value_at(x); }), value_at(x));
    }
  }
  EXPECT_GE(n_computed, n);
  EXPECT_LT(n_computed, n + n / 10) << "few places share all of their slots";
}

TEST(ValueMemory, TellsNeighborsApart) {
  ValueMemory<2> memory;
  const double next = std::nextafter(1.0, 2.0);
  EXPECT_EQ(memory.get({1.0, 0.0}, [] { return 3.0; }), 3);
  EXPECT_EQ(memory.get({next, 0.0}, [] { return 4.0; }), 4);
  EXPECT_EQ(memory.get({1.0, 0.0}, [] { return 5.0; }), 3);
  EXPECT_EQ(memory.get({next, 0.0}, [] { return 5.0; }), 4);
}

TEST(ValueMemory, AnswersRightWhenItIsFullAndSharedByThreads) {
  const auto memory = std::make_unique<ValueMemory<3>>();
  std::atomic<int> n_wrong = 0;
  for (int round = 0; round < 2; ++round)
    parallel_for(3'000'000, [&](std::size_t i) {
      const Vec<3> x{static_cast<double>(i % 1000), static_cast<double>(i / 1000), static_cast<double>(i % 7)};
      if (memory->get(x, [&] { return value_at(x); }) != value_at(x)) ++n_wrong;
    });
  EXPECT_EQ(n_wrong, 0);
}

}  // namespace
}  // namespace voropack
