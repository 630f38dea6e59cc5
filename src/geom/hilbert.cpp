#include "geom/hilbert.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/parallel.h"
#include "base/random.h"

namespace voropack {

namespace {

/// A point and its key on the curve.
struct Keyed {
  std::uint64_t key;
  std::uint32_t index;
  friend constexpr auto operator<=>(const Keyed&, const Keyed&) = default;
};

constexpr int kMaxRounds = 16;
/// A round is 2^3 times as large as all rounds before it.
constexpr int kRoundRatioBits = 3;
/// The first round holds about this many points.
constexpr std::uint64_t kFirstRound = 512;
/// Runs of equal keys that are longer than this are sorted along a finer curve.
constexpr std::ptrdiff_t kLongestTie = 32;

/// The Hilbert curve as an automaton: one step per level of the grid, from the coarsest. A state is the pair of the
/// curve's entry corner and direction in a cell [Hamilton, Compact Hilbert Indices, 2006, section 2.1].
template <int K>
struct CurveTable {
  static constexpr unsigned kCorners = 1U << K;
  static constexpr unsigned kStates = kCorners * K;
  std::array<std::array<std::uint8_t, kCorners>, kStates> place{};  ///< Octant -> its place on the curve.
  std::array<std::array<std::uint8_t, kCorners>, kStates> next{};   ///< Octant -> the state inside it.

  static constexpr unsigned rotate_left(unsigned bits, unsigned by) {
    by %= K;
    return ((bits << by) | (bits >> (K - by))) & (kCorners - 1);
  }
  static constexpr unsigned gray(unsigned i) { return i ^ (i >> 1U); }
  static constexpr unsigned entry(unsigned w) { return w == 0 ? 0 : gray(2 * ((w - 1) / 2)); }
  static constexpr unsigned direction(unsigned w) {
    if (w == 0) return 0;
    return static_cast<unsigned>(std::countr_one(w % 2 == 0 ? w - 1 : w)) % K;
  }

  constexpr CurveTable() {
    for (unsigned e = 0; e < kCorners; ++e)
      for (unsigned d = 0; d < K; ++d)
        for (unsigned w = 0; w < kCorners; ++w) {
          const unsigned octant = rotate_left(gray(w), d + 1) ^ e;
          const unsigned next_e = e ^ rotate_left(entry(w), d + 1);
          const unsigned next_d = (d + direction(w) + 1) % K;
          place[e * K + d][octant] = static_cast<std::uint8_t>(w);
          next[e * K + d][octant] = static_cast<std::uint8_t>(next_e * K + next_d);
        }
  }
};

/// The same for several levels at a time: a step takes so many bits of each axis.
template <int K>
struct StepTable {
  static constexpr unsigned kLevels = 6 / K;
  static constexpr unsigned kCells = 1U << (K * kLevels);
  struct Step {
    std::uint8_t place, next;
  };
  /// State, and the bits of each axis, those of axis 0 lowest -> the place on the curve, and the state inside.
  std::array<std::array<Step, kCells>, CurveTable<K>::kStates> steps{};

