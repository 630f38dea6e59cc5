#include "geom/parallel_insertion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <numeric>
#include <span>

#include "base/parallel.h"
#include "geom/box_partition.h"

namespace voropack {

namespace {

/// The shares of points before a cut, phase by phase. Cuts of different phases are far from each other where they are
/// parallel, so that a vertex near a cut of each phase is near to cuts across all axes: there are few.
constexpr std::array<double, 3> kCutFractions = {1.0 / 2, 1.0 / 3, 2.0 / 3};

/// Parts with fewer vertices consist of little but their borders.
template <int K>
constexpr std::size_t kLeastPart = kLeastParallelRound<K> / 2;

constexpr std::size_t kSamplePerPart = 512;

template <int K>
class ParallelInsertion {
 public:
  ParallelInsertion(SimplexArrays<K>& arrays, InsertionState<K>& insertion) : a_(arrays), insertion_(insertion) {}

  /// Tries the vertices once; returns those postponed.
  std::vector<std::uint32_t> run(const std::vector<std::uint32_t>& vertices, const BoxPartition<K>& boxes) {
    assign_parts(boxes);
    group(vertices);
    std::vector<InsertionState<K>> states = share_out_slots();
    parallel_for(
        n_parts(), [&](std::size_t p) { insert_part(p, states[p]); }, 1);
    insertion_.round += static_cast<std::uint32_t>(vertices.size());
    std::vector<std::uint32_t> postponed;
    for (std::size_t p = 0; p < n_parts(); ++p) {
      insertion_.free_slots.give(states[p].free_slots);
      if (states[p].last_slot != SimplexArrays<K>::kEmpty) insertion_.last_slot = states[p].last_slot;
      insertion_.recreated.insert(insertion_.recreated.end(), states[p].recreated.begin(), states[p].recreated.end());
      const auto mine = part_vertices(p);
      postponed.insert(postponed.end(), mine.begin(), mine.begin() + static_cast<std::ptrdiff_t>(n_postponed_[p]));
    }
    std::sort(postponed.begin(), postponed.end());
    return postponed;
  }

 private:
  [[nodiscard]] std::size_t n_parts() const { return start_.size() - 1; }
  [[nodiscard]] std::span<std::uint32_t> part_vertices(std::size_t p) {
    return std::span(grouped_).subspan(start_[p], start_[p + 1] - start_[p]);
  }

  void assign_parts(const BoxPartition<K>& boxes) {
    part_.resize(a_.points.size());
    parallel_for(part_.size(), [&](std::size_t v) { part_[v] = boxes.part_of(a_.points[v]); });
    start_.assign(boxes.n_parts() + 1, 0);
  }

  /// Sorts the vertices by part, ascending in each.
  void group(const std::vector<std::uint32_t>& vertices) {
    for (const std::uint32_t v : vertices) ++start_[part_[v] + 1U];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    grouped_.resize(vertices.size());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (const std::uint32_t v : vertices) grouped_[next[part_[v]]++] = v;
    n_postponed_.assign(n_parts(), 0);
  }

  /// Gives each part the free slots and the numbers of attempts that its vertices should need.
  std::vector<InsertionState<K>> share_out_slots() {
    std::vector<std::size_t> wanted;
    for (std::size_t p = 0; p < n_parts(); ++p) wanted.push_back(expected_simplices<K>(part_vertices(p).size()));
    const std::size_t all = std::accumulate(wanted.begin(), wanted.end(), std::size_t{0});
    SlotPool& pool = insertion_.free_slots;
    if (const std::size_t n = a_.simplices.size(); pool.size() < all) {
      const std::size_t end = std::min<std::size_t>(n + all - pool.size(), SimplexArrays<K>::kMaxSlots);
      a_.grow(end);
      pool.give(static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(end));
    }
    std::vector<InsertionState<K>> states(n_parts());
    for (std::size_t p = 0; p < n_parts(); ++p) {
      states[p].free_slots = pool.split_off(wanted[p]);
      states[p].round = insertion_.round + static_cast<std::uint32_t>(start_[p]);
    }
    return states;
  }

