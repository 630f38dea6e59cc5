#include "spheres/independent_set.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 1024;
/// So many candidates are worth more than one batch.
constexpr std::size_t kSplitSize = 4096;
/// Priorities that are looked at to cut the candidates into batches.
constexpr std::size_t kSamples = 1024;

enum State : std::uint8_t { kRejected = 0, kAccepted = 1, kUndecided = 2 };

/// For a block of candidates: those of higher rank that each conflicts with.
struct Rivals {
  std::vector<std::uint32_t> offsets, ids;
};

template <int K>
std::vector<Rivals> find_rivals(const std::vector<Ball<K>>& candidates, const std::vector<std::uint64_t>& priority,
                                double lipschitz) {
  SphereSet<K> set(candidates.front().center, lipschitz, candidates.front().radius);
  for (const Ball<K>& c : candidates) set.add(c);
  std::vector<Rivals> rivals((candidates.size() + kBlock - 1) / kBlock);
  parallel_for(
      rivals.size(),
      [&](std::size_t block) {
        Rivals& r = rivals[block];
        r.offsets.push_back(0);
        for (std::size_t i = block * kBlock; i < std::min(candidates.size(), (block + 1) * kBlock); ++i) {
          const Ball<K>& c = candidates[i];
          set.visit_near(c.center, c.radius, [&](std::uint32_t j) {
            const bool ranks_higher = priority[j] < priority[i] || (priority[j] == priority[i] && j < i);
            if (ranks_higher && SphereSet<K>::overlap(candidates[j], c.center, c.radius)) r.ids.push_back(j);
            return false;
          });
          r.offsets.push_back(static_cast<std::uint32_t>(r.ids.size()));
        }
      },
      1);
  return rivals;
}

/// The independent set of a batch, by rounds over the whole conflict graph.
template <int K>
std::vector<std::uint8_t> resolve(const std::vector<Ball<K>>& candidates, const std::vector<std::uint64_t>& priority,
                                  double lipschitz) {
  std::vector<std::uint8_t> state(candidates.size(), kUndecided), next(candidates.size());
  if (candidates.empty()) return state;
  const std::vector<Rivals> rivals = find_rivals(candidates, priority, lipschitz);
  std::vector<std::uint32_t> undecided(candidates.size());
  for (std::uint32_t i = 0; i < undecided.size(); ++i) undecided[i] = i;
  while (!undecided.empty()) {
    // Read `state`, write `next`: what one round decides does not depend on the order within it.
    parallel_for(undecided.size(), [&](std::size_t k) {
      const std::uint32_t i = undecided[k];
      const Rivals& r = rivals[i / kBlock];
      std::uint8_t result = kAccepted;
      for (std::uint32_t e = r.offsets[i % kBlock]; e < r.offsets[i % kBlock + 1]; ++e) {
        const std::uint8_t rival = state[r.ids[e]];
        if (rival == kAccepted) {
          result = kRejected;
          break;
        }
        if (rival == kUndecided) result = kUndecided;
      }
      next[i] = result;
    });
    for (const std::uint32_t i : undecided) state[i] = next[i];
    std::erase_if(undecided, [&](std::uint32_t i) { return state[i] != kUndecided; });
  }
  return state;
}

/// Priorities that cut the candidates into batches: about a sixteenth, as many again, then twice as many each time.
std::vector<std::uint64_t> batch_ends(const std::vector<std::uint64_t>& priority) {
  std::vector<std::uint64_t> ends;
  if (priority.size() >= kSplitSize) {
    std::vector<std::uint64_t> sample;
    for (std::size_t i = 0; i < kSamples; ++i) sample.push_back(priority[i * priority.size() / kSamples]);
    std::sort(sample.begin(), sample.end());
    for (std::size_t part = 16; part > 1; part /= 2) ends.push_back(sample[kSamples / part]);
  }
  ends.push_back(std::numeric_limits<std::uint64_t>::max());
  return ends;
}

}  // namespace

/// Rank by rank in a few batches: most candidates of the later ones conflict with a sphere that was chosen before,
/// which one search finds and which costs less than to know all rivals.
template <int K>
std::vector<std::uint8_t> independent_set(const std::vector<Ball<K>>& candidates,
                                          const std::vector<std::uint64_t>& priority, double lipschitz) {
  std::vector<std::uint8_t> state(candidates.size(), kUndecided);
  if (candidates.empty()) return state;
  SphereSet<K> chosen(candidates.front().center, lipschitz, candidates.front().radius);
  for (const std::uint64_t end : batch_ends(priority)) {
    parallel_for(candidates.size(), [&](std::size_t i) {
      if (state[i] == kUndecided && priority[i] <= end && chosen.conflicts(candidates[i].center, candidates[i].radius))
        state[i] = kRejected;
    });
    std::vector<std::uint32_t> ids;
    std::vector<Ball<K>> batch;
    std::vector<std::uint64_t> batch_priority;
    for (std::uint32_t i = 0; i < candidates.size(); ++i) {
      if (state[i] != kUndecided || priority[i] > end) continue;
      ids.push_back(i);
      batch.push_back(candidates[i]);
      batch_priority.push_back(priority[i]);
    }
    const std::vector<std::uint8_t> joins = resolve(batch, batch_priority, lipschitz);
    for (std::size_t k = 0; k < ids.size(); ++k) {
      state[ids[k]] = joins[k];
      if (joins[k] == kAccepted) chosen.add(batch[k]);
    }
  }
  return state;
}

template std::vector<std::uint8_t> independent_set(const std::vector<Ball<1>>&, const std::vector<std::uint64_t>&,
                                                   double);
template std::vector<std::uint8_t> independent_set(const std::vector<Ball<2>>&, const std::vector<std::uint64_t>&,
                                                   double);
template std::vector<std::uint8_t> independent_set(const std::vector<Ball<3>>&, const std::vector<std::uint64_t>&,
                                                   double);

}  // namespace voropack
