// Space cut into boxes by planes across the axes, each part with a given share of a sample of points.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "voropack/vec.h"

namespace voropack {

/// A k-d tree of `levels` levels without points: 2^levels parts, numbered from 0. Every box is cut across the longest
/// side of the bounding box of its sample, and `fraction` of the sample comes before the cut. A plane that holds many
/// points of the sample makes the shares less even.
template <int K>
class BoxPartition {
 public:
  static constexpr unsigned kMaxLevels = 8;  ///< So that a byte holds the number of a part.

  BoxPartition(std::vector<Vec<K>> sample, unsigned levels, double fraction) {
    cuts_.resize(std::size_t{1} << levels);
    cut(sample, 1, fraction);
  }

  [[nodiscard]] std::size_t n_parts() const { return cuts_.size(); }

  struct Place {
    std::uint8_t part;
    double depth;  ///< The least distance from the planes that bound the part.
  };

  [[nodiscard]] Place place_of(const Vec<K>& x) const {
    double depth = std::numeric_limits<double>::infinity();
    std::size_t node = 1;
    while (node < cuts_.size()) {
      const double beyond = x[cuts_[node].axis] - cuts_[node].at;
      depth = std::min(depth, std::abs(beyond));
      node = 2 * node + (beyond < 0 ? 0 : 1);
    }
    return {static_cast<std::uint8_t>(node - cuts_.size()), depth};
  }

 private:
  struct Cut {
    int axis = 0;
    double at = 0;
  };

  /// `node` is 1 for the whole; its halves are 2 node and 2 node + 1.
  void cut(std::span<Vec<K>> sample, std::size_t node, double fraction) {
    if (node >= cuts_.size() || sample.empty()) return;
    Box<K> box;
    for (const Vec<K>& x : sample) box.add(x);
    int axis = 0;
    for (int k = 1; k < K; ++k)
      if (box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis]) axis = k;
    const auto rank = static_cast<std::size_t>(fraction * static_cast<double>(sample.size()));
    const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(sample.begin(), middle, sample.end(),
                     [axis](const Vec<K>& a, const Vec<K>& b) { return a[axis] < b[axis]; });
    cuts_[node] = {axis, (*middle)[axis]};
    cut(sample.first(rank), 2 * node, fraction);
    cut(sample.subspan(rank), 2 * node + 1, fraction);
  }

  std::vector<Cut> cuts_;  ///< [2^levels] By node; entry 0 is not used.
};

}  // namespace voropack