  /// Inserts the vertices of a part and moves those postponed to the front of them.
  void insert_part(std::size_t p, InsertionState<K>& state) {
    constexpr std::uint32_t kEmpty = SimplexArrays<K>::kEmpty;
    const auto own = static_cast<std::uint8_t>(p);
    VertexInserter<K, PartOfTriangulation> inserter(a_, state, {part_.data(), own});
    const auto is_own = [&](std::uint32_t v) { return part_[v] == own; };
    std::size_t n_postponed = 0;
    const std::span<std::uint32_t> vertices = part_vertices(p);
    for (const std::uint32_t v : vertices) {
      const std::uint32_t start = state.last_slot != kEmpty ? state.last_slot : slot_nearby(a_, v, is_own);
      if (start == kEmpty || !inserter.insert(v, start)) vertices[n_postponed++] = v;
    }
    n_postponed_[p] = n_postponed;
  }

  SimplexArrays<K>& a_;
  InsertionState<K>& insertion_;
  std::vector<std::uint8_t> part_;        ///< By number.
  std::vector<std::uint32_t> grouped_;    ///< The vertices to insert, part by part.
  std::vector<std::size_t> start_;        ///< [n_parts + 1] Where those of a part begin.
  std::vector<std::size_t> n_postponed_;  ///< [n_parts]
};

/// A partition for each phase.
template <int K>
std::vector<BoxPartition<K>> make_cuts(const std::vector<Vec<K>>& points, unsigned levels) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / (kSamplePerPart << levels));
  std::vector<Vec<K>> sample;
  for (std::size_t v = 1; v < points.size(); v += stride) sample.push_back(points[v]);
  std::vector<BoxPartition<K>> cuts;
  for (const double fraction : kCutFractions) cuts.emplace_back(sample, levels, fraction);
  return cuts;
}

/// For each phase the vertices that are farther from its cuts than from those of other phases.
template <int K>
std::vector<std::vector<std::uint32_t>> choose_phases(const std::vector<Vec<K>>& points,
                                                      const std::vector<std::uint32_t>& vertices,
                                                      const std::vector<BoxPartition<K>>& cuts) {
  std::vector<std::uint8_t> best(vertices.size());
  parallel_for(vertices.size(), [&](std::size_t i) {
    double deepest = -1;
    for (std::size_t phase = 0; phase < cuts.size(); ++phase) {
      const double depth = cuts[phase].depth(points[vertices[i]]);
      if (depth <= deepest) continue;
      deepest = depth;
      best[i] = static_cast<std::uint8_t>(phase);
    }
  });
  std::vector<std::vector<std::uint32_t>> chosen(cuts.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) chosen[best[i]].push_back(vertices[i]);
  return chosen;
}

}  // namespace

template <int K>
std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<K>& arrays, InsertionState<K>& insertion,
                                              const std::vector<std::uint32_t>& vertices) {
  const auto most = static_cast<unsigned>(std::bit_width(vertices.size() / kLeastPart<K>)) - 1;
  const unsigned levels = std::min(BoxPartition<K>::kMaxLevels, most);
  const std::vector<BoxPartition<K>> cuts = make_cuts(arrays.points, levels);
  std::vector<std::vector<std::uint32_t>> chosen = choose_phases(arrays.points, vertices, cuts);
  ParallelInsertion<K> phase(arrays, insertion);
  std::vector<std::uint32_t> postponed;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    std::vector<std::uint32_t> now;
    std::merge(chosen[i].begin(), chosen[i].end(), postponed.begin(), postponed.end(), std::back_inserter(now));
    postponed = phase.run(now, cuts[i]);
  }
  return postponed;
}

template std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<2>&, InsertionState<2>&,
                                                       const std::vector<std::uint32_t>&);
template std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<3>&, InsertionState<3>&,
                                                       const std::vector<std::uint32_t>&);

}  // namespace voropack
