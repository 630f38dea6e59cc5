#include "spheres/region_labels.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <unordered_map>

#include "base/disjoint_sets.h"
#include "base/parallel.h"
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

/// Slots per task. What the tasks find is put together in their order.
constexpr std::size_t kBlock = 1U << 14U;

template <int K>
class Labeler {
 public:
  Labeler(const DelaunayKernel<K>& kernel, const std::vector<ProtectedFace<K>>& faces)
      : kernel_(kernel), faces_(faces), closed_(kernel.n_slots(), 0) {
    index_.reserve(faces.size());
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
      Face<K> key = faces[i].corners;
      const bool odd = sort_corners<K>(key);
      index_.emplace(key, Entry{i, odd});
      last_fixed_ = std::max(last_fixed_, key.back());
    }
  }

  RegionLabels<K> run() {
    RegionLabels<K> labels;
    labels.region.assign(closed_.size(), kUnlabeled);
    find_seeds();
    labels.missing_faces = missing_faces();
    if (!labels.missing_faces.empty()) return labels;
    flood(labels.region);
    labels.leaking_faces = leaking_faces(labels.region);
    return labels;
  }

 private:
  struct Entry {
    std::uint32_t face;
    bool odd;
  };

  /// A simplex whose region is known.
  struct Seed {
    std::uint32_t slot;
    int region;
  };

  struct Found {
    std::vector<Seed> seeds;
    std::vector<std::uint32_t> faces;  ///< Protected faces that were met.
  };

  /// Marks the closed faces of all simplices. Seeds are the simplices at these and at infinity.
  void find_seeds() {
    found_.resize((closed_.size() + kBlock - 1) / kBlock);
    parallel_for(
        found_.size(),
        [&](std::size_t block) {
          const std::size_t end = std::min(closed_.size(), (block + 1) * kBlock);
          for (std::size_t slot = block * kBlock; slot < end; ++slot)
            if (kernel_.is_alive(static_cast<std::uint32_t>(slot)))
              look_at(static_cast<std::uint32_t>(slot), found_[block]);
        },
        1);
  }

  void look_at(std::uint32_t slot, Found& found) {
    const auto corners = kernel_.corners(slot);
    const bool finite = kernel_.is_finite(slot);
    if (!finite) found.seeds.push_back({slot, Walls<K>::kOutside});
    for (std::size_t i = 0; i <= K; ++i) {
      bool fixed = true;
      for (std::size_t j = 0; j <= K; ++j) fixed = fixed && (j == i || corners[j] <= last_fixed_);
      if (!fixed) continue;
      Face<K> f = inward_face<K>(corners, i);
      const bool odd = sort_corners<K>(f);
      const auto it = index_.find(f);
      if (it == index_.end()) continue;
      closed_[slot] = static_cast<std::uint8_t>(closed_[slot] | (1U << i));
      found.faces.push_back(it->second.face);
      if (finite) found.seeds.push_back({slot, faces_[it->second.face].regions[odd == it->second.odd ? 0 : 1]});
    }
  }

  /// Faces that were not met from both sides.
  [[nodiscard]] std::vector<std::uint32_t> missing_faces() const {
    std::vector<std::uint8_t> seen(faces_.size(), 0);
    for (const Found& found : found_)
      for (const std::uint32_t face : found.faces) ++seen[face];
    std::vector<std::uint32_t> missing;
    for (const auto& [key, entry] : index_)
      if (seen[entry.face] != 2) missing.push_back(entry.face);
    std::sort(missing.begin(), missing.end());
    return missing;
  }

  /// Simplices that are joined by faces that are not closed get the region of their first seed.
  void flood(std::vector<int>& region) const {
    DisjointSets sets(region.size());
    parallel_for(region.size(), [&](std::size_t i) {
      const auto slot = static_cast<std::uint32_t>(i);
      if (!kernel_.is_alive(slot)) return;
      const auto neighbors = kernel_.neighbors(slot);
      for (std::size_t k = 0; k <= K; ++k)
        if ((closed_[slot] >> k & 1U) == 0 && neighbors[k] < slot) sets.join(slot, neighbors[k]);
    });
    for (const Found& found : found_)
      for (const Seed& seed : found.seeds)
        if (int& r = region[sets.find(seed.slot)]; r == kUnlabeled) r = seed.region;
    // The root of a set is its smallest slot, so the blocks that read a root may not be done with it yet: they do not
    // change it.
    parallel_for(region.size(), [&](std::size_t i) {
      const auto slot = static_cast<std::uint32_t>(i);
      if (const std::uint32_t root = sets.find(slot); root != slot)
        region[slot] = region[root];
      else if (!kernel_.is_alive(slot))
        region[slot] = Walls<K>::kOutside;
    });
  }

  /// Faces of the seeds that a flood with another region has reached.
  [[nodiscard]] std::vector<std::uint32_t> leaking_faces(const std::vector<int>& region) const {
    std::vector<std::uint32_t> leaking;
    for (const Found& found : found_)
      for (const Seed& seed : found.seeds) {
        if (region[seed.slot] == seed.region) continue;
        const auto corners = kernel_.corners(seed.slot);
        for (std::size_t i = 0; i <= K; ++i) {
          if ((closed_[seed.slot] >> i & 1U) == 0) continue;
          Face<K> f = inward_face<K>(corners, i);
          sort_corners<K>(f);
          leaking.push_back(index_.at(f).face);
        }
      }
    return leaking;
  }

  const DelaunayKernel<K>& kernel_;
  const std::vector<ProtectedFace<K>>& faces_;
  std::unordered_map<Face<K>, Entry, FaceHash<K>> index_;
  std::uint32_t last_fixed_ = 0;
  std::vector<std::uint8_t> closed_;  ///< By slot. Bit i: the face opposite to corner i is protected.
  std::vector<Found> found_;          ///< By block of slots.
};

}  // namespace

