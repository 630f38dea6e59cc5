#include "spheres/region_labels.h"

#include <algorithm>
#include <unordered_map>

#include "base/random.h"
#include "geom/predicates.h"

namespace voropack {

namespace {

constexpr int kUnlabeled = -2;

template <int K>
using Face = std::array<std::uint32_t, K>;

template <int K>
struct FaceHash {
  std::size_t operator()(const Face<K>& f) const {
    std::uint64_t h = 0;
    for (const std::uint32_t v : f) h = mix64(h ^ v);
    return h;
  }
};

/// Sorts the corners; true if the permutation is odd.
template <int K>
bool sort_corners(Face<K>& f) {
  bool odd = false;
  for (std::size_t i = 0; i + 1 < K; ++i)
    for (std::size_t j = 0; j + 1 < K - i; ++j)
      if (f[j] > f[j + 1]) {
        std::swap(f[j], f[j + 1]);
        odd = !odd;
      }
  return odd;
}

/// The face opposite to corner i of a positively oriented simplex, in an order such that its side 0 (see Walls) is the
/// simplex's side.
template <int K>
Face<K> inward_face(const std::array<std::uint32_t, K + 1>& corners, std::size_t i) {
  Face<K> f;
  std::size_t n = 0;
  for (std::size_t j = 0; j <= K; ++j)
    if (j != i) f[n++] = corners[j];
  // (0,1,2) positive: 2 is to the left of 0 -> 1. (0,1,2,3) positive: 3 is on the side of (1-0) x (2-0). Each step back
  // in i is a swap.
  const bool flip = (K - i) % 2 == 1;
  if (flip) std::swap(f[0], f[1]);
  return f;
}

}  // namespace

template <int K>
RegionLabels<K> label_regions(const DelaunayKernel<K>& kernel, const std::vector<ProtectedFace<K>>& faces) {
  struct Entry {
    std::uint32_t face;
    bool odd;
    int seen = 0;
  };
  std::unordered_map<Face<K>, Entry, FaceHash<K>> index;
  index.reserve(faces.size());
  std::uint32_t last_fixed = 0;
  for (std::uint32_t i = 0; i < faces.size(); ++i) {
    Face<K> key = faces[i].corners;
    const bool odd = sort_corners<K>(key);
    index.emplace(key, Entry{i, odd});
    last_fixed = std::max(last_fixed, key.back());
  }

  RegionLabels<K> labels;
  const std::uint32_t n = kernel.n_slots();
  labels.region.assign(n, kUnlabeled);
  std::vector<std::uint8_t> closed(n, 0);  // Bit i: the face opposite to corner i is protected.
  std::vector<std::uint32_t> stack;
  std::vector<std::pair<std::uint32_t, int>> seeds;
  for (std::uint32_t slot = 0; slot < n; ++slot) {
    if (!kernel.is_alive(slot)) {
      labels.region[slot] = Walls<K>::kOutside;
      continue;
    }
    if (faces.empty()) {
      labels.region[slot] = kernel.is_finite(slot) ? 0 : Walls<K>::kOutside;
      continue;
    }
    const auto corners = kernel.corners(slot);
    const bool finite = kernel.is_finite(slot);
    if (!finite) seeds.push_back({slot, Walls<K>::kOutside});
    for (std::size_t i = 0; i <= K; ++i) {
      bool fixed = true;
      for (std::size_t j = 0; j <= K; ++j) fixed = fixed && (j == i || corners[j] <= last_fixed);
      if (!fixed) continue;
      Face<K> f = inward_face<K>(corners, i);
      const bool odd = sort_corners<K>(f);
      const auto it = index.find(f);
      if (it == index.end()) continue;
      closed[slot] = static_cast<std::uint8_t>(closed[slot] | (1U << i));
      ++it->second.seen;
      if (finite) seeds.push_back({slot, faces[it->second.face].regions[odd == it->second.odd ? 0 : 1]});
    }
  }
  for (const auto& [key, entry] : index)
    if (entry.seen != 2) labels.missing_faces.push_back(entry.face);
  std::sort(labels.missing_faces.begin(), labels.missing_faces.end());
  if (!labels.missing_faces.empty()) return labels;

  for (const auto& [seed, region] : seeds) {
    if (labels.region[seed] != kUnlabeled) continue;
    labels.region[seed] = region;
    stack.assign(1, seed);
    while (!stack.empty()) {
      const std::uint32_t slot = stack.back();
      stack.pop_back();
      const auto neighbors = kernel.neighbors(slot);
      for (std::size_t i = 0; i <= K; ++i) {
        if ((closed[slot] >> i & 1U) != 0 || labels.region[neighbors[i]] != kUnlabeled) continue;
        labels.region[neighbors[i]] = region;
        stack.push_back(neighbors[i]);
      }
    }
  }
  for (const auto& [seed, region] : seeds) {
    if (labels.region[seed] == region) continue;
    const auto corners = kernel.corners(seed);
    for (std::size_t i = 0; i <= K; ++i) {
      if ((closed[seed] >> i & 1U) == 0) continue;
      Face<K> f = inward_face<K>(corners, i);
      sort_corners<K>(f);
      labels.leaking_faces.push_back(index.at(f).face);
    }
  }
  return labels;
}

template <int K>
Triangulation<K> export_triangulation(const DelaunayKernel<K>& kernel, const std::vector<int>& region) {
  constexpr std::uint32_t kNone = Triangulation<K>::kNoNeighbor;
  const std::uint32_t n = kernel.n_slots();
  std::vector<std::uint32_t> index(n, kNone);
  std::uint32_t count = 0;
  for (std::uint32_t slot = 0; slot < n; ++slot)
    if (kernel.is_finite(slot) && region[slot] >= 0) index[slot] = count++;
  Triangulation<K> t;
  t.simplices.resize(count);
  t.neighbors.resize(count);
  t.regions.resize(count);
  for (std::uint32_t slot = 0; slot < n; ++slot) {
    const std::uint32_t s = index[slot];
    if (s == kNone) continue;
    t.simplices[s] = kernel.corners(slot);
    t.regions[s] = region[slot];
    const auto neighbors = kernel.neighbors(slot);
    for (std::size_t i = 0; i <= K; ++i) t.neighbors[s][i] = index[neighbors[i]];
  }
  return t;
}

template RegionLabels<2> label_regions(const DelaunayKernel<2>&, const std::vector<ProtectedFace<2>>&);
template RegionLabels<3> label_regions(const DelaunayKernel<3>&, const std::vector<ProtectedFace<3>>&);

template Triangulation<2> export_triangulation(const DelaunayKernel<2>&, const std::vector<int>&);
template Triangulation<3> export_triangulation(const DelaunayKernel<3>&, const std::vector<int>&);

}  // namespace voropack