  constexpr StepTable() {
    const CurveTable<K> curve;
    for (unsigned first = 0; first < CurveTable<K>::kStates; ++first)
      for (unsigned cell = 0; cell < kCells; ++cell) {
        unsigned place = 0, state = first;
        for (unsigned level = kLevels; level-- > 0;) {
          unsigned octant = 0;
          for (unsigned axis = 0; axis < K; ++axis) octant |= ((cell >> (axis * kLevels + level)) & 1U) << axis;
          place = place << static_cast<unsigned>(K) | curve.place[state][octant];
          state = curve.next[state][octant];
        }
        steps[first][cell] = {static_cast<std::uint8_t>(place), static_cast<std::uint8_t>(state)};
      }
  }
};

template <int K>
constexpr StepTable<K> kStepTable{};

/// The digits of a radix sort.
constexpr unsigned kDigitBits = 12;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

/// From `from` to `to` by one digit of the keys; where it is equal, the order stays. In parallel.
void sort_by_digit(std::span<const Keyed> from, std::span<Keyed> to, unsigned shift) {
  constexpr std::size_t kBlock = 1U << 18U;
  const std::size_t n_blocks = (from.size() + kBlock - 1) / kBlock;
  const auto for_blocks = [&](auto&& fn) {
    parallel_for(
        n_blocks,
        [&](std::size_t block) {
          for (const Keyed& k : from.subspan(block * kBlock, std::min(kBlock, from.size() - block * kBlock)))
            fn(block, k, (k.key >> shift) % kDigits);
        },
        1);
  };
  std::vector<std::array<std::uint32_t, kDigits>> next(n_blocks);
  for_blocks([&](std::size_t block, const Keyed&, std::size_t digit) { ++next[block][digit]; });
  std::uint32_t sum = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit)
    for (auto& of_block : next) sum += std::exchange(of_block[digit], sum);
  for_blocks([&](std::size_t block, const Keyed& k, std::size_t digit) { to[next[block][digit]++] = k; });
}

/// What is almost in order already, as points are along another curve of the same kind: those beside a descent are
/// sorted on their own, and merged with the others. False, and nothing is done, if they are many.
bool merge_few(std::span<Keyed> keyed) {
  const std::size_t most = keyed.size() / 16;
  std::vector<Keyed> ascending, others;
  ascending.reserve(keyed.size());
  for (const Keyed& k : keyed) {
    if (ascending.empty() || ascending.back() < k) {
      ascending.push_back(k);
      continue;
    }
    if (others.size() >= most) return false;
    others.push_back(ascending.back());
    others.push_back(k);
    ascending.pop_back();
  }
  std::ranges::sort(others);
  std::ranges::merge(ascending, others, keyed.begin());
  return true;
}

/// Sorts by key, then index; indices ascend at first. `n_bits`: of the keys, those that are not all equal.
void sort_keyed(std::span<Keyed> keyed, unsigned n_bits) {
  constexpr std::size_t kEnoughForRadix = 1U << 14U;
  if (std::ranges::is_sorted(keyed) || merge_few(keyed)) return;
  if (keyed.size() < kEnoughForRadix || n_bits == 0) {
    std::ranges::sort(keyed);
    return;
  }
  // By the first digits only, the lower one first. Few have both in common.
  const unsigned shift = n_bits - std::min(n_bits, 2 * kDigitBits);
  std::vector<Keyed> other(keyed.size());
  sort_by_digit(keyed, other, shift);
  sort_by_digit(other, keyed, shift + kDigitBits);
  for (auto first = keyed.begin(); first != keyed.end();) {
    const auto last =
        std::find_if(first, keyed.end(), [&](const Keyed& k) { return (k.key ^ first->key) >> shift != 0; });
    if (last - first > 1) sort_keyed({first, last}, shift);
    first = last;
  }
}

std::vector<std::uint32_t> indices_of(const std::vector<Keyed>& keyed) {
  std::vector<std::uint32_t> indices(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) indices[i] = keyed[i].index;
  return indices;
}

template <int K>
class Sorter {
 public:
  explicit Sorter(std::span<const Vec<K>> points) : points_(points) {}

  /// Sorts `keyed`, whose entries name points, along a curve through their bounding box.
  void sort(std::vector<Keyed>& keyed) const {
    set_keys(keyed);
    const auto same_key = [](const Keyed& a, const Keyed& b) { return a.key == b.key; };
    // One point many times, or differences too small or too large to scale: no finer curve helps.
    if (std::equal(keyed.begin(), keyed.end() - 1, keyed.begin() + 1, same_key)) return;
    sort_keyed(keyed, K * kHilbertBits<K>);
    for (auto first = keyed.begin(); first != keyed.end();) {
      const auto last = std::find_if(first, keyed.end(), [&](const Keyed& k) { return !same_key(k, *first); });
      if (last - first > kLongestTie) refine(first, last);
      first = last;
    }
  }