template <int K>
RegionLabels<K> label_regions(const DelaunayKernel<K>& kernel, const std::vector<ProtectedFace<K>>& faces) {
  if (!faces.empty()) return Labeler<K>(kernel, faces).run();
  RegionLabels<K> labels;
  labels.region.resize(kernel.n_slots());
  parallel_for(labels.region.size(), [&](std::size_t slot) {
    labels.region[slot] = kernel.is_finite(static_cast<std::uint32_t>(slot)) ? 0 : Walls<K>::kOutside;
  });
  return labels;
}

template <int K>
Triangulation<K> export_triangulation(const DelaunayKernel<K>& kernel, const std::vector<int>& region) {
  constexpr std::uint32_t kNone = Triangulation<K>::kNoNeighbor;
  const std::uint32_t n = kernel.n_slots();
  // Blocks count what they keep before they number it.
  constexpr std::size_t kBlock = 1U << 16U;
  const auto kept = [&](std::size_t slot) {
    return region[slot] >= 0 && kernel.is_finite(static_cast<std::uint32_t>(slot));
  };
  std::vector<std::uint32_t> first((n + kBlock - 1) / kBlock + 1, 0);
  const auto for_blocks = [&](const auto& fn) {
    parallel_for(
        first.size() - 1, [&](std::size_t b) { fn(b, b * kBlock, std::min<std::size_t>(n, (b + 1) * kBlock)); }, 1);
  };
  for_blocks([&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) first[b + 1] += kept(slot) ? 1U : 0U;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> index(n);
  for_blocks([&](std::size_t b, std::size_t begin, std::size_t end) {
    std::uint32_t next = first[b];
    for (std::size_t slot = begin; slot < end; ++slot) index[slot] = kept(slot) ? next++ : kNone;
  });
  const std::uint32_t count = first.back();
  Triangulation<K> t;
  t.simplices.resize(count);
  t.neighbors.resize(count);
  t.regions.resize(count);
  parallel_for(n, [&](std::size_t i) {
    const auto slot = static_cast<std::uint32_t>(i);
    const std::uint32_t s = index[slot];
    if (s == kNone) return;
    t.simplices[s] = kernel.corners(slot);
    t.regions[s] = region[slot];
    const auto neighbors = kernel.neighbors(slot);
    for (std::size_t k = 0; k <= K; ++k) t.neighbors[s][k] = index[neighbors[k]];
  });
  return t;
}

template RegionLabels<2> label_regions(const DelaunayKernel<2>&, const std::vector<ProtectedFace<2>>&);
template RegionLabels<3> label_regions(const DelaunayKernel<3>&, const std::vector<ProtectedFace<3>>&);

template Triangulation<2> export_triangulation(const DelaunayKernel<2>&, const std::vector<int>&);
template Triangulation<3> export_triangulation(const DelaunayKernel<3>&, const std::vector<int>&);

}  // namespace voropack
