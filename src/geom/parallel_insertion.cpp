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

/// The shares of points before a cut, phase by phase. Parallel cuts of different phases are far from each other, so
/// only vertices near to cuts across all axes are near to cuts of every phase: there are few.
constexpr std::array<double, 3> kCutFractions = {1.0 / 2, 1.0 / 3, 2.0 / 3};

/// Parts with fewer vertices consist of little but their borders.
template <int K>
constexpr std::size_t kLeastPart = kLeastParallelRound<K> / 2;

constexpr std::size_t kSamplePerPart = 512;

/// Where the vertices of a triangulation, and those to insert, are in the partition of each phase.
template <int K>
class Cuts {
 public:
  Cuts(const SimplexArrays<K>& arrays, const std::vector<std::uint32_t>& vertices, unsigned levels) {
    const std::vector<Vec<K>>& points = arrays.points;
    const std::size_t stride = std::max<std::size_t>(1, points.size() / (kSamplePerPart << levels));
    std::vector<Vec<K>> sample;
    for (std::size_t v = 1; v < points.size(); v += stride) sample.push_back(points[v]);
    std::vector<BoxPartition<K>> boxes;
    for (const double fraction : kCutFractions) boxes.emplace_back(sample, levels, fraction);
    n_parts_ = boxes.front().n_parts();

    for (auto& part : part_) part.resize(points.size());
    parallel_for(points.size(), [&](std::size_t v) {
      if (arrays.vertex_slot[v] != SimplexArrays<K>::kEmpty) place(points[v], v, boxes);
    });
    std::vector<std::uint8_t> deepest(vertices.size());
    parallel_for(vertices.size(), [&](std::size_t i) { deepest[i] = place(points[vertices[i]], vertices[i], boxes); });
    for (std::size_t i = 0; i < vertices.size(); ++i) chosen_[deepest[i]].push_back(vertices[i]);
  }

  [[nodiscard]] std::size_t n_parts() const { return n_parts_; }
  /// By number: the part of the vertex.
  [[nodiscard]] const std::vector<std::uint8_t>& part(std::size_t phase) const { return part_[phase]; }
  /// The vertices to insert that are farther from the cuts of the phase than from those of other phases, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& chosen(std::size_t phase) const { return chosen_[phase]; }

 private:
  /// Sets the parts of a vertex; returns the phase in which it is farthest from the cuts.
  std::uint8_t place(const Vec<K>& x, std::size_t v, const std::vector<BoxPartition<K>>& boxes) {
    std::uint8_t best = 0;
    double deepest = -1;
    for (std::size_t phase = 0; phase < boxes.size(); ++phase) {
      const auto [part, depth] = boxes[phase].place_of(x);
      part_[phase][v] = part;
      best = depth > deepest ? static_cast<std::uint8_t>(phase) : best;
      deepest = std::max(depth, deepest);
    }
    return best;
  }

  std::size_t n_parts_;
  std::array<std::vector<std::uint8_t>, kCutFractions.size()> part_;
  std::array<std::vector<std::uint32_t>, kCutFractions.size()> chosen_;
};

/// One phase.
template <int K>
class ParallelInsertion {
 public:
  ParallelInsertion(SimplexArrays<K>& arrays, InsertionState<K>& insertion, const std::vector<std::uint8_t>& part,
                    std::size_t n_parts)
      : a_(arrays), insertion_(insertion), part_(part), start_(n_parts + 1, 0), n_postponed_(n_parts, 0) {}

  /// Tries the vertices once; returns those postponed.
  std::vector<std::uint32_t> run(const std::vector<std::uint32_t>& vertices) {
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

  /// Sorts the vertices by part, ascending in each.
  void group(const std::vector<std::uint32_t>& vertices) {
    for (const std::uint32_t v : vertices) ++start_[part_[v] + 1U];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    grouped_.resize(vertices.size());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (const std::uint32_t v : vertices) grouped_[next[part_[v]]++] = v;
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
  const std::vector<std::uint8_t>& part_;  ///< By number.
  std::vector<std::uint32_t> grouped_;     ///< The vertices to insert, part by part.
  std::vector<std::size_t> start_;         ///< [n_parts + 1] Where those of a part begin.
  std::vector<std::size_t> n_postponed_;   ///< [n_parts]
};

}  // namespace

template <int K>
std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<K>& arrays, InsertionState<K>& insertion,
                                              const std::vector<std::uint32_t>& vertices) {
  const auto most = static_cast<unsigned>(std::bit_width(vertices.size() / kLeastPart<K>)) - 1;
  const unsigned levels = std::min(BoxPartition<K>::kMaxLevels, most);
  const Cuts<K> cuts(arrays, vertices, levels);
  std::vector<std::uint32_t> postponed;
  for (std::size_t i = 0; i < kCutFractions.size(); ++i) {
    const std::vector<std::uint32_t>& chosen = cuts.chosen(i);
    std::vector<std::uint32_t> now;
    std::merge(chosen.begin(), chosen.end(), postponed.begin(), postponed.end(), std::back_inserter(now));
    postponed = ParallelInsertion<K>(arrays, insertion, cuts.part(i), cuts.n_parts()).run(now);
  }
  return postponed;
}

template std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<2>&, InsertionState<2>&,
                                                       const std::vector<std::uint32_t>&);
template std::vector<std::uint32_t> insert_in_parallel(SimplexArrays<3>&, InsertionState<3>&,
                                                       const std::vector<std::uint32_t>&);

}  // namespace voropack
