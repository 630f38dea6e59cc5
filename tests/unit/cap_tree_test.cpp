// The least of many caps, as found by looking at all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "base/random.h"
#include "spacing/cap_tree.h"

namespace voropack {
namespace {

template <int D>
void test_against_all() {
  constexpr double kSlope = 0.25;
  Random random(D);
  const auto point = [&] {
    Vec<D> x;
    for (int k = 0; k < D; ++k) x[k] = random.unit();
    return x;
  };
  // Many in a small place, as at the tip of an angle, and some anywhere.
  std::vector<SpacingCap<D>> caps;
  for (int i = 0; i < 1000; ++i) {
    const bool is_near = i % 4 != 0;
    const double size = is_near ? 0.01 : 1, unit = random.unit();
    caps.push_back({size * point(), i % 3 == 0 ? 0.05 * size * unit : 0, 0.01 * size * (1 + random.unit())});
  }
  const Vec<D> apex = point();
  const auto base = [&](const Vec<D>& x) { return 0.005 + kSlope * distance(x, apex); };
  const CapTree<D> tree(Box<D>(Vec<D>{},
                               [] {
                                 Vec<D> one;
                                 for (int k = 0; k < D; ++k) one[k] = 1;
                                 return one;
                               }()),
                        caps, kSlope);
  std::vector<Vec<D>> places;
  for (int i = 0; i < 4000; ++i) places.push_back((i % 2 == 0 ? 0.02 : 1.0) * point());
  std::vector<double> found(places.size());
  parallel_for(places.size(), [&](std::size_t i) { found[i] = tree.minimum(places[i], base(places[i]), base); });
  for (std::size_t i = 0; i < places.size(); ++i) {
    double least = base(places[i]);
    for (const SpacingCap<D>& cap : caps)
      least = std::min(least, cap.value + kSlope * std::max(0.0, distance(places[i], cap.center) - cap.radius));
    EXPECT_EQ(found[i], least);
  }
}
TEST(CapTree, FindsTheLeast) {
  test_against_all<2>();
  test_against_all<3>();
}

}  // namespace
}  // namespace voropack