 private:
  void set_keys(std::vector<Keyed>& keyed) const {
    Box<K> box;
    for (const Keyed& k : keyed) box.add(points_[k.index]);
    double extent = 0;
    for (int axis = 0; axis < K; ++axis) extent = std::max(extent, box.hi[axis] - box.lo[axis]);
    const double cells = std::ldexp(1.0, kHilbertBits<K>);
    const double scale = extent > 0 && std::isfinite(cells / extent) ? cells / extent : 0.0;
    const double top = cells - 1;
    parallel_for(keyed.size(), [&](std::size_t i) {
      Keyed& k = keyed[i];
      std::array<std::uint32_t, K> cell{};
      for (int axis = 0; axis < K; ++axis)
        cell[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(std::min((points_[k.index][axis] - box.lo[axis]) * scale, top));
      k.key = hilbert_key<K>(cell);
    });
  }

  /// Sorts points that fell into one cell. The recursion ends because their box is at most a cell large.
  void refine(std::vector<Keyed>::iterator first, std::vector<Keyed>::iterator last) const {
    std::vector<Keyed> part(first, last);
    sort(part);
    std::copy(part.begin(), part.end(), first);
  }

  std::span<const Vec<K>> points_;
};

}  // namespace

template <int K>
std::uint64_t hilbert_key(const std::array<std::uint32_t, K>& cell) {
  constexpr unsigned kLevels = StepTable<K>::kLevels;
  static_assert(kHilbertBits<K> % kLevels == 0);
  std::uint64_t key = 0;
  unsigned state = 0;
  for (unsigned level = kHilbertBits<K>; level > 0;) {
    level -= kLevels;
    unsigned bits = 0;
    for (unsigned axis = 0; axis < K; ++axis)
      bits |= ((cell[axis] >> level) & ((1U << kLevels) - 1)) << (axis * kLevels);
    const auto step = kStepTable<K>.steps[state][bits];
    key = key << (K * kLevels) | step.place;
    state = step.next;
  }
  return key;
}

template <int K>
std::uint64_t hilbert_key(const Vec<K>& x, const Box<K>& box) {
  constexpr double kTop = (std::uint64_t{1} << static_cast<unsigned>(kHilbertBits<K>)) - 1;
  std::array<std::uint32_t, K> cell{};
  for (int axis = 0; axis < K; ++axis) {
    const double extent = box.hi[axis] - box.lo[axis];
    const double part = extent > 0 ? std::clamp((x[axis] - box.lo[axis]) / extent, 0.0, 1.0) : 0.0;
    cell[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(part * kTop);
  }
  return hilbert_key<K>(cell);
}

template <int K>
std::vector<std::uint32_t> hilbert_order(std::span<const Vec<K>> points) {
  std::vector<Keyed> keyed(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) keyed[i] = {0, static_cast<std::uint32_t>(i)};
  if (!keyed.empty()) Sorter<K>(points).sort(keyed);
  return indices_of(keyed);
}

template <int K>
std::vector<std::uint32_t> hilbert_order(std::span<const Vec<K>> points, const Box<K>& box) {
  std::vector<Keyed> keyed(points.size());
  parallel_for(points.size(), [&](std::size_t i) {
    keyed[i] = {hilbert_key<K>(points[i], box), static_cast<std::uint32_t>(i)};
  });
  sort_keyed(keyed, K * kHilbertBits<K>);
  return indices_of(keyed);
}

std::vector<std::uint32_t> insertion_rounds(std::size_t n) {
  int n_rounds = 1;
  for (std::size_t m = n >> kRoundRatioBits; m >= kFirstRound && n_rounds < kMaxRounds; m >>= kRoundRatioBits)
    ++n_rounds;
  const auto round_of = [&](std::size_t i) {
    return n_rounds - 1 - std::min(std::countr_zero(hash_words(i)) / kRoundRatioBits, n_rounds - 1);
  };
  std::array<std::size_t, kMaxRounds> next{};
  for (std::size_t i = 0; i < n; ++i) ++next[static_cast<std::size_t>(round_of(i))];
  std::size_t sum = 0;
  for (std::size_t& m : next) sum += std::exchange(m, sum);
  std::vector<std::uint32_t> order(n);
  for (std::size_t i = 0; i < n; ++i)
    order[next[static_cast<std::size_t>(round_of(i))]++] = static_cast<std::uint32_t>(i);
  return order;
}

template std::uint64_t hilbert_key<2>(const std::array<std::uint32_t, 2>&);
template std::uint64_t hilbert_key<3>(const std::array<std::uint32_t, 3>&);
template std::uint64_t hilbert_key<2>(const Vec<2>&, const Box<2>&);
template std::uint64_t hilbert_key<3>(const Vec<3>&, const Box<3>&);
template std::vector<std::uint32_t> hilbert_order<2>(std::span<const Vec<2>>);
template std::vector<std::uint32_t> hilbert_order<3>(std::span<const Vec<3>>);
template std::vector<std::uint32_t> hilbert_order<2>(std::span<const Vec<2>>, const Box<2>&);
template std::vector<std::uint32_t> hilbert_order<3>(std::span<const Vec<3>>, const Box<3>&);

}  // namespace voropack
